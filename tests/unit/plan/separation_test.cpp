// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/detectability/separation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/plan/information.h"

namespace slipstack::workbench {
namespace {

/// A slow sine with white force noise, as a log.
Log sine_log(double amplitude_m, double rate_rad_per_s, int samples) {
  Log log;
  log.sample_rate_Hz = 500.0;
  log.mass_kg = 5.0;
  std::mt19937_64 random(9);
  std::normal_distribution<double> noise(0.0, 0.05);
  for (int i = 0; i < samples; ++i) {
    const double t_s = i / log.sample_rate_Hz;
    log.position_m.push_back(amplitude_m * std::sin(rate_rad_per_s * t_s));
    log.force_N.push_back(-5.0 * amplitude_m * rate_rad_per_s * rate_rad_per_s *
                              std::sin(rate_rad_per_s * t_s) +
                          noise(random));
  }
  return log;
}

TEST(Separation, OfASineIsKnownInClosedForm) {
  const Measurement measurement(sine_log(0.1, 4.0, 12000));
  const FittedModel base = fit_gains(measurement, {term_for_log(measurement, *find_effect("inertia"))});
  // v = w A c and x = A s with c, s of one angle: orthogonal.
  Terms terms{make_term(measurement, *find_effect("viscous")),
              make_term(measurement, *find_effect("quadratic_drag")),
              make_term(measurement, *find_effect("cable_chain_stiffness"))};
  const std::vector<Separation> found = separations(measurement, base, terms, 0.01);
  const auto angle = [&](const std::string& a, const std::string& b) {
    for (const Separation& one : found) {
      if (one.effect == a && one.other == b) return one.angle_deg;
    }
    return -1.0;
  };
  // cos of the angle between c and c|c|: <|c|^3> / sqrt(<c^2> <c^4>), means over a period.
  const double mixed = 4.0 / (3.0 * M_PI);
  const double expected_deg = std::acos(mixed / std::sqrt(0.5 * 0.375)) * 180.0 / M_PI;
  EXPECT_NEAR(angle("viscous", "quadratic_drag"), expected_deg, 0.5);
  EXPECT_NEAR(angle("quadratic_drag", "viscous"), expected_deg, 0.5);
  EXPECT_GT(angle("viscous", "cable_chain_stiffness"), 88.0);
}

TEST(Information, OfPartsAddsUp) {
  const Measurement measurement(sine_log(0.1, 4.0, 12000));
  const FittedModel base = fit_gains(measurement, {term_for_log(measurement, *find_effect("inertia"))});
  std::vector<Information::Expected> effects;
  for (const char* id : {"viscous", "stribeck"}) {
    Term term = make_term(measurement, *find_effect(id));
    for (double& gain : term.gains) gain = 1.0;
    effects.push_back({term, {}});
  }
  const auto rows = measurement.row_samples().size();
  std::vector<int> halves(rows);
  for (std::size_t i = 0; i < rows; ++i) halves[i] = i < rows / 3 ? 0 : 1;
  std::vector<Information> parts = Information::of(measurement, base, effects, halves, 2, {0.1, 4.0});
  const std::vector<Information> whole =
      Information::of(measurement, base, effects, std::vector<int>(rows, 0), 1, {0.1, 4.0});
  const double alone = parts[0].alone(0).chi_squared;
  parts[0].add(parts[1]);
  EXPECT_GT(parts[0].alone(0).chi_squared, alone);
  EXPECT_NEAR(parts[0].alone(0).chi_squared / whole[0].alone(0).chi_squared, 1.0, 1e-9);
  EXPECT_NEAR(parts[0].alone(0).rows, whole[0].alone(0).rows, 0.0);
  // An effect is explained by itself.
  EXPECT_LT(parts[0].against(0, 0).chi_squared, 1e-3 * parts[0].alone(0).chi_squared);
}

}  // namespace
}  // namespace slipstack::workbench
