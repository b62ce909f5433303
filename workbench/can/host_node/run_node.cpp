// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/host_node/run_node.h"

#include <fmt/format.h>
#include <signal.h>
#include <time.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>

#include "hal/socketcan/socket_can.h"
#include "sim_host/loop/emulated_board.h"
#include "workbench/base/text.h"
#include "workbench/can/host_node/simulated_drive.h"
#include "workbench/can/host_node/updatable_drive.h"
#include "workbench/console/output.h"
#include "workbench/loop/axis_options.h"
#include "workbench/loop/board.h"
#include "workbench/loop/board_image.h"

namespace slipstack::workbench {
namespace {

constexpr int kTicksPerTurn = 10;
constexpr long kTurn_ns = 1'000'000;

std::atomic<bool> stopped{false};
void on_signal(int) {
  stopped.store(true);
}

/// Flash in a file, so that stored values are kept between runs.
void load_flash(host::HostNonvolatile& flash, const std::string& path) {
  if (path.empty()) return;
  std::ifstream file(path, std::ios::binary);
  if (!file) return;  // a new one
  file.read(reinterpret_cast<char*>(flash.bytes.data()), static_cast<std::streamsize>(flash.bytes.size()));
  if (file.gcount() != static_cast<std::streamsize>(flash.bytes.size()) || file.peek() != EOF) {
    throw UsageError(fmt::format("--flash {}: not the flash of a node ({} bytes); name a new file",
                                 printable(path), flash.bytes.size()));
  }
}

void save_flash(std::span<const std::byte> pages, const std::string& path) {
  Outputs outputs;
  outputs.claim(path);
  outputs.set(path, std::string(reinterpret_cast<const char*>(pages.data()), pages.size()));
  outputs.commit("");
}

/// Calls `turn` for every millisecond of the node's time until a signal arrives or it returns false. `pace`:
/// of that time, over the clock's. After a delay the missing calls follow at once.
template <class Turn>
void in_time(double pace, Turn&& turn) {
  const long turn_ns = std::lround(static_cast<double>(kTurn_ns) / pace);
  ::signal(SIGINT, on_signal);
  ::signal(SIGTERM, on_signal);
  timespec next{};
  ::clock_gettime(CLOCK_MONOTONIC, &next);
  while (!stopped.load() && turn()) {
    next.tv_nsec += turn_ns;
    while (next.tv_nsec >= 1'000'000'000) {
      next.tv_nsec -= 1'000'000'000;
      ++next.tv_sec;
    }
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
  }
}

/// A port that asks the socket again only once it was told to: the ticks of a turn follow each other at once,
/// so that what one of them did not find, the next would seldom find either. Asking costs a call of the
/// kernel, where a tick costs a few microseconds.
class PortByTurn final : public CanPort {
 public:
  explicit PortByTurn(CanPort& port) : port_(port) {}
  void begin_turn() { empty_ = false; }
  bool send(const CanFrame& frame) override { return port_.send(frame); }
  bool receive(CanFrame& frame) override {
    empty_ = empty_ || !port_.receive(frame);
    return !empty_;
  }
  CanBusStatus status() const override { return port_.status(); }
  void recover() override { port_.recover(); }

 private:
  CanPort& port_;
  bool empty_ = false;
};

/// Writes the file when the pages have changed.
class FlashFile {
 public:
  FlashFile(std::string path, std::span<const std::byte> pages)
      : path_(std::move(path)), saved_(pages.begin(), pages.end()) {}
  void keep(std::span<const std::byte> pages) {
    if (path_.empty() || std::equal(pages.begin(), pages.end(), saved_.begin(), saved_.end())) return;
    save_flash(pages, path_);
    saved_.assign(pages.begin(), pages.end());
  }

