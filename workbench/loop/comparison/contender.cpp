// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/contender.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "workbench/loop/comparison/known_friction.h"
#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {
namespace {

using Hysteresis = EffectParameters<PreslidingHysteresis<float>, float>;
using Mass = EffectParameters<Inertia<float>, float>;

/// The force of the contender's friction model along the reference, N: in the middle of each tick, over which
/// it is held, as slipstack's own.
std::vector<double> friction_along(const Contender& contender, const Trajectory& trajectory) {
  const FrictionFit& fit = *contender.friction;
  SampledMotion motion;
  motion.step_s = trajectory.tick_s;
  for (const sim::MotionPoint& point : trajectory.points) {
    const double gained_mps = 0.5 * trajectory.tick_s * point.a_mps2;
    motion.position_m.push_back(point.x_m + 0.5 * trajectory.tick_s * (point.v_mps + 0.5 * gained_mps));
    motion.velocity_mps.push_back(point.v_mps + gained_mps);
  }
  const Eigen::MatrixXd columns = model_columns(fit.kind, fit.shape, fit.slips_m, motion);
  const double offset_N = fit.gains[fit.gains.size() - 1];
  const Eigen::VectorXd force_N =
      contender.level * (columns * fit.gains.head(columns.cols())).array() + offset_N;
  return {force_N.begin(), force_N.end()};
}

void learn(const Contender& contender, const Trajectory& trajectory, const DriveRun& run,
           std::vector<double>& learned_N) {
  const std::vector<double> taps = low_pass_taps(contender.learning_cutoff_Hz, 1.0 / trajectory.tick_s);
  learned_N.resize(trajectory.size(), 0.0);
  for (std::size_t i = 0; i < run.feedback_N.size(); ++i)
    learned_N[i] += contender.learning_gain * run.feedback_N[i];
  learned_N = filter_all(learned_N, taps);
}

}  // namespace

Compensation compensation_on(const Contender& contender, const sim::Axis& axis,
                             const Trajectory& trajectory) {
  Compensation compensation;
  compensation.own_model = contender.own_model;
  compensation.mass_share = contender.mass_share;
  if (contender.friction) compensation.friction_N = friction_along(contender, trajectory);
  if (contender.bound()) compensation.friction_N = known_friction_N(axis, trajectory);
  return compensation;
}

DriveRun run(const Contender& contender, const sim::Axis& axis, const Trajectory& trajectory,
             std::uint64_t noise_seed) {
  if (!contender.bound())
    return run(contender, axis, trajectory, compensation_on(contender, axis, trajectory), noise_seed);
  sim::Axis other = axis;
  other.force_noise_N *= contender.noise_share;
  other.encoder_resolution_m *= contender.encoder_share;
  Contender on_it = contender;
  on_it.axis.encoder_resolution_m = static_cast<float>(other.encoder_resolution_m);
  return run(on_it, other, trajectory, compensation_on(contender, axis, trajectory), noise_seed);
}

DriveRun run(const Contender& contender, const sim::Axis& axis, const Trajectory& trajectory,
             Compensation compensation, std::uint64_t noise_seed) {
  AxisParameters parameters = contender.axis;
  parameters.disturbance_share = static_cast<float>(contender.observer_share);
  DriveRun last;
  for (int i = 0; i < contender.repetitions; ++i) {
    if (i > 0) learn(contender, trajectory, last, compensation.learned_N);
    const ComparedDrive drive(axis, parameters, contender.model, noise_seed + static_cast<std::uint64_t>(i));
    last = drive.run(trajectory, compensation);
    if (last.lost) break;
  }
  return last;
}

std::vector<Contender> each_parameter_times(const Contender& contender, double factor) {
  std::vector<Contender> all;
  const auto add = [&](const std::function<void(Contender&)>& change) {
    Contender other = contender;
    change(other);
    all.push_back(std::move(other));
  };
  const auto by = static_cast<float>(factor);
  add([&](Contender& c) { std::get<Mass>(c.model).gains[0] *= by; });
  if (contender.own_model) {
    add([&](Contender& c) {
      for (float& gain : std::get<Hysteresis>(c.model).gains) gain *= by;
    });
    // Of lengths alone: the level stays.
    add([&](Contender& c) {
      Hysteresis& own = std::get<Hysteresis>(c.model);
      for (float& slip_m : own.shapes) slip_m *= by;
      for (float& gain : own.gains) gain /= by;
    });
  }
  if (contender.friction) {
    add([&](Contender& c) { c.level *= factor; });
    for (std::size_t i = 0; i < contender.friction->shape.size(); ++i)
      add([&](Contender& c) { c.friction->shape[i] *= factor; });
    if (!contender.friction->slips_m.empty()) {
      add([&](Contender& c) {
        for (double& slip_m : c.friction->slips_m) slip_m *= factor;
      });
    }
  }
  if (contender.observer_share > 0.0)
    add([&](Contender& c) { c.observer_share = std::min(1.0, c.observer_share * factor); });
  if (contender.repetitions > 1) {
    add([&](Contender& c) { c.learning_gain *= factor; });
    add([&](Contender& c) { c.learning_cutoff_Hz *= factor; });
  }
  return all;
}

}  // namespace slipstack::workbench
