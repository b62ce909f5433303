// SPDX-License-Identifier: Apache-2.0
#include "sim_host/log/record.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "sim_host/plant/prescribed_axis.h"
#include "sim_host/sensors/low_pass.h"

namespace slipstack::sim {
namespace {

double late_s(const Axis& axis) {
  return axis.effects.delay ? axis.effects.delay->delay_s : 0.0;
}
double filter_s(const Axis& axis) {
  return axis.effects.delay ? axis.effects.delay->filter_s : 0.0;
}

double rms_of(const std::vector<double>& signal) {
  double squares = 0.0;
  for (const double value : signal) squares += value * value;
  return std::sqrt(squares / static_cast<double>(signal.size()));
}

}  // namespace

Recorder::Recorder(const Axis& axis, double rate_Hz, int oversampling, bool keep_parts, Rng noise)
    : axis_(axis),
      oversampling_(oversampling),
      keep_parts_(keep_parts),
      rng_(noise),
      encoder_(axis.encoder_resolution_m, rng_.uniform()),
      delay_(1.0 / (rate_Hz * oversampling), late_s(axis), filter_s(axis)) {
  if (axis.outside.slip) encoder_.set_slip(*axis.outside.slip);
  if (axis.outside.ring) {
    ring_.emplace(1.0 / (rate_Hz * oversampling), axis.outside.ring->frequency_Hz,
                  axis.outside.ring->damping_ratio);
  }
  log_.rate_Hz = rate_Hz;
}

void Recorder::reserve(std::size_t samples) {
  log_.position_m.reserve(samples);
  log_.force_N.reserve(samples);
  log_.true_position_m.reserve(samples);
  log_.noise_N.reserve(samples);
  if (keep_parts_) log_.parts_N.reserve(samples);
}

double Recorder::draw_noise_N() {
  return axis_.force_noise_N > 0.0 ? axis_.force_noise_N * rng_.normal() : 0.0;
}

// Half of the values are outliers, half stay at zero force, as with a loose connector.
double Recorder::burst_N(double t_s) {
  const Burst& burst = *axis_.outside.burst;
  if (t_s < burst.start_s || t_s >= burst.start_s + burst.duration_s) return 0.0;
  return rng_.chance(0.5) ? burst.amplitude_N * rng_.uniform(-1.0, 1.0) : 0.0;
}

void Recorder::push(double position_m, const PerEffect& parts_N, double noise_N) {
  double prompt_N = 0.0;
  for (const double part : parts_N) prompt_N += part;
  const double ring_N = ring_ ? axis_.outside.ring->share * ring_->push(prompt_N) : 0.0;
  prompt_N += ring_N;
  const double late_N = axis_.effects.delay ? delay_.push(prompt_N) : prompt_N;
  const bool logged = phase_ == 0;
  phase_ = (phase_ + 1) % oversampling_;
  if (!logged) return;

  const double t_s = log_.time_s(log_.size());
  PerEffect parts = parts_N;
  parts[index(EffectId::kOutside)] += ring_N;
  log_.ring_rms_N += ring_N * ring_N;
  parts[index(EffectId::kTimeDelay)] += late_N - prompt_N;
  double force_N = late_N;
  if (axis_.outside.burst) {
    const double wild_N = burst_N(t_s);
    parts[index(EffectId::kOutside)] += wild_N;
    force_N += wild_N;
  }
  for (std::size_t i = 0; i < kEffectCount; ++i) log_.parts_rms_N[i] += parts[i] * parts[i];
  if (keep_parts_) log_.parts_N.push_back(parts);
  if (axis_.outside.force_filter) outside_N_.push_back(parts[index(EffectId::kOutside)]);
  log_.position_m.push_back(encoder_.position_m(position_m, t_s));
  log_.true_position_m.push_back(position_m);
  log_.noise_N.push_back(noise_N);
  log_.force_N.push_back(force_N + noise_N);
}

// What the filter takes, of the noise too, is a part outside the catalogue.
void Recorder::filter_force() {
  const ForceFilter& filter = *axis_.outside.force_filter;
  const std::vector<double> smooth_N =
      low_passed(log_.force_N, log_.rate_Hz, filter.cut_Hz, filter.order, filter.zero_phase);
  for (std::size_t i = 0; i < smooth_N.size(); ++i) {
    outside_N_[i] += smooth_N[i] - log_.force_N[i];
    if (keep_parts_) log_.parts_N[i][index(EffectId::kOutside)] = outside_N_[i];
  }
  log_.force_N = smooth_N;
}

SimulatedLog Recorder::finish() {
  const double count = static_cast<double>(log_.size());
  for (double& square : log_.parts_rms_N) square = std::sqrt(square / count);
  log_.ring_rms_N = std::sqrt(log_.ring_rms_N / count);
  if (axis_.outside.force_filter) {
    filter_force();
    log_.parts_rms_N[index(EffectId::kOutside)] = rms_of(outside_N_);
  }
  log_.force_rms_N = rms_of(log_.force_N);
  return std::move(log_);
}

SimulatedLog simulate_log(const Axis& axis, const MotionProgramme& programme, double rate_Hz,
                          std::uint64_t seed, bool keep_parts) {
  if (!(rate_Hz > 0.0)) throw std::invalid_argument("log: rate must be positive");
  const int oversampling = axis.effects.delay || axis.outside.ring ? 8 : 1;
  const double step_s = 1.0 / (rate_Hz * oversampling);
  const auto steps = static_cast<std::size_t>(std::ceil(programme.duration_s() / step_s));
  Recorder recorder(axis, rate_Hz, oversampling, keep_parts, Rng(seed, "noise"));
  recorder.reserve(steps / static_cast<std::size_t>(oversampling) + 1);
  PrescribedAxis plant(axis, programme);
  for (std::size_t i = 0; i < steps; ++i) {
    if (i > 0) plant.advance_to(static_cast<double>(i) * step_s);
    const double noise_N = recorder.logs_next() ? recorder.draw_noise_N() : 0.0;
    recorder.push(plant.motion().x_m, plant.parts(), noise_N);
  }
  return recorder.finish();
}

}  // namespace slipstack::sim
