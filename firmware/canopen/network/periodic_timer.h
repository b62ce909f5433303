// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack::canopen {

/// Says when something periodic is due. It stays on its time grid although it is asked at irregular instants;
/// when nobody asked for a whole period, the grid begins anew.
class PeriodicTimer {
 public:
  void restart(std::uint32_t now_us) { last_us_ = now_us; }

  /// True once in every period; never with a period of zero.
  bool due(std::uint32_t now_us, std::uint32_t period_us) {
    const std::uint32_t since_us = now_us - last_us_;
    if (period_us == 0 || since_us < period_us) return false;
    last_us_ = since_us < 2 * period_us ? last_us_ + period_us : now_us;
    return true;
  }

 private:
  std::uint32_t last_us_ = 0;
};

}  // namespace slipstack::canopen
