// SPDX-License-Identifier: Apache-2.0
#include "tests/browser/synthetic_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

namespace slipstack::test {
namespace {

using nlohmann::json;
using Series = std::vector<double>;

constexpr double kRate_Hz = 2000.0;
constexpr std::size_t kSamples = 40000;
constexpr double kMass_kg = 35.45;
constexpr double kPitch_m = 0.024;
constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kHole = std::numeric_limits<double>::quiet_NaN();

struct Axis {
  Series time_s, position_m, velocity_mps, acceleration_mps2, friction_N, ripple_N, noise_N;
};

/// Slow traverses, then fast moves, then two bursts of small loops: each part shows something else.
double reference_m(double time_s) {
  if (time_s < 8.0) return 0.12 - 0.10 * std::cos(kTwoPi * time_s / 4.0);
  if (time_s < 14.0) return 0.12 - 0.10 * std::cos(kTwoPi * (time_s - 8.0) / 0.75);
  const double small = time_s - 14.0;
  return 0.02 + 40e-6 * std::sin(kTwoPi * small / 1.0) + 12e-6 * std::sin(kTwoPi * small / 0.2);
}

Axis simulate(std::mt19937& random) {
  // Eight elastic sliders in parallel; the report needs a plausible loop, not the plant.
  constexpr std::array<double, 8> kSlip_m = {1e-6, 2e-6, 4e-6, 8e-6, 14e-6, 24e-6, 40e-6, 70e-6};
  constexpr std::array<double, 8> kLevel_N = {0.6, 1.0, 1.6, 2.2, 2.6, 2.6, 2.4, 2.0};
  std::array<double, 8> stretch_m{};
  std::normal_distribution<double> noise_N(0.0, 0.33);
  Axis axis;
  const double dt = 1.0 / kRate_Hz;
  double previous = reference_m(0.0);
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double t = static_cast<double>(i) * dt;
    const double x = reference_m(t);
    double friction_N = 0.0;
    for (std::size_t k = 0; k < stretch_m.size(); ++k) {
      stretch_m[k] = std::clamp(stretch_m[k] + x - previous, -kSlip_m[k], kSlip_m[k]);
      friction_N += kLevel_N[k] * stretch_m[k] / kSlip_m[k];
    }
    previous = x;
    axis.time_s.push_back(t);
    axis.position_m.push_back(x);
    axis.velocity_mps.push_back((reference_m(t + dt) - reference_m(t - dt)) / (2.0 * dt));
    const bool jump = std::abs(t - 8.0) < 2.0 * dt || std::abs(t - 14.0) < 2.0 * dt;
    const double a = (reference_m(t + dt) - 2.0 * x + reference_m(t - dt)) / (dt * dt);
    axis.acceleration_mps2.push_back(jump ? 0.0 : a);
    axis.friction_N.push_back(friction_N);
    axis.ripple_N.push_back(4.2 * std::sin(kTwoPi * x / kPitch_m) +
                            1.5 * std::sin(2.0 * kTwoPi * x / kPitch_m + 0.7));
    axis.noise_N.push_back(noise_N(random));
  }
  return axis;
}

double rmse(const Series& values) {
  double sum = 0.0;
  double count = 0.0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    sum += value * value;
    count += 1.0;
  }
  return std::sqrt(sum / count);
}

json list(const Series& values) {
  json out = json::array();
  for (const double value : values) out.push_back(std::isnan(value) ? json() : json(value));
  return out;
}

/// Mean and spread of `values` in equal bins of `x`, for the samples that `keep` lets through.
struct Binned {
  Series x, mean, spread;
};

Binned binned(const Series& x, const Series& values, const std::function<bool(std::size_t)>& keep) {
  constexpr std::size_t kBins = 96;
  const auto [low, high] = std::ranges::minmax(x);
  Series count(kBins), sum(kBins), square(kBins);
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::isnan(values[i]) || !keep(i)) continue;
    const double share = (x[i] - low) / (high - low) * kBins;
    const std::size_t bin = std::min(kBins - 1, static_cast<std::size_t>(share));
    count[bin] += 1.0;
    sum[bin] += values[i];
    square[bin] += values[i] * values[i];
  }
  Binned out;
  for (std::size_t b = 0; b < kBins; ++b) {
    const bool enough = count[b] >= 5.0;
    const double mean = enough ? sum[b] / count[b] : kHole;
    out.x.push_back(low + (static_cast<double>(b) + 0.5) * (high - low) / kBins);
    out.mean.push_back(mean);
    out.spread.push_back(enough ? std::sqrt(std::max(0.0, square[b] / count[b] - mean * mean)) : kHole);
  }
  return out;
}

