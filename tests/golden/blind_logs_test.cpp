// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/golden/shared_data.h"
#include "workbench/estimate/uncertainty/standard_errors.h"

// Six logs made by a generator that shares no code with the project; truth.json states the hidden effects.
namespace slipstack::workbench {
namespace {

/// The generator discretised its mode by the trapezoidal rule, which shifts a frequency by (2 pi f
/// T)^2/12: 2.0e-4 at 15.6 Hz and 2 kHz, a hundred standard errors; the damping by about 5e-4.
constexpr double kGenerator = 6e-4;

class BlindLog : public testing::TestWithParam<int> {
 protected:
  void diagnose_log(const std::string& name) {
    const auto truth_file = shared_file("hidden_effect/truth.json");
    truth_ = nlohmann::json::parse(std::ifstream(truth_file))[name];
    Measurement measurement = measured(shared_file(("hidden_effect/" + name + ".csv").c_str()));
    force_noise_N_ = measurement.force_noise_N();
    diagnosis_ = diagnose(measurement,
                          {.baseline = {"inertia", "presliding_hysteresis"}, .start = {}, .progress = {}});
    best_ = with_standard_errors(measurement, diagnosis_.best).terms;
  }
  const Term& found() const { return diagnosis_.candidates.front().term; }

  /// A shape of the effect that was found lies within `share` of the truth, and within its standard error
  /// plus the error of the generator.
  void expect_shape(std::size_t index, const char* key, double share) {
    const Term& term = *find_term(best_, found().id());
    const double truth = truth_[key];
    const double error = term.shape_standard_errors[index];
    EXPECT_NEAR(found().shapes[index], truth, share * truth);
    EXPECT_NEAR(term.shapes[index], truth, 4.0 * error + kGenerator * truth);
    EXPECT_LT(error, share * truth) << "an error that says nothing";
    EXPECT_GT(error, 1e-6 * truth);
  }

  Diagnosis diagnosis_;
  Terms best_;
  nlohmann::json truth_;
  double force_noise_N_ = 0.0;
};

TEST_P(BlindLog, IsDiagnosedCorrectly) {
  SKIP_WITHOUT(shared_file("hidden_effect/truth.json"));
  diagnose_log("blind_" + std::to_string(GetParam()));
  const std::string hidden = truth_["effects"][0];
  if (hidden == "none") {
    EXPECT_EQ(diagnosis_.verdict, Verdict::complete);
    EXPECT_EQ(diagnosis_.steps.size(), 1u);
  } else {
    EXPECT_EQ(diagnosis_.verdict, Verdict::missing_effect);
    EXPECT_EQ(found().id(), hidden);
    EXPECT_EQ(diagnosis_.steps.size(), 2u) << "further effects were named";
  }
  // The noise floor agrees with the noise that the generator added, and the error with the noise floor.
  const double noise_N = truth_["noise_N"];
  EXPECT_NEAR(force_noise_N_, noise_N, 0.03 * noise_N);
  const double over_floor = diagnosis_.best.holdout_rmse_N / diagnosis_.noise_floor_N;
  EXPECT_LE(over_floor, 1.15);
  EXPECT_GE(over_floor, 0.9) << "better than the noise allows";
}

INSTANTIATE_TEST_SUITE_P(All, BlindLog, testing::Range(1, 7));

TEST_F(BlindLog, ViscousCoefficientIsFound) {
  SKIP_WITHOUT(shared_file("hidden_effect/truth.json"));
  diagnose_log("blind_1");
  EXPECT_NEAR(found().gains[0], truth_["c"].get<double>(), 0.01 * truth_["c"].get<double>());
  const Term& viscous = *find_term(best_, "viscous");
  EXPECT_NEAR(viscous.gains[0], truth_["c"].get<double>(), 4.0 * viscous.gain_standard_errors[0]);
}

TEST_F(BlindLog, StribeckVelocityIsFound) {
  SKIP_WITHOUT(shared_file("hidden_effect/truth.json"));
  diagnose_log("blind_2");
  expect_shape(0, "vs", 0.05);
  EXPECT_NEAR(found().shapes[1], 1.0, 0.05);  // the log's weakening is exponential
}

TEST_F(BlindLog, RipplePitchIsFound) {
  SKIP_WITHOUT(shared_file("hidden_effect/truth.json"));
  diagnose_log("blind_4");
  expect_shape(0, "pitch_m", 1e-3);
}

TEST_F(BlindLog, ResonanceIsFound) {
  SKIP_WITHOUT(shared_file("hidden_effect/truth.json"));
  diagnose_log("blind_5");
  expect_shape(0, "f0", 2e-3);
  expect_shape(1, "zeta", 0.05);
}

}  // namespace
}  // namespace slipstack::workbench
