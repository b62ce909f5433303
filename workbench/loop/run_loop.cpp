// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/run_loop.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <tuple>
#include <type_traits>
#include <vector>

#include "firmware/app/lockstep/link_service.h"
#include "firmware/effects/catalogue.h"
#include "sim_host/log/draw.h"
#include "sim_host/log/write.h"
#include "sim_host/loop/run.h"
#include "workbench/base/text.h"
#include "workbench/console/output.h"
#include "workbench/console/progress.h"
#include "workbench/loop/axis_options.h"
#include "workbench/loop/board.h"
#include "workbench/loop/loop_parameters.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

constexpr double kTick_s = 1e-4;

void check(const LoopRequest& request) {
  const auto refuse = [](const std::string& text) { throw UsageError(text); };
  check_board(request.board, request.image);
  static_cast<void>(setup_named(request.setup));
  static_cast<void>(seed_of(request.seed));
  if (!(request.seconds >= 8.0 && request.seconds <= 3600.0)) {
    refuse("--seconds: must be between 8 and 3600");
  }
  if (!(request.log_rate_Hz >= 100.0 && request.log_rate_Hz <= 1.0 / kTick_s)) {
    refuse("--log-rate: must be between 100 and 10000 Hz, the rate of the tick");
  }
  const double per_sample = 1.0 / (kTick_s * request.log_rate_Hz);
  if (std::fabs(per_sample - std::round(per_sample)) > 1e-6) {
    refuse("--log-rate: 10000 must be a multiple of it");
  }
  check_strength(request.strength);
  if (!std::isfinite(request.push_N)) refuse("--push: must be a number");
}

/// Puts the parameter block into the link.
void set_parameters(PlantLink& link, const LoopRequest& request, const sim::Axis& axis) {
  lockstep::ParameterBlock block{loop_parameters(axis, kTick_s), mass_only_model(axis.mass_kg)};
  if (!request.model.empty()) {
    block.model = target_parameters(read_controller_model(request.model).target_terms);
    const ParameterStatus status = slipstack::check(block.axis, block.model);
    if (status != ParameterStatus::kOk) {
      throw UsageError(
          fmt::format("{}: the controller refuses this model (status {}); it needs a mass, and every value "
                      "within its bounds",
                      printable(request.model), static_cast<int>(status)));
    }
  }
  block.axis.adapt_level = request.adapt;
  lockstep::write_parameters(link, block);
}

std::string text_of(const LoopRequest& request, const PlantLink& link, const sim::LoopResult& result) {
  const double simulated_s = static_cast<double>(result.ticks) * kTick_s;
  std::string text = fmt::format(
      "board      {}, model {:08x}{}\n"
      "ticks      {}: {:.1f} s of the axis in {:.2f} s, {:.1f} times real time; a tick in {:.2f} us ({:.0f} "
      "times)\n"
      "tracking   {:.2f} um rms, {:.2f} um in the 50 ms after a reversal, {:.1f} um at most\n"
      "current    {:.2f} A at most; residual {:.1f} N at most; level {:.3f}\n"
      "tick       {} overruns, longest period {} and duration {} of {} clock ticks\n"
      "memory     {} loops held, {} lost\n",
      request.board, static_cast<std::uint32_t>(link.model_hash),
      request.model.empty() ? " (mass alone)" : fmt::format(" ({})", printable(request.model)), result.ticks,
      simulated_s, result.wall_s, simulated_s / result.wall_s, 1e6 * result.median_round_trip_s,
      kTick_s / result.median_round_trip_s, 1e6 * result.rms_error_m, 1e6 * result.rms_reversal_error_m,
      1e6 * result.peak_error_m, result.peak_current_A, result.largest_residual_N,
      static_cast<double>(link.level), static_cast<std::uint32_t>(link.overruns),
      static_cast<std::uint32_t>(link.longest_period), static_cast<std::uint32_t>(link.longest_duration),
      static_cast<std::uint32_t>(link.period), static_cast<std::uint32_t>(link.memory_depth),
      static_cast<std::uint32_t>(link.memory_overflow));
  if (link.stream_refused != 0) {
    text += fmt::format(
        "{} set-points were refused: the programme asks for more than the axis's limits of velocity, "
        "acceleration or jerk; the reference braked.\n",
        static_cast<std::uint32_t>(link.stream_refused));
  }
  if (result.stopped_by_fault) {
    text += fmt::format("The controller stopped with fault {:04X}h after {:.4f} s; the log ends there.\n",
                        error_code(static_cast<Fault>(static_cast<std::uint32_t>(link.fault))), simulated_s);
  }
  return text;
}

