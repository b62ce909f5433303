// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/effects/effect.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/statistics.h"
#include "workbench/estimate/measurement/parts.h"
#include "workbench/log/log.h"
#include "workbench/signal/encoder_interpolation.h"
#include "workbench/signal/row_filter.h"
#include "workbench/signal/turning_points.h"

namespace slipstack::workbench {

/// Longest pre-sliding travel that is identified; that of a rolling guideway is chosen as 2 mm.
inline double longest_slip_m() {
  return axis_length(2e-3);
}

/// Travel after which the state of the hysteresis is known, for a log with this travel in all.
inline double burn_in_travel_m(double log_travel_m) {
  return std::min(2.0 * longest_slip_m(), 0.95 * log_travel_m);
}

/// Samples at the start of a chunk after which dynamic effects (vibrations, lags) no longer depend on their
/// unknown initial state: two seconds, but no more than a chunk can spare.
inline std::size_t settling_samples(double sample_rate_Hz) {
  return static_cast<std::size_t>(std::min(2.0 * sample_rate_Hz, 10240.0));
}

/// Cross-validation: a block belongs to fold block % kFolds. blocks_of_share() is the number of blocks of a
/// log that makes up this share of all rows, equally many in every fold.
inline constexpr int kFolds = 5;
int blocks_of_share(double share);

/// How a log is conditioned. Zero means chosen from the log.
struct ConditioningOptions {
  double bandwidth_Hz = 0.0;  ///< of the filter that force and regressors share
  /// Where the force was low-passed alone before it was recorded (half of the amplitude); zero: not known.
  double force_cut_Hz = 0.0;
  std::size_t maximum_rows = 40000;  ///< filtered instants kept for the regression
  /// Effects whose gains are fitted for each log separately.
  std::vector<std::string> per_log = effects_of_each_log();
  /// Standard deviation of the force's noise before the filter; zero: estimated.
  double force_noise_N = 0.0;
};

/// The dynamics between the force on the axis and its recorded value: a delay, then a first-order low pass.
struct MeasurementDynamics {
  double delay_s = 0.0;
  double filter_s = 0.0;  ///< time constant
  double total_s() const { return delay_s + filter_s; }
};

struct RowRange {
  Eigen::Index first = 0;
  Eigen::Index count = 0;
};

/// Another realisation of the quantisation error: a motion, and an encoder of equal resolution, that would
/// have given readings like the recorded ones.
struct EncoderRealisation {
  double shift_steps = 0.0;          ///< of the encoder's grid
  UnobservedMotion unobserved = {};  ///< its longest_known is set from the bandwidth
  double beyond_corners = 0.0;       ///< of a zigzag: see find_turning_points()
};

/// A log prepared for inverse-dynamics identification ([5], IDIM): smooth motion at every sample, and the
/// force after a zero-phase low pass at a set of instants, the *rows*. Whatever is compared with the force
/// passes the same filter first (filtered()). Several logs of one axis lie one after another, as parts(): no
/// filter and no memory of an effect reaches from one to the next, and each has blocks in every fold.
class Measurement {
 public:
  explicit Measurement(Log log, const ConditioningOptions& options = {});
  explicit Measurement(std::vector<Log> logs, const ConditioningOptions& options = {});
  /// Chunks of long logs; the state of every effect is reset at the start of each.
  explicit Measurement(std::vector<LogChunk> chunks, const ConditioningOptions& options = {});
  /// A chunk conditioned exactly as `like` was, which contains the same log: the same filter, noise and gain
  /// sets. Its blocks are the samples from each of `borders` to the next, counted from its first; rows lie
  /// only there.
  Measurement(LogChunk chunk, const Measurement& like, const std::vector<std::size_t>& borders);

  /// The logs, in the order in which they were given, or chunks of them.
  const std::vector<LogPart>& parts() const { return parts_; }
  std::size_t log_count() const { return log_samples_.size(); }
  /// Samples of one whole log, whatever part of it this measurement contains.
  std::size_t log_sample_count(std::size_t log) const { return log_samples_[log]; }
  /// Samples of all whole logs.
  std::size_t whole_sample_count() const;
  bool is_excerpt() const { return whole_sample_count() > sample_count(); }
  /// Parts [first, end) of one log; empty where this measurement contains none of it.
  Interval parts_of_log(std::size_t log) const;
  RowRange rows_of_log(std::size_t log) const;
  /// Number of gain sets of an effect: one, or one for each log.
  std::size_t gain_sets(std::string_view effect) const;

