// SPDX-License-Identifier: Apache-2.0
#include "sim_host/cli/define_sim.h"

namespace slipstack::sim {
namespace {

void add_log_options(CLI::App& log, LogRequest& request) {
  log.add_option("--setup", request.setup, "pick_and_place ([1] set-up 3) or random");
  log.add_option("--seed", request.seed_number, "everything random follows from it");
  log.add_option("--effects", request.effects, "names with commas, none, random, random:2 (default: random)");
  log.add_option("--strength", request.strength, "effect over noise floor, rms (default: 1.5 to 15, drawn)");
  log.add_flag("--closed-loop", request.closed_loop, "a controller moves the axis; the log has its errors");
  log.add_option("--outside", request.outside,
                 "line, bump, backlash, burst, slip, ring or force_filter: outside the catalogue");
  log.add_option("--seconds", request.seconds, "length of the programme (default: 60, random: 40 to 80)");
  log.add_option("--rate", request.rate_Hz, "samples per second (default: 2000, random: 1000 to 5000)");
  log.add_option("--setpoints", request.set_points,
                 "run the motion of this CSV file (time_s, position_m) instead of the usual programme");
  log.add_option("--out", request.out, "the log, CSV")->required();
  log.add_option("--truth", request.truth, "what is hidden, JSON");
}

}  // namespace

void define_sim(CLI::App& app, LogRequest& request) {
  app.description("Simulated measurements of a linear axis");
  app.require_subcommand(1);
  CLI::App* log = app.add_subcommand("log", "Write a log with a hidden effect, and the truth about it");
  app.add_subcommand("effects", "List the effects that can be hidden");
  add_log_options(*log, request);
}

}  // namespace slipstack::sim
