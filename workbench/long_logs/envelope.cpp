// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/envelope.h"

#include <algorithm>

namespace slipstack::workbench {

void Envelope::take(const std::vector<double>& position_m) {
  for (const double x : position_m) {
    const auto at = static_cast<float>(x);
    if (in_last_ == samples_) {
      if (all_.size() == most_) join_pairs();
      all_.push_back({at, at, at});
      in_last_ = 0;
    }
    ++in_last_;
    all_.back().low_m = std::min(all_.back().low_m, at);
    all_.back().high_m = std::max(all_.back().high_m, at);
  }
}

void Envelope::join_pairs() {
  for (std::size_t i = 0; i < all_.size() / 2; ++i) {
    const EnvelopePoint& first = all_[2 * i];
    const EnvelopePoint& second = all_[2 * i + 1];
    all_[i] = {first.first_m, std::min(first.low_m, second.low_m), std::max(first.high_m, second.high_m)};
  }
  all_.resize(all_.size() / 2);
  samples_ *= 2;
}

}  // namespace slipstack::workbench
