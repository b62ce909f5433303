// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/measurement/measurement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "workbench/cleaning/repair.h"
#include "workbench/estimate/measurement/conditioning.h"
#include "workbench/signal/white_noise.h"
#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {
namespace {

/// The motion keeps this much more bandwidth than the rows, so that what is non-linear in it (signs, slip,
/// exponentials of speed) is formed before the common filter and not after.
constexpr double kMotionBandwidthRatio = 3.0;

/// Hysteresis is driven by displacement as it is, where it lies on an encoder's grid: a filter with a sharp
/// edge overshoots by nanometres where a move ends, and to hysteresis that is a reversal. Readings on no grid
/// carry noise instead, which is as bad; these taps are positive, so that they make no reversal of their own.
constexpr std::array<double, 5> kDisplacementTaps{1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0};

/// Rows per period of the bandwidth: above the Nyquist density, so nothing is lost.
constexpr double kRowsPerCycle = 3.0;

constexpr int kBlocksPerFold = 6;

std::vector<double> motion_taps(double bandwidth_Hz, double rate_Hz) {
  return low_pass_taps(std::min(kMotionBandwidthRatio * bandwidth_Hz, 0.3 * rate_Hz), rate_Hz);
}

/// The turning points of all parts, in the order of time.
std::vector<TurningPoint> turning_points_of(const std::vector<double>& displacement_m,
                                            const std::vector<LogPart>& parts, double beyond_corners) {
  std::vector<TurningPoint> found;
  for (const LogPart& part : parts) {
    find_turning_points(displacement_m, {part.first_sample, part.end_sample()}, part.encoder_resolution_m,
                        beyond_corners, found);
  }
  return found;
}

}  // namespace

int blocks_of_share(double share) {
  return kFolds * std::max(1, static_cast<int>(std::lround(kBlocksPerFold * share)));
}

Measurement::Measurement(Log log, const ConditioningOptions& options)
    : Measurement(std::vector<Log>{std::move(log)}, options) {}

Measurement::Measurement(std::vector<Log> logs, const ConditioningOptions& options)
    : Measurement(join(std::move(logs)), options) {}

Measurement::Measurement(std::vector<LogChunk> pieces, const ConditioningOptions& options)
    : Measurement(join(std::move(pieces)), options) {}

Measurement::Measurement(LogChunk piece, const Measurement& like, const std::vector<std::size_t>& borders)
    : log_samples_(like.log_samples_),
      per_log_(like.per_log_),
      bandwidth_Hz_(like.bandwidth_Hz_),
      force_noise_given_(true),
      row_stride_(like.row_stride_) {
  const LogPart& same = like.parts_[like.parts_of_log(piece.log_index).first];
  std::vector<LogChunk> pieces;
  pieces.push_back(std::move(piece));
  JoinedLogs joined = join(std::move(pieces));
  take_log(std::move(joined.log));
  parts_ = std::move(joined.parts);
  LogPart& part = parts_.front();
  part.encoder_resolution_m = same.encoder_resolution_m;
  part.rough_mass_kg = same.rough_mass_kg;
  part.force_noise_N = same.force_noise_N;
  encoder_resolution_m_ = part.encoder_resolution_m;
  estimate_motion();
  find_burn_in(part);
  filter_ = like.filter_;
  choose_rows({borders.front(), borders.back()});
  fold_count_ = kFolds;
  block_count_ = part.block_count = static_cast<int>(borders.size()) - 1;
  for (const std::size_t sample : row_samples_) {
    const auto behind = std::upper_bound(borders.begin(), borders.end(), sample);
    row_blocks_.push_back(static_cast<int>(behind - borders.begin()) - 1);
  }
}

Measurement::Measurement(JoinedLogs joined, const ConditioningOptions& options)
    : parts_(std::move(joined.parts)),
      log_samples_(std::move(joined.log_samples)),
      per_log_(options.per_log) {
  take_log(std::move(joined.log));
  encoder_resolution_m_ = log_->encoder_resolution_m.value_or(0.0);
  force_noise_given_ = options.force_noise_N > 0.0;
  for (LogPart& part : parts_) {
    const std::vector<double> force_N = part_of(log_->force_N, part);
    part.rough_mass_kg =
        part.mass_kg ? *part.mass_kg
                     : rough_mass_kg(part_of(log_->position_m, part), force_N, sample_rate_Hz(), part.cut);
    part.force_noise_N = force_noise_given_ ? options.force_noise_N : white_noise(force_N);
  }
  share_noise();
  bandwidth_Hz_ = options.bandwidth_Hz > 0.0 ? std::min(options.bandwidth_Hz, 0.25 * sample_rate_Hz())
                                             : bandwidth_shown_Hz(*log_, parts_);
  estimate_motion();
  for (LogPart& part : parts_) find_burn_in(part);
  filter_ = RowFilter(bandwidth_Hz_, sample_rate_Hz());
  choose_stride(options.maximum_rows);
  choose_rows({0, sample_count()});
  choose_blocks();
}

