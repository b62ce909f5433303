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
#include "workbench/plan/motion.h"

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
// Noise of the force at rest: a fiftieth of what the motor can do moves nothing, and shows in the record.
constexpr double kSteadyForce = 0.02;
constexpr double kForceOverFriction = 3.0;  // while the travel is checked
// While the ends are searched: steps from small to large, each twice the one before, at a pace at which an
// axis of 50 kg brings less than a tenth of a joule to the stop.
constexpr double kAssumedTravel_m = 0.05;  // about where it stands, before the ends are known
constexpr double kFirstStep_m = 1e-3;
constexpr double kLargestStep_m = 0.2;
constexpr double kSearch_mps = 0.05;
constexpr double kSearch_mps2 = 0.3;
constexpr double kSearchError_m = 2e-3;  // of the reference, at which the drive stops: it stands at an end
constexpr double kFarthest_m = 10.0;
constexpr double kBack_m = 2e-3;
constexpr double kSamePlace_m = 0.5e-3;
constexpr double kShortestTravel_m = 5e-3;

void check_place(const Stages& stages) {
  const double travel_m = stages.plate.travel_m;
  const double at_m = stages.axis.position_m() - stages.plate.low_m;
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

json pulses(LiveAxis& axis, const Nameplate& plate) {
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

// From little upwards: what is steady also with 1.7 times its gains has that gain margin for certain.
json steady_share(Stages& stages, const AxisLimits& limits, const Feedback& full) {
  const double most_N = stages.plate.force_limit_N();
  std::size_t unsteady = 0;
  std::string fault;
  for (; unsteady < kShares.size(); ++unsteady) {
    deploy(stages.axis, settings_of(part_of(full, kShares[unsteady]), limits, most_N));
    const AxisRecord record = stages.run(holding_motion(limits), approach_mps(limits));
    fault = record.fault;
    if (!fault.empty() && !record.lost_hold) throw CommissionStopped("the feedback: " + fault);
    if (!is_steady(record, kHoldFrom_s, kHoldTo_s, kSteadyForce * most_N)) break;
  }
  const bool all = unsteady == kShares.size();
  if (!all) stages.axis.switch_off();
  if (unsteady < 2) {
    throw CommissionStopped(
        fmt::format("no feedback holds the axis steadily{}; slipstack bode shows what resonates",
                    fault.empty() ? "" : " (" + fault + ")"));
  }
  return {{"share", kShares[all ? unsteady - 1 : unsteady - 2]}};
}

void find_feedback(Stages& stages, PreparedAxis& axis) {
  const Feedback full = full_feedback(axis.mass_kg, stages.plate.tick_s);
  const json& stage = stages.stage("feedback", 0.06, [&] { return steady_share(stages, axis.limits, full); });
  const double share = stage.at("share").get<double>();
  const Feedback feedback = part_of(full, share);
  axis.feedback = feedback;
  axis.settings = settings_of(feedback, axis.limits, stages.plate.force_limit_N());
  stages.report("feedback",
                fmt::format("Kp {:.3g} 1/s, Kv {:.4g} N s/m, integral {:.3g} 1/s; on a rigid mass: modulus "
                            "margin {:.2f}, phase {:.0f} degrees, gain {:.1f}",
                            feedback.gains.position_gain_per_s, feedback.gains.velocity_gain_N_s_per_m,
                            feedback.gains.integral_per_s, feedback.margins.modulus,
                            57.29578 * feedback.margins.phase_rad, feedback.margins.gain));
  if (share < kShares.back()) {
    stages.notes.push_back(
        fmt::format("The feedback has {:.0f} % of the gains that suit a rigid mass: with more the axis was "
                    "not steady. A resonance may limit it, which slipstack bode shows.",
                    100.0 * share));
  }
}

/// No more force than three times the friction, and this for the inertia. A limit switch stops the axis, and
/// a drive catches up with its set-points, as fast as that allows.
DriveSettings with_little_force(const PreparedAxis& axis, double inertia_N) {
  DriveSettings gentle = axis.settings;
  gentle.force_limit_N = std::min(gentle.force_limit_N, kForceOverFriction * axis.friction_N + inertia_N);
  gentle.acceleration_limit_mps2 =
      std::min(gentle.acceleration_limit_mps2, (gentle.force_limit_N - 1.5 * axis.friction_N) / axis.mass_kg);
  return gentle;
}

/// From where it stands towards one end, until something holds it. Where that was, and whether it was a
/// switch.
struct End {
  double at_m = 0.0;
  bool limit_switch = false;
};

End walk_to_end(LiveAxis& axis, double direction, double first_step_m, double velocity_mps) {
  AxisLimits pace;
  pace.velocity_mps = velocity_mps;
  pace.acceleration_mps2 = kSearch_mps2;
  pace.jerk_mps3 = kSearch_mps2 / 0.05;
  double gone_m = 0.0;
  for (double step_m = first_step_m; gone_m < kFarthest_m; step_m = std::min(2.0 * step_m, kLargestStep_m)) {
    MotionBuilder builder(1000.0, axis.position_m());
    builder.dwell(0.05);
    builder.move_to(axis.position_m() + direction * step_m, pace);
    builder.dwell(0.1);
    const AxisRecord record = axis.run(builder.points());
    gone_m += step_m;
    if (record.fault.empty()) continue;
    if ((!record.lost_hold && !record.limit_switch) || record.position_m.empty())
      throw CommissionStopped("the search of the ends: " + record.fault);
    return {record.position_m.back(), record.limit_switch};
  }
  throw CommissionStopped(fmt::format(
      "no end within {:.0f} m; is this a linear axis with stops or limit switches?", kFarthest_m));
}

/// An end that holds the axis again, more slowly, at the same place; the axis stands off it then.
End firm_end(LiveAxis& axis, double direction) {
  const auto step_back = [&] {
    AxisLimits pace;
    pace.velocity_mps = kSearch_mps;
    pace.acceleration_mps2 = kSearch_mps2;
    pace.jerk_mps3 = kSearch_mps2 / 0.05;
    const double from_m = axis.position_m();
    MotionBuilder builder(1000.0, from_m);
    builder.dwell(0.05);
    builder.move_to(from_m - direction * kBack_m, pace);
    builder.dwell(0.1);
    const AxisRecord record = axis.run(builder.points());
    if (!record.fault.empty()) throw CommissionStopped("the way back from an end: " + record.fault);
  };
  const End first = walk_to_end(axis, direction, kFirstStep_m, kSearch_mps);
  step_back();
  const End again = walk_to_end(axis, direction, 2.0 * kBack_m, 0.5 * kSearch_mps);
  step_back();
  if (std::fabs(first.at_m - again.at_m) < kSamePlace_m) return again;
  throw CommissionStopped(
      fmt::format("something holds the axis at {:.2f} mm and then at {:.2f} mm: no end that it can rely on; "
                  "see what is in the way, or name the ends",
                  1e3 * first.at_m, 1e3 * again.at_m));
}

json searched(Stages& stages, const PreparedAxis& axis) {
  DriveSettings gentle = with_little_force(axis, 2.0 * kSearch_mps2 * axis.mass_kg);
  gentle.following_error_m = kSearchError_m;
  gentle.velocity_limit_mps = 1.5 * kSearch_mps;
  deploy(stages.axis, gentle);
  const End low = firm_end(stages.axis, -1.0);
  const End high = firm_end(stages.axis, 1.0);
  if (high.at_m - low.at_m < kShortestTravel_m) {
    throw CommissionStopped(
        fmt::format("between its ends the axis has {:.2f} mm only; is something in the way?",
                    1e3 * (high.at_m - low.at_m)));
  }
  return {{"low_m", low.at_m},
          {"high_m", high.at_m},
          {"low_switch", low.limit_switch},
          {"high_switch", high.limit_switch},
          {"force_N", gentle.force_limit_N}};
}

void find_ends(Stages& stages, PreparedAxis& axis) {
  const json& found = stages.stage("ends", 0.1, [&] { return searched(stages, axis); });
  const double low_m = found.at("low_m").get<double>();
  const double high_m = found.at("high_m").get<double>();
  stages.plate.low_m = low_m;
  stages.plate.travel_m = high_m - low_m;
  const auto what = [&](const char* which) { return found.at(which).get<bool>() ? "limit switch" : "stop"; };
  stages.report(
      "ends", fmt::format("{} at {:.2f} mm, {} at {:.2f} mm; with {:.3g} N", what("low_switch"), 1e3 * low_m,
                          what("high_switch"), 1e3 * high_m, found.at("force_N").get<double>()));
  axis.limits = first_limits(stages.plate, axis.mass_kg, axis.friction_N);
  axis.settings = settings_of(axis.feedback, axis.limits, stages.plate.force_limit_N());
}

void check_travel(Stages& stages, PreparedAxis& axis) {
  const json& stage = stages.stage("travel", 0.12, [&] {
    const SetPoints motion = travel_motion(axis.limits);
    const double inertia_N = axis.mass_kg * extremes_of(motion).acceleration_mps2;
    const DriveSettings gentle = with_little_force(axis, 2.0 * inertia_N);
    deploy(stages.axis, gentle);
    const AxisRecord record = stages.run(motion, approach_mps(axis.limits));
    if (!record.fault.empty()) {
      throw CommissionStopped(fmt::format(
          "the axis does not get through its travel of {:.1f} mm with {:.3g} N: {}; is it shorter, or "
          "something in the way?",
          1e3 * stages.plate.travel_m, gentle.force_limit_N, record.fault));
    }
    stages.folder.write("travel.csv", log_csv(record, stages.plate));
    return json{{"log", "travel.csv"}, {"force_N", gentle.force_limit_N}};
  });
  axis.travel_log = stages.folder.path(stage.at("log").get<std::string>());
  stages.report("travel", fmt::format("free from {:.1f} to {:.1f} mm with {:.3g} N", 1e3 * axis.limits.low_m,
                                      1e3 * axis.limits.high_m, stage.at("force_N").get<double>()));
  deploy(stages.axis, axis.settings);
}

}  // namespace

PreparedAxis prepare(Stages& stages) {
  const bool search = !(stages.plate.travel_m > 0.0);
  if (search) {
    stages.plate.low_m = stages.axis.position_m() - 0.5 * kAssumedTravel_m;
    stages.plate.travel_m = kAssumedTravel_m;
  } else {
    check_place(stages);
  }
  find_direction(stages);
  PreparedAxis axis;
  const json& mass = stages.stage("mass", 0.03, [&] { return pulses(stages.axis, stages.plate); });
  axis.mass_kg = mass.at("mass_kg").get<double>();
  axis.friction_N = mass.at("friction_N").get<double>();
  stages.report("mass",
                fmt::format("{:.4g} kg (standard error {:.2g} kg), {:.3g} N of friction; by pulses of "
                            "{:.3g} N",
                            axis.mass_kg, mass.at("mass_error_kg").get<double>(), axis.friction_N,
                            mass.at("force_N").get<double>()));
  axis.limits = first_limits(stages.plate, axis.mass_kg, axis.friction_N);
  find_feedback(stages, axis);
  if (search) find_ends(stages, axis);
  check_travel(stages, axis);
  return axis;
}

}  // namespace slipstack::workbench
