// SPDX-License-Identifier: Apache-2.0
#include "workbench/frequency/bode_charts.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace slipstack::workbench {
namespace {

constexpr double kNoChartValue = std::numeric_limits<double>::quiet_NaN();
// Nyquist charts end where the loop is far from -1.
constexpr double kNyquistRadius = 3.0;

// From the highest angle downwards, without steps of a turn.
std::vector<double> unwrapped_deg(const std::vector<Complex>& values) {
  std::vector<double> angles;
  double last = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i == 0) {
      last = std::arg(values[i]);
      if (last > 0.5 * std::numbers::pi) last -= 2.0 * std::numbers::pi;
    } else {
      last += std::arg(values[i] / values[i - 1]);
    }
    angles.push_back(last * 180.0 / std::numbers::pi);
  }
  return angles;
}

ExperimentChart over_frequency(const std::string& title, const std::vector<double>& frequency_Hz,
                               const ChartAxis& axis) {
  return {title, {"Frequency", "Hz", 1.0, true}, axis, frequency_Hz, {}, false};
}

std::vector<double> sizes(const std::vector<Complex>& values) {
  std::vector<double> made;
  made.reserve(values.size());
  for (const Complex& value : values)
    made.push_back(std::isfinite(value.real()) ? std::abs(value) : kNoChartValue);
  return made;
}

std::vector<Complex> sensitivity_of(const std::vector<Complex>& loop) {
  std::vector<Complex> made;
  made.reserve(loop.size());
  for (const Complex& value : loop) made.push_back(1.0 / (1.0 + value));
  return made;
}

}  // namespace

void add_plant_charts(ExperimentResult& result, const LoopAnalysis& analysis) {
  std::vector<Complex> plant;
  std::vector<double> sd;
  for (const ResponsePoint& point : analysis.plant) {
    plant.push_back(point.plant);
    sd.push_back(point.plant_sd);
  }
  ExperimentChart size = over_frequency("Plant: position over force", analysis.frequency_Hz,
                                        {"Position over force", "µm/N", 1e6, true});
  size.curves = {{"plant", sizes(plant), {}, "measured", false},
                 {"standard deviation", sd, {}, "reference", true}};
  ExperimentChart phase = over_frequency("Plant: phase", analysis.frequency_Hz, {"Phase", "°", 1.0, false});
  phase.curves = {{"plant", unwrapped_deg(plant), {}, "measured", false}};
  result.charts.push_back(std::move(size));
  result.charts.push_back(std::move(phase));
}

void add_loop_charts(ExperimentResult& result, const std::vector<NamedLoop>& loops,
                     const LoopAnalysis& analysis, bool measured) {
  const std::vector<double>& x = *loops.front().frequency_Hz;
  ExperimentChart size = over_frequency("Open loop: size", x, {"Open loop", "", 1.0, true});
  ExperimentChart phase = over_frequency("Open loop: phase", x, {"Phase", "°", 1.0, false});
  ExperimentChart sensitivity = over_frequency("Sensitivity", x, {"Sensitivity", "", 1.0, true});
  ExperimentChart nyquist{
      "Nyquist", {"Real part", "", 1.0, false}, {"Imaginary part", "", 1.0, false}, {}, {}, true};
  std::size_t colour = 0;
  for (const NamedLoop& one : loops) {
    const std::string role = palette_role(colour++);
    const auto alike = [&](std::vector<double> y) {
      std::vector<double> made(x.size(), kNoChartValue);
      for (std::size_t i = 0, k = 0; i < x.size() && k < y.size(); ++k) {
        while (i < x.size() && x[i] < (*one.frequency_Hz)[k]) ++i;
        if (i < x.size()) made[i] = y[k];
      }
      return made;
    };
    size.curves.push_back({one.name, alike(sizes(*one.loop)), {}, role, false});
    phase.curves.push_back({one.name, alike(unwrapped_deg(*one.loop)), {}, role, false});
    sensitivity.curves.push_back({one.name, alike(sizes(sensitivity_of(*one.loop))), {}, role, false});
    ChartCurve curve{one.name, {}, {}, role, false};
    for (const Complex& value : *one.loop) {
      const bool near = std::abs(value) < kNyquistRadius;
      curve.x.push_back(near ? value.real() : kNoChartValue);
      curve.y.push_back(near ? value.imag() : kNoChartValue);
    }
    std::erase_if(curve.x, [](double value) { return std::isnan(value); });
    std::erase_if(curve.y, [](double value) { return std::isnan(value); });
    nyquist.curves.push_back(std::move(curve));
  }
  if (measured) {
    std::vector<Complex> values;
    for (const ResponsePoint& point : analysis.plant) values.push_back(point.sensitivity);
    if (std::isfinite(values.front().real()))
      sensitivity.curves.push_back({"measured directly", sizes(values), {}, "measured", true});
  }
  ChartCurve margin{"distance 0.5 from -1", {}, {}, "reference", true};
  for (int i = 0; i <= 72; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 72.0;
    margin.x.push_back(-1.0 + 0.5 * std::cos(angle));
    margin.y.push_back(0.5 * std::sin(angle));
  }
  nyquist.curves.push_back(std::move(margin));
  for (ExperimentChart* chart : {&size, &phase, &sensitivity, &nyquist})
    result.charts.push_back(std::move(*chart));
}

}  // namespace slipstack::workbench
