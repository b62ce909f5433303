// SPDX-License-Identifier: Apache-2.0
// An axis with a BiSS-C encoder of 36 bits, frame by frame: place without homing, frames that are lost or
// wrong, and what the bus shows of them. The encoder shares no code with the receiver.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>

#include "hal/biss/receiver.h"
#include "sim_host/sensors/biss_encoder.h"
#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

using Disturbance = sim::BissEncoder::Fault;

// As a board has it: the tick reads what the frame before has brought.
class BissBoard final : public AbsoluteEncoder {
 public:
  static constexpr std::uint8_t kBits = 36;
  // Where the axis has its zero on the scale: beyond 2^32 counts, and close to a multiple of it, so that the
  // counts wrap on the way.
  static constexpr std::int64_t kScaleZero = (std::int64_t{3} << 32) - 150000;

  void use(const EncoderInterface& interface) override {
    interface_ = interface;
    receiver_.use(interface, false);
  }
  FrameCounters counters() const override { return receiver_.counters(); }

  bool in_use() const { return interface_.kind == EncoderInterface::Kind::kBissC; }
  EncoderReading read(std::int64_t counts) {
    const EncoderReading reading = receiver_.read();
    const Disturbance fault = disturb ? disturb(frames_) : Disturbance{};
    receiver_.received(encoder_.cycle(static_cast<std::uint64_t>(kScaleZero + counts), fault, 16), 0);
    ++frames_;
    return reading;
  }

  std::function<Disturbance(std::int64_t frame)> disturb;

 private:
  sim::BissEncoder encoder_{{.bits = kBits}};
  EncoderInterface interface_;
  biss::Receiver receiver_;
  std::int64_t frames_ = 0;
};

class BissAxis : public Bench {
 public:
  BissAxis() : Bench(false) {
    start_anew();
    EXPECT_EQ(write(0x2503, 1, 1, 1), 0U);
    EXPECT_EQ(write(0x2503, 2, BissBoard::kBits, 1), 0U);
    EXPECT_EQ(write(0x2012, 1, 1, 1), 0U);
    configure();
    store_and_reset();
  }
  void start_anew() {
    absolute_encoder = &board;
    const double here_m = loop->plant.position_m();
    power_on();
    loop->plant.reset(here_m);
    loop->reads = [this](std::int64_t counts) -> EncoderReading {
      if (!board.in_use()) return {static_cast<std::int32_t>(counts), 0, true};
      return board.read(counts);
    };
    begin();
    run_ms(5);
  }
  void store_and_reset() {
    ASSERT_EQ(write(0x1010, 1, 0x65766173, 4), 0U);
    nmt(0x81);
    run_ms(20);
  }

  std::uint32_t code() { return read(0x603F, 0); }
  // Profile position, absolute, at 0.2 m/s.
  void go(std::int32_t target) {
    ASSERT_EQ(write(0x6081, 0, 200000, 4), 0U);
    ASSERT_EQ(write(0x607A, 0, static_cast<std::uint32_t>(target), 4), 0U);
    ASSERT_EQ(write(0x6040, 0, 0x0F, 2), 0U);
    ASSERT_EQ(write(0x6040, 0, 0x1F, 2), 0U);
  }
  // Takes as zero what is known to be `position` from there: method 37 with 607Ch.
  void home_here(std::int32_t position) {
    ASSERT_EQ(write(0x607C, 0, static_cast<std::uint32_t>(-position), 4), 0U);
    ASSERT_EQ(write(0x6098, 0, 37, 1), 0U);
    ASSERT_EQ(write(0x6060, 0, 6, 1), 0U);
    ASSERT_EQ(write(0x6040, 0, 0x10, 2), 0U);
    run_ms(50);
    ASSERT_NE(read(0x6041, 0) & 0x1000U, 0U);
    ASSERT_EQ(write(0x6040, 0, 0, 2), 0U);
    run_ms(2);
  }

  BissBoard board;
};

TEST(AbsoluteEncoder, KnowsItsPlaceWithoutHoming) {
  BissAxis axis;
  EXPECT_EQ(axis.code(), 0U);
  EXPECT_NE(axis.read(0x6041, 0) & 0x8000U, 0U);
  const auto counts = static_cast<std::int64_t>(axis.loop->encoder.counts(axis.loop->plant.position_m()));
  EXPECT_EQ(static_cast<std::uint32_t>(axis.read_signed(0x6063, 0)),
            static_cast<std::uint32_t>(BissBoard::kScaleZero + counts));
}

// Zero is set once, by 607Ch from a place that is known, and holds for ever: wherever the axis is when the
// power comes back.
TEST(AbsoluteEncoder, HomeOffsetIsKeptOverAPowerCut) {
  BissAxis axis;
  axis.home_here(12345);
  EXPECT_NEAR(axis.read_signed(0x6064, 0), 12345, 2);
  const double home_m = axis.loop->plant.position_m();
  ASSERT_EQ(axis.write(0x1010, 1, 0x65766173, 4), 0U);
  for (const double moved_m : {0.03, -0.05}) {
    axis.loop->plant.reset(home_m + moved_m);
    axis.start_anew();
    EXPECT_NE(axis.read(0x6041, 0) & 0x8000U, 0U);
    EXPECT_NEAR(axis.read_signed(0x6064, 0), 12345 + moved_m / axis.axis.encoder_resolution_m, 2);
  }
}

