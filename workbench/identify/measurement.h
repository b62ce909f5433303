// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/effects/effect.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

/// How a log is conditioned. Zero: chosen from the log.
struct ConditioningOptions {
  double bandwidth_Hz = 0.0;       ///< of the filter that force and regressors share
  std::size_t maximum_rows = 40000;  ///< filtered instants kept for the regression
};

/// A log made ready for inverse-dynamics identification ([5], IDIM): smooth motion at every sample, and the
/// force seen through one zero-phase low-pass at a set of instants, the *rows*. Whatever is compared with the
/// force goes through the same filter first (filtered()).
class Measurement {
 public:
  explicit Measurement(Log log, const ConditioningOptions& options = {});

  const Log& log() const { return log_; }
  std::size_t sample_count() const { return log_.position_m.size(); }
  double sample_rate_Hz() const { return log_.sample_rate_Hz; }
  double tick_s() const { return 1.0 / log_.sample_rate_Hz; }
  double duration_s() const { return static_cast<double>(sample_count()) * tick_s(); }
  double bandwidth_Hz() const { return bandwidth_Hz_; }
  double encoder_resolution_m() const { return encoder_resolution_m_; }

  // Smooth motion, one value per sample.
  const std::vector<double>& position_m() const { return position_m_; }
  const std::vector<double>& velocity_mps() const { return velocity_mps_; }
  const std::vector<double>& acceleration_mps2() const { return acceleration_mps2_; }

  /// What the effects know at sample `index`; time counts from the start of the log.
  Sample<double> sample(std::size_t index) const;

  // Rows.
  Eigen::Index row_count() const { return static_cast<Eigen::Index>(row_samples_.size()); }
  const std::vector<std::size_t>& row_samples() const { return row_samples_; }
  /// Contiguous block of each row; blocks and their folds depend on the log alone.
  const std::vector<int>& row_blocks() const { return row_blocks_; }
  int block_count() const { return block_count_; }
  int fold_of_block(int block) const { return block % fold_count_; }
  int fold_count() const { return fold_count_; }

  /// The measured force at the rows; with a delay, what was measured that much later.
  Eigen::VectorXd force_N(double delay_s = 0.0) const;
  /// Any signal with a value per sample, at the rows.
  Eigen::VectorXd filtered(std::span<const double> signal) const;
  /// Taps of the filter.
  const std::vector<double>& taps() const { return taps_; }
  std::size_t row_stride() const { return row_stride_; }

  // Noise.
  /// Standard deviation of white noise on the force before the filter, from differences of sixth order.
  double force_noise_N() const { return force_noise_N_; }
  /// Standard deviation, at the rows, of force noise and of encoder quantisation, the latter seen through
  /// `mass_kg` and through a stiffness for each row (the tangent stiffness of the hysteresis there).
  double noise_floor_N(double mass_kg, const Eigen::VectorXd& stiffness_N_per_m) const;

  /// A mass good enough to choose the bandwidth: the header's, or a quick regression.
  double rough_mass_kg() const { return rough_mass_kg_; }

 private:
  void estimate_noise();
  void estimate_motion();
  void choose_bandwidth(double wished_Hz);
  void choose_rows(std::size_t maximum_rows);

  Log log_;
  double encoder_resolution_m_ = 0.0;
  double bandwidth_Hz_ = 0.0;
  double force_noise_N_ = 0.0;
  double rough_mass_kg_ = 0.0;
  std::vector<double> displacement_m_;
  std::vector<double> position_m_;
  std::vector<double> velocity_mps_;
  std::vector<double> acceleration_mps2_;
  std::vector<double> taps_;
  std::vector<double> motion_taps_;
  std::size_t row_stride_ = 1;
  std::vector<std::size_t> row_samples_;
  std::vector<int> row_blocks_;
  int block_count_ = 0;
  int fold_count_ = 0;
};

}  // namespace slipstack::workbench
