// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/commands/define_can.h"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "workbench/base/text.h"
#include "workbench/can/client/socket_link.h"
#include "workbench/can/commands/master.h"
#include "workbench/can/commands/update_drive.h"
#include "workbench/can/drive/objects.h"
#include "workbench/can/host_node/run_node.h"
#include "workbench/console/output.h"
#include "workbench/console/progress.h"

namespace slipstack::workbench {
namespace {

struct Request {
  std::string can;
  int node = 5;
  std::string model;
  bool no_store = false;
  double seconds = 20.0;
  double rate_Hz = 1000.0;
  bool trace = false;
  int decimation = 1;
  std::vector<std::string> objects;
  std::string image;
  std::string out;
};

void add_bus(CLI::App& command, Request& request) {
  command.add_option("--can", request.can, "CAN interface, as can0 or vcan0")->type_name("NAME")->required();
  command.add_option("--node", request.node, "node id (default: 5)")
      ->type_name("N")
      ->check(CLI::Range(1, 127));
}

void deploy(const Request& request) {
  const Model model = read_controller_model(request.model);
  const std::unique_ptr<CanLink> link = open_link(request.can);
  SdoClient drive(*link, static_cast<std::uint8_t>(request.node));
  drive.await_node();
  Progress progress;
  const std::string text = deploy_model(drive, model, request.model, !request.no_store,
                                        [&](const std::string& stage, double f) { progress.show(stage, f); });
  progress.finish();
  fmt::print("{}", text);
}

void record(const Request& request) {
  if (!(request.seconds > 0.0 && request.seconds <= 36000.0)) {
    throw UsageError("--seconds: must be between 0 and 36000");
  }
  if (!(request.rate_Hz >= 10.0 && request.rate_Hz <= 2000.0)) {
    throw UsageError(
        "--rate: must be between 10 and 2000 Hz, what a bus carries; --trace records every tick");
  }
  Outputs outputs;
  outputs.claim(request.out);
  const std::unique_ptr<CanLink> link = open_link(request.can);
  SdoClient drive(*link, static_cast<std::uint8_t>(request.node));
  drive.await_node();
  Progress progress;
  const Show show = [&](const std::string& stage, double f) { progress.show(stage, f); };
  const Recording recording = request.trace
                                  ? record_trace(drive, static_cast<std::uint32_t>(request.decimation), show)
                                  : record_stream(drive, request.seconds, request.rate_Hz, show);
  outputs.set(request.out, recording.log);
  progress.finish();
  std::string text = fmt::format("log        {}\nsamples    {}, {} lost\n", printable(request.out),
                                 recording.samples, recording.lost);
  if (recording.arrival_spread_s) {
    text +=
        fmt::format("arrival    within {:.2f} ms of the drive's clock\n", 1e3 * *recording.arrival_spread_s);
  }
  outputs.commit(text);
}

void status(const Request& request) {
  const std::unique_ptr<CanLink> link = open_link(request.can);
  SdoClient drive(*link, static_cast<std::uint8_t>(request.node));
  drive.await_node();
  fmt::print("{}", drive_status(drive));
}

void objects(const Request& request) {
  const std::unique_ptr<CanLink> link = open_link(request.can);
  SdoClient drive(*link, static_cast<std::uint8_t>(request.node));
  drive.await_node();
  for (const std::string& one : request.objects) fmt::print("{}", access_object(drive, one));
}

void update_program(const Request& request) {
  const UpdateFile file = read_update_file(request.image);
  const std::unique_ptr<CanLink> link = open_link(request.can);
  SdoClient drive(*link, static_cast<std::uint8_t>(request.node));
  drive.await_node();
  Progress progress;
  const std::string text =
      update_drive(drive, file, [&](const std::string& stage, double f) { progress.show(stage, f); });
  progress.finish();
  fmt::print("{}", text);
}

void define_node(CLI::App& app) {
  const auto request = std::make_shared<NodeRequest>();
  CLI::App* node = app.add_subcommand("node", "Run the firmware as a CANopen node around a simulated axis");
  node->add_option("--board", request->board,
                   "host, or mps2-an386 or mps2-an500: the image in the emulator, SLCAN on a terminal")
      ->type_name("NAME");
  node->add_option("--image", request->image, "firmware image (default: the one that the build makes)")
      ->type_name("FILE");
  node->add_option("--can", request->can, "CAN interface, as can0 or vcan0; --board host only")
      ->type_name("NAME");
  node->add_option("--node", request->node, "node id where none is stored (default: 5)")
      ->type_name("N")
      ->check(CLI::Range(1, 127));
  node->add_option("--seed", request->seed, "of the axis")->type_name("N")->check(CLI::Range(0, 1000000));
  node->add_option("--effects", request->effects,
                   "what the axis has beside mass and hysteresis (default: none)")
      ->type_name("A,B,..");
  node->add_option("--strength", request->strength,
                   "effect over noise floor, rms (default: 1.5 to 15, drawn)")
      ->type_name("X");
  node->add_option(
          "--reversed", request->reversed,
          "what is connected the wrong way round, on an axis that was never enabled; --board host only")
      ->check(CLI::IsMember({"encoder", "motor", "none"}))
      ->type_name("PART");
  node->add_option("--pace", request->pace,
                   "of the node's time over the clock's, for a machine that is too busy (default: 1)")
      ->type_name("X")
      ->check(CLI::Range(0.01, 1.0));
  node->add_option("--flash", request->flash, "file that keeps what is stored")->type_name("FILE");
  node->callback([request] { run_node(*request); });
}

}  // namespace

void define_can(CLI::App& app) {
  const auto request = std::make_shared<Request>();
  CLI::App* one = app.add_subcommand("deploy", "Put a model on a controller: stage, read back, apply, store");
  one->add_option("MODEL", request->model, "model file")->type_name("FILE")->required();
  add_bus(*one, *request);
  one->add_flag("--no-store", request->no_store, "do not store: gone with the next reset");
  one->callback([request] { deploy(*request); });

  one = app.add_subcommand("record", "Record a log from a controller");
  add_bus(*one, *request);
  one->add_option("--seconds", request->seconds, "length (default: 20)")->type_name("S");
  one->add_option("--rate", request->rate_Hz, "samples per second of the stream (default: 1000)")
      ->type_name("HZ");
  CLI::Option* trace =
      one->add_flag("--trace", request->trace, "the trace buffer instead of a stream: every tick");
  one->add_option("--decimation", request->decimation, "every Nth tick of the trace")
      ->type_name("N")
      ->check(CLI::Range(1, 10000))
      ->needs(trace);
  one->add_option("--out", request->out, "log to write; '-': standard output")->type_name("FILE")->required();
  one->callback([request] { record(*request); });

  one = app.add_subcommand("status", "Tell the state of a controller");
  add_bus(*one, *request);
  one->callback([request] { status(*request); });

  one = app.add_subcommand("object", "Read or write objects of a controller by SDO, in this order");
  add_bus(*one, *request);
  one->add_option("OBJECT", request->objects,
                  "INDEX[:SUB][=VALUE], hexadecimal index: 6041, 2500:03=1.2; or reset")
      ->type_name("OBJECT ...")
      ->required();
  one->callback([request] { objects(*request); });

  one = app.add_subcommand("update", "Put new firmware into a controller and wait until it has reported in");
  add_bus(*one, *request);
  one->add_option("IMAGE", request->image, "update file, as slipstack-stm32g474.update")
      ->type_name("IMAGE")
      ->required();
  one->callback([request] { update_program(*request); });

  define_node(app);
}

}  // namespace slipstack::workbench
