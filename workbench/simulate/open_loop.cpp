// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/open_loop.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "workbench/simulate/model_stepper.h"

namespace slipstack::workbench {
namespace {

/// Step times the angular frequency of the mass on the stiffest hysteresis. The scheme is stable below 2;
/// this value is chosen for accuracy.
constexpr double kStepTimesRate = 0.1;
constexpr int kMostSteps = 200;
constexpr std::size_t kSamplesPerReport = 4096;

/// The measured force between samples, with the delay and low pass of the model compensated.
class Drive {
 public:
  Drive(const Measurement& measurement, const MeasurementDynamics& lag)
      : force_N_(measurement.log().force_N),
        late_(lag.delay_s * measurement.sample_rate_Hz()),
        filter_(lag.filter_s * measurement.sample_rate_Hz()) {}

  double at(double sample) const {
    const double place = std::clamp(sample + late_, 0.0, static_cast<double>(force_N_.size() - 1));
    const auto i = std::min(static_cast<std::size_t>(place), force_N_.size() - 2);
    const double t = place - static_cast<double>(i);
    return force_N_[i] + (t + filter_) * (force_N_[i + 1] - force_N_[i]);
  }

 private:
  const std::vector<double>& force_N_;
  double late_;    ///< samples
  double filter_;  ///< the same
};

int steps_for(const ModelStepper& probe, double tick_s) {
  const double rate_per_s = std::sqrt(probe.stiffness_N_per_m() / probe.mass_kg());
  const double wanted = std::ceil(tick_s * rate_per_s / kStepTimesRate);
  return static_cast<int>(std::clamp(wanted, 4.0, static_cast<double>(kMostSteps)));
}

void judge(OpenLoop& result) {
  double squares = 0.0;
  double mean = 0.0;
  for (const double x : result.measured_m) mean += x;
  mean /= static_cast<double>(result.measured_m.size());
  double spread = 0.0;
  for (std::size_t i = 0; i < result.position_m.size(); ++i) {
    const double error = result.position_m[i] - result.measured_m[i];
    squares += error * error;
    spread += (result.measured_m[i] - mean) * (result.measured_m[i] - mean);
    result.largest_m = std::max(result.largest_m, std::abs(error));
    result.final_m = error;
  }
  result.rmse_m = std::sqrt(squares / static_cast<double>(result.position_m.size()));
  result.fit = 1.0 - std::sqrt(squares / std::max(spread, 1e-300));
}

}  // namespace

OpenLoop simulate_open_loop(const Measurement& measurement, const Terms& terms,
                            const OpenLoopOptions& options) {
  const double tick_s = measurement.tick_s();
  OpenLoop result;
  result.first = static_cast<std::size_t>(std::max(0.0, std::round(options.start_s / tick_s)));
  std::size_t end = measurement.sample_count();
  if (options.end_s > 0.0) {
    end = std::min(end, static_cast<std::size_t>(std::round(options.end_s / tick_s)) + 1);
  }
  if (result.first + 2 > end) throw std::invalid_argument("nothing is left between start and end");
  if (!(mass_kg(terms) > 0.0)) {
    throw std::invalid_argument("the model has no mass; fit it with " + effect_with_role(Role::inertia).id());
  }
  result.steps_per_sample = steps_for(ModelStepper(terms, tick_s), tick_s);
  const double step_s = tick_s / result.steps_per_sample;
  ModelStepper model(terms, step_s);
  const Drive drive(measurement, model.lag());

  // Before the start, the effects follow the measured motion, at the step width of the integration.
  Sample<double> sample = measurement.sample(0);
  model.reset(sample);
  for (std::size_t i = 1; i <= result.first; ++i) {
    const Sample<double> from = measurement.sample(i - 1);
    const Sample<double> to = measurement.sample(i);
    for (int k = 1; k <= result.steps_per_sample; ++k) {
      const double t = static_cast<double>(k) / result.steps_per_sample;
      sample = to;
      sample.time_s = from.time_s + t * (to.time_s - from.time_s);
      sample.position_m = from.position_m + t * (to.position_m - from.position_m);
      sample.displacement = from.displacement + t * (to.displacement - from.displacement);
      model.step(sample);
    }
  }
  sample = measurement.sample(result.first);
  // The displacement (interpolated readings) and the smooth position differ by less than an encoder step.
  // From here on the difference is constant.
  const double apart_m = sample.displacement - sample.position_m;
  double position_m = sample.position_m;
  double velocity_mps = sample.velocity_mps;
  double acceleration_mps2 = 0.0;
  result.position_m.reserve(end - result.first);
  result.measured_m.reserve(end - result.first);
  for (std::size_t i = result.first; i < end; ++i) {
    result.position_m.push_back(position_m);
    result.measured_m.push_back(measurement.log().position_m[i]);
    for (int k = 0; k < result.steps_per_sample; ++k) {
      const double place = static_cast<double>(i) + static_cast<double>(k) / result.steps_per_sample;
      sample.time_s = place * tick_s;
      sample.position_m = position_m;
      sample.displacement = position_m + apart_m;
      sample.velocity_mps = velocity_mps;
      sample.acceleration_mps2 = acceleration_mps2;
      const ModelStepper::Forces forces = model.step(sample);
      acceleration_mps2 = (drive.at(place) / forces.factor - forces.friction_N) / model.mass_kg();
      velocity_mps += step_s * acceleration_mps2;
      position_m += step_s * velocity_mps;
    }
    if (options.progress && i % kSamplesPerReport == 0) {
      options.progress(static_cast<double>(i - result.first) / static_cast<double>(end - result.first));
    }
  }
  judge(result);
  return result;
}

}  // namespace slipstack::workbench