json profile(const char* coordinate, const char* unit, const Series& x, const Series& residual,
             const Series& after, const Series& velocity) {
  const auto all = [](std::size_t) { return true; };
  const Binned mean = binned(x, residual, all);
  json out = {{"coordinate", coordinate},
              {"title", std::string("Residual against ") + coordinate},
              {"unit", unit},
              {"x", list(mean.x)},
              {"mean_N", list(mean.mean)},
              {"spread_N", list(mean.spread)}};
  if (!after.empty()) out["after_mean_N"] = list(binned(x, after, all).mean);
  if (std::string(coordinate) == "position") {
    const auto forward = [&](std::size_t i) { return velocity[i] > 0.0; };
    const auto backward = [&](std::size_t i) { return velocity[i] < 0.0; };
    out["forward_mean_N"] = list(binned(x, residual, forward).mean);
    out["backward_mean_N"] = list(binned(x, residual, backward).mean);
  }
  return out;
}

/// Amplitude density by averaged Hann windows of 1024 samples, by plain summation at logarithmic frequencies.
Series amplitude_density(const Series& values, const Series& frequency_Hz) {
  constexpr std::size_t kWindow = 4096;
  Series out;
  for (const double f : frequency_Hz) {
    double power = 0.0;
    double windows = 0.0;
    for (std::size_t start = 0; start + kWindow <= values.size(); start += 2 * kWindow) {
      std::complex<double> sum = 0.0;
      for (std::size_t i = 0; i < kWindow; ++i) {
        const double hann = 0.5 - 0.5 * std::cos(kTwoPi * static_cast<double>(i) / kWindow);
        const double value = std::isnan(values[start + i]) ? 0.0 : values[start + i];
        sum += hann * value * std::polar(1.0, -kTwoPi * f * static_cast<double>(i) / kRate_Hz);
      }
      power += std::norm(sum) * 2.0 / (kRate_Hz * 0.375 * kWindow);
      windows += 1.0;
    }
    out.push_back(std::sqrt(power / windows));
  }
  return out;
}

json loop(const std::string& title, const Axis& axis, const Series& model, const Series& after,
          std::size_t from, std::size_t to) {
  const auto cut = [&](const Series& s) {
    return Series(s.begin() + static_cast<std::ptrdiff_t>(from), s.begin() + static_cast<std::ptrdiff_t>(to));
  };
  Series displacement = cut(axis.position_m);
  Series measured;
  for (std::size_t i = from; i < to; ++i)
    measured.push_back(axis.friction_N[i] + axis.ripple_N[i] + axis.noise_N[i]);
  const double centre = 0.5 * (std::ranges::min(displacement) + std::ranges::max(displacement));
  for (double& value : displacement) value -= centre;
  json out = {{"title", title},
              {"displacement_m", list(displacement)},
              {"measured_N", list(measured)},
              {"model_N", list(cut(model))}};
  if (!after.empty()) {
    Series better;
    for (std::size_t i = from; i < to; ++i) better.push_back(measured[i - from] - after[i]);
    out["after_N"] = list(better);
  }
  return out;
}

constexpr const char* kCriterionNote =
    "Criterion: change of the information criterion by the effect; the log supports the effect below -2.";

struct Candidate {
  const char* effect;
  const char* title;
  double share;
  double share_se;
  std::vector<const char*> confounded;
};

json candidates(double before_N, double after_N, double others) {
  const std::vector<Candidate> rows = {
      {"force_ripple", "Force ripple", 1.0 - after_N / before_N, 0.004, {"motor_constant_ripple"}},
      {"motor_constant_ripple", "Motor constant ripple", 0.41, 0.05, {"force_ripple"}},
      {"position_dependent_preload", "Position-dependent preload", 0.118, 0.031, {}},
      {"cable_chain_stiffness", "Cable chain stiffness", 0.021, 0.014, {}},
      {"stribeck", "Stribeck", 0.006, 0.009, {"frictional_lag"}},
      {"time_delay", "Time delay", 0.003, 0.004, {}},
      {"viscous", "Viscous friction", 0.001, 0.003, {}},
      {"offset_force", "Offset force", 0.0, 0.002, {}},
      {"direction_asymmetry", "Direction asymmetry", -0.004, 0.006, {}},
      {"payload_mass", "Payload mass", -0.011, 0.008, {}},
  };
  json out = json::array();
  for (Candidate row : rows) {
    if (!out.empty()) row.share *= others;
    out.push_back(
        {{"effect", row.effect},
         {"title", row.title},
         {"holdout_rmse_N", before_N * (1.0 - row.share)},
         {"error_reduction", row.share},
         {"error_reduction_se", row.share_se},
         {"criterion_difference", 12.0 - 1e4 * row.share},
         {"confounded_with", row.confounded},
         {"evidence",
          "The residual repeats every 24.0 mm of position, the same in both directions, and does not grow "
          "with force."},
         {"cause",
          "Cogging: the magnets attract the iron core more strongly at some positions than at others."},
         {"confirm_with",
          "Move at constant 5 mm/s over 200 mm both ways: force against position must lie on one curve with "
          "a 24.0 mm period."}});
  }
  return out;
}

