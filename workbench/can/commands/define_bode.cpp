// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/commands/define_bode.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "workbench/base/text.h"
#include "workbench/can/client/socket_link.h"
#include "workbench/can/commands/measure_loop.h"
#include "workbench/can/commands/tune_drive.h"
#include "workbench/console/output.h"
#include "workbench/console/progress.h"
#include "workbench/frequency/bode_result.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"

namespace slipstack::workbench {
namespace {

struct BodeRequest {
  std::string can;
  int node = 5;
  std::string log;
  std::string out;
  std::string report;
  std::string json;
  LoopMeasurement measurement;
  TuneRequest tune;
  bool apply = false;
  bool store = false;
};

void check_request(const BodeRequest& request) {
  if (request.can.empty() == request.log.empty())
    throw UsageError("give either --can, an axis to be measured, or --log, a recording");
  if (!request.log.empty() && request.apply)
    throw UsageError("--apply: a recording has no drive; give --can");
  if (request.store && !request.apply) throw UsageError("--store: only with --apply");
}

void add_measurement(CLI::App& command, BodeRequest& request) {
  command.add_option("--can", request.can, "CAN interface of the axis to be measured, as can0")
      ->type_name("NAME");
  command.add_option("--node", request.node, "node id (default: 5)")
      ->type_name("N")
      ->check(CLI::Range(1, 127));
  command.add_option("--log", request.log, "a recording of --out instead of an axis")->type_name("FILE");
  LoopMeasurement& wanted = request.measurement;
  command.add_option("--from", wanted.lowest_Hz, "lowest frequency, Hz (default: 4)")
      ->type_name("HZ")
      ->check(CLI::Range(0.2, 1e4));
  command.add_option("--to", wanted.highest_Hz, "highest frequency, Hz (default: 0.15 of the tick's rate)")
      ->type_name("HZ")
      ->check(CLI::Range(1.0, 2e4));
  command
      .add_option_function<std::string>(
          "--at", [&wanted](const std::string& place) { wanted.at_force = place == "force"; },
          "where the excitation is added: force, or reference, the position reference (default: force)")
      ->type_name("PLACE")
      ->check(CLI::IsMember({"force", "reference"}));
  command
      .add_option("--amplitude", wanted.amplitude_A,
                  "current of the excitation, A; at the reference by Kp Kv (default: a tenth of the current "
                  "limit)")
      ->type_name("A")
      ->check(CLI::Range(1e-4, 1e3));
  command.add_option("--deviation", wanted.deviation_m, "position error that ends it, m (default: 0.001)")
      ->type_name("M")
      ->check(CLI::Range(1e-7, 1.0));
  command
      .add_option("--velocity", wanted.velocity_mps,
                  "move to and fro at this velocity meanwhile, m/s; below 0: backwards first (default: 0, at "
                  "standstill)")
      ->type_name("MPS")
      ->check(CLI::Range(-1.0, 1.0));
  command.add_option("--captures", wanted.captures, "traces per band, of four periods each (default: 4)")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  command.add_option("--out", request.out, "write the recording, CSV")->type_name("FILE");
  command.add_option("--report", request.report, "write a report: one HTML page that opens offline")
      ->type_name("FILE");
  command.add_option("--json", request.json, "write the result for machines; '-': standard output")
      ->type_name("FILE");
}

struct MeasuredAxis {
  std::unique_ptr<CanLink> link;
  std::unique_ptr<SdoClient> drive;  ///< null: of a log
  LoopRecording recording;
  LoopAnalysis analysis;
  std::string setup;
};

MeasuredAxis measure_axis(const BodeRequest& request, const Show& show) {
  MeasuredAxis axis;
  if (!request.log.empty()) {
    axis.setup = request.log;
    axis.recording = read_recording(request.log);
  } else {
    axis.link = open_link(request.can);
    axis.drive = std::make_unique<SdoClient>(*axis.link, static_cast<std::uint8_t>(request.node));
    axis.drive->await_node();
    axis.setup = fmt::format("node {} on {}", request.node, request.can);
    axis.recording = measure_loop(*axis.drive, request.measurement, show);
  }
  axis.analysis = analyse(axis.recording, axis.setup);
  return axis;
}

void run_loop_command(const BodeRequest& request, const std::string& command_line,
                      ExperimentResult (*work)(const BodeRequest&, MeasuredAxis&, const Show&)) {
  check_request(request);
  Outputs outputs;
  if (!request.log.empty()) outputs.protect_input(request.log);
  outputs.claim(request.out);
  outputs.claim(request.report);
  outputs.claim(request.json);
  Progress progress;
  const Show show = [&](const std::string& stage, double f) { progress.show(stage, f); };
  MeasuredAxis axis = measure_axis(request, show);
  if (!request.out.empty()) outputs.set(request.out, recording_text(axis.recording));
  const ExperimentResult result = work(request, axis, show);
  outputs.set(request.json, published_text(result_json(result), kExperimentSchema));
  if (!request.report.empty())
    outputs.set(request.report, render_report(result_report(result, command_line)));
  progress.finish();
  outputs.commit(result_text(result));
}

ExperimentResult bode(const BodeRequest&, MeasuredAxis& axis, const Show&) {
  return bode_result(axis.recording, axis.analysis, axis.setup);
}

ExperimentResult tune(const BodeRequest& request, MeasuredAxis& axis, const Show& show) {
  show("tune", -1.0);
  if (!request.apply) {
    const Tuning tuning = propose_or_refuse(axis.recording, axis.analysis, request.tune);
    return tune_result(axis.recording, axis.analysis, tuning, request.tune, nullptr, axis.setup);
  }
  const TunedDrive tuned = tune_drive(*axis.drive, axis.recording, axis.analysis, request.measurement,
                                      request.tune, request.store, show);
  return tune_result(axis.recording, axis.analysis, tuned.tuning, request.tune, &tuned.loop, axis.setup);
}

}  // namespace

void define_bode(CLI::App& app, const std::string& command_line) {
  const auto request = std::make_shared<BodeRequest>();
  CLI::App* one =
      app.add_subcommand("bode", "Measure plant, open loop and sensitivity of an axis, with margins");
  add_measurement(*one, *request);
  one->callback([request, &command_line] { run_loop_command(*request, command_line, bode); });

  one = app.add_subcommand("tune", "Propose loop gains and notches for a stated margin, by a measurement");
  add_measurement(*one, *request);
  one->add_option("--modulus-margin", request->tune.modulus_margin,
                  "smallest distance of the loop from -1, the reciprocal of the peak of S (default: 0.5)")
      ->type_name("X")
      ->check(CLI::Range(0.1, 0.9));
  one->add_flag("--apply", request->apply, "put the gains into the drive, and measure again");
  one->add_flag("--store", request->store, "with --apply: store them where the measurement confirms them");
  one->callback([request, &command_line] { run_loop_command(*request, command_line, tune); });
}

}  // namespace slipstack::workbench