void Measurement::take_log(Log log) {
  sample_rate_Hz_ = log.sample_rate_Hz;
  log_ = std::make_shared<const Log>(std::move(log));
}

void Measurement::share_noise() {
  for (std::size_t log = 0; log < log_count(); ++log) {
    const Interval own = parts_of_log(log);
    double squares = 0.0;
    double samples = 0.0;
    for (std::size_t p = own.first; p < own.end; ++p) {
      const auto count = static_cast<double>(parts_[p].sample_count);
      squares += count * parts_[p].force_noise_N * parts_[p].force_noise_N;
      samples += count;
    }
    for (std::size_t p = own.first; p < own.end; ++p) parts_[p].force_noise_N = std::sqrt(squares / samples);
  }
}

std::size_t Measurement::whole_sample_count() const {
  return std::accumulate(log_samples_.begin(), log_samples_.end(), std::size_t{0});
}

Interval Measurement::parts_of_log(std::size_t log) const {
  Interval parts{0, parts_.size()};
  while (parts.first < parts.end && parts_[parts.first].log != log) ++parts.first;
  while (parts.first < parts.end && parts_[parts.end - 1].log != log) --parts.end;
  return parts;
}

RowRange Measurement::rows_of_log(std::size_t log) const {
  const Interval own = parts_of_log(log);
  if (own.first == own.end) return {};
  const std::size_t first = parts_[own.first].first_row;
  const std::size_t end = parts_[own.end - 1].first_row + parts_[own.end - 1].row_count;
  return {static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(end - first)};
}

double Measurement::time_s(std::size_t index) const {
  const LogPart& part = parts_[part_at(index)];
  std::size_t before = index - part.first_sample;
  for (std::size_t log = 0; log < part.log; ++log) before += log_samples_[log];
  return part.start_s + static_cast<double>(before) * tick_s();
}

void Measurement::estimate_motion() {
  const double rate = sample_rate_Hz();
  const std::vector<double> taps = motion_taps(bandwidth_Hz_, rate);
  const bool several = parts_.size() > 1;
  const auto append = [several](std::vector<double>& all, std::vector<double> more) {
    if (several) {
      all.insert(all.end(), more.begin(), more.end());
    } else {
      all = std::move(more);
    }
  };
  Motion motion;
  if (several) {
    for (auto* all : {&displacement_m_, &motion.position_m, &motion.velocity_mps, &motion.acceleration_mps2})
      all->reserve(sample_count());
  }
  for (const LogPart& part : parts_) {
    const std::span<const double> reading_m =
        std::span(log_->position_m).subspan(part.first_sample, part.sample_count);
    std::vector<double> position_m = interpolate_between_steps(reading_m, part.encoder_resolution_m);
    std::vector<double> smooth_m = filter_all(position_m, taps);
    append(displacement_m_, part.encoder_resolution_m > 0.0 ? std::move(position_m)
                                                            : filter_all(position_m, kDisplacementTaps));
    append(motion.velocity_mps, first_derivative(smooth_m, rate));
    append(motion.acceleration_mps2, second_derivative(smooth_m, rate));
    append(motion.position_m, std::move(smooth_m));
  }
  motion_ = std::make_shared<const Motion>(std::move(motion));
  turning_points_ = turning_points_of(displacement_m_, parts_, 0.0);
}

std::span<const TurningPoint> Measurement::turning_points(std::size_t first, std::size_t count) const {
  const auto at = [&](std::size_t sample) {
    return std::lower_bound(turning_points_.begin(), turning_points_.end(), sample,
                            [](const TurningPoint& point, std::size_t s) { return point.before_sample < s; });
  };
  return {at(first), at(first + count)};
}