json parameter(const std::string& name, double value, double error, const char* unit, const char* note) {
  return {{"name", name},
          {"value", value},
          {"standard_error", error > 0.0 ? json(error) : json()},
          {"unit", unit},
          {"note", note}};
}

json parameters(std::mt19937& random) {
  std::uniform_real_distribution<double> jitter(0.8, 1.2);
  json hysteresis = json::array();
  for (int i = 0; i < 28; ++i) {
    hysteresis.push_back(parameter(std::string("k").append(std::to_string(i + 1)),
                                   6e5 * std::exp(-0.2 * i) * jitter(random), 2.1e3, "N/m",
                                   i == 0    ? "slips at 0.5 µm"
                                   : i == 27 ? "slips at 120 µm"
                                             : ""));
  }
  return {{{"effect", "inertia"},
           {"title", "Inertia"},
           {"formula", "F = m·a"},
           {"parameters", {parameter("mass", kMass_kg, 0.0, "kg", "from the log")}}},
          {{"effect", "force_ripple"},
           {"title", "Force ripple"},
           {"formula", "F = Σₙ aₙ·sin(2πnx/p) + bₙ·cos(2πnx/p)"},
           {"parameters",
            {parameter("a1", 4.203, 0.0061, "N", "1st harmonic"), parameter("b1", -0.0042, 0.0062, "N", ""),
             parameter("a2", 1.147, 0.0061, "N", "2nd harmonic"), parameter("b2", 0.966, 0.0060, "N", ""),
             parameter("pitch", 0.02400013, 1.4e-6, "m", "searched 5…60 mm")}}},
          {{"effect", "presliding_hysteresis"},
           {"title", "Pre-sliding hysteresis"},
           {"formula", "F = Σᵢ kᵢ·zᵢ,  −Δᵢ ≤ zᵢ ≤ Δᵢ"},
           {"parameters", hysteresis}}};
}

json verdict(const std::string& kind, double before_N, double after_N) {
  std::array<char, 200> detail{};
  if (kind == "missing_effect" || kind == "hostile") {
    std::snprintf(detail.data(), detail.size(),
                  "Adding it lowers the held-out error from %.2f N to %.2f N; noise floor 0.33 N.", before_N,
                  after_N);
    return {{"kind", "missing_effect"}, {"headline", "Missing: force ripple"}, {"detail", detail.data()}};
  }
  if (kind == "complete") {
    return {{"kind", kind},
            {"headline", "Nothing is missing"},
            {"detail",
             "No effect of the catalogue lowers the held-out error by more than 3 %, and what is left has no "
             "structure."}};
  }
  if (kind == "unexplained") {
    return {{"kind", kind},
            {"headline", "Something is left that no effect of the catalogue explains"},
            {"detail", "The residual depends on position, and no candidate removes more than 3 % of it."}};
  }
  return {{"kind", kind},
          {"headline", "The model misses 3.16 N of 13.9 N"},
          {"detail", "Root mean square over the whole log."}};
}

void excluded(Series& values) {
  // The workbench leaves out what its filter cannot see: the ends, and the jumps between the parts of the
  // experiment.
  for (const auto& [from, to] :
       {std::pair<std::size_t, std::size_t>{0, 60}, {15970, 16030}, {27970, 28030}, {39940, 40000}}) {
    std::fill(values.begin() + static_cast<std::ptrdiff_t>(from),
              values.begin() + static_cast<std::ptrdiff_t>(to), kHole);
  }
}

/// Every string of `value` replaced by one that tries to become markup; keys and the names that steer the
/// page stay.
void make_hostile(json& value, const std::string& key) {
  static const std::array<std::string, 6> kAttempts = {"</script><script>window.pwned=1</script><b>",
                                                       "<img src=x onerror=window.pwned=1>",
                                                       "\" onmouseover=\"window.pwned=1\" x=\"",
                                                       "</style><svg onload=window.pwned=1>",
                                                       "<!--<script>{{data}}{{script}}",
                                                       "&lt;b&gt; \xff\xfe <b>' \u2028 ]]>"};
  static std::size_t next = 0;
  if (value.is_string() && key != "kind") {
    value = kAttempts[next++ % kAttempts.size()];
  } else if (value.is_structured()) {
    for (auto it = value.begin(); it != value.end(); ++it)
      make_hostile(*it, value.is_object() ? it.key() : key);
  }
}

