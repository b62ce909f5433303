// SPDX-License-Identifier: Apache-2.0
// SPI3 and its DMA as far as the encoder's port uses them, with a BiSS encoder on the line.
#include "hal/stm32g474/biss_port.h"

#include <gtest/gtest.h>

#include <functional>

#include "hal/stm32g474/encoder.h"
#include "sim_host/sensors/biss_encoder.h"
#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474 {
namespace {
using test::SimWord;

struct FrameClock {
  const std::uint32_t* time;
  std::uint32_t now() const { return *time; }
  std::uint32_t ticks_per_second() const { return 170'000'000; }
};

constexpr EncoderInterface kBiss{EncoderInterface::Kind::kBissC, 36, 0};

class SimSpi {
 public:
  using Port = BissPort<Spi<SimWord>, Dma<SimWord>, Dmamux<SimWord>, FrameClock>;

  // Channel 2 begins to send: the clock runs, and channel 1 stores what comes in.
  SimSpi() {
    dma.ccr2.on_write = [this](SimWord& self, std::uint32_t written) {
      const bool begins = (self.value & 1U) == 0 && (written & 1U) != 0;
      self.value = written;
      if (begins) clock_frame();
    };
  }

  // One tick: what it reads; then the frame ends, if it does.
  EncoderReading tick(std::uint64_t position, const sim::BissEncoder::Fault& fault = {}) {
    time += 17000;
    position_ = position;
    fault_ = fault;
    const EncoderReading reading = port.read();
    if (frames_end && stored_) port.on_interrupt();
    return reading;
  }

  Spi<SimWord> spi;
  Dma<SimWord> dma;
  Dmamux<SimWord> dmamux;
  std::uint32_t time = 0;
  Port port{spi, dma, dmamux, FrameClock{&time}};
  bool frames_end = true;
  int frames = 0;

 private:
  void clock_frame() {
    ++frames;
    stored_ = false;
    // As RM0440 has it: master, enabled, 8 bits, both requests; both channels count bytes, the receiver is
    // first.
    EXPECT_EQ(spi.cr1.value, 0x36FU);
    EXPECT_EQ(spi.cr2.value, 0x1703U);
    EXPECT_EQ(dmamux.c0cr.value, 14U);
    EXPECT_EQ(dmamux.c1cr.value, 15U);
    EXPECT_EQ(dma.ccr1.value, 0x83U);  // memory increments, end interrupts
    EXPECT_EQ(dma.ccr2.value, 0x11U);  // from memory, the same byte again
    EXPECT_EQ(dma.cndtr1.value, 16U);
    EXPECT_EQ(dma.cndtr2.value, 16U);
    const auto dr = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&spi.dr));
    EXPECT_EQ(dma.cpar1.value, dr);
    EXPECT_EQ(dma.cpar2.value, dr);
    // The address has 32 bits on the part; its upper half here is that of the port.
    const std::uintptr_t high = reinterpret_cast<std::uintptr_t>(&port) & ~std::uintptr_t{0xFFFFFFFF};
    auto* to = reinterpret_cast<volatile std::uint8_t*>(high | dma.cmar1.value);
    ASSERT_GE(reinterpret_cast<std::uintptr_t>(to), reinterpret_cast<std::uintptr_t>(&port));
    ASSERT_LT(reinterpret_cast<std::uintptr_t>(to), reinterpret_cast<std::uintptr_t>(&port + 1));
    for (const std::uint8_t byte : encoder_.cycle(position_, fault_, 16)) *to++ = byte;
    stored_ = true;
  }

  sim::BissEncoder encoder_{{.bits = 36, .delay_clocks = 1, .processing_clocks = 20}};
  std::uint64_t position_ = 0;
  sim::BissEncoder::Fault fault_;
  bool stored_ = false;
};

