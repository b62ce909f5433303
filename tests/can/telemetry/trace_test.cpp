// SPDX-License-Identifier: Apache-2.0
// The trace buffer: what a block transfer brings is what an independent record of every tick says, for each
// trigger, share before it, and decimation.
#include <cmath>
#include <cstring>

#include "tests/can/bench.h"
#include "tests/can/sdo/block_master.h"

namespace slipstack::can {
namespace {

struct Moment {
  std::int32_t counts;
  std::int32_t reference;
  float current_A;
  std::uint32_t tick;
};

struct Settings {
  std::uint32_t decimation = 1;
  std::uint32_t trigger = 0;  // 0 at once, 1 rising, 2 falling
  std::uint32_t channel = 0;  // 0 position, 1 reference, 2 current
  float level = 0.0F;
  std::uint32_t before = 0;
};

constexpr std::uint32_t kCapacity = 4096;

/// The axis goes to and fro by 20 mm, and the sensors' words are written down at every tick.
class Recorder {
 public:
  Recorder() {
    bench.configure();
    bench.enable(1);
    home_ = bench.read_signed(0x6064, 0);
  }

  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const float held_A = bench.loop->motor.set_point_A;  // until the encoder is read
      bench.loop->step();
      const Controller& controller = bench.loop->controller();
      moments.push_back({bench.loop->board_encoder.next.counts, controller.output().reference_counts,
                         0.5F * (held_A + bench.loop->motor.set_point_A), controller.ticks()});
      bench.drive->after_tick();
      if (moments.size() % 10 == 0) turn();
    }
  }

  std::int32_t home() const { return home_; }

  Bench bench;
  std::vector<Moment> moments;

 private:
  // A turn of the main loop; a new target when the one before has been reached.
  void turn() {
    bench.now_us += 1000;
    if ((bench.read(0x6041, 0) & 0x0400) != 0) {
      out_ = !out_;
      EXPECT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(home_ + (out_ ? 20000 : 0)), 4), 0U);
      EXPECT_EQ(bench.write(0x6040, 0, 0x3F, 2), 0U);
      EXPECT_EQ(bench.write(0x6040, 0, 0x2F, 2), 0U);
    }
    bench.poll();
  }

  std::int32_t home_ = 0;
  bool out_ = false;
};

float value_of(const Moment& moment, std::uint32_t channel) {
  if (channel == 2) return moment.current_A;
  return static_cast<float>(channel == 0 ? moment.counts : moment.reference);
}

/// What the buffer should hold: ticks on the grid of the decimation, which begins anew at the trigger.
/// `place`: of the trigger; empty when it has not come, or not enough has come after it.
std::vector<Moment> expected(std::span<const Moment> moments, const Settings& settings, std::size_t& place) {
  std::size_t trigger = 0;
  if (settings.trigger != 0) {
    for (trigger = 1; trigger < moments.size(); ++trigger) {
      const bool was_above = value_of(moments[trigger - 1], settings.channel) >= settings.level;
      const bool is_above = value_of(moments[trigger], settings.channel) >= settings.level;
      if (was_above != is_above && is_above == (settings.trigger == 1)) break;
    }
  }
  const std::size_t after = kCapacity - settings.before;
  if (trigger + (after - 1) * settings.decimation >= moments.size()) return {};
  std::vector<Moment> kept;
  for (std::size_t i = 0; i < trigger; i += settings.decimation) kept.push_back(moments[i]);
  if (kept.size() > settings.before) {
    kept.erase(kept.begin(), kept.end() - static_cast<std::ptrdiff_t>(settings.before));
  }
  place = kept.size();
  for (std::size_t i = 0; i < after; ++i) kept.push_back(moments[trigger + i * settings.decimation]);
  return kept;
}

void arm(Bench& bench, const Settings& settings) {
  ASSERT_EQ(bench.write(0x2300, 3, settings.decimation, 2), 0U);
  ASSERT_EQ(bench.write(0x2300, 4, settings.trigger, 1), 0U);
  ASSERT_EQ(bench.write(0x2300, 5, settings.channel, 1), 0U);
  ASSERT_EQ(bench.write_real(0x2300, 6, settings.level), 0U);
  ASSERT_EQ(bench.write(0x2300, 7, settings.before, 2), 0U);
  ASSERT_EQ(bench.write(0x2300, 1, 1, 1), 0U);
}

