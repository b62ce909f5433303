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
#include "workbench/estimate/measurement/parts.h"
#include "workbench/log/log.h"
#include "workbench/signal/encoder_interpolation.h"
#include "workbench/signal/row_filter.h"
#include "workbench/signal/turning_points.h"

namespace slipstack::workbench {

/// Longest pre-sliding travel of a rolling guideway that is looked for.
inline constexpr double kLongestSlip_m = 2e-3;

/// Travel after which the state of the hysteresis is known, of a log that travels so far in all.
inline double burn_in_travel_m(double log_travel_m) {
  return std::min(2.0 * kLongestSlip_m, 0.95 * log_travel_m);
}

/// Samples at the start of a piece of a log after which what swings or follows late has forgotten a state
/// that is not known: two seconds, or so many as a piece can spare.
inline std::size_t settling_samples(double sample_rate_Hz) {
  return static_cast<std::size_t>(std::min(2.0 * sample_rate_Hz, 10240.0));
}

/// Cross-validation: a block is of fold block % kFolds. A log that is this share of all is cut into so many
/// blocks, as many in one fold as in another.
inline constexpr int kFolds = 5;
int blocks_of_share(double share);

/// How a log is conditioned. Zero: chosen from the log.
struct ConditioningOptions {
  double bandwidth_Hz = 0.0;         ///< of the filter that force and regressors share
  std::size_t maximum_rows = 40000;  ///< filtered instants kept for the regression
  /// Effects whose gains are each log's own where there are several.
  std::vector<std::string> per_log = effects_of_each_log();
  /// Standard deviation of the force's noise before the filter; zero: estimated.
  double force_noise_N = 0.0;
};

/// What the recorded force went through after the axis: a delay, then a first-order low pass.
struct MeasurementDynamics {
  double delay_s = 0.0;
  double filter_s = 0.0;  ///< time constant
  double total_s() const { return delay_s + filter_s; }
};

struct RowRange {
  Eigen::Index first = 0;
  Eigen::Index count = 0;
};

/// How else an encoder of equal resolution may have come to its readings.
struct EncoderRealisation {
  double shift_steps = 0.0;          ///< of its grid
  UnobservedMotion unobserved = {};  ///< how long a stay is known follows from the bandwidth
  double beyond_corners = 0.0;       ///< of a zigzag: see find_turning_points()
};

/// A log made ready for inverse-dynamics identification ([5], IDIM): smooth motion at every sample, and the
/// force seen through one zero-phase low-pass at a set of instants, the *rows*. Whatever is compared with the
/// force goes through the same filter first (filtered()). Several logs of one axis lie one after another, as
/// parts(): no filter and no effect's memory reaches from one to the next, and each has blocks in every fold.
class Measurement {
 public:
  explicit Measurement(Log log, const ConditioningOptions& options = {});
  explicit Measurement(std::vector<Log> logs, const ConditioningOptions& options = {});
  /// Pieces of long logs, each with a memory of its own.
  explicit Measurement(std::vector<LogChunk> pieces, const ConditioningOptions& options = {});
  /// A piece conditioned exactly as `like` was, which has its log: the same filter, noise and gain sets. Its
  /// blocks are the samples from each of `borders` to the next, counted from its first; rows fall only there.
  Measurement(LogChunk piece, const Measurement& like, const std::vector<std::size_t>& borders);

  /// The logs, in the order in which they were given, or pieces of them.
  const std::vector<LogPart>& parts() const { return parts_; }
  std::size_t log_count() const { return log_samples_.size(); }
  /// Samples of one log, whatever part of it is here.
  std::size_t log_sample_count(std::size_t log) const { return log_samples_[log]; }
  /// Samples of all logs, of which these are parts.
  std::size_t whole_sample_count() const;
  bool is_excerpt() const { return whole_sample_count() > sample_count(); }
  /// Parts [first, end) of one log; none where a piece of another is all that is here.
  Interval parts_of_log(std::size_t log) const;
  RowRange rows_of_log(std::size_t log) const;
  /// Calls visit(part index, first sample, count) for each part of the samples [first, first + count).
  template <class Visit>
  void each_part(std::size_t first, std::size_t count, Visit&& visit) const {
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const std::size_t from = std::max(first, parts_[p].first_sample);
      const std::size_t to = std::min(first + count, parts_[p].end_sample());
      if (from < to) visit(p, from, to - from);
    }
  }
  /// How many sets of gains an effect has: one, or one for each log.
  std::size_t gain_sets(std::string_view effect) const;

  const Log& log() const { return *log_; }
  std::size_t sample_count() const { return log_->position_m.size(); }
  double sample_rate_Hz() const { return sample_rate_Hz_; }
  double tick_s() const { return 1.0 / sample_rate_Hz_; }
  /// Of all logs.
  double duration_s() const { return static_cast<double>(whole_sample_count()) * tick_s(); }
  double bandwidth_Hz() const { return bandwidth_Hz_; }
  double encoder_resolution_m() const { return encoder_resolution_m_; }

