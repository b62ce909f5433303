// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/define_commission.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "workbench/base/text.h"
#include "workbench/commission/commission.h"
#include "workbench/console/output.h"
#include "workbench/console/progress.h"
#include "workbench/loop/drawn_axis.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"

namespace slipstack::workbench {
namespace {

struct CommissionRequest {
  DrawnAxis axis;
  std::string out;
  std::string json;
  bool reveal = false;
};

CommissionResult commission_in(CommissionFolder& folder, LiveAxis& axis, const CommissionRequest& request,
                               Progress& progress) {
  const auto stopped = [&](const std::string& state, const std::exception& why) {
    return RunError(
        fmt::format("stopped, {}: {}; what was found is in {}", state, why.what(), printable(request.out)));
  };
  try {
    return commission(axis, folder, progress);
  } catch (const CommissionStopped& why) {
    throw stopped("the axis is off", why);
  } catch (const DriveLost& why) {
    throw stopped("the drive does not answer", why);
  } catch (const nlohmann::json::exception&) {
    throw UsageError(fmt::format("{}: is not as a commissioning writes it; name another folder with --out",
                                 printable(folder.path("stages.json").string())));
  }
}

void run_commission(const std::string& command_line, const CommissionRequest& request) {
  Outputs outputs;
  outputs.claim(request.json);
  Progress progress;
  progress.show("draw the axis");
  const std::unique_ptr<LiveAxis> axis = live_axis(request.axis);
  const std::string title = title_of(request.axis);
  CommissionFolder folder(request.out, title);
  const ExperimentResult shown = commission_result(title, commission_in(folder, *axis, request, progress));
  folder.write("report.html", render_report(result_report(shown, command_line)));
  outputs.set(request.json, published_text(result_json(shown), kExperimentSchema));
  progress.finish();
  outputs.commit(result_text(shown) +
                 (request.reveal ? fmt::format("\nhidden: {}\n", hidden_in(request.axis)) : ""));
}

}  // namespace

void define_commission(CLI::App& app, const std::string& command_line) {
  CLI::App* command = app.add_subcommand(
      "commission", "From an unknown axis to a compensated one: mass, feedback, experiments, model");
  const auto request = std::make_shared<CommissionRequest>();
  command->add_option("--out", request->out, "folder of logs, models and report; goes on where it was left")
      ->type_name("DIR")
      ->required();
  DrawnAxis& axis = request->axis;
  command->add_option("--board", axis.board, "host, mps2-an386 (Cortex-M4F) or mps2-an500 (Cortex-M7)")
      ->type_name("NAME");
  command->add_option("--image", axis.image, "firmware image (default: the one that the build makes)")
      ->type_name("FILE");
  command->add_option("--setup", axis.setup, "pick_and_place or random")->type_name("NAME");
  command->add_option("--seed", axis.seed, "everything random of the axis follows from it")->type_name("N");
  command
      ->add_option("--effects", axis.effects,
                   "what the axis has beside mass and hysteresis; none: nothing; random: one drawn")
      ->type_name("A,B,..");
  command->add_option("--strength", axis.strength, "effect over noise floor, rms (default: 1.5 to 15, drawn)")
      ->type_name("X");
  command->add_flag("--motor-reversed", axis.motor_reversed, "the motor is connected the wrong way");
  command->add_flag("--reveal", request->reveal, "say at the end what was hidden in the axis");
  command->add_option("--json", request->json, "write the result for machines; '-': standard output")
      ->type_name("FILE");
  command->callback([&command_line, request] { run_commission(command_line, *request); });
}

}  // namespace slipstack::workbench