/// Arms, runs until the buffer is full, reads it, compares. Returns the number of samples.
std::size_t check(Recorder& recorder, const Settings& settings) {
  Bench& bench = recorder.bench;
  const std::size_t begin = recorder.moments.size();
  arm(bench, settings);
  std::size_t place = 0;
  std::vector<Moment> wanted;
  for (int i = 0; i < 400 && wanted.empty(); ++i) {
    EXPECT_NE(bench.read(0x2300, 2), 3U) << "ready before its time";
    EXPECT_EQ(bench.write(0x2300, 3, 5, 2), 0x08000022U) << "settings stay while it records";
    recorder.run(200);
    wanted = expected(std::span(recorder.moments).subspan(begin), settings, place);
  }
  EXPECT_FALSE(wanted.empty()) << "no trigger came";
  EXPECT_EQ(bench.read(0x2300, 2), 3U);
  EXPECT_EQ(bench.read(0x2300, 8), wanted.size());
  const Data data = block_upload(bench, 0x2310, 127, [](int) { return false; });
  // Time passes while it is read, without the record: begin anew next time.
  if (data.size() != 48 + 12 * wanted.size() || wanted.empty()) {
    ADD_FAILURE() << data.size() << " bytes for " << wanted.size() << " samples";
    return 0;
  }
  EXPECT_EQ(Bench::number(data, 8), wanted.size());
  EXPECT_EQ(Bench::number(data, 12), settings.decimation);
  EXPECT_EQ(Bench::number(data, 36), place);
  EXPECT_EQ(Bench::number(data, 40), wanted.back().tick);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const std::size_t at = 48 + 12 * i;
    if (static_cast<std::int32_t>(Bench::number(data, at)) != wanted[i].counts ||
        static_cast<std::int32_t>(Bench::number(data, at + 4)) != wanted[i].reference ||
        Bench::number(data, at + 8) != std::bit_cast<std::uint32_t>(wanted[i].current_A)) {
      ADD_FAILURE() << "sample " << i << " of " << wanted.size() << ", the trigger at " << place;
      return 0;
    }
  }
  return wanted.size();
}

TEST(Trace, AtOnceHoldsEveryTickOrEveryNth) {
  Recorder recorder;
  for (const std::uint32_t decimation : {1U, 3U, 7U}) {
    EXPECT_EQ(check(recorder, {.decimation = decimation}), kCapacity) << decimation;
  }
}

TEST(Trace, TriggersOnEachSourceRisingAndFalling) {
  Recorder recorder;
  const auto middle = static_cast<float>(recorder.home() + 10000);
  for (const std::uint32_t channel : {0U, 1U, 2U}) {
    for (const std::uint32_t trigger : {1U, 2U}) {
      // A current that only an acceleration needs.
      const float level = channel < 2 ? middle : (trigger == 1 ? 0.5F : -0.5F);
      EXPECT_GT(check(recorder, {1, trigger, channel, level, 1000}), kCapacity - 1000)
          << channel << ' ' << trigger;
    }
  }
}

// Long before the trigger the ring has gone round; with a trigger that comes at once there is less before it
// than was asked for.
TEST(Trace, ShareBeforeTheTriggerAndWrap) {
  Recorder recorder;
  const auto middle = static_cast<float>(recorder.home() + 10000);
  for (const std::uint32_t before : {0U, 1U, 500U, 4095U}) {
    for (const std::uint32_t decimation : {1U, 4U}) {
      check(recorder, {decimation, 1, 0, middle, before});
    }
  }
  // The ring goes round: armed for a trigger that the moves never give, then moved by.
  Bench& bench = recorder.bench;
  arm(bench, {1, 1, 0, 1e9F, 2000});
  recorder.run(3 * static_cast<int>(kCapacity) + 17);
  EXPECT_EQ(bench.read(0x2300, 2), 1U);
  EXPECT_EQ(bench.read(0x2300, 8), 2000U) << "kept while it waits";
  EXPECT_EQ(bench.sdo(Bench::address(0x40, 0x2310, 0)).at(0), 0x80) << "not read while it records";
  ASSERT_EQ(bench.write(0x2300, 1, 0, 1), 0U);
  const Data data = block_upload(bench, 0x2310, 127, [](int) { return false; });
  ASSERT_EQ(data.size(), 48 + 12 * 2000U);
  const auto last = std::span(recorder.moments).last(2000);
  for (std::size_t i = 0; i < last.size(); ++i) {
    ASSERT_EQ(static_cast<std::int32_t>(Bench::number(data, 48 + 12 * i)), last[i].counts) << i;
  }
}

TEST(Trace, MoreBeforeTheTriggerThanThereIsLeavesOneForIt) {
  Recorder recorder;
  Bench& bench = recorder.bench;
  arm(bench, {1, 0, 0, 0.0F, 65535});
  recorder.run(20);
  EXPECT_EQ(bench.read(0x2300, 2), 3U);
  EXPECT_EQ(bench.read(0x2300, 8), 1U);
}

TEST(Trace, RefusesSettingsThatAreNone) {
  Bench bench;
  EXPECT_EQ(bench.write(0x2300, 3, 0, 2), 0x06090032U);
  EXPECT_EQ(bench.write(0x2300, 4, 3, 1), 0x06090031U);
  EXPECT_EQ(bench.write(0x2300, 5, 3, 1), 0x06090031U);
  EXPECT_EQ(bench.write_real(0x2300, 6, std::nanf("")), 0x06090032U);
  EXPECT_EQ(bench.write(0x2300, 1, 2, 1), 0x06090031U);
  EXPECT_EQ(bench.sdo(Bench::address(0x40, 0x2310, 0)).at(0), 0x80) << "nothing recorded yet";
}

}  // namespace
}  // namespace slipstack::can
