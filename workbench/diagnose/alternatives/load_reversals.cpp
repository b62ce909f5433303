// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/load_reversals.h"

#include <algorithm>
#include <cmath>

#include "workbench/diagnose/alternatives/stop_operator.h"

namespace slipstack::workbench {
namespace {

/// A time since the last reversal before any [s]: beyond every knot.
constexpr double kNever = 1e12;
/// A change of sign counts when the force exceeds this share of the friction: noise of the acceleration would
/// be many at standstill.
constexpr double kClear = 0.1;

}  // namespace

LoadReversals::LoadReversals(const Parameters& parameters, double tick_s)
    : deceleration_mps2_(std::max(parameters.deceleration_mps2, 1e-12)),
      slip_m_(std::max(parameters.slip_m, 1e-12)),
      tick_s_(tick_s) {}

void LoadReversals::reset(const Sample<double>& sample) {
  position_m_ = sample.position_m;
  deflection_ = 0.0;
  load_ = 0.0;
  side_ = 0.0;
  since_s_ = kNever;
}

void LoadReversals::step(const Sample<double>& sample) {
  deflection_ = moved(deflection_, sample.position_m - position_m_, slip_m_);
  position_m_ = sample.position_m;
  load_ = sample.acceleration_mps2 / deceleration_mps2_ + deflection_;
  since_s_ += tick_s_;
  if (std::abs(load_) < kClear) return;
  const double now = load_ > 0.0 ? 1.0 : -1.0;
  if (side_ != 0.0 && now != side_) since_s_ = 0.0;
  side_ = now;
}

}  // namespace slipstack::workbench