 private:
  std::string path_;
  std::vector<std::byte> saved_;
};

Wiring wiring_of(const NodeRequest& request) {
  return {request.reversed == "encoder", request.reversed == "motor", request.reversed.empty()};
}

void run_on_host(const NodeRequest& request, const sim::Axis& axis, host::HostNonvolatile& flash) {
  SocketCan socket;
  const std::string error = socket.open(request.can);
  if (!error.empty()) throw UsageError(fmt::format("--can {}: {}", printable(request.can), error));
  PortByTurn port(socket);
  UpdatableDrive drive([&](ProgramMemory& programs) {
    return std::make_unique<SimulatedDrive>(axis, port, flash, static_cast<std::uint8_t>(request.node),
                                            static_cast<std::uint64_t>(request.seed), wiring_of(request),
                                            &programs);
  });
  fmt::print("node {} on {}: a simulated axis of {:.4g} kg; ends with Ctrl-C\n", request.node,
             printable(request.can), axis.mass_kg);
  std::fflush(stdout);
  FlashFile file(request.flash, flash.bytes);
  in_time(request.pace, [&] {
    port.begin_turn();
    for (int tick = 0; tick < kTicksPerTurn; ++tick) drive.step();
    file.keep(flash.bytes);
    return !socket.down();
  });
  if (socket.down()) throw RunError(fmt::format("--can {}: the interface went down", printable(request.can)));
}

/// New flash receives the values of a commissioning: data sheet and mass of the axis, which a simulated drive
/// stores, and the node id, by LSS of a node of the same firmware in this process.
void commission(const NodeRequest& request, const sim::Axis& axis, host::HostNonvolatile& flash) {
  host::HostCanPort device(64);
  host::HostCanPort master(64);
  device.connect(master);
  const auto drive =
      std::make_unique<SimulatedDrive>(axis, device, flash, static_cast<std::uint8_t>(request.node),
                                       static_cast<std::uint64_t>(request.seed), wiring_of(request));
  const auto send = [&](std::uint32_t id, std::array<std::uint8_t, 8> data) {
    CanFrame frame;
    frame.id = id;
    frame.length = 8;
    frame.data = data;
    master.send(frame);
    drive->step();
  };
  send(0x7E5, {0x04, 1});
  send(0x7E5, {0x11, static_cast<std::uint8_t>(request.node)});
  send(0x7E5, {0x17});
  send(0x7E5, {0x04, 0});
}

bool blank(const host::HostNonvolatile& flash) {
  return std::all_of(flash.bytes.begin(), flash.bytes.end(),
                     [](std::byte b) { return b == std::byte{0xFF}; });
}

void run_emulated(const NodeRequest& request, const sim::Axis& axis, host::HostNonvolatile& flash) {
  if (blank(flash)) commission(request, axis, flash);
  sim::EmulatedBoard::Options options;
  options.can = "pty";
  options.pages = flash.bytes;
  std::unique_ptr<sim::EmulatedBoard> board;
  try {
    board = std::make_unique<sim::EmulatedBoard>(request.board, board_image(request.board, request.image),
                                                 options);
  } catch (const sim::LoopError& error) {
    throw UsageError(error.what());
  }
  PlantLink& link = board->link();
  link.period = static_cast<std::uint32_t>(SimulatedDrive::kTick_s * PlantLink::kClockTicks_Hz);
  link.encoder_valid = 1;
  link.current_valid = 1;
  link.control_word = PlantLink::kCommandedByBus;
  link.edge_terminal = sim::CapturedSwitch::kTerminal;
  sim::Plant plant(axis, 0.5 * axis.stroke_m);
  const sim::Encoder encoder(axis.encoder_resolution_m, 0.37);
  const sim::Switches switches = sim::switches_of(axis);
  const sim::CapturedSwitch captured = sim::captured_switch_of(axis);
  double last_m = plant.position_m();
  sim::Rng rng(static_cast<std::uint64_t>(request.seed), "node");
  fmt::print("{} around a simulated axis of {:.4g} kg; ends with Ctrl-C\nSLCAN on {}: slcand -o {} slcan0\n",
             request.board, axis.mass_kg, board->can_terminal(), board->can_terminal());
  std::fflush(stdout);
  const std::span<const std::byte> pages = board->flash().subspan(8, flash.bytes.size());
  FlashFile file(request.flash, flash.bytes);
  try {
    in_time(request.pace, [&] {
      for (int tick = 0; tick < kTicksPerTurn; ++tick) {
        link.counts = static_cast<std::int32_t>(encoder.counts(plant.position_m()));
        link.digital_inputs = switches.levels(plant.position_m()) | captured.levels(plant.position_m());
        captured.passed(encoder, last_m, plant.position_m(), [&link](std::int32_t counts, bool high) {
          const std::uint32_t number = link.edge_sequence + 1;
          link.edge_counts[number % PlantLink::kEdges] = counts;
          link.edge_high = high ? 1 : 0;
          link.edge_sequence = number;
        });
        if (const auto mark = sim::kMarks.passed(encoder, last_m, plant.position_m())) {
          link.index_counts = *mark;
          link.index_sequence = link.index_sequence + 1;
        }
        last_m = plant.position_m();
        board->tick();
        plant.step(link.driving != 0 ? static_cast<double>(link.current_A) : 0.0, SimulatedDrive::kTick_s,
                   axis.force_noise_N > 0.0 ? axis.force_noise_N * rng.normal() : 0.0);
      }
      file.keep(pages);
      return true;
    });
  } catch (const sim::LoopError& error) {
    throw RunError(error.what());
  }
}

}  // namespace

void run_node(const NodeRequest& request) {
  const bool host = request.board == "host";
  check_board(request.board, request.image);
  if (host && request.can.empty()) throw UsageError("--can is required: a CAN interface, as can0 or vcan0");
  if (!host && !request.can.empty()) {
    throw UsageError("--can: an emulated board speaks SLCAN on a terminal of its own; leave this out");
  }
  check_strength(request.strength);
  const std::vector<sim::EffectId> effects = effects_of(request.effects);
  host::HostNonvolatile flash(2, 2048, 8);
  load_flash(flash, request.flash);
  const auto seed = static_cast<std::uint64_t>(request.seed);
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, seed);
  sim::add_effects(bench.axis, effects, sim::draw_programme(bench, seed), bench.rate_Hz, request.strength,
                   seed);
  if (host) return run_on_host(request, bench.axis, flash);
  run_emulated(request, bench.axis, flash);
}

}  // namespace slipstack::workbench
