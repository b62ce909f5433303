// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "sim_host/experiments/describing_function.h"
#include "sim_host/motion/programme.h"
#include "sim_host/plant/prescribed_axis.h"
#include "sim_host/plant/smooth_axis.h"
#include "sim_host/rng.h"
#include "sim_host/sensors/delay_line.h"
#include "sim_host/sensors/encoder.h"
#include "sim_host/turn.h"

namespace slipstack::sim {
namespace {

constexpr std::size_t kDiscardedCycles = 2;

// Averages the samples of successive cycles.
class Averager {
 public:
  Averager(const ExperimentSetup& setup, const LoopRequest& request, double step_s, const Rng& noise)
      : setup_(setup),
        request_(request),
        noise_(noise),
        encoder_(setup.sensors.encoder_resolution_m),
        late_x_(step_s, setup.sensors.delay_s, setup.sensors.filter_s),
        late_F_(step_s, setup.sensors.delay_s, setup.sensors.filter_s),
        x_(request.samples, 0.0),
        force_(request.samples, 0.0) {}

  // Sample k of a cycle. Position and force pass the same delay and filter: the sensors must not widen the
  // loop.
  void push(std::size_t cycle, std::size_t k, double x_m, double force_N) {
    if (request_.sensors) {
      const SensorSet& sensors = setup_.sensors;
      x_m += sensors.position_noise_m > 0.0 ? sensors.position_noise_m * noise_.normal() : 0.0;
      x_m = late_x_.push(encoder_.position_m(x_m));
      force_N = late_F_.push(force_N + sensors.force_noise_N * noise_.normal());
    }
    if (cycle < kDiscardedCycles) return;
    x_[k] += x_m / static_cast<double>(request_.cycles);
    force_[k] += force_N / static_cast<double>(request_.cycles);
  }
  MeasuredLoop loop() && {
    MeasuredLoop loop;
    loop.displacement_m = std::move(x_);
    loop.force_N = std::move(force_);
    return loop;
  }

