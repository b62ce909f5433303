// SPDX-License-Identifier: Apache-2.0
// Touch probes (60B8h to 60BDh, 60D5h to 60D8h, IEC 61800-7-201): positions at the edges of inputs and at
// index marks.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <random>
#include <span>
#include <vector>

#include "hal/plant_link/drivers.h"
#include "tests/can/profile/homing_axis.h"

namespace slipstack::can {
namespace {

constexpr std::uint32_t kEnable = 1, kContinuous = 2, kIndex = 4, kPositive = 0x10, kNegative = 0x20;
constexpr std::uint32_t kRefused = 0x06090030;

// Probe 1 on terminal 7, probe 2 on terminal 8, which is active while low.
class Probed : public Bench {
 public:
  Probed() {
    EXPECT_EQ(write(0x2010, 7, 0x80, 2), 0U);
    EXPECT_EQ(write(0x2013, 1, 7, 1), 0U);
    EXPECT_EQ(write(0x2013, 2, 8, 1), 0U);
    loop->io.inputs = 0x80;
    configure();
  }
  void arm(std::uint32_t function) { ASSERT_EQ(write(0x60B8, 0, function, 2), 0U); }
  std::uint32_t status() { return read(0x60B9, 0); }
  // The probes' terminals for a while.
  void set(bool first, bool second, int milliseconds = 1) {
    loop->io.inputs = (first ? 0x40U : 0U) | (second ? 0U : 0x80U);
    run_ms(milliseconds);
  }
  // Moves on and on.
  void travel() {
    ASSERT_EQ(write(0x2403, 0, 0, 2), 0U);
    enable(3);
    ASSERT_EQ(write(0x60FF, 0, 50000, 4), 0U);
    run_ms(200);
  }
  std::int32_t place() { return read_signed(0x6064, 0); }
};

TEST(TouchProbe, KeepsNothingUntilItIsEnabled) {
  Probed bench;
  bench.set(true, true);
  bench.set(false, false);
  EXPECT_EQ(bench.status(), 0U);
  EXPECT_EQ(bench.read(0x60D5, 0), 0U);
  bench.arm(kPositive | kNegative);
  bench.set(true, true);
  EXPECT_EQ(bench.status(), 0U);
  EXPECT_EQ(bench.read(0x60BA, 0), 0U);
}

TEST(TouchProbe, OnceAtEachEdge) {
  Probed bench;
  bench.travel();
  bench.arm(kEnable | kPositive | kNegative);
  EXPECT_EQ(bench.status(), 1U);
  const std::int32_t before = bench.place();
  bench.set(true, false);
  const std::int32_t after = bench.place();
  EXPECT_EQ(bench.status() & 0x3FU, 3U);
  const std::int32_t first = bench.read_signed(0x60BA, 0);
  EXPECT_GT(first, before);
  EXPECT_LT(first, after);
  bench.set(false, false);
  EXPECT_EQ(bench.status() & 0x3FU, 7U);
  EXPECT_GE(bench.read_signed(0x60BB, 0), after);
  // Another edge changes nothing.
  bench.set(true, false);
  bench.set(false, false);
  EXPECT_EQ(bench.read_signed(0x60BA, 0), first);
  EXPECT_EQ(bench.read(0x60D5, 0), 1U);
  // Armed anew by the bit of the edge: the position stays until the next one.
  bench.arm(kEnable | kNegative);
  bench.arm(kEnable | kPositive | kNegative);
  EXPECT_EQ(bench.status() & 0x3FU, 5U);
  EXPECT_EQ(bench.read_signed(0x60BA, 0), first);
  bench.set(true, false);
  EXPECT_EQ(bench.status() & 0x3FU, 7U);
  EXPECT_GT(bench.read_signed(0x60BA, 0), first);
  EXPECT_EQ(bench.read(0x60D5, 0), 2U);
  bench.arm(0);
  EXPECT_EQ(bench.status(), 0U);
}

TEST(TouchProbe, OnlyTheEdgeThatIsSampled) {
  Probed bench;
  bench.arm(kEnable | kNegative);
  bench.set(true, false);
  EXPECT_EQ(bench.status() & 0x3FU, 1U);
  bench.set(false, false);
  EXPECT_EQ(bench.status() & 0x3FU, 5U);
  EXPECT_EQ(bench.read(0x60D5, 0), 0U);
  EXPECT_EQ(bench.read(0x60D6, 0), 1U);
}

TEST(TouchProbe, AnInputThatIsActiveWhenArmedIsNoEdge) {
  Probed bench;
  bench.set(true, false);
  bench.arm(kEnable | kPositive);
  bench.run_ms(3);
  EXPECT_EQ(bench.status(), 1U);
  bench.set(false, false);
  bench.set(true, false);
  EXPECT_EQ(bench.status() & 0x3FU, 3U);
}

TEST(TouchProbe, ContinuousKeepsTheLatestAndSaysSo) {
  Probed bench;
  bench.travel();
  bench.arm((kEnable | kContinuous | kPositive) << 8U);
  std::int32_t last = bench.place();
  std::uint32_t toggle = bench.status() & 0x4000U;
  for (std::uint32_t i = 1; i <= 5; ++i) {
    bench.set(false, true);
    const std::int32_t now = bench.read_signed(0x60BC, 0);
    EXPECT_GT(now, last);
    last = now;
    EXPECT_EQ(bench.read(0x60D7, 0), i);
    EXPECT_NE(bench.status() & 0x4000U, toggle);
    toggle = bench.status() & 0x4000U;
    bench.set(false, false);
  }
  EXPECT_EQ(bench.status() & 0xFFU, 0U) << "the other probe";
}

TEST(TouchProbe, RefusesWhatItCannotDo) {
  Probed bench;
  for (const std::uint32_t function : {0x08U, 0x0CU, 0x40U, 0x80U, 0x0800U, 0x4000U}) {
    EXPECT_EQ(bench.write(0x60B8, 0, function, 2), kRefused) << function;
  }
  ASSERT_EQ(bench.write(0x2013, 1, 0, 1), 0U);
  EXPECT_EQ(bench.write(0x60B8, 0, kEnable | kPositive, 2), kRefused) << "no terminal";
  EXPECT_EQ(bench.write(0x60B8, 0, kEnable | kIndex | kPositive, 2), 0U) << "the index needs none";
  EXPECT_EQ(bench.write(0x2013, 1, 17, 1), 0x06090031U);
  EXPECT_EQ(bench.read(0x60B8, 0), kEnable | kIndex | kPositive);
}

TEST(TouchProbe, InTheUserUnit) {
  Probed bench;
  ASSERT_EQ(bench.write(0x6092, 1, 1000, 4), 0U);
  ASSERT_EQ(bench.write(0x608F, 1, 100, 4), 0U);
  ASSERT_EQ(bench.write(0x607E, 0, 0x80, 1), 0U);
  bench.arm(kEnable | kPositive);
  bench.set(true, false);
  EXPECT_EQ(bench.read_signed(0x60BA, 0), bench.place()) << "at rest";
}

// Terminals 1 to 3 are limit and home switches; the home switch begins at 0.1 m.
TEST(TouchProbe, FindsAnEdgeToTheWayOfOneTickBesideHoming) {
  HomingAxis axis(0.06);
  ASSERT_EQ(axis.write(0x2013, 1, sim::Switches::kWiring[3], 1), 0U);
  ASSERT_EQ(axis.write(0x60B8, 0, kEnable | kContinuous | kPositive | kNegative, 2), 0U);
  ASSERT_EQ(axis.home(23), HomingAxis::kDone) << "homing has a latch of its own";
  EXPECT_GT(axis.read(0x60D5, 0), 0U);
  const double zero_m = axis.zero_m();
  // Homing itself went over the edge at 0.01 m/s and took it for zero; now across at 0.1 m/s.
  ASSERT_EQ(axis.write(0x6081, 0, axis.counts(0.1), 4), 0U);
  ASSERT_EQ(axis.write(0x6083, 0, axis.counts(2.0), 4), 0U);
  ASSERT_EQ(axis.write(0x6084, 0, axis.counts(2.0), 4), 0U);
  const auto go = [&](double metres) {
    const auto target = static_cast<std::uint32_t>(
        static_cast<std::int32_t>(std::lround((metres - zero_m) / axis.axis.encoder_resolution_m)));
    ASSERT_EQ(axis.write(0x607A, 0, target, 4), 0U);
    ASSERT_EQ(axis.write(0x6040, 0, 0x3F, 2), 0U);
    axis.run_ms(1);
    ASSERT_EQ(axis.write(0x6040, 0, 0x0F, 2), 0U);
    axis.run_ms(1500);
    ASSERT_NEAR(axis.x_m(), metres, 1e-4);
  };
  axis.enable(1);
  go(0.06);
  ASSERT_EQ(axis.write(0x60B8, 0, 0, 2), 0U);
  ASSERT_EQ(axis.write(0x60B8, 0, kEnable | kPositive | kNegative, 2), 0U);
  go(0.14);
  const double one_tick_m = 0.1 * 1e-4 + axis.axis.encoder_resolution_m;
  const double positive_m = zero_m + axis.read_signed(0x60BA, 0) * axis.axis.encoder_resolution_m;
  const double negative_m = zero_m + axis.read_signed(0x60BB, 0) * axis.axis.encoder_resolution_m;
  EXPECT_GE(positive_m, 0.1 - 2e-6);
  EXPECT_LE(positive_m, 0.1 + one_tick_m + 2e-6);
  EXPECT_GE(negative_m, 0.112 - 2e-6);
  EXPECT_LE(negative_m, 0.112 + one_tick_m + 2e-6);
}

// Marks every 15 mm from 4.3 mm on: seen to the count at any velocity.
TEST(TouchProbe, KeepsTheIndexToTheCount) {
  HomingAxis axis(0.06);
  ASSERT_EQ(axis.write(0x60B8, 0, kEnable | kContinuous | kIndex | kPositive, 2), 0U);
  ASSERT_EQ(axis.write(0x2403, 0, 0, 2), 0U);
  axis.enable(3);
  const double zero_m = axis.zero_m();
  ASSERT_EQ(axis.write(0x60FF, 0, axis.counts(0.2), 4), 0U);
  axis.run_ms(400);
  const double travelled_m = axis.x_m() - 0.06;
  const double mark_m = zero_m + axis.read_signed(0x60BA, 0) * axis.axis.encoder_resolution_m;
  const double marks = (mark_m - 0.0043) / 0.015;
  EXPECT_NEAR(marks, std::round(marks), 2e-6 / 0.015);
  EXPECT_NEAR(axis.read(0x60D5, 0), travelled_m / 0.015, 1.0);
}

// Probe 1 on the terminal whose edges the board captures, on an axis that coasts.
class Captured : public Bench {
 public:
  static constexpr std::uint32_t kBit = 1U << (sim::CapturedSwitch::kTerminal - 1U);

