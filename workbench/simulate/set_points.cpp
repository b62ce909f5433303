// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/set_points.h"

#include <fmt/format.h>

#include <iterator>

#include "workbench/base/axis_units.h"
#include "workbench/base/text.h"
#include "workbench/simulate/model_stepper.h"

namespace slipstack::workbench {
namespace {

std::vector<double> differences(const std::vector<double>& values, double rate_Hz) {
  std::vector<double> slope(values.size(), 0.0);
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    slope[i] = 0.5 * rate_Hz * (values[i + 1] - values[i - 1]);
  }
  // One-sided differences at the ends: the file may begin and end during a movement.
  slope.front() = rate_Hz * (values[1] - values[0]);
  slope.back() = rate_Hz * (values[values.size() - 1] - values[values.size() - 2]);
  return slope;
}

}  // namespace

std::string to_csv(const SetPoints& points, const std::vector<std::string>& header) {
  std::string text;
  for (const std::string& line : header) text += "# " + printable(line) + "\n";
  text += fmt::format("time_s,{},{},{}\n", axis_key("position_m"), axis_key("velocity_mps"),
                      axis_key("acceleration_mps2"));
  for (std::size_t i = 0; i < points.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{:.9g},{:.12f},{:.9g},{:.9g}\n",
                   static_cast<double>(i) / points.rate_Hz, points.position_m[i], points.velocity_mps[i],
                   points.acceleration_mps2[i]);
  }
  return text;
}

SetPoints complete(SetPoints points) {
  if (points.velocity_mps.empty()) points.velocity_mps = differences(points.position_m, points.rate_Hz);
  if (points.acceleration_mps2.empty()) {
    points.acceleration_mps2 = differences(points.velocity_mps, points.rate_Hz);
  }
  return points;
}

std::vector<double> force_along(const SetPoints& points, const Terms& terms) {
  ModelStepper model(terms, 1.0 / points.rate_Hz);
  std::vector<double> force_N(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Sample<double> sample{.time_s = static_cast<double>(i) / points.rate_Hz,
                                .displacement = points.position_m[i],
                                .position_m = points.position_m[i],
                                .velocity_mps = points.velocity_mps[i],
                                .acceleration_mps2 = points.acceleration_mps2[i]};
    if (i == 0) model.reset(sample);
    const ModelStepper::Forces forces = model.step(sample);
    force_N[i] = (model.mass_kg() * points.acceleration_mps2[i] + forces.friction_N) * forces.factor;
  }
  return force_N;
}

}  // namespace slipstack::workbench
