// SPDX-License-Identifier: Apache-2.0
// The firmware image in the emulator against the same tick in this process, with the same plant.
#include <gtest/gtest.h>

#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <vector>

#include "firmware/app/lockstep/link_service.h"
#include "sim_host/loop/emulated_board.h"
#include "tests/loop/axis_loop.h"
#include "tests/loop/image.h"

namespace slipstack::loop {
namespace {

bool available(const std::string& machine) {
  return std::system("command -v qemu-system-arm >/dev/null 2>&1") == 0 &&
         std::filesystem::is_regular_file(image_of(machine));
}

class Emulated : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!available(GetParam())) GTEST_SKIP() << "no emulator or no image " << image_of(GetParam());
  }
};
INSTANTIATE_TEST_SUITE_P(Boards, Emulated, ::testing::Values("mps2-an386", "mps2-an500"),
                         [](const auto& own) { return own.param == "mps2-an386" ? "CortexM4" : "CortexM7"; });

// The emulated controller with a plant, driven through the link.
class EmulatedLoop {
 public:
  EmulatedLoop(const std::string& machine, const sim::Axis& axis)
      : board(machine, image_of(machine)), plant(axis, 0.1), encoder_(axis.encoder_resolution_m, 0.37) {
    PlantLink& link = board.link();
    lockstep::write_parameters(link, {pick_and_place_parameters(axis), identified_model(axis, 0.0, 0.0)});
    link.parameter_sequence = 1;
    link.encoder_valid = 1;
    link.current_valid = 1;
    link.period = 1000;
    link.control_word = 0;
  }
  void step() {
    PlantLink& link = board.link();
    link.counts = static_cast<std::int32_t>(encoder_.counts(plant.position_m()));
    board.tick();
    plant.step(link.driving != 0 ? static_cast<double>(link.current_A) : 0.0, kTick_s);
  }

  sim::EmulatedBoard board;
  sim::Plant plant;

 private:
  sim::Encoder encoder_;
};

TEST_P(Emulated, RunsTheSameLoopAsTheHost) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 3);
  bench.axis.force_noise_N = 0.0;
  EmulatedLoop target(GetParam(), bench.axis);
  const auto host = std::make_unique<AxisLoop>(bench.axis);
  ASSERT_EQ(host->controller().configure(pick_and_place_parameters(bench.axis),
                                         identified_model(bench.axis, 0.0, 0.0)),
            ParameterStatus::kOk);
  PlantLink& link = target.board.link();
  const int moves = 8;
  int ticks = 0;
  std::vector<double> turn_s;
  std::int32_t home = 0;
  const auto both = [&] {
    const auto begin = std::chrono::steady_clock::now();
    target.step();
    turn_s.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    host->step();
    ++ticks;
    ASSERT_EQ(link.current_A, host->motor.set_point_A) << ticks;
    ASSERT_EQ(link.state, static_cast<std::uint32_t>(host->controller().state().state())) << ticks;
    const auto& by_effect_N = host->controller().friction().by_effect_N;
    for (std::size_t i = 0; i < by_effect_N.size(); ++i) {
      ASSERT_EQ(link.by_effect_N[i], by_effect_N[i]) << ticks << ' ' << i;
    }
  };
  for (const int control : {0, 6, 7, 15}) {
    link.control_word = static_cast<std::uint32_t>(control);
    host->controller().command(static_cast<std::uint16_t>(control));
    for (int i = 0; i < 3; ++i) both();
  }
  ASSERT_EQ(link.state, static_cast<std::uint32_t>(DriveState::kOperationEnabled));
  ASSERT_EQ(link.model_hash, host->controller().parameters().hash);
  home = link.reference_counts;
  for (int move = 0; move < moves; ++move) {
    const std::int32_t to = home + (move % 2 == 0 ? 50000 : 0);
    link.move_counts = to;
    link.move_sequence = link.move_sequence + 1;
    ASSERT_EQ(host->controller().move_to(to), PlanStatus::kOk);
    do {
      both();
      if (HasFatalFailure()) return;
    } while (link.reference_idle == 0);
  }
  // The median turn: what others take of the two cores that this needs is not the loop's.
  std::nth_element(turn_s.begin(), turn_s.begin() + ticks / 2, turn_s.end());
  const double times_real_time = kTick_s / turn_s[static_cast<std::size_t>(ticks) / 2];
  RecordProperty("times_real_time", std::to_string(times_real_time));
  std::printf("%d ticks, %.1f times real time at 10 kHz\n", ticks, times_real_time);
  EXPECT_EQ(link.ticks, static_cast<std::uint32_t>(ticks));
  EXPECT_EQ(link.watchdog_refreshed, static_cast<std::uint32_t>(ticks));
  EXPECT_EQ(link.longest_period, 1000U);
  EXPECT_EQ(link.overruns, 0U);
}