  Captured() {
    EXPECT_EQ(write(0x2013, 1, sim::CapturedSwitch::kTerminal, 1), 0U);
    configure();
  }
  void arm(std::uint32_t function) { ASSERT_EQ(write(0x60B8, 0, function, 2), 0U); }
  std::uint32_t status() { return read(0x60B9, 0); }
  // An edge that the board has caught, and the level with it.
  void catch_edge(std::int32_t counts, bool high) {
    loop->edges.wired = sim::CapturedSwitch::kTerminal;
    loop->edges.caught.push_back({counts, high});
    loop->io.inputs = high ? loop->io.inputs | kBit : loop->io.inputs & ~kBit;
  }
  std::int32_t at(std::uint16_t index) {
    return read_signed(index, 0) + loop->controller().position().origin();
  }
};

// 0.2 mm of travel from tick to tick: the position is that of the edge.
TEST(TouchProbe, KeepsACapturedEdgeToTheCountAt2MetresPerSecond) {
  double farthest_counts = 0.0, tick_late_m = 0.0;
  for (int run = 0; run < 24; ++run) {
    Captured bench;
    const bool up = run % 2 == 0;
    // Anywhere between two ticks.
    bench.loop->captured = sim::CapturedSwitch{0.15 + 17e-6 * run, 0.25 + 29e-6 * run};
    bench.loop->plant.reset(0.2 + (up ? -0.1 : 0.1), up ? 2.0 : -2.0);
    bench.loop->step();
    bench.arm(kEnable | kPositive | kNegative);
    bench.run_ms(100);
    ASSERT_EQ(bench.status() & 0x3FU, 7U) << run;
    const sim::CapturedSwitch& flag = *bench.loop->captured;
    const auto off = [&](double edge_m, std::uint16_t index) {
      const auto expected = static_cast<double>(bench.loop->encoder.counts(edge_m));
      farthest_counts = std::max(farthest_counts, std::abs(bench.at(index) - expected));
    };
    off(up ? flag.begin_m : flag.end_m, 0x60BA);
    off(up ? flag.end_m : flag.begin_m, 0x60BB);
    // What the tick would have made of it.
    const double way_m = std::abs(bench.loop->plant.velocity_mps()) * loop::kTick_s;
    tick_late_m = std::max(tick_late_m, way_m);
  }
  EXPECT_EQ(farthest_counts, 0.0);
  EXPECT_GT(tick_late_m, 1.5e-4) << "the axis is fast enough to tell";
}

TEST(TouchProbe, ACapturedTerminalIsNotLookedAtByTheTickToo) {
  Captured bench;
  bench.loop->edges.wired = sim::CapturedSwitch::kTerminal;
  bench.run_ms(1);
  bench.arm(kEnable | kContinuous | kPositive | kNegative);
  bench.catch_edge(4711, true);
  bench.run_ms(3);
  EXPECT_EQ(bench.read(0x60D5, 0), 1U);
  EXPECT_EQ(bench.read(0x60D6, 0), 0U);
  EXPECT_EQ(bench.at(0x60BA), 4711);
  // Shorter than a tick: no tick has seen it.
  bench.catch_edge(4800, false);
  bench.catch_edge(4801, true);
  bench.catch_edge(4802, false);
  bench.catch_edge(4803, true);
  bench.run_ms(1);
  EXPECT_EQ(bench.read(0x60D5, 0), 3U);
  EXPECT_EQ(bench.read(0x60D6, 0), 2U);
  EXPECT_EQ(bench.at(0x60BA), 4803);
  EXPECT_EQ(bench.at(0x60BB), 4802);
}

TEST(TouchProbe, ACapturedEdgeFromBeforeItWasArmedIsNone) {
  Captured bench;
  bench.arm(kEnable | kPositive);
  bench.arm(0);
  bench.catch_edge(100, true);
  bench.run_ms(1);
  bench.catch_edge(200, false);
  bench.catch_edge(300, true);
  bench.arm(kEnable | kPositive | kNegative);  // not polled in between
  bench.run_ms(1);
  EXPECT_EQ(bench.status(), 1U);
  bench.catch_edge(400, false);
  bench.run_ms(1);
  EXPECT_EQ(bench.status() & 0x3FU, 5U);
  EXPECT_EQ(bench.at(0x60BB), 400);
  // Once: what bounces behind it changes nothing.
  bench.catch_edge(410, true);
  bench.catch_edge(420, false);
  bench.run_ms(1);
  EXPECT_EQ(bench.at(0x60BA), 410);
  EXPECT_EQ(bench.at(0x60BB), 400);
}

TEST(TouchProbe, ACapturedInputMayBeActiveWhileLow) {
  Captured bench;
  ASSERT_EQ(bench.write(0x2010, 7, Captured::kBit, 2), 0U);
  bench.configure();
  bench.arm(kEnable | kPositive | kNegative);
  bench.catch_edge(50, true);
  bench.catch_edge(60, false);
  bench.run_ms(1);
  EXPECT_EQ(bench.at(0x60BB), 50);
  EXPECT_EQ(bench.at(0x60BA), 60);
}

// The index is asked for: the input's edges are none. The other probe has a terminal of its own.
TEST(TouchProbe, ACapturedEdgeIsForTheProbeThatHasTheTerminal) {
  Captured bench;
  ASSERT_EQ(bench.write(0x2013, 2, 7, 1), 0U);
  bench.arm(kEnable | kIndex | kPositive | (kEnable | kPositive) << 8U);
  bench.catch_edge(70, true);
  bench.run_ms(1);
  EXPECT_EQ(bench.status(), 0x0101U);
  // Both on the same one.
  bench.arm(0);
  ASSERT_EQ(bench.write(0x2013, 2, sim::CapturedSwitch::kTerminal, 1), 0U);
  bench.arm(kEnable | kNegative | (kEnable | kContinuous | kNegative) << 8U);
  bench.catch_edge(80, false);
  bench.catch_edge(90, true);
  bench.catch_edge(95, false);
  bench.run_ms(1);
  EXPECT_EQ(bench.at(0x60BB), 80);
  EXPECT_EQ(bench.at(0x60BD), 95);
}

// With an absolute encoder nothing counts the edges: the terminal is one like the others.
TEST(TouchProbe, ATerminalThatIsNotCapturedNowIsSeenToTheTick) {
  Captured bench;
  bench.arm(kEnable | kPositive);
  bench.catch_edge(1000000, true);
  bench.loop->edges.wired = 0;
  bench.run_ms(1);
  EXPECT_EQ(bench.status() & 0x3FU, 3U);
  EXPECT_EQ(bench.at(0x60BA), bench.loop->controller().measured_counts());
}

// The words by which a simulated plant hands edges to an emulated board.
TEST(TouchProbe, EdgesComeOverTheLinkToo) {
  PlantLink link{};
  LinkEdgeCapture capture(link);
  std::array<CapturedEdge, EdgeCapture::kKept> edges;
  EXPECT_EQ(capture.terminal(), 0U);
  link.edge_terminal = 9;
  EXPECT_EQ(capture.terminal(), 9U);
  EXPECT_EQ(capture.take(edges), 0U);
  std::uint32_t number = 0;
  const auto edge = [&](std::int32_t counts) {
    ++number;
    link.edge_counts[number % PlantLink::kEdges] = counts;
    link.edge_high = number % 2;
    link.edge_sequence = number;
  };
  for (std::int32_t n = 1; n <= 3; ++n) edge(10 * n);
  ASSERT_EQ(capture.take(edges), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(edges[i].counts, 10 * static_cast<std::int32_t>(i + 1));
    EXPECT_EQ(edges[i].high, i != 1);
  }
  EXPECT_EQ(capture.take(edges), 0U);
  for (std::int32_t n = 4; n <= 30; ++n) edge(10 * n);
  ASSERT_EQ(capture.take(edges), EdgeCapture::kKept) << "the latest";
  EXPECT_EQ(edges[0].counts, 160);
  EXPECT_FALSE(edges[0].high);
  EXPECT_EQ(edges[14].counts, 300);
  edge(310);
  edge(320);
  ASSERT_EQ(capture.take(std::span(edges).first(1)), 1U);
  EXPECT_EQ(edges[0].counts, 320);
}

TEST(TouchProbe, InProcessData) {
  Probed bench;
  const auto map = [&](std::uint16_t communication, std::uint16_t mapping,
                       std::initializer_list<std::uint32_t> entries) {
    const std::uint32_t cob_id = bench.read(communication, 1);
    ASSERT_EQ(bench.write(communication, 1, cob_id | 0x80000000U, 4), 0U);
    ASSERT_EQ(bench.write(communication, 2, communication == 0x1800 ? 1 : 255, 1), 0U);
    ASSERT_EQ(bench.write(mapping, 0, 0, 1), 0U);
    std::uint8_t sub = 0;
    for (const std::uint32_t entry : entries) ASSERT_EQ(bench.write(mapping, ++sub, entry, 4), 0U);
    ASSERT_EQ(bench.write(mapping, 0, sub, 1), 0U);
    ASSERT_EQ(bench.write(communication, 1, cob_id & 0x7FFFFFFFU, 4), 0U);
  };
  map(0x1800, 0x1A00, {0x60B90010, 0x60BA0020});  // at every SYNC
  map(0x1400, 0x1600, {0x60B80010});
  bench.nmt(1);
  bench.send(0x200 + kNode, {kEnable | kPositive, 0});
  bench.run_ms(1);
  bench.set(true, false);
  bench.all();
  bench.send(0x80, {});
  bench.run_ms(1);
  const std::vector<Data> sent = bench.all_with(0x180 + kNode);
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(Bench::number(sent[0], 0, 2), 0x43U) << "enabled, stored, first value";
  EXPECT_EQ(static_cast<std::int32_t>(Bench::number(sent[0], 2)), bench.read_signed(0x60BA, 0));
}

// Whatever the inputs do and however late the main loop is: what an oracle keeps that sees every tick.
TEST(TouchProbe, IsAnOracleForRandomInputs) {
  Probed bench;
  bench.travel();
  std::mt19937 random(20261124);
  struct Kept {
    std::array<std::uint32_t, 2> number{};
    std::array<std::int32_t, 2> counts{};
    std::array<bool, 2> stored{};
  };
  std::array<Kept, 2> kept{};
  std::array<bool, 2> was{};
  std::uint32_t function = 0;
  for (int round = 0; round < 400; ++round) {
    if (random() % 8 == 0) {
      const std::uint32_t wanted = static_cast<std::uint32_t>(random()) & 0x3333U;
      ASSERT_EQ(bench.write(0x60B8, 0, wanted, 2), 0U);
      for (std::size_t i = 0; i < 2; ++i) {
        const std::uint32_t changed = ((wanted ^ function) >> (8 * i)) & 0xFFU;
        if ((changed & 0x03U) != 0) kept[i].stored = {};
        if ((changed & kPositive) != 0) kept[i].stored[0] = false;
        if ((changed & kNegative) != 0) kept[i].stored[1] = false;
      }
      function = wanted;
    }
    const int ticks = 1 + static_cast<int>(random() % 50);
    for (int tick = 0; tick < ticks; ++tick) {
      if (random() % 6 == 0) bench.loop->io.inputs = static_cast<std::uint32_t>(random() % 4U) << 6U;
      bench.loop->step();
      bench.drive->after_tick();
      const std::array<bool, 2> now{(bench.loop->io.inputs & 0x40U) != 0,
                                    (bench.loop->io.inputs & 0x80U) == 0};
      for (std::size_t i = 0; i < 2; ++i) {
        const std::uint32_t half = (function >> (8 * i)) & 0xFFU;
        const std::size_t edge = now[i] ? 0 : 1;
        const bool sampled = (half & (edge == 0 ? kPositive : kNegative)) != 0 && (half & kEnable) != 0;
        if (now[i] != was[i] && sampled && (!kept[i].stored[edge] || (half & kContinuous) != 0)) {
          kept[i].stored[edge] = true;
          ++kept[i].number[edge];
          kept[i].counts[edge] = bench.loop->controller().measured_counts();
        }
      }
      was = now;
    }
    bench.now_us += static_cast<std::uint32_t>(ticks) * 100U;
    bench.poll();
    std::uint32_t status = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto index = static_cast<std::uint16_t>(2 * i);
      const std::uint32_t half = (function >> (8 * i)) & 0xFFU;
      const auto positive = static_cast<std::uint16_t>(0x60BA + index);
      const auto counter = static_cast<std::uint16_t>(0x60D5 + index);
      for (std::uint16_t edge = 0; edge < 2; ++edge) {
        ASSERT_EQ(bench.read(static_cast<std::uint16_t>(counter + edge), 0), kept[i].number[edge] & 0xFFFFU);
        const std::int32_t zero = bench.loop->controller().position().origin();
        const std::int32_t expected = kept[i].number[edge] == 0 ? 0 : kept[i].counts[edge] - zero;
        ASSERT_EQ(bench.read_signed(static_cast<std::uint16_t>(positive + edge), 0), expected) << round;
      }
      if ((half & kEnable) == 0) continue;
      status |= (1U | (kept[i].stored[0] ? 2U : 0U) | (kept[i].stored[1] ? 4U : 0U) |
                 (kept[i].number[0] & 1U) << 6U | (kept[i].number[1] & 1U) << 7U)
                << (8 * i);
    }
    ASSERT_EQ(bench.status(), status) << round;
  }
  EXPECT_GT(kept[0].number[0], 50U);
  EXPECT_GT(kept[1].number[1], 50U);
}

// The main loop stood still for longer than the ticks are kept: an edge of that time is lost, not misplaced.
TEST(TouchProbe, AnEdgeThatNobodySawIsNotInvented) {
  Probed bench;
  bench.arm(kEnable | kPositive);
  bench.loop->io.inputs = 0xC0;
  for (int tick = 0; tick < 100; ++tick) {
    bench.loop->step();
    bench.drive->after_tick();
  }
  bench.now_us += 10000;
  bench.poll();
  EXPECT_EQ(bench.status(), 1U);
}

TEST(TouchProbe, AResetForgets) {
  Probed bench;
  bench.arm(kEnable | kPositive);
  bench.set(true, false);
  EXPECT_EQ(bench.status() & 2U, 2U);
  bench.nmt(0x81);
  bench.run_ms(5);
  EXPECT_EQ(bench.read(0x60B8, 0), 0U);
  EXPECT_EQ(bench.status(), 0U);
}

}  // namespace
}  // namespace slipstack::can
