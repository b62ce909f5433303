// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/define_loop.h"

#include <memory>

#include "workbench/loop/run_loop.h"

namespace slipstack::workbench {
namespace {

// The comparison has an axis, a motion and models of its own; what it shares with a run are axis, seed and
// the file for machines.
void define_comparison(CLI::App& loop, const std::shared_ptr<LoopRequest>& request) {
  const auto wanted = std::make_shared<ComparisonRequest>();
  const auto compare = std::make_shared<bool>(false);
  CLI::Option* flag =
      loop.add_flag("--compare", *compare, "compare ways to compensate friction on the same axis and motion");
  for (const char* other :
       {"--board", "--image", "--seconds", "--log-rate", "--push", "--model", "--adapt", "--out"})
    flag->excludes(loop.get_option(other));
  loop.add_option("--seeds", wanted->seeds, "of the comparison: so many axes, from --seed on (default: 1)")
      ->type_name("N")
      ->needs(flag);
  loop.add_option("--encoder", wanted->encoder_nm,
                  "of the comparison: resolution of the encoder (default: that of the axis)")
      ->type_name("NM")
      ->needs(flag);
  loop.add_flag("--brief", wanted->brief,
                "of the comparison: without wrong parameters, hidden effects and other levels of friction")
      ->needs(flag);
  loop.add_option(
          "--keep", wanted->keep,
          "of the comparison: add each axis that is done to this file, and measure none again that is "
          "in it")
      ->type_name("FILE")
      ->needs(flag);
  loop.callback([request, wanted, compare] {
    if (!*compare) return run_loop(*request);
    wanted->setup = request->setup;
    wanted->seed = request->seed;
    wanted->json = request->json;
    wanted->effects = request->effects;
    wanted->strength = request->strength;
    run_comparison(*wanted);
  });
}

}  // namespace

void define_loop(CLI::App& app) {
  CLI::App* loop = app.add_subcommand(
      "loop", "Run the firmware against the simulated axis, in this process or on an emulated board");
  const auto request = std::make_shared<LoopRequest>();
  loop->add_option("--board", request->board, "host, mps2-an386 (Cortex-M4F) or mps2-an500 (Cortex-M7)")
      ->type_name("NAME");
  loop->add_option("--image", request->image, "firmware image (default: the one that the build makes)")
      ->type_name("FILE");
  loop->add_option("--setup", request->setup, "pick_and_place or random")->type_name("NAME");
  loop->add_option("--seed", request->seed, "everything random of the axis follows from it")->type_name("N");
  loop->add_option(
          "--effects", request->effects,
          "what the axis has beside mass and hysteresis; none: nothing; of the comparison also random: "
          "one effect, by the seed")
      ->type_name("A,B,..");
  loop->add_option("--strength", request->strength,
                   "effect over noise floor, rms (default: 1.5 to 15, drawn; of the comparison 6)")
      ->type_name("X");
  loop->add_option("--seconds", request->seconds, "length of the programme (default: 60)")->type_name("S");
  loop->add_option("--log-rate", request->log_rate_Hz, "samples per second of the log (default: 2000)")
      ->type_name("HZ");
  loop->add_option("--push", request->push_N, "constant force on the axis")->type_name("N");
  loop->add_option("--model", request->model, "compensate with this model (default: the mass alone)")
      ->type_name("FILE");
  loop->add_flag("--adapt", request->adapt, "adapt the friction level slowly");
  loop->add_option("--out", request->out, "write the log, CSV; '-': standard output")->type_name("FILE");
  loop->add_option("--json", request->json, "write the result for machines; '-': standard output")
      ->type_name("FILE");
  define_comparison(*loop, request);
}

}  // namespace slipstack::workbench
