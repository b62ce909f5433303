// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/stages.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "workbench/plan/motion.h"

namespace slipstack::workbench {
namespace {

constexpr double kApproach_mps2 = 0.5;

/// From where the axis is held to where a motion begins.
SetPoints approach(double from_m, const SetPoints& motion, double velocity_mps) {
  AxisLimits slow;
  slow.velocity_mps = velocity_mps;
  slow.acceleration_mps2 = kApproach_mps2;
  slow.jerk_mps3 = kApproach_mps2 / 0.05;
  MotionBuilder builder(motion.rate_Hz, from_m);
  builder.dwell(0.05);
  builder.move_to(motion.position_m.front(), slow);
  builder.dwell(0.25);
  return builder.points();
}

}  // namespace

const nlohmann::json& Stages::stage(const std::string& name, double fraction,
                                    const std::function<nlohmann::json()>& work) {
  if (folder.done(name)) return folder.found(name);
  progress.show(name, fraction);
  nlohmann::json found = work();
  const double now_s = axis.used_s();
  found["axis_s"] = now_s - counted_s_;
  counted_s_ = now_s;
  folder.finish(name, std::move(found));
  return folder.found(name);
}

void Stages::report(const std::string& name, const std::string& found) {
  reports.push_back({name, found, folder.found(name).at("axis_s").get<double>()});
}

AxisRecord Stages::run(const SetPoints& motion, double approach_mps) {
  AxisRecord there = axis.run(approach(axis.position_m(), motion, approach_mps));
  return there.fault.empty() ? axis.run(motion) : there;
}

AxisRecord Stages::follow(const SetPoints& motion, double approach_mps, const std::string& what) {
  AxisRecord record = run(motion, approach_mps);
  if (!record.fault.empty()) throw CommissionStopped(what + ": " + record.fault);
  return record;
}

double Stages::used_s() const {
  double sum_s = 0.0;
  for (const StageReport& report : reports) sum_s += report.axis_s;
  return sum_s;
}

}  // namespace slipstack::workbench
