// SPDX-License-Identifier: Apache-2.0
// The firmware image in the emulator against the same tick in this process, with the same plant.
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <vector>

#include "sim_host/loop/emulated_board.h"
#include "tests/loop/axis_loop.h"

namespace slipstack::loop {
namespace {

struct ParameterBlock {
  AxisParameters axis;
  ModelParameters model;
};

bool available() {
  return std::system("command -v qemu-system-arm >/dev/null 2>&1") == 0 &&
         std::system("test -f " SLIPSTACK_LOOP_IMAGE) == 0;
}

// The emulated controller with a plant, driven through the link.
class EmulatedLoop {
 public:
  explicit EmulatedLoop(const sim::Axis& axis)
      : board("mps2-an386", SLIPSTACK_LOOP_IMAGE),
        plant(axis, 0.1),
        encoder_(axis.encoder_resolution_m, 0.37) {
    PlantLink& link = board.link();
    const ParameterBlock block{pick_and_place_parameters(axis), identified_model(axis, 0.0, 0.0)};
    static_assert(sizeof block <= sizeof(PlantLink::parameters));
    std::memcpy(link.parameters.data(), &block, sizeof block);
    link.parameter_bytes = sizeof block;
    link.parameter_sequence = 1;
    link.encoder_valid = 1;
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

TEST(Emulated, RunsTheSameLoopAsTheHostFasterThanTheAxis) {
  if (!available()) GTEST_SKIP() << "no emulator or no image " SLIPSTACK_LOOP_IMAGE;
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 3);
  bench.axis.force_noise_N = 0.0;
  EmulatedLoop target(bench.axis);
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
  EXPECT_GT(times_real_time, 10.0);
}

TEST(Emulated, AKilledEmulatorIsOneClearErrorAndNothingIsLeft) {
  if (!available()) GTEST_SKIP() << "no emulator or no image " SLIPSTACK_LOOP_IMAGE;
  const sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 3);
  pid_t process = 0;
  {
    EmulatedLoop loop(bench.axis);
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

TEST(Emulated, AMissingImageSaysHowToBuildIt) {
  try {
    sim::EmulatedBoard board("mps2-an386", "no_such_image.elf");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("cmake --build"), std::string::npos);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace slipstack::loop
