// SPDX-License-Identifier: Apache-2.0
// Values of one PDO belong to one tick, whichever way they go and wherever the tick interrupts.
#include "firmware/canopen/pdo/pdo_map.h"
#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

/// A device whose every value is the number of the last tick; a tick comes after so many reads.
class TickingDevice final : public canopen::ObjectAccess {
 public:
  std::uint32_t read(std::size_t) override {
    const std::uint32_t value = tick_;
    if (++reads_ == interrupted_after) ++tick_;
    return value;
  }
  std::uint32_t tick() const override { return tick_; }
  canopen::Abort check(std::size_t, std::uint32_t) override { return canopen::Abort::kNone; }
  void written(std::size_t, std::uint32_t) override {
    EXPECT_EQ(commits, 0) << "a value after the commit";
    ++writes;
  }
  void commit() override { ++commits; }
  canopen::Abort begin_upload(std::size_t, std::uint32_t&) override { return canopen::Abort::kNone; }
  void upload(std::size_t, std::uint32_t, std::span<std::uint8_t>) override {}
  canopen::Abort begin_download(std::size_t, std::uint32_t) override { return canopen::Abort::kNone; }
  canopen::Abort download(std::size_t, std::uint32_t, std::span<const std::uint8_t>) override {
    return canopen::Abort::kNone;
  }
  canopen::Abort end_download(std::size_t, std::uint32_t) override { return canopen::Abort::kNone; }

  int interrupted_after = 0;
  int commits = 0;
  std::size_t writes = 0;

 private:
  std::uint32_t tick_ = 7;
  int reads_ = 0;
};

TEST(Snapshot, ATpdoHoldsTheValuesOfOneTick) {
  // Position, torque, tick.
  constexpr std::array<std::uint32_t, 3> kEntries = {0x60640020, 0x60770010, 0x22100510};
  canopen::PdoMap map;
  ASSERT_EQ(map.build(kEntries, false), canopen::Abort::kNone);
  for (int after = 1; after <= 6; ++after) {
    TickingDevice device;
    device.interrupted_after = after;
    canopen::Dictionary dictionary(device);
    std::array<std::uint8_t, 8> out{};
    map.pack(dictionary, out);
    EXPECT_EQ(out[0], out[4]) << after;
    EXPECT_EQ(out[0], out[6]) << after;
  }
}

TEST(Snapshot, AnRpdoIsCommittedOnceAfterItsLastValue) {
  constexpr std::array<std::uint32_t, 4> kEntries = {0x60400010, 0x60710010, 0x60B20010, 0x60600008};
  TickingDevice device;
  canopen::Dictionary dictionary(device);
  canopen::Pdos pdos(dictionary);
  const std::size_t map = canopen::kRow<0x1600>;
  for (std::size_t i = 0; i < kEntries.size(); ++i) dictionary.set(map + 1 + i, kEntries[i]);
  dictionary.set(map, kEntries.size());
  pdos.load();
  CanFrame frame;
  frame.id = 0x200;
  frame.length = 7;
  for (const std::uint32_t type : {255U, 1U}) {
    dictionary.set(canopen::kRow<0x1400, 2>, type);
    device.commits = 0;
    device.writes = 0;
    ASSERT_EQ(pdos.receive(frame, 0), canopen::Pdos::Fit::kRight);
    canopen::Outbox out;
    if (type == 1) pdos.sync(0, 0, out);
    EXPECT_EQ(device.writes, kEntries.size()) << type;
    EXPECT_EQ(device.commits, 1) << type;
  }
}

// Mode, target and offset act in one and the same tick, although ticks come between the writes.
TEST(Snapshot, WhatComesTogetherActsInOneTick) {
  Bench bench;
  bench.configure();
  ASSERT_EQ(bench.write(0x2403, 0, 0, 2), 0U);
  bench.enable(10);
  bench.run_ms(5);
  const float before_A = bench.loop->motor.set_point_A;
  canopen::Dictionary& dictionary = bench.node->dictionary();
  constexpr std::array<std::pair<std::size_t, std::uint32_t>, 2> kValues = {
      {{canopen::kRow<0x6071>, 30}, {canopen::kRow<0x60B2>, static_cast<std::uint32_t>(-12)}}};
  for (const auto& [row, value] : kValues) {
    ASSERT_EQ(dictionary.put(row, value), canopen::Abort::kNone);
    dictionary.announce(row);
    bench.loop->step();
    EXPECT_EQ(bench.loop->motor.set_point_A, before_A) << "half of what came";
  }
  dictionary.access().commit();
  bench.loop->step();
  // 18 thousandths of 10 A.
  EXPECT_NEAR(bench.loop->motor.set_point_A, 0.18F, 1e-4F);
}

}  // namespace
}  // namespace slipstack::can