json full_report(const std::string& kind, std::uint32_t seed) {
  std::mt19937 random(seed);
  const Axis axis = simulate(random);
  const bool hidden = kind != "complete";
  const bool solved = kind == "missing_effect" || kind == "hostile";
  Series measured, model, residual, after;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double known = kMass_kg * axis.acceleration_mps2[i] + axis.friction_N[i];
    const double ripple = hidden ? axis.ripple_N[i] : 0.0;
    measured.push_back(known + ripple + axis.noise_N[i]);
    model.push_back(known);
    residual.push_back(ripple + axis.noise_N[i]);
    after.push_back(axis.noise_N[i] + 0.015 * axis.ripple_N[i]);
  }
  for (Series* series : {&measured, &model, &residual, &after}) excluded(*series);
  const double before_N = rmse(residual);
  const double after_N = rmse(after);
  if (!solved) after.clear();

  Series frequency_Hz;
  for (int i = 0; i < 240; ++i) frequency_Hz.push_back(0.5 * std::pow(2000.0, i / 239.0));
  json data = {
      {"title", "Friction diagnosis"},
      {"command", "slipstack diagnose pick_and_place_0417.csv --stepwise --report R.html"},
      {"log", "pick_and_place_0417.csv"},
      {"samples", kSamples},
      {"duration_s", kSamples / kRate_Hz},
      {"sample_rate_Hz", kRate_Hz},
      {"header", {{"mass_kg", kMass_kg}, {"magnet_pitch_m", kPitch_m}, {"encoder_resolution_m", 1e-6}}},
      {"verdict", verdict(kind, before_N, after_N)},
      {"figures",
       {{"noise_floor_N", 0.33},
        {"train_rmse_N", before_N * 0.995},
        {"holdout_rmse_N", before_N},
        {"relative_error", before_N / rmse(measured)}}},
      {"baseline_effects", {"inertia", "presliding_hysteresis"}},
      {"series",
       {{"time_s", list(axis.time_s)},
        {"position_m", list(axis.position_m)},
        {"velocity_mps", list(axis.velocity_mps)},
        {"acceleration_mps2", list(axis.acceleration_mps2)},
        {"measured_N", list(measured)},
        {"model_N", list(model)},
        {"residual_N", list(residual)}}},
      {"loops",
       {loop("Pre-sliding loops at 20.0 mm", axis, axis.friction_N, after, 30000, 38000),
        loop("One slow stroke, 200 mm", axis, axis.friction_N, after, 1000, 9000)}},
      {"profiles",
       {profile("position", "m", axis.position_m, residual, after, axis.velocity_mps),
        profile("velocity", "m/s", axis.velocity_mps, residual, after, axis.velocity_mps),
        profile("acceleration", "m/s^2", axis.acceleration_mps2, residual, after, axis.velocity_mps),
        profile("time", "s", axis.time_s, residual, after, axis.velocity_mps)}},
      {"spectrum",
       {{"frequency_Hz", list(frequency_Hz)},
        {"residual_N", list(amplitude_density(residual, frequency_Hz))},
        {"floor_N", 0.33 / std::sqrt(kRate_Hz / 2.0)}}},
      {"unexplained", json()},
      {"notes",
       {"Force and regressors share one zero-phase filter with its corner at 200 Hz.",
        "240 of 40 000 samples were left out: the filter's ends and two jumps of the reference."}},
  };
  if (kind == "comparison") return data;
  data["candidates"] = candidates(before_N, solved ? after_N : before_N * 0.985, solved ? 1.0 : 0.03);
  data["parameters"] = parameters(random);
  if (kind == "unexplained")
    data["unexplained"] = {
        {"coordinate", "position"},
        {"description",
         "the mean residual changes by 9.8 N between 40 mm and 47 mm, twenty times what noise would do."}};
  if (solved) {
    data["figures"]["after_rmse_N"] = after_N;
    data["series"]["after_N"] = list(after);
    data["spectrum"]["after_N"] = list(amplitude_density(after, frequency_Hz));
    data["steps"] = {
        {{"effect", "baseline"}, {"holdout_rmse_N", before_N}},
        {{"effect", "force_ripple"}, {"holdout_rmse_N", after_N}, {"criterion_difference", -8512.3}},
        {{"effect", "cable_chain_stiffness"},
         {"holdout_rmse_N", after_N * 0.985},
         {"criterion_difference", -31.04}}};
    data["criterion_note"] = kCriterionNote;
  }
  return data;
}

}  // namespace

nlohmann::json synthetic_report(const std::string& kind, std::uint32_t seed) {
  if (kind == "bare")
    return {{"title", "Friction diagnosis"},
            {"verdict", {{"kind", "complete"}, {"headline", "Nothing is missing"}}}};
  if (kind != "missing_effect" && kind != "complete" && kind != "unexplained" && kind != "comparison" &&
      kind != "hostile") {
    throw std::invalid_argument("no such kind of report: " + kind);
  }
  json data = full_report(kind, seed);
  if (kind == "hostile") make_hostile(data, "");
  return data;
}

}  // namespace slipstack::test
