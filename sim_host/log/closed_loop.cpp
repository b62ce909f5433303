// SPDX-License-Identifier: Apache-2.0
#include "sim_host/log/closed_loop.h"

#include <cmath>
#include <stdexcept>

#include "sim_host/control/cascade.h"
#include "sim_host/plant/plant.h"

namespace slipstack::sim {

SimulatedLog simulate_closed_loop_log(const Axis& axis, const MotionProgramme& programme, double rate_Hz,
                                      std::uint64_t seed, bool keep_parts) {
  if (!(rate_Hz > 0.0)) throw std::invalid_argument("log: rate must be positive");
  const int ticks_per_sample = static_cast<int>(std::ceil(5000.0 / rate_Hz));
  const double tick_s = 1.0 / (rate_Hz * ticks_per_sample);
  const auto ticks = static_cast<std::size_t>(std::ceil(programme.duration_s() / tick_s));
  Recorder recorder(axis, rate_Hz, ticks_per_sample, keep_parts, Rng(seed, "noise"));
  recorder.reserve(ticks / static_cast<std::size_t>(ticks_per_sample) + 1);

  Rng rng(seed, "controller");
  const double start_m = programme.at(0.0).x_m;
  Plant plant(axis, start_m);
  const Encoder& encoder = recorder.encoder();
  CascadeController controller(CascadeController::tuned(axis, rng.uniform(25.0, 50.0)), tick_s,
                               encoder.position_m(start_m));
  double previous_A = 0.0;
  for (std::size_t i = 0; i < ticks; ++i) {
    const double t_s = static_cast<double>(i) * tick_s;
    const MotionPoint reference = programme.at(t_s);
    const double noise_N = recorder.draw_noise_N();
    const double measured_m = encoder.position_m(plant.position_m(), t_s);
    const double current_A = controller.update_N(reference, measured_m) / axis.motor_constant_N_per_A;
    const bool logged = recorder.logs_next();
    // A command is held until the next one; at the instant of the encoder reading the current is taken as the
    // mean of the commands before and after it.
    const double around_A = 0.5 * (previous_A + current_A);
    previous_A = current_A;
    recorder.push(plant.position_m(), plant.parts(around_A, noise_N), -noise_N);
    if (logged) recorder.add_reference(reference.x_m);
    plant.step(current_A, tick_s, noise_N);
    if (!(std::fabs(plant.position_m() - reference.x_m) < axis.stroke_m)) {
      throw std::runtime_error(
          "closed loop: the controller lost the axis; choose another seed or a weaker effect");
    }
  }
  return recorder.finish();
}

}  // namespace slipstack::sim
