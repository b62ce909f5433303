// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/edge_capture.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <deque>
#include <random>
#include <utility>
#include <vector>

#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474 {
namespace {
using test::SimWord;

// TIM2's channel 4 and DMA1's channel 3 as far as they are used here: an edge puts the count into the ring,
// the channel's counter goes down and begins anew.
struct SimEdges {
  using Edges = TimerEdges<Timer<SimWord>, Dma<SimWord>, Dmamux<SimWord>, Gpio<SimWord>>;
  Timer<SimWord> timer;
  Dma<SimWord> dma;
  Dmamux<SimWord> dmamux;
  Gpio<SimWord> port;
  Edges edges{timer, dma, dmamux, {port, 10}};

  SimEdges() {
    test::clear_by_one(dma.ifcr);
    dma.ifcr.on_write = [this](SimWord&, std::uint32_t written) {
      if ((written & kDMA_IFCR_CGIF3.mask) != 0) dma.isr.value &= ~kDMA_ISR_TCIF3.mask;
    };
    edges.start();
  }
  void edge(std::int32_t counts) {
    pin();
    captured(counts);
  }
  // The level first; the count in the ring is later by filter and DMA.
  void pin() { port.idr.value ^= 1U << 10; }
  void captured(std::int32_t counts) {
    // The address has 32 bits on the part; its upper half here is that of the object.
    const std::uintptr_t half = reinterpret_cast<std::uintptr_t>(&edges) & ~std::uintptr_t{0xFFFFFFFF};
    auto* const ring = reinterpret_cast<volatile std::uint32_t*>(half | dma.cmar3.value);
    ring[Edges::kRing - dma.cndtr3.value] = static_cast<std::uint32_t>(counts);
    if (--dma.cndtr3.value != 0) return;
    dma.cndtr3.value = Edges::kRing;
    dma.isr.value |= kDMA_ISR_TCIF3.mask;
  }
  std::vector<CapturedEdge> take() {
    std::array<CapturedEdge, EdgeCapture::kKept> taken;
    const std::size_t count = edges.take(taken);
    return {taken.begin(), taken.begin() + static_cast<std::ptrdiff_t>(count)};
  }
};

TEST(TimerEdges, SetsTheDmaUp) {
  SimEdges board;
  EXPECT_EQ(board.dmamux.c2cr.value, 59U);  // TIM2_CH4
  EXPECT_EQ(board.dma.ccr3.value, 0xAA1U);  // words to words that increment, circular, on
  EXPECT_EQ(board.dma.cndtr3.value, 16U);
  EXPECT_EQ(board.timer.dier.value, 0x1000U);
  EXPECT_EQ(board.dma.cpar3.value,
            static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&board.timer.ccr4)));
}

TEST(TimerEdges, TellsCountsAndDirections) {
  SimEdges board;
  EXPECT_TRUE(board.take().empty());
  board.edge(-5);
  auto taken = board.take();
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(taken[0].counts, -5);
  EXPECT_TRUE(taken[0].high);
  EXPECT_TRUE(board.take().empty()) << "each once";
  board.edge(7);
  board.edge(8);
  board.edge(9);
  taken = board.take();
  ASSERT_EQ(taken.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(taken[i].counts, 7 + static_cast<std::int32_t>(i));
    EXPECT_EQ(taken[i].high, i == 1) << i;
  }
}

// However many there are between two calls: in their order, and the latest of too many.
TEST(TimerEdges, IsARingForRandomNumbers) {
  SimEdges board;
  std::mt19937 random(17);
  std::deque<std::pair<std::int32_t, bool>> expected;
  std::int32_t counts = 0;
  bool high = false;
  int overrun = 0;
  for (int round = 0; round < 3000; ++round) {
    // Within one round of the ring behind its end; what is beyond twice its size cannot be told.
    const std::uint32_t most = random() % 4 == 0 ? SimEdges::Edges::kRing : 6;
    const std::uint32_t number = static_cast<std::uint32_t>(random()) % (most + 1);
    for (std::uint32_t i = 0; i < number; ++i) {
      high = !high;
      board.edge(++counts);
      expected.emplace_back(counts, high);
    }
    for (; expected.size() > EdgeCapture::kKept; ++overrun) expected.pop_front();
    const auto taken = board.take();
    ASSERT_EQ(taken.size(), expected.size()) << round;
    for (const CapturedEdge& edge : taken) {
      EXPECT_EQ(edge.counts, expected.front().first);
      EXPECT_EQ(edge.high, expected.front().second);
      expected.pop_front();
    }
  }
  EXPECT_GT(overrun, 20);
}

// The pin has changed, the count is not in the ring yet: the edges before it keep their directions.
TEST(TimerEdges, APinAheadOfItsEdgeIsWaitedFor) {
  SimEdges board;
  board.edge(100);
  board.pin();
  int reads = 0;
  board.dma.cndtr3.on_read = [&](std::uint32_t value) {
    if (++reads != 4) return value;
    board.captured(101);
    return board.dma.cndtr3.value;
  };
  const auto taken = board.take();
  ASSERT_EQ(taken.size(), 2U);
  EXPECT_TRUE(taken[0].high);
  EXPECT_FALSE(taken[1].high);
  EXPECT_EQ(taken[1].counts, 101);
}

TEST(TimerEdges, AnInputThatNeverRestsEndsTheCall) {
  SimEdges board;
  board.edge(1);
  bool noisy = true;
  board.port.idr.on_read = [&](std::uint32_t value) {
    if (noisy) board.port.idr.value ^= 1U << 10;
    return value;
  };
  EXPECT_TRUE(board.take().empty());
  noisy = false;
  EXPECT_EQ(board.take().size(), 1U) << "and loses nothing";
}

}  // namespace
}  // namespace slipstack::stm32g474