TEST(BissPort, ReadsThePositionOfTheTickBefore) {
  SimSpi board;
  board.port.start(kBiss, false);
  EXPECT_FALSE(board.tick(1000).valid) << "no frame yet";
  std::uint64_t position = 0x2FFFFFF00ULL;
  static_cast<void>(board.tick(position));
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t before = position;
    const std::uint32_t then = board.time;
    position += 700;
    const EncoderReading reading = board.tick(position);
    ASSERT_TRUE(reading.valid);
    ASSERT_EQ(static_cast<std::uint32_t>(reading.counts), static_cast<std::uint32_t>(before));
    ASSERT_EQ(reading.latched, then);
  }
  EXPECT_EQ(board.frames, 1002);
}

TEST(BissPort, BadFramesAreNotValidAndCounted) {
  SimSpi board;
  board.port.start(kBiss, false);
  static_cast<void>(board.tick(5));
  static_cast<void>(board.tick(6, {.flipped = 9}));
  EXPECT_FALSE(board.tick(7).valid);
  EXPECT_TRUE(board.tick(8, {.error = true}).valid);
  EXPECT_FALSE(board.tick(9, {.unplugged = true}).valid);
  EXPECT_FALSE(board.tick(10).valid);
  EXPECT_EQ(board.tick(11).counts, 10);
  const FrameCounters counters = board.port.counters();
  EXPECT_EQ(counters.bad_crc, 1U);
  EXPECT_EQ(counters.errors, 1U);
  EXPECT_EQ(counters.silent, 1U);
}

// A frame that the processor had no time for is waited for; one that never ends is begun anew.
TEST(BissPort, AFrameThatDoesNotEndInTimeIsMissingAndTheLineRecovers) {
  SimSpi board;
  board.port.start(kBiss, false);
  static_cast<void>(board.tick(5));
  board.frames_end = false;
  EXPECT_TRUE(board.tick(6).valid);
  const int frames = board.frames;
  EXPECT_FALSE(board.tick(7).valid);
  EXPECT_EQ(board.frames, frames) << "the buffer is not written again while it waits";
  board.port.on_interrupt();
  board.frames_end = true;
  EXPECT_EQ(board.tick(8).counts, 6);
  EXPECT_EQ(board.tick(9).counts, 8);
  board.frames_end = false;
  for (int i = 0; i < 10; ++i) static_cast<void>(board.tick(10));
  board.frames_end = true;
  static_cast<void>(board.tick(20));
  for (int i = 0; i < 4; ++i) static_cast<void>(board.tick(21));
  EXPECT_EQ(board.tick(22).counts, 21);
  EXPECT_GT(board.port.counters().silent, 5U);
}

// TIM2 and SPI3 behind one encoder: what the axis has is read, and only that.
TEST(AxisEncoder, ReadsTheKindThatIsChosen) {
  SimSpi board;
  Timer<SimWord> timer;
  QuadratureEncoder<Timer<SimWord>, FrameClock> quadrature(timer, FrameClock{&board.time});
  AxisEncoder<decltype(quadrature), SimSpi::Port> encoder(quadrature, board.port);
  quadrature.start({});
  timer.cnt.value = 77;
  timer.sr.value = kTIM_SR_CC3IF.mask;
  std::int32_t counts = 0;
  EXPECT_TRUE(encoder.take_index(counts));
  EXPECT_EQ(encoder.read().counts, 77);
  EXPECT_EQ(board.frames, 0) << "nothing is clocked";
  encoder.set_reversed(true);
  encoder.use(kBiss);
  static_cast<void>(encoder.read());
  EXPECT_EQ(board.frames, 1);
  board.port.on_interrupt();
  EXPECT_EQ(encoder.read().counts, 0);
  EXPECT_FALSE(encoder.take_index(counts)) << "an absolute encoder has no index";
  encoder.use({});
  EXPECT_EQ(board.spi.cr1.value, 0U);
  EXPECT_EQ(encoder.read().counts, 77);
}

}  // namespace
}  // namespace slipstack::stm32g474
