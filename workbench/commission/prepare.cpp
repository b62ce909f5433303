// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/prepare.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "workbench/commission/mass.h"
#include "workbench/commission/motions.h"
#include "workbench/commission/record_log.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

constexpr double kPulse_s = 0.04;
constexpr double kFirstPulse = 0.02;  // of the largest force
constexpr double kLargestPulse = 0.5;
constexpr double kPulseGrowth = 1.4;
constexpr double kMassCertainty = 0.05;  // relative standard error
constexpr double kMassAgreement = 0.25;  // of the masses to and fro, relative
constexpr double kLargestMotion = 0.02;  // of the travel, in a pulse
// Of the gains for a rigid mass: each 1.7 times the one before.
constexpr std::array kShares{0.2, 0.35, 0.6, 1.0};
// Noise of the force at rest: a fiftieth of what the motor can do moves nothing, and is heard.
constexpr double kQuietForce = 0.02;
constexpr double kForceOverFriction = 3.0;  // while the travel is checked

void check_place(const LiveAxis& axis) {
  const double travel_m = axis.nameplate().travel_m;
  const double at_m = axis.position_m();
  if (at_m > 0.1 * travel_m && at_m < 0.9 * travel_m) return;
  throw CommissionStopped(fmt::format(
      "the axis stands at {:.1f} mm of {:.1f} mm, too close to an end; move it to the middle by hand",
      1e3 * at_m, 1e3 * travel_m));
}

void find_direction(Stages& stages) {
  LiveAxis& axis = stages.axis;
  using Direction = LiveAxis::Direction;
  std::optional<Direction> found;
  const json& stage = stages.stage("direction", 0.01, [&] {
    found = axis.check_direction();
    const bool reversed = found == Direction::kReversed;
    if (reversed) {
      axis.reverse_motor();
      found = axis.check_direction();
    }
    if (found == Direction::kBlocked) {
      throw CommissionStopped(
          "half of the largest force moves the axis in neither direction; is it blocked, or its brake "
          "closed, "
          "or the encoder not connected?");
    }
    if (found == Direction::kReversed)
      throw CommissionStopped("the axis moves against the force, whichever way the motor is connected");
    return json{{"reversed", reversed}};
  });
  const bool reversed = stage.at("reversed").get<bool>();
  if (!found) {
    if (reversed) axis.reverse_motor();
    if (axis.check_direction() != Direction::kRight)
      throw CommissionStopped("the axis does not move along the force as it did before; see to its wires");
  }
  stages.report("direction", reversed ? "the motor is connected the other way round; the drive knows now"
                                      : "a push moves the axis its way");
}

json pulses(LiveAxis& axis) {
  const Nameplate& plate = axis.nameplate();
  double sign = 1.0;
  std::vector<PulseResult> good;
  double force_N = kFirstPulse * plate.force_limit_N();
  while (good.size() < 2) {
    if (force_N > kLargestPulse * plate.force_limit_N())
      throw CommissionStopped("pulses up to half of the largest force do not show the mass of the axis");
    const AxisRecord record = axis.pulse(sign * force_N, kPulse_s);
    if (!record.fault.empty()) throw CommissionStopped("a pulse of the force: " + record.fault);
    const PulseResult found = result_of_pulse(record, sign * force_N, kPulse_s, plate.encoder_resolution_m);
    // To and fro, so that the axis stays where it is: twice with one force, else with more of it.
    sign = -sign;
    if (found.mass_kg > 0.0 && found.mass_error_kg < kMassCertainty * found.mass_kg) {
      good.push_back(found);
      continue;
    }
    good.clear();
    if (found.moved_m > kLargestMotion * plate.travel_m) {
      throw CommissionStopped(fmt::format(
          "a pulse of {:.3g} N moves the axis by {:.3g} mm and does not show its mass; what holds it back?",
          force_N, 1e3 * found.moved_m));
    }
    force_N *= kPulseGrowth;
  }
  const double mass_kg = 0.5 * (good[0].mass_kg + good[1].mass_kg);
  if (std::fabs(good[0].mass_kg - good[1].mass_kg) > kMassAgreement * mass_kg) {
    throw CommissionStopped(fmt::format(
        "pulses to and fro disagree about the mass ({:.3g} and {:.3g} kg); is the axis level and free?",
        good[0].mass_kg, good[1].mass_kg));
  }
  return {{"mass_kg", mass_kg},
          {"mass_error_kg", 0.5 * std::hypot(good[0].mass_error_kg, good[1].mass_error_kg)},
          {"friction_N", std::max(good[0].friction_N, good[1].friction_N)},
          {"force_N", force_N}};
}

void deploy(LiveAxis& axis, const DriveSettings& settings) {
  const std::string refused = axis.deploy(settings, {});
  if (!refused.empty()) throw CommissionStopped(refused);
}

