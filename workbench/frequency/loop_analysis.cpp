// SPDX-License-Identifier: Apache-2.0
#include "workbench/frequency/loop_analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "workbench/frequency/tune.h"

namespace slipstack::workbench {
namespace {

// Two standard deviations of both are no difference. The computed one has that of the plant, times |S|² |C|.
double difference_of(const LoopAnalysis& analysis, const std::vector<Complex>& feedback) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < analysis.plant.size(); ++i) {
    const ResponsePoint& point = analysis.plant[i];
    if (!std::isfinite(std::abs(point.sensitivity))) continue;
    const Complex computed = 1.0 / (1.0 + analysis.loop[i]);
    const double computed_sd = std::norm(computed) * std::abs(feedback[i]) * point.plant_sd;
    const double noise = 2.0 * std::hypot(computed_sd, point.sensitivity_sd);
    const double difference = std::max(std::abs(point.sensitivity - computed) - noise, 0.0);
    differences.push_back(difference / std::abs(computed));
  }
  if (differences.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return *middle;
}

// What a change of the reference has made: of the force that it makes alone.
void refer_to_force(std::vector<ResponsePoint>& points, const DriveController& drive) {
  const std::vector<Complex> reference = FeedbackResponse(drive, points).of_reference(drive);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].sensitivity /= reference[i];
    points[i].sensitivity_sd /= std::abs(reference[i]);
  }
}

}  // namespace

LoopAnalysis analyse(const LoopRecording& recording, const std::string& name) {
  std::vector<std::vector<ResponsePoint>> bands;
  for (const auto& captures : recording.bands) {
    bands.push_back(response(captures, name));
    if (!captures.front().at_force) refer_to_force(bands.back(), recording.drive);
  }
  LoopAnalysis analysis;
  analysis.plant = smoothed(joined(bands));
  for (const ResponsePoint& point : analysis.plant) analysis.frequency_Hz.push_back(point.frequency_Hz);
  const std::vector<Complex> feedback = FeedbackResponse(recording.drive, analysis.plant).of(recording.drive);
  analysis.loop = loop_of(analysis.plant, feedback);
  analysis.margins = margins_of(analysis.frequency_Hz, analysis.loop);
  for (std::size_t i = 0; i < analysis.loop.size(); ++i) {
    if (analysis.frequency_Hz[i] == analysis.margins.peak_Hz)
      analysis.modulus_sd = std::abs(feedback[i]) * analysis.plant[i].plant_sd;
  }
  analysis.sensitivity_difference = difference_of(analysis, feedback);
  return analysis;
}

}  // namespace slipstack::workbench
