// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/can/define_can.h"

#include <fmt/format.h>
#include <signal.h>
#include <time.h>

#include <atomic>
#include <fstream>
#include <memory>
#include <vector>

#include "hal/socketcan/socket_can.h"
#include "workbench/cli/can/master.h"
#include "workbench/cli/can/simulated_drive.h"
#include "workbench/cli/can/socket_link.h"
#include "workbench/cli/output.h"
#include "workbench/cli/progress.h"
#include "workbench/log/text.h"

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
  std::string out;
  std::int64_t seed = 1;
  std::string flash;
};

void add_bus(CLI::App& command, Request& request) {
  command.add_option("--can", request.can, "CAN interface, as can0 or vcan0")->type_name("NAME")->required();
  command.add_option("--node", request.node, "node id (default: 5)")
      ->type_name("N")
      ->check(CLI::Range(1, 127));
}

void deploy(const Request& request) {
  const Model model = read_model(request.model);
  const std::unique_ptr<CanLink> link = open_link(request.can);
  SdoClient drive(*link, static_cast<std::uint8_t>(request.node));
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
  Progress progress;
  const Show show = [&](const std::string& stage, double f) { progress.show(stage, f); };
  const Recording recording = request.trace
                                  ? record_trace(drive, static_cast<std::uint32_t>(request.decimation), show)
                                  : record_stream(drive, request.seconds, request.rate_Hz, show);
  outputs.set(request.out, recording.log);
  progress.finish();
  outputs.commit(fmt::format("log        {}\nsamples    {}, {} lost\n", printable(request.out),
                             recording.samples, recording.lost));
}

void status(const Request& request) {
  const std::unique_ptr<CanLink> link = open_link(request.can);
  SdoClient drive(*link, static_cast<std::uint8_t>(request.node));
  fmt::print("{}", drive_status(drive));
}

std::atomic<bool> stopped{false};
void on_signal(int) {
  stopped.store(true);
}

/// Flash that lies in a file, so that what is stored survives the program.
void load_flash(host::HostNonvolatile& flash, const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return;  // a new one
  file.read(reinterpret_cast<char*>(flash.bytes.data()), static_cast<std::streamsize>(flash.bytes.size()));
  if (file.gcount() != static_cast<std::streamsize>(flash.bytes.size()) || file.peek() != EOF) {
    throw UsageError(fmt::format("--flash {}: not the flash of a node ({} bytes); name a new file",
                                 printable(path), flash.bytes.size()));
  }
}

void save_flash(const host::HostNonvolatile& flash, const std::string& path) {
  Outputs outputs;
  outputs.claim(path);
  outputs.set(path, std::string(reinterpret_cast<const char*>(flash.bytes.data()), flash.bytes.size()));
  outputs.commit("");
}

void node(const Request& request) {
  host::HostNonvolatile flash(2, 2048, 8);
  if (!request.flash.empty()) load_flash(flash, request.flash);
  SocketCan port;
  const std::string error = port.open(request.can);
  if (!error.empty()) throw UsageError(fmt::format("--can {}: {}", printable(request.can), error));
  const sim::Bench bench =
      sim::draw_bench(sim::Setup::kPickAndPlace, static_cast<std::uint64_t>(request.seed));
  const auto drive =
      std::make_unique<SimulatedDrive>(bench.axis, port, flash, static_cast<std::uint8_t>(request.node),
                                       static_cast<std::uint64_t>(request.seed));
  ::signal(SIGINT, on_signal);
  ::signal(SIGTERM, on_signal);
  fmt::print("node {} on {}: a simulated axis of {:.4g} kg; ends with Ctrl-C\n", request.node,
             printable(request.can), bench.axis.mass_kg);
  std::fflush(stdout);
  std::vector<std::byte> saved = flash.bytes;
  timespec next{};
  ::clock_gettime(CLOCK_MONOTONIC, &next);
  while (!stopped.load() && !port.down()) {
    for (int tick = 0; tick < 10; ++tick) drive->step();
    if (!request.flash.empty() && flash.bytes != saved) {
      save_flash(flash, request.flash);
      saved = flash.bytes;
    }
    next.tv_nsec += 1'000'000;
    if (next.tv_nsec >= 1'000'000'000) {
      next.tv_nsec -= 1'000'000'000;
      ++next.tv_sec;
    }
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
  }
  if (port.down()) throw UsageError(fmt::format("--can {}: the interface went down", printable(request.can)));
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

  one = app.add_subcommand("node", "Run the firmware as a CANopen node around a simulated axis");
  add_bus(*one, *request);
  one->add_option("--seed", request->seed, "of the axis")->type_name("N")->check(CLI::Range(0, 1000000));
  one->add_option("--flash", request->flash, "file that keeps what is stored")->type_name("FILE");
  one->callback([request] { node(*request); });
}

}  // namespace slipstack::workbench