// From little upwards: what is quiet also with 1.7 times its gains has that gain margin for certain.
json quiet_share(Stages& stages, const AxisLimits& limits, const Feedback& full) {
  const double most_N = stages.axis.nameplate().force_limit_N();
  std::size_t loud = 0;
  std::string fault;
  for (; loud < kShares.size(); ++loud) {
    deploy(stages.axis, settings_of(part_of(full, kShares[loud]), limits, most_N));
    const AxisRecord record = stages.run(quiet_motion(limits), approach_mps(limits));
    fault = record.fault;
    if (!fault.empty() && !record.lost_hold) throw CommissionStopped("the feedback: " + fault);
    if (!is_quiet(record, kQuietFrom_s, kQuietTo_s, kQuietForce * most_N)) break;
  }
  const bool all = loud == kShares.size();
  if (!all) stages.axis.switch_off();
  if (loud < 2) {
    throw CommissionStopped(
        fmt::format("no feedback holds the axis quietly{}; slipstack bode shows what resonates",
                    fault.empty() ? "" : " (" + fault + ")"));
  }
  return {{"share", kShares[all ? loud - 1 : loud - 2]}};
}

void find_feedback(Stages& stages, PreparedAxis& axis) {
  const Feedback full = full_feedback(axis.mass_kg, stages.axis.nameplate().tick_s);
  const json& stage = stages.stage("feedback", 0.06, [&] { return quiet_share(stages, axis.limits, full); });
  const double share = stage.at("share").get<double>();
  const Feedback feedback = part_of(full, share);
  axis.settings = settings_of(feedback, axis.limits, stages.axis.nameplate().force_limit_N());
  stages.report("feedback",
                fmt::format("Kp {:.3g} 1/s, Kv {:.4g} N s/m, integral {:.3g} 1/s; on a rigid mass: modulus "
                            "margin {:.2f}, phase {:.0f} degrees, gain {:.1f}",
                            feedback.gains.position_gain_per_s, feedback.gains.velocity_gain_N_s_per_m,
                            feedback.gains.integral_per_s, feedback.margins.modulus,
                            57.29578 * feedback.margins.phase_rad, feedback.margins.gain));
  if (share < kShares.back()) {
    stages.notes.push_back(
        fmt::format("The feedback has {:.0f} % of the gains that suit a rigid mass: with more the axis was "
                    "not quiet. A resonance may limit it, which slipstack bode shows.",
                    100.0 * share));
  }
}

void check_travel(Stages& stages, PreparedAxis& axis) {
  const json& stage = stages.stage("travel", 0.12, [&] {
    const SetPoints motion = travel_motion(axis.limits);
    const double inertia_N = axis.mass_kg * extremes_of(motion).acceleration_mps2;
    DriveSettings gentle = axis.settings;
    gentle.force_limit_N =
        std::min(gentle.force_limit_N, kForceOverFriction * axis.friction_N + 2.0 * inertia_N);
    deploy(stages.axis, gentle);
    const AxisRecord record = stages.run(motion, approach_mps(axis.limits));
    if (!record.fault.empty()) {
      throw CommissionStopped(fmt::format(
          "the axis does not get through its travel of {:.1f} mm with {:.3g} N: {}; is it shorter, or "
          "something in the way?",
          1e3 * stages.axis.nameplate().travel_m, gentle.force_limit_N, record.fault));
    }
    stages.folder.write("travel.csv", log_csv(record, stages.axis.nameplate()));
    return json{{"log", "travel.csv"}, {"force_N", gentle.force_limit_N}};
  });
  axis.travel_log = stages.folder.path(stage.at("log").get<std::string>());
  stages.report("travel", fmt::format("free from {:.1f} to {:.1f} mm with {:.3g} N", 1e3 * axis.limits.low_m,
                                      1e3 * axis.limits.high_m, stage.at("force_N").get<double>()));
  deploy(stages.axis, axis.settings);
}

}  // namespace

PreparedAxis prepare(Stages& stages) {
  check_place(stages.axis);
  find_direction(stages);
  PreparedAxis axis;
  const json& mass = stages.stage("mass", 0.03, [&] { return pulses(stages.axis); });
  axis.mass_kg = mass.at("mass_kg").get<double>();
  axis.friction_N = mass.at("friction_N").get<double>();
  stages.report("mass",
                fmt::format("{:.4g} kg (standard error {:.2g} kg), {:.3g} N of friction; by pulses of "
                            "{:.3g} N",
                            axis.mass_kg, mass.at("mass_error_kg").get<double>(), axis.friction_N,
                            mass.at("force_N").get<double>()));
  axis.limits = first_limits(stages.axis.nameplate(), axis.mass_kg, axis.friction_N);
  find_feedback(stages, axis);
  check_travel(stages, axis);
  return axis;
}

}  // namespace slipstack::workbench
