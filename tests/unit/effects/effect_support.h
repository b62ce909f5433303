// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "firmware/effects/catalogue.h"
#include "tests/unit/draw.h"

namespace slipstack::test {

/// Calls visit(std::type_identity<E>{}) for every effect of the catalogue.
template <class Real, class Visit>
void for_each_effect(Visit&& visit) {
  [&]<class... Effects>(std::type_identity<std::tuple<Effects...>>) {
    (visit(std::type_identity<Effects>{}), ...);
  }(std::type_identity<Catalogue<Real>>{});
}

inline constexpr double kTick_s = 1e-4;
inline constexpr double kResolution_m = 1e-7;

/// A sample in double with all numbers exact in float too, so that both precisions are asked the same.
inline Sample<double> rounded(Sample<double> sample) {
  const auto round = [](double& value) { value = static_cast<double>(static_cast<float>(value)); };
  round(sample.time_s);
  round(sample.position_m);
  round(sample.velocity_mps);
  round(sample.acceleration_mps2);
  round(sample.dry_friction_N);
  return sample;
}

/// An instant of no particular motion: every magnitude that an axis can have.
inline Sample<double> random_sample(Draw& draw) {
  Sample<double> sample;
  sample.time_s = draw.log_uniform(1e-3, 1e4);
  sample.position_m = draw.uniform(-0.5, 0.5);
  sample.displacement = sample.position_m;
  sample.velocity_mps = draw.sign() * draw.log_uniform(1e-7, 3.0);
  sample.acceleration_mps2 = draw.sign() * draw.log_uniform(1e-4, 50.0);
  sample.dry_friction_N = draw.sign() * draw.log_uniform(1e-3, 100.0);
  return rounded(sample);
}

/// Whole counts, as the target's encoder gives them.
inline std::int32_t counts(double displacement_m) {
  return static_cast<std::int32_t>(std::lround(displacement_m / kResolution_m));
}

/// The same instant for the target.
inline Sample<float> on_target(const Sample<double>& sample) {
  Sample<float> out;
  out.time_s = static_cast<float>(sample.time_s);
  out.displacement = counts(sample.displacement);
  out.position_m = static_cast<float>(sample.position_m);
  out.velocity_mps = static_cast<float>(sample.velocity_mps);
  out.acceleration_mps2 = static_cast<float>(sample.acceleration_mps2);
  out.dry_friction_N = static_cast<float>(sample.dry_friction_N);
  return out;
}

/// A smooth random motion on a grid of counts: sums of sines from creeping to fast moves, with stops.
inline std::vector<Sample<double>> random_motion(std::uint64_t seed, std::size_t count) {
  Draw draw(seed);
  struct Wave {
    double amplitude_m, rad_per_s, phase;
  };
  std::vector<Wave> waves;
  for (const double amplitude : {0.1, 0.01, 1e-3, 1e-4, 3e-5, 1e-5}) {
    const double fastest = std::sqrt(20.0 / amplitude);
    waves.push_back(
        {amplitude * draw.uniform(0.5, 1.0), fastest * draw.uniform(0.02, 0.4), draw.uniform(0.0, 6.28)});
  }
  std::vector<Sample<double>> motion(count);
  for (std::size_t i = 0; i < count; ++i) {
    Sample<double>& sample = motion[i];
    sample.time_s = static_cast<double>(i) * kTick_s;
    for (const Wave& wave : waves) {
      const double angle = wave.rad_per_s * sample.time_s + wave.phase;
      sample.position_m += wave.amplitude_m * std::sin(angle);
      sample.velocity_mps += wave.amplitude_m * wave.rad_per_s * std::cos(angle);
      sample.acceleration_mps2 -= wave.amplitude_m * wave.rad_per_s * wave.rad_per_s * std::sin(angle);
    }
    sample.displacement = counts(sample.position_m) * kResolution_m;
    sample = rounded(sample);
  }
  return motion;
}

/// Random shapes within the bounds of the effect and of what an axis has.
template <class E>
std::array<double, E::shape_count> random_shapes(Draw& draw) {
  std::array<double, E::shape_count> shapes{};
  std::size_t i = 0;
  for (double& shape : shapes) {
    const ShapeSpec& spec = E::shapes[i++];
    switch (spec.kind) {
      case ShapeKind::exponent:
        shape = draw.uniform(0.5, 2.5);
        break;
      case ShapeKind::nominal_exponent:
        shape = draw.uniform(1.6, 2.4);
        break;
      case ShapeKind::time_constant:
        shape = draw.log_uniform(1.0, 2.0);
        break;
      case ShapeKind::duration:
        shape = draw.log_uniform(0.5, 5.0);
        break;
      case ShapeKind::delay:
        shape = draw.uniform(-0.01, 0.01);
        break;
      case ShapeKind::filter:
        shape = draw.uniform(0.0, 0.01);
        break;
      case ShapeKind::pitch:
        shape = draw.log_uniform(1e-3, 0.1);
        break;
      case ShapeKind::frequency:
        shape = draw.log_uniform(5.0, 300.0);
        break;
      case ShapeKind::damping:
        shape = draw.log_uniform(0.01, 0.2);
        break;
      case ShapeKind::acceleration:
        shape = draw.log_uniform(0.1, 100.0);
        break;
      case ShapeKind::lag_distance:
        shape = draw.log_uniform(1e-3, 0.1);
        break;
      case ShapeKind::position:
        shape = draw.uniform(-0.15, -0.05);
        break;
      case ShapeKind::travel:
        shape = draw.uniform(0.1, 0.3);
        break;
      case ShapeKind::slip_distance:
        shape = kResolution_m * std::round(draw.log_uniform(2.0, 2e4));
        break;
      case ShapeKind::table:
        shape = std::string_view(spec.unit) == "1/m"   ? draw.uniform(60.0, 600.0)
                : std::string_view(spec.unit) == "s/m" ? draw.uniform(10.0, 60.0)
                : std::string_view(spec.unit) == "m"   ? draw.uniform(-0.15, -0.05)
                                                       : draw.log_uniform(1e-3, 9e-3);
        break;
      default:  // velocities
        shape = draw.log_uniform(1e-3, 9e-3);
        break;
    }
    shape = static_cast<double>(static_cast<float>(shape));
  }
  return shapes;
}

/// Bases of an effect along samples, one row each.
template <class E, class Real>
std::vector<std::array<Real, E::gain_count>> run(E& effect, const std::vector<Sample<Real>>& samples) {
  std::vector<std::array<Real, E::gain_count>> rows(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) effect.basis(samples[i], rows[i]);
  return rows;
}

template <class Real, std::size_t N>
std::array<Real, N> as(const std::array<double, N>& values) {
  std::array<Real, N> out{};
  for (std::size_t i = 0; i < N; ++i) out[i] = static_cast<Real>(values[i]);
  return out;
}

}  // namespace slipstack::test
