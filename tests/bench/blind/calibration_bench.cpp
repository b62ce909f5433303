// SPDX-License-Identifier: Apache-2.0
// Whether estimates lie as near to the truth as their standard errors state: simulated axes with one known
// effect each, recorded several times with different noise. Bias (of the mean over the records) and scatter
// are reported separately.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>

#include "sim_host/log/closed_loop.h"
#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "sim_host/log/write.h"
#include "tests/bench/blind/estimates.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/estimate/nonlinear/robust.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/log/log.h"

namespace {

using namespace slipstack;
using bench::Estimate;
using nlohmann::json;

constexpr sim::EffectId kEffects[] = {
    sim::EffectId::kViscous,     sim::EffectId::kQuadraticDrag,       sim::EffectId::kOffsetForce,
    sim::EffectId::kPayloadMass, sim::EffectId::kCableChainStiffness, sim::EffectId::kForceRipple,
    sim::EffectId::kTimeDelay,   sim::EffectId::kStructuralResonance,
};

/// Every third axis is recorded under control.
bool under_control(std::uint64_t seed) {
  return seed % 3 == 0;
}

/// Factors by which sensors and amplifier of each axis are better than drawn: to find the cause of a bias.
struct Instruments {
  double noise = 1.0;
  double resolution = 1.0;
};

/// The estimates of the hidden effect of one axis: one list for each record.
std::vector<std::vector<Estimate>> records_of(sim::EffectId effect, std::uint64_t seed, int repeats,
                                              const Instruments& instruments) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
  bench.axis.force_noise_N *= instruments.noise;
  bench.axis.encoder_resolution_m *= instruments.resolution;
  const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
  sim::add_effects(bench.axis, {effect}, programme, bench.rate_Hz, 0.0, seed);
  const bool closed_loop = under_control(seed);
  const std::vector<std::string> effects{"inertia", "presliding_hysteresis", std::string(sim::name(effect))};
  std::vector<std::vector<Estimate>> records;
  for (int k = 0; k < repeats; ++k) {
    const std::uint64_t noise_seed = seed + 1'000'000 * static_cast<std::uint64_t>(k);
    const sim::SimulatedLog log =
        closed_loop ? sim::simulate_closed_loop_log(bench.axis, programme, bench.rate_Hz, noise_seed)
                    : sim::simulate_log(bench.axis, programme, bench.rate_Hz, noise_seed);
    const json truth =
        json::parse(sim::truth_as_json(bench.axis, log, {"random", seed, closed_loop, {effect}, ""}));
    workbench::Measurement measurement(workbench::test::log_of(bench.axis, log));
    workbench::weigh_rows(measurement);
    const workbench::RobustFit fit = workbench::fit_robustly(
        measurement,
        workbench::refine_nominal_shapes(measurement, workbench::fit_effects(measurement, effects, {})));
    records.push_back(
        bench::estimates_of(workbench::with_standard_errors(measurement, fit.model).terms, truth));
    if (records.back().empty()) break;  // the plant has another formula than the catalogue
  }
  return records;
}

/// Deviations in standard errors over many parameters, and what of their mean square is the same in each
/// record of an axis (bias) and what differs (scatter).
struct Deviations {
  double axes = 0.0;
  double of_first = 0.0;  ///< sums of squares
  double bias = 0.0;
  double scatter = 0.0;

  void add(double first, double mean, double own_scatter, double records) {
    axes += 1.0;
    of_first += first * first;
    scatter += own_scatter * own_scatter;
    bias += mean * mean - own_scatter * own_scatter / records;  // the mean scatters, too
  }
  std::string line(const char* name) const {
    const auto rms = [&](double sum) { return std::sqrt(std::max(0.0, sum) / std::max(1.0, axes)); };
    return fmt::format(
        "{:<42} rms deviation {:.2f} in the first record; over all: bias {:.2f}, scatter {:.2f}\n", name,
        rms(of_first), rms(bias), rms(scatter));
  }
};

/// Mean deviation over the records and its scatter, both in standard errors, for each parameter of one axis.
void print_axis(sim::EffectId effect, std::uint64_t seed, const std::vector<std::vector<Estimate>>& records,
                Deviations& sum_of) {
  for (std::size_t i = 0; i < records.front().size(); ++i) {
    double sum = 0.0;
    double squares = 0.0;
    double count = 0.0;
    for (const auto& record : records) {
      if (i >= record.size()) continue;
      const double d = record[i].deviation();
      sum += d;
      squares += d * d;
      count += 1.0;
    }
    const double mean = sum / count;
    const double scatter =
        count > 1.0 ? std::sqrt((squares / count - mean * mean) * count / (count - 1.0)) : 0.0;
    fmt::print(
        stderr, "{:<24} {:>6} {:<7} {:<42} {:>11.5g} {:>11.5g} +- {:<9.2g} bias {:>6.2f} scatter {:.2f}\n",
        sim::name(effect), seed, under_control(seed) ? "closed" : "", records.front()[i].parameter,
        records.front()[i].truth, records.front()[i].value, records.front()[i].standard_error, mean, scatter);
    sum_of.add(records.front()[i].deviation(), mean, scatter, count);
  }
}

struct Axes {
  bool prescribed = true;
  bool controlled = true;
  std::string effect;  ///< empty: each in turn
};

int run(std::uint64_t first_seed, std::uint64_t count, int repeats, const Axes& axes,
        const Instruments& instruments) {
  std::vector<Estimate> of_motion[2];  // prescribed, under control
  Deviations deviations[2];
  for (const sim::EffectId effect : kEffects) {
    if (!axes.effect.empty() && axes.effect != sim::name(effect)) continue;
    for (std::uint64_t seed = first_seed; seed < first_seed + count; ++seed) {
      const bool controlled = under_control(seed);
      if (!(controlled ? axes.controlled : axes.prescribed)) continue;
      const auto records = records_of(effect, seed, repeats, instruments);
      if (records.front().empty()) continue;
      print_axis(effect, seed, records, deviations[controlled]);
      // An axis counts once: systematic errors are the same in each of its records.
      of_motion[controlled].insert(of_motion[controlled].end(), records.front().begin(),
                                   records.front().end());
    }
  }
  fmt::print("\n{}{}", deviations[0].line("prescribed motion"), deviations[1].line("under control"));
  for (const auto& own : of_motion) fmt::print("{}", bench::calibration(own));
  of_motion[0].insert(of_motion[0].end(), of_motion[1].begin(), of_motion[1].end());
  fmt::print("{}", bench::calibration(of_motion[0]));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Whether the stated standard errors are true, on simulated axes whose effect is known");
  std::uint64_t first_seed = 1;
  std::uint64_t count = 10;
  int repeats = 1;
  std::string motion = "both";
  std::string effect;
  Instruments instruments;
  app.add_option("--first-seed", first_seed);
  app.add_option("--count", count, "axes of each effect; those of another formula do not count");
  app.add_option("--repeats", repeats, "records of each axis, with other noise")->check(CLI::PositiveNumber);
  app.add_option("--motion", motion, "axes to record")
      ->check(CLI::IsMember({"both", "prescribed", "controlled"}));
  app.add_option("--effect", effect, "only axes with this effect");
  app.add_option("--noise-factor", instruments.noise, "the force's noise, relative to that drawn");
  app.add_option("--resolution-factor", instruments.resolution, "the encoder's step, relative to that drawn");
  try {
    app.parse(argc, argv);
    return run(first_seed, count, repeats, {motion != "controlled", motion != "prescribed", effect},
               instruments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    fmt::print(stderr, "calibration_bench: {}\n", error.what());
    return 1;
  }
}