nlohmann::json json_of(const LoopRequest& request, const PlantLink& link, const sim::LoopResult& result) {
  const double simulated_s = static_cast<double>(result.ticks) * kTick_s;
  nlohmann::json by_effect = nlohmann::json::object();
  [&]<class... Effects>(std::type_identity<std::tuple<Effects...>>) {
    std::size_t i = 0;
    // + 0: an effect without a force may say -0.
    ((by_effect[Effects::text.id] = static_cast<double>(link.by_effect_N[i++]) + 0.0), ...);
  }(std::type_identity<Catalogue<float>>{});
  return {{"schema", "urn:slipstack:loop-1"},
          {"board", request.board},
          {"model_hash", fmt::format("{:08x}", static_cast<std::uint32_t>(link.model_hash))},
          {"ticks", result.ticks},
          {"simulated_s", simulated_s},
          {"times_real_time", simulated_s / result.wall_s},
          {"median_round_trip_s", result.median_round_trip_s},
          {"rms_error_m", result.rms_error_m},
          {"rms_reversal_error_m", result.rms_reversal_error_m},
          {"peak_error_m", result.peak_error_m},
          {"peak_current_A", result.peak_current_A},
          {"largest_residual_N", result.largest_residual_N},
          {"level", static_cast<double>(link.level)},
          {"refused_set_points", static_cast<std::uint32_t>(link.stream_refused)},
          {"overruns", static_cast<std::uint32_t>(link.overruns)},
          {"memory_depth", static_cast<std::uint32_t>(link.memory_depth)},
          {"memory_overflow", static_cast<std::uint32_t>(link.memory_overflow)},
          {"last_force_by_effect_N", by_effect},
          {"fault",
           result.stopped_by_fault
               ? fmt::format("{:04X}", error_code(static_cast<Fault>(static_cast<std::uint32_t>(link.fault))))
               : ""}};
}

}  // namespace

void run_loop(const LoopRequest& request) {
  check(request);
  Outputs outputs;
  if (!request.model.empty()) outputs.protect_input(request.model);
  if (!request.image.empty()) outputs.protect_input(request.image);
  outputs.claim(request.out);
  outputs.claim(request.json);
  const std::uint64_t seed = seed_of(request.seed);
  sim::Bench bench = sim::draw_bench(setup_named(request.setup), seed);
  bench.programme.seconds = request.seconds;
  const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
  Progress progress;
  progress.show("draw the axis");
  sim::add_effects(bench.axis, effects_of(request.effects), programme, request.log_rate_Hz, request.strength,
                   seed);

  const std::unique_ptr<sim::LockstepBoard> board = lockstep_board(request.board, request.image);
  set_parameters(board->link(), request, bench.axis);
  sim::LoopOptions options;
  options.tick_s = kTick_s;
  options.log_rate_Hz = request.log_rate_Hz;
  options.push_N = request.push_N;
  options.seed = seed;
  sim::LoopResult result;
  try {
    result = sim::run_loop(*board, bench.axis, programme, options,
                           [&](double share) { progress.show("run the loop", share); });
  } catch (const sim::LoopError& error) {
    throw RunError(error.what());
  }
  if (!request.out.empty()) outputs.set(request.out, sim::log_as_csv(bench.axis, result.log));
  if (!request.json.empty())
    outputs.set(request.json, json_of(request, board->link(), result).dump(2) + "\n");
  progress.finish();
  outputs.commit(text_of(request, board->link(), result));
}

}  // namespace slipstack::workbench
