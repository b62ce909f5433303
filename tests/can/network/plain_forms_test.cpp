// SPDX-License-Identifier: Apache-2.0
// The small parts of the network against plain forms of the same, on random input: frames and emergencies in
// their order, what is periodic, and which identifiers may be written.
#include <algorithm>
#include <deque>

#include "firmware/canopen/network/emergency.h"
#include "firmware/canopen/network/outbox.h"
#include "firmware/canopen/network/periodic_timer.h"
#include "tests/can/bench.h"
#include "tests/unit/draw.h"

namespace slipstack::can {
namespace {

/// A port that takes so many frames.
class TakingPort final : public CanPort {
 public:
  bool send(const CanFrame& frame) override {
    if (room == 0) return false;
    --room;
    taken.push_back(frame.id);
    return true;
  }
  bool receive(CanFrame&) override { return false; }
  CanBusStatus status() const override { return {}; }
  void recover() override {}
  std::size_t room = 0;
  std::vector<std::uint32_t> taken;
};

TEST(Outbox, IsAQueueOfThirtyTwoAndCountsWhatFindsNoRoom) {
  test::Draw draw(1);
  canopen::Outbox outbox;
  std::deque<std::uint32_t> plain;
  std::uint32_t lost = 0;
  for (std::uint32_t id = 0; id < 5000; ++id) {
    const bool room = plain.size() < 32;
    ASSERT_EQ(outbox.push(id, Data{1, 2, 3}), room);
    if (room) plain.push_back(id);
    lost += room ? 0 : 1;
    if (draw.below(100) == 0) {
      outbox.clear();
      plain.clear();
    }
    TakingPort port;
    // Slower than frames come, then faster.
    port.room = draw.below(id % 200 < 100 ? 2 : 4);
    const std::size_t takes = std::min(port.room, plain.size());
    outbox.flush(port);
    ASSERT_TRUE(std::equal(port.taken.begin(), port.taken.end(), plain.begin()));
    ASSERT_EQ(port.taken.size(), takes);
    plain.erase(plain.begin(), plain.begin() + static_cast<std::ptrdiff_t>(takes));
    ASSERT_EQ(outbox.room(), 32 - plain.size());
    ASSERT_EQ(outbox.lost(), lost);
  }
  EXPECT_GT(lost, 100U);
}

// However irregularly it is asked: on its grid, but for a whole period in which nobody asked.
TEST(PeriodicTimer, StaysOnItsGrid) {
  test::Draw draw(2);
  for (int run = 0; run < 50; ++run) {
    const auto period_us = 1 + static_cast<std::uint32_t>(draw.below(1000));
    canopen::PeriodicTimer timer;
    auto now_us = static_cast<std::uint32_t>(draw.uniform(0.0, 4.2e9));
    timer.restart(now_us);
    std::uint64_t since_grid = 0;
    for (int i = 0; i < 2000; ++i) {
      const auto step =
          static_cast<std::uint32_t>(draw.below(std::size_t{period_us} * (i % 50 == 0 ? 4 : 1) + 1));
      now_us += step;
      since_grid += step;
      const bool due = since_grid >= period_us;
      ASSERT_EQ(timer.due(now_us, period_us), due);
      if (due) since_grid = since_grid < 2 * std::uint64_t{period_us} ? since_grid - period_us : 0;
      ASSERT_FALSE(timer.due(now_us, 0)) << "no period, never";
    }
  }
}

/// CiA 301, 7.2.7, as lists: what is there, what was told, what waits.
class PlainEmergency {
 public:
  struct Waiting {
    std::uint16_t code;
    std::uint8_t bits, source;
    std::uint32_t detail;
  };
  void set(int source, std::uint16_t code, std::uint32_t detail) {
    const auto at = static_cast<std::size_t>(source);
    if (codes[at] == code && (code == 0 || details[at] == detail)) return;
    codes[at] = code;
    details[at] = detail;
    if (code != 0) {
      history.push_front(code | static_cast<std::uint32_t>(source) << 16);
      if (history.size() > canopen::kErrorHistory) history.pop_back();
    }
    const auto left = std::find_if(codes.begin(), codes.end(), [](std::uint16_t one) { return one != 0; });
    const std::uint16_t told = code != 0 ? code : left != codes.end() ? *left : std::uint16_t{0};
    waiting.push_back({told, bits(), static_cast<std::uint8_t>(source), detail});
    if (waiting.size() > 8) waiting.pop_front();
  }
  // Generic; current, voltage, temperature, communication, profile by the class of the code.
  std::uint8_t bits() const {
    unsigned all = 0;
    for (const std::uint16_t code : codes) {
      if (code == 0) continue;
      all |= 1U;
      if (code >> 12 == 2) all |= 2U;
      if (code >> 12 == 3) all |= 4U;
      if (code >> 12 == 4) all |= 8U;
      if (code >> 8 == 0x81 || code >> 8 == 0x82) all |= 0x10U;
      if (code >> 12 == 8 && code >> 8 != 0x81 && code >> 8 != 0x82) all |= 0x20U;
    }
    return static_cast<std::uint8_t>(all);
  }
  std::array<std::uint16_t, static_cast<std::size_t>(canopen::ErrorSource::kCount)> codes{};
  std::array<std::uint32_t, static_cast<std::size_t>(canopen::ErrorSource::kCount)> details{};
  std::deque<std::uint32_t> history;
  std::deque<Waiting> waiting;
};

TEST(EmergencyLists, RegisterHistoryAndMessagesAreThoseOfThePlainForm) {
  test::Draw draw(3);
  canopen::Emergency emergency;
  PlainEmergency plain;
  const std::uint16_t codes[] = {0x0000, 0x0000, 0x2310, 0x3210, 0x4310,
                                 0x5210, 0x7305, 0x8110, 0x8250, 0x8611};
  std::uint32_t now_us = 5, sent_us = 0;
  bool sent = false;
  for (int i = 0; i < 20000; ++i) {
    now_us += static_cast<std::uint32_t>(draw.below(3000));
    if (draw.below(3) != 0) {
      const auto source = static_cast<int>(draw.below(plain.codes.size()));
      const std::uint16_t code = codes[draw.below(std::size(codes))];
      const auto detail = static_cast<std::uint32_t>(draw.below(3)) * 0x01020304U;
      emergency.set(static_cast<canopen::ErrorSource>(source), code, detail);
      plain.set(source, code, detail);
    }
    if (draw.below(500) == 0) {
      emergency.clear_history();
      plain.history.clear();
    }
    if (draw.below(500) == 0) {
      emergency.reset_communication();
      for (std::size_t k = 1; k < plain.codes.size(); ++k) plain.codes[k] = 0;
      plain.waiting.clear();
      if (plain.codes[0] != 0) plain.waiting.push_back({plain.codes[0], plain.bits(), 0, 0});
    }
    ASSERT_EQ(emergency.error_register(), plain.bits());
    ASSERT_EQ(emergency.count(), plain.history.size());
    for (std::size_t k = 0; k < plain.history.size(); ++k)
      ASSERT_EQ(emergency.history(static_cast<std::uint8_t>(k + 1)), plain.history[k]);
    ASSERT_EQ(emergency.history(static_cast<std::uint8_t>(plain.history.size() + 1)), 0U);
    // 1 ms between two; none while the identifier is off.
    const bool off = draw.below(10) == 0;
    canopen::Outbox outbox;
    emergency.step(now_us, off ? 0x80000085U : 0x85U, 10, outbox);
    const bool due = !off && !plain.waiting.empty() && (!sent || now_us - sent_us >= 1000);
    ASSERT_EQ(outbox.room(), due ? 31U : 32U);
    if (!due) continue;
    sent = true;
    sent_us = now_us;
    host::HostCanPort here{8}, there{8};
    here.connect(there);
    outbox.flush(there);
    CanFrame frame;
    ASSERT_TRUE(here.receive(frame));
    const PlainEmergency::Waiting told = plain.waiting.front();
    plain.waiting.pop_front();
    const Data data(frame.data.begin(), frame.data.begin() + frame.length);
    ASSERT_EQ(frame.id, 0x85U);
    ASSERT_EQ(data.size(), 8U);
    ASSERT_EQ(Bench::number(data, 0, 2), told.code);
    ASSERT_EQ(data[2], told.bits);
    ASSERT_EQ(data[3], told.source);
    ASSERT_EQ(Bench::number(data, 4), told.detail);
  }
}

// 1005h and 1014h: eleven bits; none that the standard keeps; and while it is in use another one only
// together with taking it out of use.
TEST(Identifiers, OfSyncAndEmergencyAreWrittenWhileTheyAreNotInUse) {
  test::Draw draw(4);
  constexpr std::uint32_t kProduces = 0x40000000U, kInvalid = 0x80000000U, kBad = 0x06090030U;
  Bench bench;
  for (const std::uint16_t index : {std::uint16_t{0x1005}, std::uint16_t{0x1014}}) {
    std::uint32_t now = bench.read(index, 0);
    int taken = 0, refused = 0;
    for (int i = 0; i < 400; ++i) {
      std::uint32_t value = 0x100U + static_cast<std::uint32_t>(draw.below(0x60));
      if (draw.below(3) == 0) value = now & 0x7FFU;
      if (draw.below(8) == 0) value = static_cast<std::uint32_t>(draw.below(0x800));
      const std::uint32_t flag = index == 0x1005 ? kProduces : kInvalid;
      if (draw.below(2) == 0) value |= flag;
      if (draw.below(10) == 0) value |= draw.below(2) == 0 ? 0x20000000U : 0x800U;
      const auto used = [&](std::uint32_t one) { return (index == 0x1005) == ((one & flag) != 0); };
      const std::uint32_t id = value & 0x7FFU;
      const bool kept = id <= 0x7F || (id >= 0x101 && id <= 0x180) || (id >= 0x581 && id <= 0x5FF) ||
                        (id >= 0x601 && id <= 0x67F) || (id >= 0x6E0 && id <= 0x6FF) || id >= 0x701;
      const bool wide = (value & ~(flag | 0x7FFU)) != 0;
      const bool moved = used(now) && used(value) && (now & 0x7FFU) != id;
      const bool bad = wide || moved || kept;
      ASSERT_EQ(bench.write(index, 0, value, 4), bad ? kBad : 0U)
          << std::hex << index << ' ' << now << ' ' << value;
      if (!bad) now = value;
      ASSERT_EQ(bench.read(index, 0), now);
      (bad ? refused : taken) += 1;
    }
    EXPECT_GT(taken, 20);
    EXPECT_GT(refused, 20);
  }
}

}  // namespace
}  // namespace slipstack::can