void Measurement::find_burn_in(LogPart& part) const {
  const bool is_chunk = part.sample_count < log_samples_[part.log];
  const auto first = position_m().begin() + static_cast<std::ptrdiff_t>(part.first_sample);
  const double needed = burn_in_travel_m(part.log_travel_m);
  const std::size_t settling = part.start_s > 0.0 ? settling_samples(sample_rate_Hz()) : 0;
  double lowest = *first;
  double highest = lowest;
  for (std::size_t i = 0; i < (is_chunk ? part.sample_count : part.sample_count / 4); ++i) {
    const double x = position_m()[part.first_sample + i];
    lowest = std::min(lowest, x);
    highest = std::max(highest, x);
    if (highest - lowest >= needed) {
      part.burn_in = std::min(std::max(i, settling), part.sample_count);
      return;
    }
  }
  // A piece of which the state is never known has no rows: others of its log have.
  if (is_chunk) part.burn_in = part.sample_count;
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
  const std::size_t seen = margin();
  for (LogPart& part : parts_) {
    part.first_row = row_samples_.size();
    const std::size_t known = part.first_sample + part.burn_in + seen;
    const std::size_t begin = std::max(known, own.first);
    const std::size_t end = std::min(known + usable(part), own.end);
    const std::size_t first = (begin + group - 1) / group * group;
    for (std::size_t i = first; i < end; i += row_stride_) row_samples_.push_back(i);
    part.row_count = row_samples_.size() - part.first_row;
  }
  row_usable_ = Eigen::VectorXd::Ones(row_count());
  for (const LogPart& part : parts_) {
    for (const Interval& cut : part.cut) {
      // Rows that see anything of it through the filters.
      const std::size_t from = part.first_sample + cut.first;
      const std::size_t to = part.first_sample + cut.end + seen;
      const auto first =
          std::lower_bound(row_samples_.begin(), row_samples_.end(), from - std::min(from, seen));
      for (auto row = first; row != row_samples_.end() && *row < to; ++row) {
        row_usable_(row - row_samples_.begin()) = 0.0;
      }
    }
  }
  row_weights_ = row_usable_;
}