// Over the place where the counts of 32 bits wrap, with frames lost, disturbed and refused by the encoder now
// and then: no fault, and the axis goes where it would have gone.
TEST(AbsoluteEncoder, BadFramesNowAndThenAreBridged) {
  BissAxis axis;
  axis.home_here(0);
  axis.enable(1);
  axis.board.disturb = [](std::int64_t frame) -> Disturbance {
    if (frame % 40 == 0) return {.unplugged = true};
    if (frame % 40 == 13) return {.flipped = 11};
    if (frame % 40 == 26 || frame % 40 == 27) return {.error = true};
    return {};
  };
  for (const std::int32_t target : {60000, -20000, 80000}) {
    axis.go(target);
    float largest_m = 0.0F;
    for (int ms = 0; ms < 1200; ++ms) {
      axis.run_ms(1);
      largest_m = std::max(largest_m, std::abs(axis.loop->controller().output().position_error_m));
    }
    EXPECT_LT(largest_m, 30e-6F);
    EXPECT_NEAR(axis.read_signed(0x6064, 0), target, 3);
  }
  EXPECT_EQ(axis.code(), 0U);
  EXPECT_GT(axis.read(0x2503, 4), 500U);
  EXPECT_GT(axis.read(0x2503, 5), 500U);
  EXPECT_GT(axis.read(0x2503, 6), 1000U);
}

// 2012h:06: so many ticks and not one more.
TEST(AbsoluteEncoder, LongerThanStatedIsAFault) {
  for (const int missing : {3, 4}) {
    for (int kind = 0; kind < 3; ++kind) {
      SCOPED_TRACE(testing::Message() << missing << " frames, kind " << kind);
      BissAxis axis;
      axis.enable(1);
      axis.go(axis.read_signed(0x6064, 0) + 50000);
      axis.run_ms(150);
      std::int64_t left = missing;
      axis.board.disturb = [&left, kind](std::int64_t) -> Disturbance {
        if (left-- <= 0) return {};
        if (kind == 0) return {.unplugged = true};
        return kind == 1 ? Disturbance{.flipped = 20} : Disturbance{.error = true};
      };
      axis.run_ms(3);
      EXPECT_EQ(axis.code(), missing == 3 ? 0U : 0x7305U);
      EXPECT_EQ(axis.loop->motor.enabled, missing == 3);
      EXPECT_NE(axis.read(0x6041, 0) & 0x8000U, 0U) << "it knows its place all the same";
    }
  }
}

// A line on which every fifth frame is bad is no line to be trusted; with one in twelve the axis goes on.
TEST(AbsoluteEncoder, ABadLineIsAFault) {
  for (const std::int64_t one_in : {5, 12}) {
    BissAxis axis;
    axis.enable(1);
    axis.board.disturb = [one_in](std::int64_t frame) -> Disturbance {
      return {.short_circuit = frame % one_in == 0};
    };
    axis.run_ms(500);
    EXPECT_EQ(axis.code(), one_in == 5 ? 0x7305U : 0U) << one_in;
  }
}

TEST(AbsoluteEncoder, AnEncoderThatIsPulledReleasesTheAxis) {
  BissAxis axis;
  axis.enable(1);
  axis.go(axis.read_signed(0x6064, 0) + 50000);
  axis.run_ms(150);
  axis.board.disturb = [](std::int64_t) -> Disturbance { return {.unplugged = true}; };
  axis.run_ms(1);
  EXPECT_EQ(axis.code(), 0x7305U);
  EXPECT_FALSE(axis.loop->motor.enabled);
  axis.board.disturb = nullptr;
  axis.run_ms(5);
  ASSERT_EQ(axis.write(0x6040, 0, 0x80, 2), 0U);
  axis.run_ms(2);
  EXPECT_EQ(axis.code(), 0U);
  axis.run_ms(3000);  // it coasts, and is not enabled before it stands
  axis.enable(1);
}

TEST(AbsoluteEncoder, ItsWarningIsShown) {
  BissAxis axis;
  EXPECT_EQ(axis.read(0x2503, 8), 0U);
  axis.board.disturb = [](std::int64_t) -> Disturbance { return {.warning = true}; };
  axis.run_ms(2);
  EXPECT_EQ(axis.read(0x2503, 8), 1U);
  EXPECT_GT(axis.read(0x2503, 7), 0U);
  EXPECT_EQ(axis.code(), 0U);
}

TEST(AbsoluteEncoder, ABoardWithoutTheInterfaceRefusesIt) {
  Bench bench;
  EXPECT_EQ(bench.write(0x2503, 1, 1, 1), 0x06010000U);
  EXPECT_EQ(bench.write(0x2503, 1, 0, 1), 0U);
  BissAxis axis;
  EXPECT_EQ(axis.write(0x2503, 3, 29, 1), 0x06090030U) << "fewer than eight bits would be left of 36";
  EXPECT_EQ(axis.write(0x2503, 3, 28, 1), 0U);
  EXPECT_EQ(axis.write(0x2503, 2, 35, 1), 0x06090030U);
}

}  // namespace
}  // namespace slipstack::can
