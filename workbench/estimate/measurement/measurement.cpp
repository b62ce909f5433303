// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/measurement/measurement.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "workbench/estimate/measurement/conditioning.h"
#include "workbench/signal/noise_estimate.h"
#include "workbench/signal/rough_mass.h"

namespace slipstack::workbench {

Measurement::Measurement(Log log, const ConditioningOptions& options)
    : Measurement(std::vector<Log>{std::move(log)}, options) {}

Measurement::Measurement(std::vector<Log> logs, const ConditioningOptions& options)
    : Measurement(join(std::move(logs)), options) {}

Measurement::Measurement(std::vector<LogChunk> chunks, const ConditioningOptions& options)
    : Measurement(join(std::move(chunks)), options) {}

Measurement::Measurement(LogChunk chunk, const Measurement& like, const std::vector<std::size_t>& borders)
    : log_samples_(like.log_samples_),
      per_log_(like.per_log_),
      bandwidth_Hz_(like.bandwidth_Hz_),
      force_cut_Hz_(like.force_cut_Hz_),
      force_noise_given_(true),
      row_stride_(like.row_stride_) {
  const LogPart& same = like.parts_[like.parts_of_log(chunk.log_index).first];
  std::vector<LogChunk> chunks;
  chunks.push_back(std::move(chunk));
  JoinedLogs joined = join(std::move(chunks));
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
    const auto next_border = std::upper_bound(borders.begin(), borders.end(), sample);
    row_blocks_.push_back(static_cast<int>(next_border - borders.begin()) - 1);
  }
}

Measurement::Measurement(JoinedLogs joined, const ConditioningOptions& options)
    : parts_(std::move(joined.parts)),
      log_samples_(std::move(joined.log_samples)),
      per_log_(options.per_log) {
  take_log(std::move(joined.log));
  encoder_resolution_m_ = log_->encoder_resolution_m.value_or(0.0);
  force_cut_Hz_ = options.force_cut_Hz;
  force_noise_given_ = options.force_noise_N > 0.0;
  for (LogPart& part : parts_) {
    const std::vector<double> force_N = part_of(log_->force_N, part);
    part.rough_mass_kg = part.mass_kg ? *part.mass_kg
                                      : rough_mass_kg(part_of(log_->position_m, part), force_N,
                                                      sample_rate_Hz(), part.encoder_resolution_m, part.cut);
    part.force_noise_N = force_noise_given_ ? options.force_noise_N : noise_of_samples(force_N, part.cut);
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

double Measurement::longest_log_s() const {
  return static_cast<double>(*std::max_element(log_samples_.begin(), log_samples_.end())) * tick_s();
}

double Measurement::time_s(std::size_t index) const {
  const LogPart& part = parts_[part_at(index)];
  std::size_t before = index - part.first_sample;
  for (std::size_t log = 0; log < part.log; ++log) before += log_samples_[log];
  return part.start_s + static_cast<double>(before) * tick_s();
}

std::size_t Measurement::gain_sets(std::string_view effect) const {
  return std::find(per_log_.begin(), per_log_.end(), effect) == per_log_.end() ? 1 : log_count();
}

void Measurement::take_samples(std::size_t part, std::size_t first, std::span<Sample<double>> samples) const {
  // By way of locals: the compiler would have to reload members after each sample that is written.
  const double start_s = parts_[part].start_s;
  // Signed: processors turn such integers into doubles in one instruction.
  const auto from = static_cast<std::ptrdiff_t>(first - parts_[part].first_sample);
  const double tick = tick_s();
  const double* const displacement = displacement_m_.data() + first;
  const double* const position_m = motion_->position_m.data() + first;
  const double* const velocity_mps = motion_->velocity_mps.data() + first;
  const double* const acceleration_mps2 = motion_->acceleration_mps2.data() + first;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    Sample<double>& sample = samples[i];
    sample.time_s = start_s + static_cast<double>(from + static_cast<std::ptrdiff_t>(i)) * tick;
    sample.displacement = displacement[i];
    sample.position_m = position_m[i];
    sample.velocity_mps = velocity_mps[i];
    sample.acceleration_mps2 = acceleration_mps2[i];
  }
}

std::size_t Measurement::part_at(std::size_t index) const {
  std::size_t part = 0;
  while (part + 1 < parts_.size() && index >= parts_[part].end_sample()) ++part;
  return part;
}

}  // namespace slipstack::workbench