  const Log& log() const { return *log_; }
  std::size_t sample_count() const { return log_->position_m.size(); }
  double sample_rate_Hz() const { return sample_rate_Hz_; }
  double tick_s() const { return 1.0 / sample_rate_Hz_; }
  /// Duration of all whole logs together.
  double duration_s() const { return static_cast<double>(whole_sample_count()) * tick_s(); }
  /// Duration of the longest whole log.
  double longest_log_s() const;
  double bandwidth_Hz() const { return bandwidth_Hz_; }
  /// That of the options.
  double force_cut_Hz() const { return force_cut_Hz_; }
  double encoder_resolution_m() const { return encoder_resolution_m_; }

  // Smooth motion, one value per sample.
  const std::vector<double>& position_m() const { return motion_->position_m; }
  ValueRange position_range_m() const { return motion_->range_m; }
  const std::vector<double>& velocity_mps() const { return motion_->velocity_mps; }
  const std::vector<double>& acceleration_mps2() const { return motion_->acceleration_mps2; }

  /// The input of the effects at sample `index`; time counts from the start of its log.
  Sample<double> sample(std::size_t index) const { return sample(index, part_at(index)); }
  Sample<double> sample(std::size_t index, std::size_t part) const {
    Sample<double> sample;
    sample.time_s = parts_[part].start_s +
                    static_cast<double>(index - parts_[part].first_sample) * (1.0 / sample_rate_Hz_);
    sample.displacement = displacement_m_[index];
    sample.position_m = motion_->position_m[index];
    sample.velocity_mps = motion_->velocity_mps[index];
    sample.acceleration_mps2 = motion_->acceleration_mps2[index];
    return sample;
  }
  /// Samples of one part from `first` on, as many as there is room for. What is not of the log keeps its
  /// value.
  void take_samples(std::size_t part, std::size_t first, std::span<Sample<double>> samples) const;
  std::size_t part_at(std::size_t index) const;
  /// Turning points before samples [first, first + count).
  std::span<const TurningPoint> turning_points(std::size_t first, std::size_t count) const;
  /// Time of a sample since the start of the first log, as if the logs followed each other.
  double time_s(std::size_t index) const;

  // Rows.
  Eigen::Index row_count() const { return static_cast<Eigen::Index>(row_samples_.size()); }
  const std::vector<std::size_t>& row_samples() const { return row_samples_; }
  /// Block of each row; blocks are contiguous, and they and their folds depend on the log alone.
  const std::vector<int>& row_blocks() const { return row_blocks_; }
  int block_count() const { return block_count_; }
  int fold_of_block(int block) const { return block % fold_count_; }
  int fold_count() const { return fold_count_; }

  /// Duration at the start of the log that has no rows, because the state of the hysteresis is unknown there:
  /// until the axis has travelled twice the longest slip distance, or nearly all of its travel. At most a
  /// quarter of the log; of several logs the longest.
  double burn_in_s() const;

  /// Weights of the rows; all one unless weigh_rows() was called. They are small where the error by
  /// quantisation is large against the noise of the force. Errors are weighted rms values.
  const Eigen::VectorXd& row_weights() const { return row_weights_; }
  void set_row_weights(const Eigen::VectorXd& weights) {
    row_weights_ = weights.cwiseProduct(row_usable_);
    fit_weights_ = row_weights_;
  }
  /// Weights by which models are fitted: lower than row_weights(), by which they are judged, where a robust
  /// fit has found outliers.
  const Eigen::VectorXd& fit_weights() const { return fit_weights_; }
  void set_fit_weights(const Eigen::VectorXd& weights) { fit_weights_ = weights.cwiseProduct(row_usable_); }
  /// Variance of what no model can explain, at each row [N^2], and its weighted root over all rows, or those
  /// of one log [N]: the noise floor, as high as the best model that is known leaves room for. Known after
  /// weigh_rows().
  const Eigen::VectorXd& noise_variance() const;
  void set_noise_variance(Eigen::VectorXd variance) { noise_variance_ = std::move(variance); }
  double noise_floor_N() const;
  /// What the noise floor was found from, kept so that a better model can lower it (lower_noise_floor()).
  struct NoiseReadings {
    std::vector<double> mass_kg;             ///< of each log, through which the encoder's steps are a force
    std::vector<Eigen::VectorXd> changes_N;  ///< of the hysteresis force, one for each encoder realisation
  };
  /// Null before weigh_rows().
  const NoiseReadings* noise_readings() const { return noise_readings_.get(); }
  void set_noise_readings(NoiseReadings readings) {
    noise_readings_ = std::make_shared<const NoiseReadings>(std::move(readings));
  }
  double noise_floor_of_log_N(std::size_t log) const;
  /// One for usable rows, zero for those to which the filters carry samples that repair() cut out.
  const Eigen::VectorXd& row_usable() const { return row_usable_; }
  /// Square root of the weighted mean square of a signal at the rows.
  double weighted_rms(const Eigen::VectorXd& rows) const;