  // Smooth motion, one value per sample.
  const std::vector<double>& position_m() const { return motion_->position_m; }
  const std::vector<double>& velocity_mps() const { return motion_->velocity_mps; }
  const std::vector<double>& acceleration_mps2() const { return motion_->acceleration_mps2; }

  /// What the effects know at sample `index`; time counts from the start of its log.
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
  std::size_t part_at(std::size_t index) const;
  /// Turning points before samples [first, first + count).
  std::span<const TurningPoint> turning_points(std::size_t first, std::size_t count) const;
  /// Time of a sample since the start of the first log, as if the logs followed each other.
  double time_s(std::size_t index) const;

  // Rows.
  Eigen::Index row_count() const { return static_cast<Eigen::Index>(row_samples_.size()); }
  const std::vector<std::size_t>& row_samples() const { return row_samples_; }
  /// Contiguous block of each row; blocks and their folds depend on the log alone.
  const std::vector<int>& row_blocks() const { return row_blocks_; }
  int block_count() const { return block_count_; }
  int fold_of_block(int block) const { return block % fold_count_; }
  int fold_count() const { return fold_count_; }

  /// Start of the log that has no rows, because the state of the hysteresis is not known there: until the
  /// axis has swept twice the longest slip distance, or nearly all of its travel. At most a quarter of the
  /// log; of several logs the longest.
  double burn_in_s() const;

  /// Weights of the rows, one each unless weigh_rows() was called: small where quantisation tells much less
  /// than the noise of the force would. Errors are weighted rms values.
  const Eigen::VectorXd& row_weights() const { return row_weights_; }
  void set_row_weights(const Eigen::VectorXd& weights) { row_weights_ = weights.cwiseProduct(row_usable_); }
  /// One for rows that count, zero for those that see what mend() cut out.
  const Eigen::VectorXd& row_usable() const { return row_usable_; }
  /// sqrt of the weighted mean of squares of a signal at the rows.
  double weighted_rms(const Eigen::VectorXd& rows) const;

  /// The force at the rows before it went through `lag`: F + filter dF/dt, measured later by the delay.
  Eigen::VectorXd force_N(const MeasurementDynamics& lag = {}) const;
  /// Any signal with a value per sample, at the rows.
  Eigen::VectorXd filtered(std::span<const double> signal) const;
  /// The filter between samples and rows.
  const RowFilter& filter() const { return filter_; }
  std::size_t row_stride() const { return row_stride_; }
  /// Samples at either end of a part that are only seen through filters.
  std::size_t margin() const;

  /// Slip distances to identify hysteresis with; empty: spread evenly over the decades. weigh_rows() puts
  /// them where this log's virgin curve bends.
  const std::vector<double>& slip_distances_m() const { return slip_distances_m_; }
  void set_slip_distances(std::vector<double> slip_m) { slip_distances_m_ = std::move(slip_m); }

  // Noise.
  /// Standard deviation of white noise on the force before the filter, from differences of sixth order or as
  /// given; of several logs the rms.
  double force_noise_N() const;
  bool force_noise_given() const { return force_noise_given_; }
  /// What the filter leaves of it at the rows.
  double filtered_force_noise_N() const;
  /// White noise of the force at the rows of force_N(lag), over what it is before: the low pass lies before
  /// the noise, its inverse makes the noise louder.
  double force_noise_gain(const MeasurementDynamics& lag) const;
  /// What encoder quantisation leaves in the acceleration at the rows of a log: white while the axis moves.
  double acceleration_noise_mps2(const LogPart& part) const;
  /// One-sided density of a position's error by quantisation, white while the axis moves [m/sqrt(Hz)]; times
  /// (2 pi f)^2 it is that of the acceleration.
  double position_noise_m_per_root_Hz(const LogPart& part) const;
  /// The same measurement with another displacement that the encoder's readings allow: what the hysteresis
  /// says differently there is what quantisation costs where the axis is slow.
  Measurement with_realisation(const EncoderRealisation& other) const;

 private:
  struct Motion {
    std::vector<double> position_m;
    std::vector<double> velocity_mps;
    std::vector<double> acceleration_mps2;
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

  // Copies share what never changes: other readings (requantised()) have another displacement alone.
  std::shared_ptr<const Log> log_;
  double sample_rate_Hz_ = 0.0;
  std::vector<LogPart> parts_;
  std::vector<std::size_t> log_samples_;
  std::vector<std::string> per_log_;
  double encoder_resolution_m_ = 0.0;
  double bandwidth_Hz_ = 0.0;
  bool force_noise_given_ = false;
  std::vector<double> slip_distances_m_;
  std::vector<double> displacement_m_;  ///< what drives the hysteresis: as read, between the steps
  std::vector<TurningPoint> turning_points_;
  std::shared_ptr<const Motion> motion_;
  RowFilter filter_;
  std::size_t row_stride_ = 1;
  std::vector<std::size_t> row_samples_;
  std::vector<int> row_blocks_;
  Eigen::VectorXd row_usable_;
  Eigen::VectorXd row_weights_;
  int block_count_ = 0;
  int fold_count_ = 0;
};

}  // namespace slipstack::workbench
