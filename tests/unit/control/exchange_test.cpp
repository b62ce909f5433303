// SPDX-License-Identifier: Apache-2.0
// What the main loop hands to the tick, with a tick at every place where one may come between: nothing is
// taken half made or out of date, and nothing is lost.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "firmware/control/exchange_box.h"
#include "firmware/control/parameters/parameter_swap.h"
#include "tests/unit/draw.h"

namespace slipstack {
namespace {

/// Lets ticks come while its state is copied.
struct SwappedSet {
  int number = 0;
  int motion = 0;                               // what the tick changes in the set in force
  static inline std::function<void()> between;  // NOLINT(*-avoid-non-const-global-variables)

  void continue_from(const SwappedSet& other) {
    motion = other.motion;
    if (between) between();
  }
};

/// The tick moves the set in force on, and sees where the motion goes on.
class SwappingTick {
 public:
  bool tick() {
    const bool taken = swap.begin_tick();
    SwappedSet& set = swap.active();
    // The new set goes on with the motion as it was a tick ago.
    EXPECT_EQ(set.motion, motion_) << "in tick " << swap.tick();
    set.motion = ++motion_;
    return taken;
  }
  ParameterSwap<SwappedSet> swap;

 private:
  int motion_ = 0;
};

TEST(ParameterSwap, TheNextTickTakesWhatWasArmed) {
  SwappingTick one;
  for (int number = 1; number < 10; ++number) {
    for (int i = 0; i < number; ++i) EXPECT_FALSE(one.tick());
    EXPECT_FALSE(one.swap.pending());
    SwappedSet* const spare = one.swap.spare();
    ASSERT_NE(spare, nullptr);
    EXPECT_NE(spare, &one.swap.active());
    spare->number = number;
    const std::uint32_t before = one.swap.tick();
    one.swap.arm();
    EXPECT_TRUE(one.swap.pending());
    EXPECT_EQ(one.swap.spare(), nullptr) << "under way";
    EXPECT_EQ(one.swap.active().number, number - 1) << "not before the tick";
    EXPECT_TRUE(one.tick());
    EXPECT_EQ(one.swap.tick(), before + 1);
    EXPECT_EQ(one.swap.active().number, number);
  }
}

// A tick while the motion is copied makes the copy out of date: it is not taken, then or ever, until it is
// armed again.
TEST(ParameterSwap, ACopyThatATickHasOvertakenIsNotTaken) {
  for (const int ticks : {1, 2, 5}) {
    SwappingTick one;
    one.tick();
    one.swap.spare()->number = 1;
    SwappedSet::between = [&] {
      for (int i = 0; i < ticks; ++i) EXPECT_FALSE(one.tick()) << "half copied";
    };
    one.swap.arm();
    SwappedSet::between = nullptr;
    for (int i = 0; i < 5; ++i) EXPECT_FALSE(one.tick()) << "out of date";
    EXPECT_TRUE(one.swap.pending());
    EXPECT_EQ(one.swap.spare(), nullptr);
    one.swap.arm();
    EXPECT_TRUE(one.tick());
    EXPECT_FALSE(one.swap.pending());
    EXPECT_EQ(one.swap.active().number, 1);
    EXPECT_FALSE(one.tick()) << "once";
  }
}

// Armed again before a tick came: one change.
TEST(ParameterSwap, ArmedTwiceItIsTakenOnce) {
  SwappingTick one;
  one.tick();
  one.swap.spare()->number = 1;
  one.swap.arm();
  one.swap.arm();
  int visited = 0;
  one.swap.each([&](SwappedSet&) { ++visited; });
  EXPECT_EQ(visited, 2);
  EXPECT_TRUE(one.tick());
  EXPECT_FALSE(one.tick());
  EXPECT_EQ(one.swap.active().number, 1);
}

/// Reads the box while it is written.
struct SeenWhileWritten {
  int first = 0, second = 0;
  static inline std::function<void()> between;  // NOLINT(*-avoid-non-const-global-variables)
  SeenWhileWritten() = default;
  SeenWhileWritten(int a, int b) : first(a), second(b) {}
  SeenWhileWritten(const SeenWhileWritten&) = default;
  SeenWhileWritten(SeenWhileWritten&&) = default;
  SeenWhileWritten& operator=(SeenWhileWritten&& other) noexcept { return *this = other; }
  ~SeenWhileWritten() = default;
  SeenWhileWritten& operator=(const SeenWhileWritten& other) {
    if (this == &other) return *this;
    first = other.first;
    if (between) between();
    second = other.second;
    return *this;
  }
};

TEST(ExchangeBox, IsNeverReadHalfWritten) {
  ExchangeBox<SeenWhileWritten> box;
  int last = 0, looked = 0;
  SeenWhileWritten::between = [&] {
    EXPECT_EQ(box.read().first, last);
    EXPECT_EQ(box.read().second, last);
    ++looked;
  };
  for (int i = 1; i < 20; ++i) {
    box.write({i, i});
    last = i;
    EXPECT_EQ(box.read().first, i);
    EXPECT_EQ(box.read().second, i);
  }
  EXPECT_EQ(looked, 19);
  SeenWhileWritten::between = nullptr;
}

}  // namespace
}  // namespace slipstack