void Measurement::choose_blocks() {
  fold_count_ = kFolds;
  row_blocks_.reserve(row_samples_.size());
  for (std::size_t log = 0; log < log_count(); ++log) {
    // Each log has as many blocks in one fold as in another, so that its own gains are judged too.
    const Interval own = parts_of_log(log);
    const std::size_t first_row = parts_[own.first].first_row;
    const std::size_t rows = parts_[own.end - 1].first_row + parts_[own.end - 1].row_count - first_row;
    const double share = static_cast<double>(rows) / static_cast<double>(row_samples_.size());
    const int blocks = blocks_of_share(share);
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

std::size_t Measurement::gain_sets(std::string_view effect) const {
  return std::find(per_log_.begin(), per_log_.end(), effect) == per_log_.end() ? 1 : log_count();
}

std::size_t Measurement::part_at(std::size_t index) const {
  std::size_t part = 0;
  while (part + 1 < parts_.size() && index >= parts_[part].end_sample()) ++part;
  return part;
}

double Measurement::weighted_rms(const Eigen::VectorXd& rows) const {
  return std::sqrt(row_weights_.dot(rows.cwiseAbs2()) / row_weights_.sum());
}

Eigen::VectorXd Measurement::filtered(std::span<const double> signal) const {
  RowCollector collector(filter_, row_samples_, 1);
  for (std::size_t first = 0; first < signal.size(); first += collector.chunk()) {
    const std::size_t count = std::min(collector.chunk(), signal.size() - first);
    std::copy_n(signal.begin() + static_cast<std::ptrdiff_t>(first), count, collector.space());
    collector.commit(count);
  }
  return collector.take().col(0);
}

Eigen::VectorXd Measurement::force_N(const MeasurementDynamics& lag) const {
  if (lag.delay_s == 0.0 && lag.filter_s == 0.0) return filtered(log_->force_N);
  // Later by whole samples, then by the rest with the cubic through four of them.
  const double samples = lag.delay_s * sample_rate_Hz();
  const auto whole = static_cast<std::ptrdiff_t>(std::floor(samples));
  const double u = samples - static_cast<double>(whole);
  const std::array<double, 4> weight{-u * (u - 1.0) * (u - 2.0) / 6.0,
                                     (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0,
                                     -(u + 1.0) * u * (u - 2.0) / 2.0, (u + 1.0) * u * (u - 1.0) / 6.0};
  std::vector<double> later(sample_count());
  for (const LogPart& part : parts_) {
    const auto first = static_cast<std::ptrdiff_t>(part.first_sample);
    const auto end = static_cast<std::ptrdiff_t>(part.end_sample());
    for (std::ptrdiff_t i = first; i < end; ++i) {
      double sum = 0.0;
      for (std::ptrdiff_t k = 0; k < 4; ++k) {
        const auto index = std::clamp<std::ptrdiff_t>(i + whole + k - 1, first, end - 1);
        sum += weight[static_cast<std::size_t>(k)] * log_->force_N[static_cast<std::size_t>(index)];
      }
      later[static_cast<std::size_t>(i)] = sum;
    }
    if (lag.filter_s == 0.0) continue;
    const std::span<double> own(later.data() + first, static_cast<std::size_t>(end - first));
    const std::vector<double> slope = first_derivative(own, sample_rate_Hz());
    for (std::size_t i = 0; i < own.size(); ++i) own[i] += lag.filter_s * slope[i];
  }
  return filtered(later);
}

double Measurement::force_noise_gain(const MeasurementDynamics& lag) const {
  const double plain = noise_gain(filter_.taps());
  if (lag.filter_s == 0.0) return std::sqrt(plain);
  // The taps are symmetric, their slope is not: the one is orthogonal to the other.
  const double slope = noise_gain(first_derivative(filter_.taps(), sample_rate_Hz()));
  return std::sqrt(plain + lag.filter_s * lag.filter_s * slope);
}

double Measurement::position_noise_m_per_root_Hz(const LogPart& part) const {
  std::size_t moving = 0;
  for (std::size_t i = part.first_sample + 1; i < part.end_sample(); ++i)
    moving += log_->position_m[i] != log_->position_m[i - 1] ? 1 : 0;
  const double share = static_cast<double>(moving) / static_cast<double>(part.sample_count);
  return part.encoder_resolution_m * std::sqrt(share / 12.0 * 2.0 / sample_rate_Hz());
}

double Measurement::acceleration_noise_mps2(const LogPart& part) const {
  const std::vector<double> both = convolve(motion_taps(bandwidth_Hz_, sample_rate_Hz()), filter_.taps());
  const double gain = noise_gain(second_derivative(both, sample_rate_Hz()));
  return position_noise_m_per_root_Hz(part) * std::sqrt(0.5 * sample_rate_Hz() * gain);
}

double Measurement::force_noise_N() const {
  double sum = 0.0;
  for (const LogPart& part : parts_) {
    sum += static_cast<double>(part.sample_count) * part.force_noise_N * part.force_noise_N;
  }
  return std::sqrt(sum / static_cast<double>(sample_count()));
}

double Measurement::filtered_force_noise_N() const {
  return force_noise_N() * force_noise_gain({});
}

/// Of a period of the force's bandwidth, how long a cubic follows the motion: a quarter of it.
constexpr double kFollowed = 0.25;

Measurement Measurement::with_realisation(const EncoderRealisation& other) const {
  Measurement copy = *this;
  UnobservedMotion unobserved = other.unobserved;
  unobserved.longest_known = kFollowed * sample_rate_Hz() / bandwidth_Hz_;
  std::vector<double> reading_m;
  for (const LogPart& part : parts_) {
    const double step_m = part.encoder_resolution_m;
    if (step_m <= 0.0) continue;
    const auto first = static_cast<std::ptrdiff_t>(part.first_sample);
    reading_m.resize(part.sample_count);
    std::transform(displacement_m_.begin() + first,
                   displacement_m_.begin() + static_cast<std::ptrdiff_t>(part.end_sample()),
                   reading_m.begin(), [&](double x) {
                     return (std::floor(x / step_m + other.shift_steps) + 0.5 - other.shift_steps) * step_m;
                   });
    const std::vector<double> displacement_m = interpolate_between_steps(reading_m, step_m, unobserved);
    std::copy(displacement_m.begin(), displacement_m.end(), copy.displacement_m_.begin() + first);
  }
  copy.turning_points_ = turning_points_of(copy.displacement_m_, parts_, other.beyond_corners);
  return copy;
}

}  // namespace slipstack::workbench