  /// The force at the rows before it passed `lag`: F + filter dF/dt, read later by the delay.
  Eigen::VectorXd force_N(const MeasurementDynamics& lag = {}) const;
  /// Any signal with a value per sample, at the rows.
  Eigen::VectorXd filtered(std::span<const double> signal) const;
  /// The filter between samples and rows.
  const RowFilter& filter() const { return filter_; }
  std::size_t row_stride() const { return row_stride_; }
  double row_rate_Hz() const { return sample_rate_Hz_ / static_cast<double>(row_stride_); }
  /// Samples at either end of a part that serve only as input of the filters.
  std::size_t margin() const;

  /// Slip distances with which hysteresis is identified; empty: evenly spaced in the logarithm. weigh_rows()
  /// places them densely where the virgin curve of this log is curved.
  const std::vector<double>& slip_distances_m() const { return slip_distances_m_; }
  void set_slip_distances(std::vector<double> slip_m) { slip_distances_m_ = std::move(slip_m); }

  // Noise.
  /// Standard deviation of the white noise of the force before the filter, estimated from sixth-order
  /// differences, or as given; of several logs the rms.
  double force_noise_N() const;
  bool force_noise_given() const { return force_noise_given_; }
  /// The same after the filter, at the rows.
  double filtered_force_noise_N() const;
  /// Standard deviation of white force noise at the rows of force_N(lag), relative to that before the filter.
  /// The low pass acts before the noise is added, so that its inverse amplifies the noise.
  double force_noise_gain(const MeasurementDynamics& lag) const;
  /// Standard deviation of the acceleration's error by quantisation at the rows of a part, white while it
  /// moves.
  double acceleration_noise_mps2(const LogPart& part) const;
  /// One-sided density of the position's error by quantisation, white while the axis moves [m/sqrt(Hz)].
  /// Multiplied by (2 pi f)^2 it is that of the acceleration.
  double position_noise_m_per_root_Hz(const LogPart& part) const;
  /// The same measurement with another displacement that is consistent with the encoder's resolution. The
  /// difference of the hysteresis forces is the error by quantisation where the axis is slow.
  Measurement with_realisation(const EncoderRealisation& other) const;
  /// What rounding makes of the smooth motion: the error of an encoder of equal resolution, with its grid
  /// shifted by a share of a step, that reads the smooth motion [m]; at every sample, zero in a log without a
  /// resolution.
  std::vector<double> rounding_m(double shift_steps) const;
  /// The same rows of a log with this smooth motion and this force, one value for each sample.
  Measurement with_motion(std::vector<double> position_m, std::vector<double> force_N) const;

 private:
  struct Motion {
    std::vector<double> position_m;
    std::vector<double> velocity_mps;
    std::vector<double> acceleration_mps2;
    ValueRange range_m;  ///< of the position
  };
  void take_log(Log log);
  void estimate_motion();
  void share_noise();
  void find_burn_in(LogPart& part) const;
  void choose_stride(std::size_t maximum_rows);
  void choose_rows(Interval own);
  void choose_blocks();
  std::size_t usable(const LogPart& part) const;

  Measurement(JoinedLogs joined, const ConditioningOptions& options);

  // Shared between copies: with_realisation() changes the displacement alone.
  std::shared_ptr<const Log> log_;
  double sample_rate_Hz_ = 0.0;
  std::vector<LogPart> parts_;
  std::vector<std::size_t> log_samples_;
  std::vector<std::string> per_log_;
  double encoder_resolution_m_ = 0.0;
  double bandwidth_Hz_ = 0.0;
  double force_cut_Hz_ = 0.0;
  bool force_noise_given_ = false;
  std::vector<double> slip_distances_m_;
  std::vector<double> displacement_m_;  ///< input of the hysteresis: readings interpolated between the steps
  std::vector<TurningPoint> turning_points_;
  std::shared_ptr<const Motion> motion_;
  RowFilter filter_;
  std::size_t row_stride_ = 1;
  std::vector<std::size_t> row_samples_;
  std::vector<int> row_blocks_;
  std::shared_ptr<const Eigen::VectorXd> recorded_force_N_;  ///< at the rows: every fit asks for it
  Eigen::VectorXd row_usable_;
  Eigen::VectorXd row_weights_;
  Eigen::VectorXd fit_weights_;
  Eigen::VectorXd noise_variance_;
  std::shared_ptr<const NoiseReadings> noise_readings_;
  int block_count_ = 0;
  int fold_count_ = 0;
};

}  // namespace slipstack::workbench
