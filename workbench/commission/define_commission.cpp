// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/define_commission.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "workbench/base/text.h"
#include "workbench/can/client/socket_link.h"
#include "workbench/can/drive/can_axis.h"
#include "workbench/commission/commission.h"
#include "workbench/commission/drive_memory.h"
#include "workbench/console/output.h"
#include "workbench/console/positive_number.h"
#include "workbench/console/progress.h"
#include "workbench/loop/drawn_axis.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"

namespace slipstack::workbench {
namespace {

struct CommissionRequest {
  DrawnAxis axis;
  std::string can;
  int node = 5;
  std::optional<double> low_mm;
  std::optional<double> high_mm;
  std::optional<double> largest_velocity_mps;
  std::optional<double> magnet_pitch_mm;
  int period_ms = 1;
  bool search_ends = false;
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
    return commission(axis, folder, progress, request.search_ends);
  } catch (const CommissionStopped& why) {
    throw stopped("the axis is off", why);
  } catch (const DriveLost& why) {
    throw stopped("the drive does not answer", why);
  } catch (const nlohmann::json::exception&) {
    throw UsageError(fmt::format("{}: is not as a commissioning writes it; name another folder with --out",
                                 printable(folder.path("stages.json").string())));
  }
}

void commission_and_report(const std::string& command_line, const CommissionRequest& request,
                           const std::string& title, CommissionFolder& folder, LiveAxis& axis,
                           Progress& progress, Outputs& outputs) {
  const ExperimentResult shown = commission_result(title, commission_in(folder, axis, request, progress));
  folder.write("report.html", render_report(result_report(shown, command_line)));
  outputs.set(request.json, published_text(result_json(shown), kExperimentSchema));
  progress.finish();
  outputs.commit(result_text(shown) +
                 (request.reveal ? fmt::format("\nhidden: {}\n", hidden_in(request.axis)) : ""));
}

void commission_drawn(const std::string& command_line, const CommissionRequest& request) {
  Outputs outputs;
  outputs.claim(request.json);
  Progress progress;
  progress.show("draw the axis");
  const std::unique_ptr<LiveAxis> axis = live_axis(request.axis);
  const std::string title = title_of(request.axis);
  CommissionFolder folder(request.out, title);
  commission_and_report(command_line, request, title, folder, *axis, progress, outputs);
}

BusAxis told_in(const CommissionRequest& request) {
  if (request.low_mm.has_value() != request.high_mm.has_value())
    throw UsageError("--from, --to: the travel has two ends; name both, or none, so that they are searched");
  if (request.low_mm && !(*request.low_mm < *request.high_mm)) throw UsageError("--from: must be below --to");
  const auto in_m = [](const std::optional<double>& mm) {
    return mm ? std::optional(1e-3 * *mm) : std::nullopt;
  };
  return {in_m(request.low_mm), in_m(request.high_mm), request.largest_velocity_mps,
          in_m(request.magnet_pitch_mm), request.period_ms};
}

void commission_on_bus(const std::string& command_line, const CommissionRequest& request) {
  const BusAxis told = told_in(request);
  Outputs outputs;
  outputs.claim(request.json);
  Progress progress;
  progress.show("ask the drive");
  const std::unique_ptr<CanLink> link = open_link(request.can);
  SdoClient drive(*link, static_cast<std::uint8_t>(request.node));
  drive.await_node();
  const std::string title = drive_title(drive);
  CommissionFolder folder(request.out, title);
  const std::unique_ptr<LiveAxis> axis = can_axis(drive, told, memory_in(folder));
  commission_and_report(command_line, request, title, folder, *axis, progress, outputs);
}

void define_bus(CLI::App& command, const std::shared_ptr<CommissionRequest>& request) {
  CLI::Option* can =
      command.add_option("--can", request->can,
                         "commission the axis of a controller on this CAN interface, and store "
                         "the model there");
  can->type_name("NAME");
  for (const char* simulated :
       {"--board", "--image", "--setup", "--seed", "--effects", "--strength", "--motor-reversed", "--reveal"})
    can->excludes(command.get_option(simulated));
  command.add_option("--node", request->node, "node id (default: 5)")
      ->type_name("N")
      ->check(CLI::Range(1, 127))
      ->needs(can);
  command.add_option("--from", request->low_mm, "lower end of the travel, position of the drive")
      ->type_name("MM")
      ->needs(can);
  command.add_option("--to", request->high_mm, "upper end of the travel (default: both are searched)")
      ->type_name("MM")
      ->needs(can);
  command
      .add_option("--largest-velocity", request->largest_velocity_mps,
                  "of the axis (default: the drive's limit, 2000h:0B)")
      ->type_name("M/S")
      ->check(positive_number())
      ->needs(can);
  command.add_option("--magnet-pitch", request->magnet_pitch_mm, "of the motor, where it is known")
      ->type_name("MM")
      ->check(positive_number())
      ->needs(can);
  command
      .add_option("--period", request->period_ms,
                  "of set-points and samples, as the bus carries (default: 1)")
      ->type_name("MS")
      ->check(CLI::IsMember({1, 2, 4}))
      ->needs(can);
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
  command->add_flag("--search-ends", request->search_ends,
                    "find out where the travel ends, by stops or limit switches");
  command->add_flag("--reveal", request->reveal, "say at the end what was hidden in the axis");
  command->add_option("--json", request->json, "write the result for machines; '-': standard output")
      ->type_name("FILE");
  define_bus(*command, request);
  command->callback([&command_line, request] {
    if (request->can.empty()) return commission_drawn(command_line, *request);
    commission_on_bus(command_line, *request);
  });
}

}  // namespace slipstack::workbench
