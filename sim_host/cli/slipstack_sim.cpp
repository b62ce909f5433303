// SPDX-License-Identifier: Apache-2.0
// slipstack-sim: simulated measurements of a linear axis, and a file with their true parameters.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim_host/cli/define_sim.h"
#include "sim_host/log/closed_loop.h"
#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "sim_host/log/write.h"
#include "sim_host/motion/set_points.h"

namespace {

using namespace slipstack::sim;

// Wrong use, reported in one line.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::vector<EffectId> parse_effects(const std::string& list, std::uint64_t seed) {
  if (list.empty() || list == "random") return draw_effect_ids(1, seed);
  if (list == "random:2") return draw_effect_ids(2, seed);
  if (list == "none") return {};
  std::vector<EffectId> ids;
  for (std::size_t start = 0; start <= list.size();) {
    const std::size_t end = std::min(list.find(',', start), list.size());
    const std::string word = list.substr(start, end - start);
    const auto id = effect_by_name(word);
    if (!id || *id == EffectId::kInertia || *id == EffectId::kPreslidingHysteresis ||
        *id == EffectId::kOutside) {
      throw UsageError("--effects: '" + word +
                       "' is not an effect that can be hidden; see slipstack-sim effects");
    }
    ids.push_back(*id);
    start = end + 1;
  }
  return ids;
}

OutsideKind parse_outside(const std::string& word) {
  if (const auto kind = outside_by_name(word)) return *kind;
  throw UsageError("--outside: '" + word +
                   "' is none of line, bump, backlash, burst, slip, ring, force_filter");
}

void check(const LogRequest& request) {
  if (request.setup != "pick_and_place" && request.setup != "random") {
    throw UsageError("--setup: '" + request.setup + "' is neither pick_and_place nor random");
  }
  if (request.seed_number < 0) throw UsageError("--seed: must not be negative");
  if (request.seconds != 0.0 && !(request.seconds >= 8.0 && request.seconds <= 3600.0)) {
    throw UsageError("--seconds: must be between 8 and 3600");
  }
  if (request.rate_Hz != 0.0 && !(request.rate_Hz >= 200.0 && request.rate_Hz <= 50000.0)) {
    throw UsageError("--rate: must be between 200 and 50000 Hz");
  }
  if (!(request.strength >= 0.0 && request.strength <= 1000.0)) {
    throw UsageError("--strength: must be a positive multiple of the noise floor, at most 1000");
  }
}

// The motion of a file, within the stroke of the axis.
MotionProgramme programme_of(const std::string& path, const Axis& axis) {
  SetPointFile points = read_set_points(path);
  for (std::size_t i = 0; i < points.position_m.size(); ++i) {
    if (!(points.position_m[i] >= 0.0 && points.position_m[i] <= axis.stroke_m)) {
      throw UsageError(path + ": set point " + std::to_string(i + 1) + " lies outside the stroke, 0 to " +
                       std::to_string(axis.stroke_m) + " m");
    }
  }
  MotionProgramme programme;
  programme.append(make_sampled(std::move(points.position_m), points.rate_Hz));
  return programme;
}

void write_log(const LogRequest& request) {
  check(request);
  const Setup setup = request.setup == "random" ? Setup::kRandom : Setup::kPickAndPlace;
  Bench bench = draw_bench(setup, request.seed());
  if (request.seconds > 0.0) bench.programme.seconds = request.seconds;
  if (request.rate_Hz > 0.0) bench.rate_Hz = request.rate_Hz;
  // An effect outside the catalogue acts alone unless effects are named.
  const bool outside_alone = !request.outside.empty() && request.effects.empty();
  const auto effects =
      outside_alone ? std::vector<EffectId>{} : parse_effects(request.effects, request.seed());
  const MotionProgramme programme = draw_programme(bench, request.seed());
  add_effects(bench.axis, effects, programme, bench.rate_Hz, request.strength, request.seed());
  if (!request.outside.empty()) {
    add_outside(bench.axis, parse_outside(request.outside), programme, bench.rate_Hz, request.strength,
                request.seed());
  }
  // The strength of the effects refers to the usual programme, whatever motion is recorded.
  const MotionProgramme asked =
      request.set_points.empty() ? MotionProgramme() : programme_of(request.set_points, bench.axis);
  const MotionProgramme& motion_run = request.set_points.empty() ? programme : asked;
  const SimulatedLog log =
      request.closed_loop ? simulate_closed_loop_log(bench.axis, motion_run, bench.rate_Hz, request.seed())
                          : simulate_log(bench.axis, motion_run, bench.rate_Hz, request.seed());
  const TruthContext context = {request.setup, request.seed(), request.closed_loop, effects, request.outside};
  write_file(request.out, log_as_csv(bench.axis, log));
  if (!request.truth.empty()) write_file(request.truth, truth_as_json(bench.axis, log, context));
}

void list_effects() {
  for (const EffectId id : drawable_effects()) std::puts(std::string(name(id)).c_str());
  std::puts(std::string(name(EffectId::kCoulomb)).c_str());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app;
  app.name("slipstack-sim");
  LogRequest request;
  define_sim(app, request);
  try {
    app.parse(argc, argv);
    if (app.got_subcommand("effects")) list_effects();
    if (app.got_subcommand("log")) write_log(request);
    return 0;
  } catch (const CLI::CallForHelp&) {
    std::fputs(app.help("", CLI::AppFormatMode::All).c_str(), stdout);
    return 0;
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "slipstack-sim: %s (see --help)\n", error.what());
    return 2;
  } catch (const UsageError& error) {
    std::fprintf(stderr, "slipstack-sim: %s\n", error.what());
    return 2;
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "slipstack-sim: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "slipstack-sim: internal fault: %s\n", error.what());
    return 1;
  }
}
