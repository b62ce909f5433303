// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/drawn_axis.h"

#include <fmt/format.h>

#include "sim_host/log/draw.h"
#include "workbench/loop/axis_options.h"
#include "workbench/loop/board.h"
#include "workbench/loop/lockstep_axis.h"

namespace slipstack::workbench {
namespace {

std::vector<sim::EffectId> effects_in(const DrawnAxis& wanted) {
  return effects_by_seed(wanted.effects, static_cast<std::uint64_t>(wanted.seed));
}

}  // namespace

std::unique_ptr<LiveAxis> live_axis(const DrawnAxis& wanted) {
  check_board(wanted.board, wanted.image);
  const sim::Setup setup = setup_named(wanted.setup);
  const std::uint64_t seed = seed_of(wanted.seed);
  check_strength(wanted.strength);
  sim::Bench bench = sim::draw_bench(setup, seed);
  sim::add_effects(bench.axis, effects_in(wanted), sim::draw_programme(bench, seed), bench.rate_Hz,
                   wanted.strength, seed);
  return lockstep_axis(lockstep_board(wanted.board, wanted.image),
                       {.axis = bench.axis, .seed = seed, .motor_reversed = wanted.motor_reversed});
}

std::string title_of(const DrawnAxis& wanted) {
  return fmt::format("{} {}, effects {}{}{}", wanted.setup, wanted.seed, wanted.effects,
                     wanted.strength > 0.0 ? fmt::format(", strength {}", wanted.strength) : "",
                     wanted.motor_reversed ? ", motor reversed" : "");
}

std::string hidden_in(const DrawnAxis& wanted) {
  return names_of(effects_in(wanted));
}

}  // namespace slipstack::workbench