TEST_P(Emulated, AKilledEmulatorIsOneClearErrorAndNothingIsLeft) {
  const sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 3);
  pid_t process = 0;
  {
    EmulatedLoop loop(GetParam(), bench.axis);
    for (int i = 0; i < 100; ++i) loop.step();
    process = loop.board.process();
    ASSERT_EQ(kill(process, SIGKILL), 0);
    EXPECT_THROW(
        {
          for (int i = 0; i < 1000; ++i) loop.step();
        },
        std::runtime_error);
  }
  EXPECT_NE(kill(process, 0), 0);
}

// The emulator is held, then killed from outside: the process that waits for it comes back either way.
TEST_P(Emulated, AStoppedEmulatorIsNoticed) {
  const sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 3);
  sim::EmulatedBoard board(GetParam(), image_of(GetParam()), {.tick_timeout_s = 0.3});
  board.tick();
  ASSERT_EQ(kill(board.process(), SIGSTOP), 0);
  try {
    for (int i = 0; i < 1000; ++i) board.tick();
    FAIL();
  } catch (const sim::LoopError& error) {
    EXPECT_NE(std::string(error.what()).find("does not answer"), std::string::npos) << error.what();
  }
}

TEST_P(Emulated, TheNodeOfTheBoardSpeaksSlcanOnItsUart) {
  const std::string path = ::testing::TempDir() + "slipstack-can-" + std::to_string(getpid());
  sim::EmulatedBoard board(GetParam(), image_of(GetParam()), {.can = "unix:" + path + ",server=on,wait=off"});
  const int line = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_LT(path.size(), sizeof address.sun_path);
  path.copy(address.sun_path, path.size());
  ASSERT_EQ(connect(line, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  board.link().period = 1000;
  // A heartbeat every second of the board's own clock; a question is answered at once.
  std::string received;
  ASSERT_EQ(write(line, "V\r", 2), 2);
  const auto begin = std::chrono::steady_clock::now();
  while (received.find("t77F17F\r") == std::string::npos &&
         std::chrono::steady_clock::now() - begin < std::chrono::seconds(60)) {
    for (int i = 0; i < 100; ++i) board.tick();
    char part[256];
    const ssize_t got = recv(line, part, sizeof part, MSG_DONTWAIT);
    if (got > 0) received.append(part, static_cast<std::size_t>(got));
  }
  EXPECT_NE(received.find("V1013\r"), std::string::npos) << received;
  EXPECT_NE(received.find("t77F17F\r"), std::string::npos) << received;
  close(line);
  unlink(path.c_str());
}

void expect_refused(const std::string& machine, const std::string& image,
                    const sim::EmulatedBoard::Options& options, const std::string& expected) {
  try {
    const sim::EmulatedBoard board(machine, image, options);
    FAIL() << expected;
  } catch (const sim::LoopError& error) {
    EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  }
}

TEST_P(Emulated, WhatCannotRunIsRefusedInOneLine) {
  expect_refused(GetParam(), image_of(GetParam()), {.emulator = "no-such-emulator"}, "install the package");
  expect_refused("no-such-machine", image_of(GetParam()), {}, "does not run on no-such-machine");
  // An image, but none that answers.
  expect_refused(GetParam(), SLIPSTACK_TARGET_BUILD "/bin/board.elf", {.start_timeout_s = 0.5},
                 "does not run on");
}

TEST(EmulatedBoard, AMissingImageSaysHowToBuildIt) {
  expect_refused("mps2-an386", "no_such_image.elf", {}, "cmake --build");
}

}  // namespace
}  // namespace slipstack::loop
