// SPDX-License-Identifier: Apache-2.0
// The rows of a measurement: the instants at which force and model are compared, and their blocks.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "workbench/estimate/measurement/conditioning.h"
#include "workbench/estimate/measurement/measurement.h"
#include "workbench/signal/repetition.h"

namespace slipstack::workbench {
namespace {

/// Rows per period of the bandwidth: above the Nyquist rate, so no information is lost.
constexpr double kRowsPerCycle = 3.0;

constexpr int kBlocksPerFold = 6;

/// By how many blocks the folds shift along a motion with a period of `blocks_of_period`, from its first
/// repetition to its last of `periods`. Below one each fold leaves out the same part of every repetition,
/// so that the others have never seen it. A period of less than half a round of the folds is in all of them.
double shift_of_folds(double blocks_of_period, double periods) {
  const double folds = std::round(blocks_of_period / kFolds);
  return folds == 0.0 ? periods : std::abs(blocks_of_period - kFolds * folds) * periods;
}

/// The number of blocks of a log of which the velocity is known at the rows: the usual one, or the nearest
/// one whose folds do not go with a motion that repeats.
int blocks_beside_repetition(int usual, std::span<const double> velocity_mps) {
  const double period_rows = repetition_period(velocity_mps);
  if (!(period_rows > 0.0)) return usual;
  const double periods = static_cast<double>(velocity_mps.size()) / period_rows;
  for (const int blocks : {usual, usual - kFolds, usual + kFolds, usual - 2 * kFolds}) {
    if (blocks > kFolds && shift_of_folds(blocks / periods, periods) >= 1.0) return blocks;
  }
  return usual;
}

/// The first sample by which the position has ranged over `travel_m`; their number where it never has.
std::size_t samples_until_travel(std::span<const double> position_m, double travel_m) {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (std::size_t i = 0; i < position_m.size(); ++i) {
    lowest = std::min(lowest, position_m[i]);
    highest = std::max(highest, position_m[i]);
    if (highest - lowest >= travel_m) return i;
  }
  return position_m.size();
}

/// Whether the axis moves where its log begins: in the first 20 ms by more than two encoder steps, and by
/// more than a fifth of what it moves in that time in the mean. Chosen: moves of machines last five times as
/// long.
bool begins_in_motion(std::span<const double> position_m, double sample_rate_Hz, double resolution_m) {
  const auto stride = std::max<std::size_t>(2, static_cast<std::size_t>(0.02 * sample_rate_Hz));
  if (position_m.size() <= stride) return false;
  const auto moved_m = [&](std::size_t i) { return std::abs(position_m[i + stride] - position_m[i]); };
  double sum_m = 0.0;
  for (std::size_t i = 0; i + stride < position_m.size(); ++i) sum_m += moved_m(i);
  const double mean_m = sum_m / static_cast<double>(position_m.size() - stride);
  return moved_m(0) > std::max(2.0 * resolution_m, 0.2 * mean_m);
}

/// Samples after which the vibrations of a log that begins in motion no longer depend on what was before it:
/// four seconds, of short logs an eighth. Chosen: a mode of 5 Hz with 3 % damping is down to 2 % then.
std::size_t settling_of_log(std::size_t samples, double sample_rate_Hz) {
  return std::min(static_cast<std::size_t>(4.0 * sample_rate_Hz), samples / 8);
}

}  // namespace

int blocks_of_share(double share) {
  return kFolds * std::max(1, static_cast<int>(std::lround(kBlocksPerFold * share)));
}

void Measurement::find_burn_in(LogPart& part) const {
  const bool is_chunk = part.sample_count < log_samples_[part.log];
  const auto first = position_m().begin() + static_cast<std::ptrdiff_t>(part.first_sample);
  const double needed = burn_in_travel_m(part.log_travel_m);
  const auto recorded_m = std::span(log_->position_m).subspan(part.first_sample, part.sample_count);
  std::size_t settling = 0;
  if (part.start_s > 0.0) {
    settling = settling_samples(sample_rate_Hz());
  } else if (begins_in_motion(recorded_m, sample_rate_Hz(), encoder_resolution_m_)) {
    settling = settling_of_log(part.sample_count, sample_rate_Hz());
  }
  const std::size_t latest = is_chunk ? part.sample_count : part.sample_count / 4;
  const std::size_t known = samples_until_travel(std::span(first, latest), needed);
  if (known < latest) {
    part.burn_in = std::min(std::max(known, settling), part.sample_count);
  } else if (is_chunk) {
    // A chunk in which the state never becomes known has no rows; other chunks of its log have.
    part.burn_in = part.sample_count;
  } else {
    // What the axis does later decides less than the way that it has gone by then.
    const auto [low, high] = std::minmax_element(first, first + static_cast<std::ptrdiff_t>(latest));
    part.burn_in = std::max(samples_until_travel(std::span(first, latest), 0.95 * (*high - *low)), settling);
  }
}

std::size_t Measurement::margin() const {
  return filter_.taps().size() / 2 + motion_taps(bandwidth_Hz_, sample_rate_Hz()).size() / 2 + 2;
}

std::size_t Measurement::usable(const LogPart& part) const {
  const std::size_t lost = part.burn_in + 2 * margin();
  return part.sample_count > lost ? part.sample_count - lost : 0;
}

void Measurement::choose_stride(std::size_t maximum_rows) {
  const std::size_t group = filter_.group();
  std::size_t all_usable = 0;
  for (const LogPart& part : parts_) all_usable += usable(part);
  row_stride_ =
      std::max<std::size_t>(1, static_cast<std::size_t>(sample_rate_Hz() / (kRowsPerCycle * bandwidth_Hz_)));
  row_stride_ = std::max(row_stride_, (all_usable + maximum_rows - 1) / maximum_rows);
  row_stride_ = (row_stride_ + group - 1) / group * group;
}

void Measurement::choose_rows(Interval own) {
  const std::size_t group = filter_.group();
  const std::size_t reach = margin();
  for (LogPart& part : parts_) {
    part.first_row = row_samples_.size();
    const std::size_t known = part.first_sample + part.burn_in + reach;
    const std::size_t begin = std::max(known, own.first);
    const std::size_t end = std::min(known + usable(part), own.end);
    const std::size_t first = (begin + group - 1) / group * group;
    for (std::size_t i = first; i < end; i += row_stride_) row_samples_.push_back(i);
    part.row_count = row_samples_.size() - part.first_row;
  }
  row_usable_ = Eigen::VectorXd::Ones(row_count());
  for (const LogPart& part : parts_) {
    for (const Interval& cut : part.cut) {
      // Rows to which the filters carry any sample of the cut.
      const std::size_t from = part.first_sample + cut.first;
      const std::size_t to = part.first_sample + cut.end + reach;
      const auto first =
          std::lower_bound(row_samples_.begin(), row_samples_.end(), from - std::min(from, reach));
      for (auto row = first; row != row_samples_.end() && *row < to; ++row) {
        row_usable_(row - row_samples_.begin()) = 0.0;
      }
    }
  }
  row_weights_ = fit_weights_ = row_usable_;
  recorded_force_N_ = std::make_shared<const Eigen::VectorXd>(filtered(log_->force_N));
}

void Measurement::choose_blocks() {
  fold_count_ = kFolds;
  row_blocks_.reserve(row_samples_.size());
  for (std::size_t log = 0; log < log_count(); ++log) {
    // Each log has equally many blocks in every fold, so that gains of that log alone are cross-validated
    // too.
    const Interval own = parts_of_log(log);
    const std::size_t first_row = parts_[own.first].first_row;
    const std::size_t rows = parts_[own.end - 1].first_row + parts_[own.end - 1].row_count - first_row;
    const double share = static_cast<double>(rows) / static_cast<double>(row_samples_.size());
    int blocks = blocks_of_share(share);
    if (own.size() == 1) {
      std::vector<double> velocity_at_rows;
      for (std::size_t row = first_row; row < first_row + rows; ++row)
        velocity_at_rows.push_back(velocity_mps()[row_samples_[row]]);
      blocks = blocks_beside_repetition(blocks, velocity_at_rows);
    }
    for (std::size_t row = 0; row < rows; ++row) {
      const std::size_t block = row * static_cast<std::size_t>(blocks) / rows;
      row_blocks_.push_back(block_count_ + static_cast<int>(block));
    }
    for (std::size_t p = own.first; p < own.end; ++p) {
      parts_[p].first_block = block_count_;
      parts_[p].block_count = blocks;
    }
    block_count_ += blocks;
  }
}

double Measurement::burn_in_s() const {
  std::size_t longest = 0;
  for (const LogPart& part : parts_) longest = std::max(longest, part.burn_in);
  return static_cast<double>(longest) * tick_s();
}

}  // namespace slipstack::workbench
