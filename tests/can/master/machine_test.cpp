// SPDX-License-Identifier: Apache-2.0
// What differs from one machine to the next: scales and signs of its signals (2500h), and the check of the
// direction at the first enabling (2501h), as a commissioning engineer meets them.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "tests/can/master/desk.h"

namespace slipstack::workbench {
namespace {

constexpr std::uint32_t kSave = 0x65766173;

// A machine that was never enabled, on new flash.
struct NewMachine : Desk {
  explicit NewMachine(const Wiring& with, std::uint64_t axis_seed = 4) : Desk(axis_seed) {
    wiring = with;
    wiring.checked = false;
    flash = host::HostNonvolatile{2, 2048, 8};
    power_on();
  }
  void run_ms(int milliseconds) {
    for (int i = 0; i < 10 * milliseconds; ++i) drive->step();
  }
  std::uint32_t status() { return client->read(0x6041, 0) & 0x6F; }
  void enable_and_wait() {
    enable();
    run_ms(700);
  }
  void write_real(std::uint16_t index, std::uint8_t sub, float value) {
    client->write(index, sub, std::bit_cast<std::uint32_t>(value), 4);
  }
  void store_and_reset() {
    client->write(0x1010, 1, kSave, 4);
    client->nmt(0x81);
    run_ms(50);
  }
};

TEST(Machine, FirstEnablingChecksTheDirectionOnce) {
  NewMachine machine({});
  EXPECT_EQ(machine.client->read(0x2501, 5), 0U);
  machine.enable();
  EXPECT_EQ(machine.status(), 0x23U) << "switched on: it is pushed";
  machine.run_ms(700);
  EXPECT_EQ(machine.status(), 0x27U);
  EXPECT_NE(machine.client->read(0x2501, 5), 0U);
  machine.client->write(0x6040, 0, 6, 2);
  machine.run_ms(1);
  machine.enable();
  EXPECT_EQ(machine.status(), 0x27U) << "at once";
  machine.client->write(0x6040, 0, 6, 2);
  machine.run_ms(1);
  machine.client->write(0x1010, 1, kSave, 4);
  machine.power_on();
  machine.enable();
  EXPECT_EQ(machine.status(), 0x27U) << "stored";
  // Another scale: another check.
  machine.client->write(0x6040, 0, 6, 2);
  machine.run_ms(1);
  machine.write_real(0x2500, 4, 0.001F);
  machine.write_real(0x2000, 9, static_cast<float>(machine.client->read_real(0x2000, 9)) * 0.99F);
  machine.store_and_reset();
  machine.enable();
  EXPECT_EQ(machine.status(), 0x23U);
  machine.run_ms(700);
  EXPECT_EQ(machine.status(), 0x27U);
}

TEST(Machine, AReversedPartIsFoundAndSetRight) {
  for (const bool encoder : {true, false}) {
    NewMachine machine({.encoder_reversed = encoder, .motor_reversed = !encoder});
    const auto from = static_cast<std::int32_t>(machine.client->read(0x6063, 0));
    machine.enable_and_wait();
    EXPECT_EQ(machine.status() & 0x4FU, 0x08U);
    EXPECT_EQ(machine.client->read(0x603F, 0), 0x8A00U);
    EXPECT_LT(std::abs(static_cast<std::int32_t>(machine.client->read(0x6063, 0)) - from), 60);
    EXPECT_EQ(machine.client->read(0x2501, 5), 0U);
    machine.client->write(0x6040, 0, 0x80, 2);
    machine.run_ms(2);
    machine.client->write(0x2500, encoder ? 1 : 2, 1, 1);
    machine.store_and_reset();
    machine.enable_and_wait();
    EXPECT_EQ(machine.status(), 0x27U) << (encoder ? "encoder" : "motor");
    // And it follows: 5 mm.
    const auto home = static_cast<std::int32_t>(machine.client->read(0x6064, 0));
    machine.client->write(0x607A, 0, static_cast<std::uint32_t>(home + 5000), 4);
    machine.client->write(0x6040, 0, 0x1F, 2);
    machine.run_ms(400);
    EXPECT_NEAR(static_cast<std::int32_t>(machine.client->read(0x6064, 0)), home + 5000, 5);
    machine.client->write(0x6040, 0, 0x06, 2);
    machine.run_ms(1);
  }
}

// While the push has current, nothing that it rests on may change.
TEST(Machine, ParametersAreLockedDuringThePush) {
  NewMachine machine({});
  machine.enable();
  machine.run_ms(22);  // it has to stand first
  ASSERT_EQ(machine.status(), 0x23U);
  EXPECT_THROW(machine.client->write(0x2500, 1, 1, 1), std::runtime_error);
  EXPECT_THROW(machine.write_real(0x2501, 2, 1e-4F), std::runtime_error);
}

TEST(Machine, ScalesAreBoundedAndTheAmplifierMustReachTheCurrentLimit) {
  NewMachine machine({});
  EXPECT_THROW(machine.write_real(0x2500, 3, 0.0F), std::runtime_error);
  EXPECT_THROW(machine.write_real(0x2500, 4, 1.01F), std::runtime_error);
  EXPECT_THROW(machine.write_real(0x2500, 6, std::nanf("")), std::runtime_error);
  const auto limit_A = static_cast<float>(machine.client->read_real(0x2000, 9));
  machine.write_real(0x2500, 3, 0.0999F * limit_A);  // 10 V are less than the limit
  machine.store_and_reset();
  EXPECT_EQ(machine.client->read(0x2140, 4), 10U);
  machine.enable();
  EXPECT_EQ(machine.status() & 0x4FU, 0x40U) << "no parameters: it cannot be enabled";
  machine.client->write(0x6040, 0, 0, 2);
  machine.write_real(0x2500, 3, 0.1001F * limit_A);
  machine.store_and_reset();
  EXPECT_EQ(machine.client->read(0x2140, 4), 0U);
  machine.enable_and_wait();
  EXPECT_EQ(machine.status(), 0x27U);
}

}  // namespace
}  // namespace slipstack::workbench