 private:
  const ExperimentSetup& setup_;
  const LoopRequest& request_;
  Rng noise_;
  Encoder encoder_;
  DelayLine late_x_;
  DelayLine late_F_;
  std::vector<double> x_;
  std::vector<double> force_;
};

double moving_mass_kg(const ExperimentSetup& setup) {
  return setup.axis.mass_kg + setup.axis.effects.payload_kg.value_or(0.0);
}

MeasuredLoop loop_by_displacement(const ExperimentSetup& setup, const LoopRequest& request, double position_m,
                                  double amplitude_m, const Rng& noise) {
  const auto cycles = static_cast<int>(request.cycles + kDiscardedCycles);
  MotionProgramme programme;
  // One cycle more at each end, where the sine fades in and out.
  programme.append(make_sine(position_m, amplitude_m, request.frequency_Hz, cycles + 2));
  const double step_s = 1.0 / (request.frequency_Hz * static_cast<double>(request.samples));
  PrescribedAxis axis(setup.axis, programme);
  Averager averager(setup, request, step_s, noise);
  const double mass_kg = moving_mass_kg(setup);
  for (std::size_t cycle = 0; cycle < request.cycles + kDiscardedCycles; ++cycle) {
    for (std::size_t k = 0; k < request.samples; ++k) {
      const double t_s =
          1.0 / request.frequency_Hz + static_cast<double>(cycle * request.samples + k + 1) * step_s;
      axis.advance_to(t_s);
      const PerEffect parts = axis.parts();
      const double force_N =
          std::accumulate(parts.begin(), parts.end(), 0.0) - mass_kg * axis.motion().a_mps2;
      averager.push(cycle, k, axis.motion().x_m, force_N);
    }
  }
  return std::move(averager).loop();
}

MeasuredLoop loop_by_force(const ExperimentSetup& setup, const LoopRequest& request, double position_m,
                           double amplitude_N, const Rng& noise) {
  SmoothAxis axis(setup.axis, position_m);
  const double w = kTurn * request.frequency_Hz;
  // A sine that begins at zero: no step of force at the start.
  axis.set_force({0.0, amplitude_N, w, -0.5 * std::numbers::pi});
  const double step_s = 1.0 / (request.frequency_Hz * static_cast<double>(request.samples));
  Averager averager(setup, request, step_s, noise);
  const double mass_kg = moving_mass_kg(setup);
  double last_v = 0.0;
  for (std::size_t cycle = 0; cycle < request.cycles + kDiscardedCycles; ++cycle) {
    for (std::size_t k = 0; k < request.samples; ++k) {
      const double t_s = static_cast<double>(cycle * request.samples + k + 1) * step_s;
      axis.advance_to(t_s);
      // Mean acceleration over the sample; at these frequencies a part in a thousand of the force.
      const double a = (axis.velocity_mps() - last_v) / step_s;
      last_v = axis.velocity_mps();
      averager.push(cycle, k, axis.position_m(), amplitude_N * std::sin(w * t_s) - mass_kg * a);
    }
  }
  return std::move(averager).loop();
}

}  // namespace

void check_loops(const ExperimentSetup& setup, const LoopRequest& request) {
  if (request.amplitudes.empty())
    throw SetupError(fmt::format("{}: no amplitude for the loops; give some", setup.name));
  if (request.positions_m.empty())
    throw SetupError(fmt::format("{}: no position for the loops; give some", setup.name));
  const double limit_N = setup.axis.current_limit_A * setup.axis.motor_constant_N_per_A;
  for (const double amplitude : request.amplitudes) {
    if (!(std::isfinite(amplitude) && amplitude > 0.0)) {
      throw SetupError(fmt::format("an amplitude of {:g} {} cannot move the axis; give a positive one",
                                   amplitude, request.by_force ? "N" : "m"));
    }
    if (request.by_force && amplitude > limit_N) {
      throw SetupError(fmt::format("the drive of {} gives at most {:g} N, not {:g}; lower the force",
                                   setup.name, limit_N, amplitude));
    }
    if (request.by_force && amplitude >= setup.axis.curve.saturation_N()) {
      throw SetupError(
          fmt::format("{:g} N are beyond the friction's level of {:g} N: the axis slides away; give less",
                      amplitude, setup.axis.curve.saturation_N()));
    }
    if (!request.by_force && request.sensors && amplitude < 0.5 * setup.sensors.encoder_resolution_m) {
      throw SetupError(fmt::format(
          "an amplitude of {:g} m is less than half an encoder step of {:g} m; give more, or leave "
          "--sensors out",
          amplitude, setup.sensors.encoder_resolution_m));
    }
  }
  for (const double position_m : request.positions_m) {
    if (!(position_m >= 0.0 && position_m <= setup.axis.stroke_m)) {
      throw SetupError(fmt::format("position {:g} m lies off the stroke of {:g} m; give one on it",
                                   position_m, setup.axis.stroke_m));
    }
  }
  if (!(request.frequency_Hz > 0.0)) throw SetupError("loops need a frequency above 0 Hz");
  if (request.frequency_Hz >= 0.5 * setup.sensors.sample_rate_Hz) {
    throw SetupError(fmt::format("{:g} Hz is not below half the sampling rate of {} ({:g} Hz); lower it",
                                 request.frequency_Hz, setup.name, 0.5 * setup.sensors.sample_rate_Hz));
  }
  // Quasi-static: the force of inertia at the frequency stays small beside the stiffness.
  const double travel_m = setup.axis.curve.travel_m();
  const double natural_Hz =
      std::sqrt(setup.axis.curve.force_N(travel_m) / travel_m / moving_mass_kg(setup)) / kTurn;
  if (request.frequency_Hz > 0.2 * natural_Hz) {
    throw SetupError(
        fmt::format("{:g} Hz is not quasi-static for {}: it swings at some {:.3g} Hz; stay below a fifth",
                    request.frequency_Hz, setup.name, natural_Hz));
  }
}

void evaluate_loop(MeasuredLoop& loop) {
  auto& x = loop.displacement_m;
  auto& force = loop.force_N;
  const auto [low, high] = std::minmax_element(x.begin(), x.end());
  const double top_N = force[static_cast<std::size_t>(high - x.begin())];
  const double bottom_N = force[static_cast<std::size_t>(low - x.begin())];
  loop.amplitude_m = 0.5 * (*high - *low);
  loop.force_amplitude_N = 0.5 * (top_N - bottom_N);
  const double middle_m = 0.5 * (*high + *low);
  double twice_area = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const std::size_t next = (k + 1) % x.size();
    twice_area += (force[next] + force[k]) * (x[next] - x[k]);
  }
  loop.area_J = 0.5 * twice_area;
  for (double& value : x) value -= middle_m;
  const double a = loop.amplitude_m;
  loop.stiffness_N_per_m = loop.force_amplitude_N / a;
  loop.damping_N_per_m = loop.area_J / (std::numbers::pi * a * a);
  loop.damping_ratio = loop.area_J / (kTurn * a * loop.force_amplitude_N);
}

std::size_t loop_count(const LoopRequest& request) {
  return request.positions_m.size() * request.amplitudes.size();
}

MeasuredLoop measure_loop(const ExperimentSetup& setup, const LoopRequest& request, std::size_t index) {
  const double position_m = request.positions_m[index / request.amplitudes.size()];
  const double asked = request.amplitudes[index % request.amplitudes.size()];
  const Rng noise(request.seed, fmt::format("loop noise {}", index));
  MeasuredLoop loop = request.by_force ? loop_by_force(setup, request, position_m, asked, noise)
                                       : loop_by_displacement(setup, request, position_m, asked, noise);
  loop.position_m = position_m;
  loop.asked = asked;
  evaluate_loop(loop);
  loop.closed_form_damping_ratio = equivalent(setup.axis.curve, loop.amplitude_m).resonance_damping_ratio;
  // Rolling has begun where the virgin curve's tangent at the tip is a twentieth of its first.
  const double a = loop.amplitude_m;
  const double first = setup.axis.curve.force_N(1e-3 * a) / (1e-3 * a);
  const double tip = (setup.axis.curve.force_N(1.01 * a) - setup.axis.curve.force_N(0.99 * a)) / (0.02 * a);
  loop.rolling = tip < 0.05 * first;
  return loop;
}

std::vector<MeasuredLoop> run_loops(const ExperimentSetup& setup, const LoopRequest& request) {
  check_loops(setup, request);
  std::vector<MeasuredLoop> loops;
  for (std::size_t i = 0; i < loop_count(request); ++i) loops.push_back(measure_loop(setup, request, i));
  return loops;
}

}  // namespace slipstack::sim
