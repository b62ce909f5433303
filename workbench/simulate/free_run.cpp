// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/free_run.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"
#include "workbench/simulate/model_stepper.h"

namespace slipstack::workbench {
namespace {

constexpr int kMostStepsPerSample = 200;
constexpr std::size_t kSamplesPerReport = 4096;

/// The measured force of one part between its samples, with the delay and low pass of the model compensated.
class Drive {
 public:
  Drive(const Measurement& measurement, const LogPart& part, const MeasurementDynamics& lag)
      : force_N_(measurement.log().force_N),
        first_(static_cast<double>(part.first_sample)),
        last_(static_cast<double>(part.end_sample() - 1)),
        late_(lag.delay_s * measurement.sample_rate_Hz()),
        filter_(lag.filter_s * measurement.sample_rate_Hz()) {}

  double at(double sample) const {
    const double place = std::clamp(sample + late_, first_, last_);
    const auto i = static_cast<std::size_t>(std::min(place, last_ - 1.0));
    const double t = place - static_cast<double>(i);
    return force_N_[i] + (t + filter_) * (force_N_[i + 1] - force_N_[i]);
  }

 private:
  const std::vector<double>& force_N_;
  double first_;
  double last_;
  double late_;    ///< samples
  double filter_;  ///< the same
};

/// The effects follow the measured motion up to the start, at the step width of the integration.
void warm_up(const Measurement& measurement, const FreeRunInterval& interval, int steps,
             ModelStepper& model) {
  model.reset(measurement.sample(interval.warm_up, interval.part));
  for (std::size_t i = interval.warm_up + 1; i <= interval.first; ++i) {
    const Sample<double> from = measurement.sample(i - 1, interval.part);
    const Sample<double> to = measurement.sample(i, interval.part);
    for (int k = 1; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      Sample<double> sample = to;
      sample.time_s = from.time_s + t * (to.time_s - from.time_s);
      sample.position_m = from.position_m + t * (to.position_m - from.position_m);
      sample.displacement = from.displacement + t * (to.displacement - from.displacement);
      model.step(sample);
    }
  }
}

}  // namespace

int free_run_steps(const Measurement& measurement, const Terms& terms, double step_times_rate) {
  if (!(mass_kg(terms) > 0.0)) {
    throw std::invalid_argument("the model has no mass; fit it with " + effect_with_role(Role::inertia).id());
  }
  const ModelStepper probe(terms, measurement.tick_s());
  const double rate_per_s = std::sqrt(probe.stiffness_N_per_m() / probe.mass_kg());
  const double wanted = std::ceil(measurement.tick_s() * rate_per_s / step_times_rate);
  return static_cast<int>(std::clamp(wanted, 4.0, static_cast<double>(kMostStepsPerSample)));
}

std::vector<double> free_run(const Measurement& measurement, const Terms& terms,
                             const FreeRunInterval& interval, int steps_per_sample, const InitialState& start,
                             const std::function<void(double fraction)>& progress) {
  const double step_s = measurement.tick_s() / steps_per_sample;
  ModelStepper model(terms, step_s);
  const Drive drive(measurement, measurement.parts()[interval.part], model.lag());
  warm_up(measurement, interval, steps_per_sample, model);

  Sample<double> sample = measurement.sample(interval.first, interval.part);
  const double start_s = sample.time_s;
  // The displacement (interpolated readings) and the smooth position differ by less than an encoder step.
  // From here on the difference is constant.
  const double apart_m = sample.displacement - sample.position_m;
  double position_m = sample.position_m + start.position_m;
  double velocity_mps = sample.velocity_mps + start.velocity_mps;
  double acceleration_mps2 = 0.0;
  std::vector<double> positions_m;
  positions_m.reserve(interval.size());
  for (std::size_t i = interval.first; i < interval.end; ++i) {
    positions_m.push_back(position_m);
    for (int k = 0; k < steps_per_sample; ++k) {
      const double place = static_cast<double>(i) + static_cast<double>(k) / steps_per_sample;
      sample.time_s = start_s + (place - static_cast<double>(interval.first)) * measurement.tick_s();
      sample.position_m = position_m;
      sample.displacement = position_m + apart_m;
      sample.velocity_mps = velocity_mps;
      sample.acceleration_mps2 = acceleration_mps2;
      const ModelStepper::Forces forces = model.step(sample);
      acceleration_mps2 = (drive.at(place) / forces.factor - forces.friction_N) / model.mass_kg();
      velocity_mps += step_s * acceleration_mps2;
      position_m += step_s * velocity_mps;
    }
    if (progress && i % kSamplesPerReport == 0) {
      progress(static_cast<double>(i - interval.first) / static_cast<double>(interval.size()));
    }
  }
  return positions_m;
}

double free_run_rmse_m(const Measurement& measurement, const Terms& terms,
                       const std::vector<FreeRunInterval>& runs, int steps_per_sample) {
  std::vector<double> squares_m2(runs.size());
  parallel_for(runs.size(), [&](std::size_t k) {
    const Terms own = terms_of_log(terms, measurement.parts()[runs[k].part].log);
    const std::vector<double> position_m = free_run(measurement, own, runs[k], steps_per_sample);
    for (std::size_t i = 0; i < position_m.size(); ++i) {
      squares_m2[k] += squared(position_m[i] - measurement.log().position_m[runs[k].first + i]);
    }
  });
  double sum_m2 = 0.0;
  double samples = 0.0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    sum_m2 += squares_m2[k];
    samples += static_cast<double>(runs[k].size());
  }
  return std::sqrt(sum_m2 / std::max(samples, 1.0));
}

Terms terms_of_log(const Terms& terms, std::size_t log) {
  Terms own = terms;
  for (Term& term : own) {
    if (term.gain_sets() == 1) continue;
    const auto first = static_cast<std::ptrdiff_t>(log * term.gains_per_set());
    const auto count = static_cast<std::ptrdiff_t>(term.gains_per_set());
    for (std::vector<double>* values : {&term.gains, &term.lower, &term.upper}) {
      *values = std::vector<double>(values->begin() + first, values->begin() + first + count);
    }
    term.gain_standard_errors.clear();
  }
  return own;
}

}  // namespace slipstack::workbench
