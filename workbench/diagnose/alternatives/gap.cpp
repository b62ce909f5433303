// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/gap.h"

#include <algorithm>
#include <cmath>

#include "workbench/diagnose/alternatives/stop_operator.h"

namespace slipstack::workbench {

GapInDrive::GapInDrive(const Parameters& parameters, double tick_s)
    : half_gap_m_(0.5 * parameters.gap_m),
      deceleration_mps2_(parameters.deceleration_mps2),
      slip_m_(std::max(parameters.slip_m, 1e-12)),
      tick_s_(tick_s) {
  // Before the friction has developed the free carriage swings on it: a few steps in each radian.
  const double per_tick = tick_s_ * std::sqrt(deceleration_mps2_ / slip_m_);
  substeps_ = static_cast<int>(std::clamp(std::ceil(4.0 * per_tick), 1.0, 16.0));
}

void GapInDrive::reset(const Sample<double>& sample) {
  flank_ = 0;
  motor_m_ = sample.position_m;
  carriage_m_ = sample.position_m;
  carriage_mps_ = sample.velocity_mps;
  deflection_ = 0.0;
  rigid_deflection_ = 0.0;
}

double GapInDrive::in_contact(const Sample<double>& sample) {
  const double before_m = carriage_m_;
  carriage_m_ = sample.position_m - flank_ * half_gap_m_;
  carriage_mps_ = sample.velocity_mps;
  deflection_ = moved(deflection_, carriage_m_ - before_m, slip_m_);
  const double push_mps2 = sample.acceleration_mps2 + deceleration_mps2_ * deflection_;
  if (flank_ * push_mps2 >= 0.0) return push_mps2;
  flank_ = 0;
  return 0.0;
}

double GapInDrive::in_gap(const Sample<double>& sample) {
  const double step_s = tick_s_ / substeps_;
  for (int i = 0; i < substeps_; ++i) {
    carriage_mps_ -= deceleration_mps2_ * deflection_ * step_s;
    carriage_m_ += carriage_mps_ * step_s;
    deflection_ = moved(deflection_, carriage_mps_ * step_s, slip_m_);
  }
  const double ahead_m = sample.position_m - carriage_m_;
  if (std::abs(ahead_m) < half_gap_m_) return 0.0;
  flank_ = ahead_m > 0.0 ? 1 : -1;
  const double impact_mps = sample.velocity_mps - carriage_mps_;
  carriage_m_ = sample.position_m - flank_ * half_gap_m_;
  carriage_mps_ = sample.velocity_mps;
  return impact_mps / tick_s_;
}

double GapInDrive::step(const Sample<double>& sample) {
  rigid_deflection_ = moved(rigid_deflection_, sample.position_m - motor_m_, slip_m_);
  motor_m_ = sample.position_m;
  const double with_gap_mps2 = flank_ == 0 ? in_gap(sample) : in_contact(sample);
  return with_gap_mps2 - (sample.acceleration_mps2 + deceleration_mps2_ * rigid_deflection_);
}

}  // namespace slipstack::workbench
