// SPDX-License-Identifier: Apache-2.0
// The board's start on a simulated part, write by write: what the amplifier sees after power, brown-out,
// watchdog and a boot loader, at every failure of a device, and at a fault behind every single write.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <random>
#include <string>

#include "hal/stm32g474/board.h"
#include "hal/stm32g474/safe_outputs.h"
#include "tests/unit/stm32g474/simulated_part.h"

namespace slipstack::stm32g474 {

CarefulRead careful_read;

namespace {
using test::AmplifierView;
using test::CutOff;
using test::SimulatedPart;

template <DriveKind kDrive>
using SimulatedBoard = Board<kDrive, SimulatedPart::Access>;
using DacBoard = SimulatedBoard<DriveKind::kDac>;
using PwmBoard = SimulatedBoard<DriveKind::kPwm>;

// As the part's start-up does: first the outputs, then the objects, then main.
template <class BoardType>
BoardFault start_up(std::unique_ptr<BoardType>& board) {
  secure_outputs<SimulatedPart::Access>();
  board = std::make_unique<BoardType>(BoardSetup{});
  board->motor_current().disable();  // the tick's constructor
  return board->start({}, false);
}
template <class BoardType>
BoardFault start_up() {
  std::unique_ptr<BoardType> board;
  return start_up(board);
}

struct Reset {
  const char* name;
  std::uint32_t flags;
};
constexpr std::array<Reset, 4> kResets{{{"power", kRCC_CSR_BORRSTF.mask | kRCC_CSR_PINRSTF.mask},
                                        {"brown-out", kRCC_CSR_BORRSTF.mask},
                                        {"watchdog", kRCC_CSR_IWDGRSTF.mask | kRCC_CSR_PINRSTF.mask},
                                        {"software", kRCC_CSR_SFTRSTF.mask | kRCC_CSR_PINRSTF.mask}}};

TEST(BringUp, TheEnableIsLowBeforeAnythingElseIsWaitedFor) {
  for (const Reset& reset : kResets) {
    SCOPED_TRACE(reset.name);
    SimulatedPart part;
    part.reset_flags = reset.flags;
    part.reset();
    std::size_t driven_at = 0;
    std::size_t polls_before = 0;
    part.on_write = [&](const AmplifierView& seen) {
      ASSERT_FALSE(seen.enabled);
      ASSERT_TRUE(!seen.command_driven || seen.command_code == 2048U) << seen.command_code;
      if (seen.enable_driven && driven_at == 0) {
        driven_at = part.writes();
        polls_before = part.polls();
      }
      // The command is driven only behind an enable that is held low.
      ASSERT_TRUE(!seen.command_driven || seen.enable_driven);
      // From the first low on it stays driven.
      ASSERT_TRUE(driven_at == 0 || seen.enable_driven);
    };
    std::unique_ptr<DacBoard> board;
    ASSERT_EQ(start_up(board), BoardFault::kNone);
    EXPECT_EQ(board->watchdog().caused_last_reset(), std::string(reset.name) == "watchdog");
    EXPECT_GT(driven_at, 0U);
    EXPECT_LE(driven_at, 8U) << "clock, level, and the writes of one pin";
    EXPECT_EQ(polls_before, 0U) << "nothing waited for before";
    EXPECT_TRUE(part.amplifier().command_driven);
    EXPECT_EQ(part.lost_writes(), 1U) << "the constructor's zero command to a converter that is still off";
  }
}

TEST(BringUp, TheCommandIsZeroBeforeTheCrystalIsWaitedFor) {
  SimulatedPart part;
  part.crystal_starts = false;
  part.reset();
  std::size_t polls_at_command = static_cast<std::size_t>(-1);
  part.on_write = [&](const AmplifierView& seen) {
    if (seen.command_driven && polls_at_command == static_cast<std::size_t>(-1))
      polls_at_command = part.polls();
  };
  std::unique_ptr<DacBoard> board;
  ASSERT_EQ(start_up(board), BoardFault::kNone);
  EXPECT_FALSE(board->runs_on_crystal());
  EXPECT_LE(polls_at_command, 10U);
  EXPECT_GT(part.polls(), 100'000U) << "the crystal was waited for";
}

// Enabled by set(): the command first, then the signal; off in the other order.
TEST(BringUp, CurrentIsCommandedBeforeTheEnableAndTakenBehindIt) {
  SimulatedPart part;
  part.reset();
  std::unique_ptr<DacBoard> board;
  ASSERT_EQ(start_up(board), BoardFault::kNone);
  part.on_write = [&](const AmplifierView& seen) {
    if (seen.enabled) {
      ASSERT_EQ(seen.command_code, 2253U);
    }
  };
  board->motor_current().set(1.0F);
  EXPECT_TRUE(part.amplifier().enabled);
  board->motor_current().disable();
  EXPECT_FALSE(part.amplifier().enabled);
  EXPECT_EQ(part.amplifier().command_code, 2048U);
}

TEST(BringUp, WhateverABootLoaderLeftTheEnableGoesFirst) {
  std::mt19937 random(17);
  for (int i = 0; i < 300; ++i) {
    SimulatedPart part;
    part.reset();
    part.leave_outputs_anyhow(random);
    bool off = false;
    part.on_write = [&](const AmplifierView& seen) {
      if (!seen.enabled) off = true;
      // Three writes at most with what was there: clock and level.
      ASSERT_TRUE(off || part.writes() < 3U);
      ASSERT_FALSE(off && seen.enabled) << "enabled again at write " << part.writes();
      ASSERT_FALSE(off && seen.moves());
    };
    ASSERT_EQ(start_up<DacBoard>(), BoardFault::kNone);
    ASSERT_EQ(part.amplifier().command_code, 2048U);
  }
}

// 2500h: signs, gains and zeros go into the converters' constants.
TEST(Scales, ReachTheConverters) {
  SimulatedPart part;
  part.reset();
  std::unique_ptr<DacBoard> board;
  ASSERT_EQ(start_up(board), BoardFault::kNone);
  auto& monitor = part.at<Adc>(kADC1_BASE).jdr1;
  auto& encoder = part.at<Timer>(kTIM2_BASE);
  monitor.value = 2048 + 1241;  // 1 V above the middle
  EXPECT_NEAR(board->motor_current().measured().current_A, 10.0F, 0.01F);
  // 3 A/V, zero at -0.1 V; monitor 4 A/V, zero at 1.5 V; both the other way round.
  board->scaling().set_scales({.encoder_reversed = true,
                               .motor_reversed = true,
                               .command_A_per_V = 3.0F,
                               .command_zero_V = -0.1F,
                               .monitor_A_per_V = 4.0F,
                               .monitor_zero_V = 1.5F});
  board->motor_current().disable();
  EXPECT_EQ(part.amplifier().command_code, 2028U);  // 2048 - 20.475, rounded
  board->motor_current().set(6.0F);                 // -2 V beside the zero
  EXPECT_EQ(part.amplifier().command_code, 1618U);  // 2048 - 20.475 - 409.5
  monitor.value = 1862 + 1241;
  EXPECT_NEAR(board->motor_current().measured().current_A, -4.0F, 0.01F);
  EXPECT_EQ(encoder.ccer.value & kTIM_CCER_CC1P.mask, kTIM_CCER_CC1P.mask);
  EXPECT_NE(encoder.cr1.value & kTIM_CR1_CEN.mask, 0U) << "counts on";
  board->scaling().set_scales({});
  EXPECT_EQ(encoder.ccer.value & kTIM_CCER_CC1P.mask, 0U);
  board->motor_current().set(1.0F);
  EXPECT_EQ(part.amplifier().command_code, 2253U);
  EXPECT_NEAR(board->scaling().largest_A({.command_A_per_V = 3.0F, .command_zero_V = -0.1F}), 29.7F, 1e-4F);
}

template <class Break>
void expect_safe_end(Break&& break_it, BoardFault expected) {
  SimulatedPart part;
  break_it(part);
  part.reset();
  part.on_write = [](const AmplifierView& seen) { ASSERT_FALSE(seen.enabled); };
  EXPECT_EQ(start_up<DacBoard>(), expected);
  EXPECT_TRUE(part.amplifier().enable_driven);
  EXPECT_EQ(part.amplifier().command_code, 2048U);
}

TEST(BringUp, EndsSafeWhenADeviceFails) {
  expect_safe_end([](SimulatedPart& part) { part.dac_works = false; }, BoardFault::kDac);
  expect_safe_end([](SimulatedPart& part) { part.pll_works = false; }, BoardFault::kClock);
  expect_safe_end([](SimulatedPart& part) { part.adc_works = false; }, BoardFault::kAdc);
  expect_safe_end([](SimulatedPart& part) { part.can_works = false; }, BoardFault::kCan);
}

// A fault's handler behind every write of the start and of a tick that drives.
template <class BoardType>
void cut_off_everywhere() {
  std::size_t cut_offs = 0;
  for (std::size_t allowed = 0;; ++allowed) {
    SimulatedPart part;
    part.reset();
    part.writes_allowed = allowed;
    bool finished = false;
    try {
      std::unique_ptr<BoardType> board;
      ASSERT_EQ(start_up(board), BoardFault::kNone);
      board->motor_current().set(-3.0F);
      board->digital_io().write(7U);  // the brake open
      finished = true;
    } catch (const CutOff&) {
      ++cut_offs;
    }
    part.writes_allowed = static_cast<std::size_t>(-1);
    int behind = 0;
    part.on_write = [&](const AmplifierView& seen) {
      if (++behind >= 2) {
        ASSERT_FALSE(seen.enabled) << "write " << allowed;
      }
    };
    secure_outputs<SimulatedPart::Access>();
    EXPECT_TRUE(part.amplifier().enable_driven) << allowed;
    EXPECT_FALSE(part.amplifier().enabled) << allowed;
    EXPECT_EQ(part.amplifier().command_code, 2048U) << allowed;
    EXPECT_EQ(part.at<Gpio>(kGPIOB_BASE).odr.value & 7U, 0U) << allowed << ": the brake is set";
    EXPECT_EQ(part.at<Timer>(kTIM1_BASE).bdtr.value & kTIM_BDTR_MOE.mask, 0U) << allowed;
    if (finished) break;
  }
  EXPECT_GT(cut_offs, 100U);
}

TEST(BringUp, AFaultBehindAnyWriteEndsSafe) {
  cut_off_everywhere<DacBoard>();
  cut_off_everywhere<PwmBoard>();
}

}  // namespace
}  // namespace slipstack::stm32g474
