// SPDX-License-Identifier: Apache-2.0
// NMT, heartbeat, SYNC, EMCY, LSS, bus-off: CiA 301 and CiA 305.
#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

TEST(Nmt, BootsUpIntoPreOperational) {
  Bench bench;
  EXPECT_EQ(bench.all(), (std::vector<Message>{{0x705, {0x00}}}));
  EXPECT_EQ(bench.node->state(), canopen::NmtState::kPreOperational);
}

TEST(Nmt, FollowsCommandsForItsNodeAndForAll) {
  Bench bench;
  bench.nmt(0x01, 6);  // another node
  EXPECT_EQ(bench.node->state(), canopen::NmtState::kPreOperational);
  bench.nmt(0x01, 0);
  EXPECT_EQ(bench.node->state(), canopen::NmtState::kOperational);
  bench.nmt(0x02);
  EXPECT_EQ(bench.node->state(), canopen::NmtState::kStopped);
  bench.nmt(0x80);
  EXPECT_EQ(bench.node->state(), canopen::NmtState::kPreOperational);
  bench.all();
  for (const std::uint8_t reset : {std::uint8_t{0x81}, std::uint8_t{0x82}}) {
    bench.nmt(reset);
    EXPECT_EQ(bench.all_with(0x705), (std::vector<Data>{{0x00}}));
    EXPECT_EQ(bench.node->state(), canopen::NmtState::kPreOperational);
  }
  bench.send(0, {0x01});  // too short
  bench.send(0, {0x01, 0, 0});
  bench.send(0, {0x55, 0});
  bench.poll();
  EXPECT_EQ(bench.node->state(), canopen::NmtState::kPreOperational);
  EXPECT_EQ(bench.read(0x2211, 3), 3U);
}

TEST(Nmt, StoppedAnswersNoSdo) {
  Bench bench;
  bench.nmt(0x02);
  EXPECT_TRUE(bench.sdo(Bench::address(0x40, 0x1000, 0)).empty());
}

TEST(Heartbeat, SaysTheStateOnItsGrid) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1017, 0, 100, 2), 0U);
  bench.run_ms(1000);
  EXPECT_EQ(bench.all_with(0x705), std::vector<Data>(10, Data{0x7F}));
  bench.nmt(0x01);
  bench.run_ms(300);
  EXPECT_EQ(bench.all_with(0x705), std::vector<Data>(3, Data{0x05}));
  bench.nmt(0x02);
  bench.run_ms(300);
  EXPECT_EQ(bench.all_with(0x705), std::vector<Data>(3, Data{0x04}));
}

TEST(Heartbeat, ConsumerReportsALostMasterOnceAndItsReturn) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1016, 1, 0x00010032, 4), 0U);           // node 1, 50 ms
  EXPECT_EQ(bench.write(0x1016, 2, 0x00010064, 4), 0x06040043U);  // the same node again
  bench.nmt(0x01);
  bench.all();
  bench.run_ms(200);
  EXPECT_TRUE(bench.all_with(0x085).empty()) << "not watched before its first heartbeat";
  bench.send(0x701, {0x05});
  bench.run_ms(49);
  EXPECT_TRUE(bench.all_with(0x085).empty());
  bench.run_ms(3);
  const auto lost = bench.all_with(0x085);
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(Bench::number(lost[0], 0, 2), 0x8130U);
  EXPECT_EQ(lost[0][2] & 0x11, 0x11);                                  // generic, communication
  EXPECT_EQ(bench.node->state(), canopen::NmtState::kPreOperational);  // 1029h:1 is 0
  EXPECT_EQ(bench.read(0x1001, 0) & 0x10, 0x10U);
  bench.send(0x701, {0x05});
  bench.run_ms(2);
  const auto back = bench.all_with(0x085);
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0], (Data{0, 0, 0, 2, 0, 0, 0, 0}));
  EXPECT_EQ(bench.read(0x1003, 0), 1U);
  EXPECT_EQ(bench.read(0x1003, 1) & 0xFFFF, 0x8130U);
  EXPECT_EQ(bench.write(0x1003, 0, 1, 1), 0x06090031U);  // only 0 may be written
  EXPECT_EQ(bench.write(0x1003, 0, 0, 1), 0U);
  EXPECT_EQ(bench.read(0x1003, 0), 0U);
}

TEST(Heartbeat, ErrorBehaviourDecides) {
  for (const auto& [behaviour, state] :
       {std::pair{0, canopen::NmtState::kPreOperational}, std::pair{1, canopen::NmtState::kOperational},
        std::pair{2, canopen::NmtState::kStopped}}) {
    Bench bench;
    bench.write(0x1029, 1, static_cast<std::uint32_t>(behaviour), 1);
    bench.write(0x1016, 1, 0x00010032, 4);
    bench.nmt(0x01);
    bench.send(0x701, {0x05});
    bench.run_ms(100);
    EXPECT_EQ(bench.node->state(), state) << behaviour;
  }
}

TEST(Sync, ProducerCountsToTheOverflowValue) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1019, 0, 4, 1), 0U);
  ASSERT_EQ(bench.write(0x1006, 0, 10000, 4), 0U);
  EXPECT_EQ(bench.write(0x1019, 0, 5, 1), 0x08000022U);  // not while the period is set
  EXPECT_EQ(bench.write(0x1019, 0, 1, 1), 0x06090030U);  // 1 and from 241 on: reserved
  EXPECT_EQ(bench.write(0x1019, 0, 241, 1), 0x06090031U);
  ASSERT_EQ(bench.write(0x1005, 0, 0x40000080, 4), 0U);
  EXPECT_EQ(bench.write(0x1005, 0, 0x40000081, 4), 0x06090030U);  // the identifier stays while producing
  bench.all();
  bench.run_ms(60);
  EXPECT_EQ(bench.all_with(0x080), (std::vector<Data>{{1}, {2}, {3}, {4}, {1}, {2}}));
}

// The node's own SYNC is one for its own PDOs as well: as many go out as of a SYNC that another one sends.
TEST(Sync, AProducerFollowsItsOwn) {
  for (const bool own : {true, false}) {
    Bench bench;
    ASSERT_EQ(bench.write(0x1801, 2, 3, 1), 0U);  // TPDO 2 with every third
    ASSERT_EQ(bench.write(0x1006, 0, 10000, 4), 0U);
    bench.nmt(0x01);
    bench.run_ms(20);
    if (own) {
      ASSERT_EQ(bench.write(0x1005, 0, 0x40000080, 4), 0U);
    }
    bench.all();
    std::size_t syncs = 0, pdos = 0;
    for (int period = 0; period < 30; ++period) {
      if (!own) bench.send(0x080, {});
      bench.run_ms(10);
      for (const Message& message : bench.all()) {
        syncs += message.id == 0x080 ? 1U : 0U;
        pdos += message.id == 0x285 ? 1U : 0U;
      }
    }
    EXPECT_EQ(syncs, own ? 30U : 0U);
    EXPECT_EQ(pdos, 10U) << (own ? "its own" : "of another");
  }
}

TEST(BusOff, WaitsRecoversAndTells) {
  Bench bench;
  bench.nmt(0x01);
  bench.all();
  bench.device.bus.state = CanBusState::kOff;
  bench.run_ms(100);
  EXPECT_EQ(bench.device.bus.state, CanBusState::kOff) << "not at once: another node may talk first";
  EXPECT_EQ(bench.node->state(), canopen::NmtState::kPreOperational);
  bench.run_ms(5);
  EXPECT_EQ(bench.device.bus.state, CanBusState::kActive);
  bench.run_ms(2);
  const auto messages = bench.all_with(0x085);
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(Bench::number(messages[0], 0, 2), 0x8140U);
  EXPECT_EQ(Bench::number(messages[1], 0, 2), 0x0000U);
  EXPECT_EQ(bench.read(0x2211, 6), 1U);
}

TEST(Emcy, InhibitTimeAndIdentifier) {
  Bench bench;
  bench.configure();
  ASSERT_EQ(bench.write(0x1015, 0, 1000, 2), 0U);  // 100 ms
  EXPECT_EQ(bench.write(0x1014, 0, 0x86, 4), 0x06090030U);
  ASSERT_EQ(bench.write(0x1014, 0, 0x80000085, 4), 0U);
  ASSERT_EQ(bench.write(0x1014, 0, 0x90, 4), 0U);
  bench.all();
  bench.loop->controller().inject(Fault::kOverCurrent);
  bench.run_ms(5);
  const auto first = bench.all_with(0x090);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(Bench::number(first[0], 0, 2), 0x2310U);
  EXPECT_EQ(first[0][2], 0x03);  // generic, current
  bench.write(0x6040, 0, 0x80, 2);
  bench.run_ms(50);
  EXPECT_TRUE(bench.all_with(0x090).empty());
  bench.run_ms(60);
  const auto reset = bench.all_with(0x090);
  ASSERT_EQ(reset.size(), 1U);
  EXPECT_EQ(Bench::number(reset[0], 0, 2), 0U);
}

Data lss(std::uint8_t command, std::uint32_t word = 0) {
  return {command,
          static_cast<std::uint8_t>(word),
          static_cast<std::uint8_t>(word >> 8),
          static_cast<std::uint8_t>(word >> 16),
          static_cast<std::uint8_t>(word >> 24),
          0,
          0,
          0};
}

TEST(Lss, SelectsByIdentityAndSetsTheNodeId) {
  Bench bench;
  bench.all();
  const std::array<std::uint32_t, 4> identity = {0, 0x534C4B31, 0x00010000, 0x12345678};
  // With a wrong serial number nobody answers.
  for (const std::uint32_t serial : {0x12345679U, 0x12345678U}) {
    for (std::uint8_t i = 0; i < 3; ++i)
      bench.send(0x7E5, lss(static_cast<std::uint8_t>(0x40 + i), identity[i]));
    bench.send(0x7E5, lss(0x43, serial));
    bench.poll();
    const auto answers = bench.all_with(0x7E4);
    if (serial != identity[3]) {
      EXPECT_TRUE(answers.empty());
    } else {
      EXPECT_EQ(answers, (std::vector<Data>{{0x44, 0, 0, 0, 0, 0, 0, 0}}));
    }
  }
  const auto ask = [&](const Data& request) {
    bench.send(0x7E5, request);
    bench.poll();
    const auto answers = bench.all_with(0x7E4);
    return answers.empty() ? Data{} : answers[0];
  };
  EXPECT_EQ(ask(lss(0x5E)), (Data{0x5E, 5, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(ask(lss(0x5D)), (Data{0x5D, 0x78, 0x56, 0x34, 0x12, 0, 0, 0}));
  EXPECT_EQ(ask(lss(0x11, 128)), (Data{0x11, 1, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(ask(lss(0x11, 33)), (Data{0x11, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(ask(lss(0x13, 0x0500)), (Data{0x13, 1, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(ask(lss(0x13, 0x0200)), (Data{0x13, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(ask(lss(0x17)), (Data{0x17, 0, 0, 0, 0, 0, 0, 0}));
  bench.send(0x7E5, lss(0x04, 0));
  bench.poll();
  EXPECT_EQ(bench.node->id(), 5) << "the new id comes with the next reset";
  bench.nmt(0x82);
  EXPECT_EQ(bench.all_with(0x721), (std::vector<Data>{{0}}));
  bench.power_on();
  bench.begin();
  EXPECT_EQ(bench.all_with(0x721), (std::vector<Data>{{0}})) << "stored";
}

// CiA 305: whoever has no node id yet answers the master that asks for such, and nobody else does.
TEST(Lss, OneWithoutANodeIdSaysSo) {
  Bench bench;
  bench.all();
  const auto asked = [&] {
    bench.send(0x7E5, lss(0x4C, 0));
    bench.poll();
    return bench.all_with(0x7E4);
  };
  EXPECT_TRUE(asked().empty()) << "it has one";
  bench.send(0x7E5, lss(0x04, 1));
  bench.send(0x7E5, lss(0x11, 255));
  bench.send(0x7E5, lss(0x04, 0));
  bench.poll();
  bench.nmt(0x82);
  bench.poll();
  bench.all();
  EXPECT_EQ(asked(), (std::vector<Data>{{0x50, 0, 0, 0, 0, 0, 0, 0}}));
}

TEST(Lss, EveryWordOfTheIdentityMustFitAndComeInItsTurn) {
  Bench bench;
  bench.all();
  const std::array<std::uint32_t, 4> identity = {0, 0x534C4B31, 0x00010000, 0x12345678};
  const auto selected = [&](const std::vector<std::uint8_t>& parts, int wrong) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::uint32_t word = identity[parts[i]] + (static_cast<int>(i) == wrong ? 1U : 0U);
      bench.send(0x7E5, lss(static_cast<std::uint8_t>(0x40 + parts[i]), word));
    }
    bench.poll();
    const bool answered = !bench.all_with(0x7E4).empty();
    bench.send(0x7E5, lss(0x04, 0));
    bench.poll();
    return answered;
  };
  EXPECT_TRUE(selected({0, 1, 2, 3}, -1));
  for (int wrong = 0; wrong < 4; ++wrong) EXPECT_FALSE(selected({0, 1, 2, 3}, wrong)) << wrong;
  EXPECT_TRUE(selected({0, 1, 2, 3}, -1));
  for (const auto& parts : std::vector<std::vector<std::uint8_t>>{{1, 2, 3},
                                                                  {0, 2, 3},
                                                                  {0, 1, 3},
                                                                  {0, 1, 2},
                                                                  {1, 0, 2, 3},
                                                                  {0, 1, 3, 2},
                                                                  {3, 0, 1, 2},
                                                                  {0, 1, 1, 2, 3}})
    EXPECT_FALSE(selected(parts, -1)) << parts.size() << ' ' << int{parts[1]};
  // One that begins anew is none that goes on.
  EXPECT_TRUE(selected({0, 1, 0, 1, 2, 3}, -1));
}

TEST(Lss, IdentifyAnswersWithinTheRangesInOrderOnly) {
  Bench bench;
  // Vendor, product, revision from and to, serial number from and to.
  const std::array<std::uint32_t, 6> own = {0, 0x534C4B31, 0x00010000, 0x00010000, 0x12345678, 0x12345678};
  const auto answered = [&](const std::array<std::uint32_t, 6>& words, std::uint8_t skipped) {
    bench.all();
    for (std::uint8_t i = 0; i < 6; ++i) {
      if (i != skipped) bench.send(0x7E5, lss(static_cast<std::uint8_t>(0x46 + i), words[i]));
    }
    bench.poll();
    const auto answers = bench.all_with(0x7E4);
    return answers == std::vector<Data>{lss(0x4F)};
  };
  EXPECT_TRUE(answered(own, 6));
  EXPECT_TRUE(answered({0, 0x534C4B31, 0, 0xFFFFFFFF, 0x12345600, 0x123456FF}, 6));
  for (std::uint8_t i = 0; i < 6; ++i) {
    EXPECT_FALSE(answered(own, i)) << "without part " << int{i};
    auto others = own;
    others[i] += i == 3 || i == 5 ? 0xFFFFFFFFU : 1U;  // the ends of a range the other way
    EXPECT_FALSE(answered(others, 6)) << "part " << int{i};
  }
  EXPECT_TRUE(answered(own, 6));
  EXPECT_EQ(bench.node->id(), 5) << "and nothing has changed";
}

TEST(Lss, AnUnconfiguredNodeIsFoundByFastscan) {
  Bench bench(true, 0xFF);
  EXPECT_TRUE(bench.all().empty()) << "no boot-up without an id";
  const auto answered = [&](std::uint32_t word, std::uint8_t bit, std::uint8_t part, std::uint8_t next) {
    Data request = lss(0x51, word);
    request[5] = bit;
    request[6] = part;
    request[7] = next;
    bench.send(0x7E5, request);
    bench.poll();
    return !bench.all_with(0x7E4).empty();
  };
  ASSERT_TRUE(answered(0, 0x80, 0, 0));
  const std::array<std::uint32_t, 4> identity = {0, 0x534C4B31, 0x00010000, 0x12345678};
  // A master that gives up half way begins anew.
  ASSERT_TRUE(answered(identity[0], 0, 0, 1));
  EXPECT_TRUE(answered(identity[1], 0, 1, 1));
  EXPECT_FALSE(answered(identity[0], 0, 0, 0)) << "another part's turn";
  ASSERT_TRUE(answered(0, 0x80, 0, 0));
  for (std::uint8_t part = 0; part < 4; ++part) {
    std::uint32_t word = 0;
    for (int bit = 31; bit >= 0; --bit) {
      if (!answered(word, static_cast<std::uint8_t>(bit), part, part)) word |= 1U << bit;
    }
    EXPECT_EQ(word, identity[part]);
    ASSERT_TRUE(answered(word, 0, part, static_cast<std::uint8_t>(part == 3 ? 0 : part + 1)));
  }
  bench.send(0x7E5, lss(0x11, 9));
  bench.run_ms(20);
  EXPECT_TRUE(bench.all_with(0x709).empty()) << "not while it is configured";
  bench.send(0x7E5, lss(0x04, 0));
  bench.poll();
  EXPECT_EQ(bench.all_with(0x709), (std::vector<Data>{{0}}));
}

TEST(Lss, ChangesTheBitRateAfterTheDelayAndIsSilentMeanwhile) {
  Bench bench;
  EXPECT_EQ(bench.device.bit_rate, 250'000U) << "as the table says, from the start";
  ASSERT_EQ(bench.write(0x1017, 0, 5, 2), 0U);
  bench.run_ms(6);
  bench.all();
  bench.send(0x7E5, lss(0x04, 1));
  bench.send(0x7E5, {0x13, 0, 2, 0, 0, 0, 0, 0});  // 500 kbit/s
  bench.poll();
  EXPECT_EQ(bench.all_with(0x7E4), (std::vector<Data>{lss(0x13)}));
  EXPECT_EQ(bench.device.bit_rate, 250'000U) << "not before it is activated";
  bench.send(0x7E5, lss(0x15, 20));
  bench.poll();
  bench.all();
  bench.run_ms(19);
  EXPECT_EQ(bench.device.bit_rate, 250'000U);
  bench.run_ms(1);
  EXPECT_EQ(bench.device.bit_rate, 500'000U);
  bench.send(0x605, Bench::address(0x40, 0x1000, 0));
  bench.run_ms(19);
  EXPECT_TRUE(bench.all().empty()) << "no heartbeat, no answer, for two delays";
  bench.run_ms(7);
  EXPECT_FALSE(bench.all_with(0x705).empty());
  EXPECT_EQ(bench.read(0x1000, 0), 0x00020192U);
  // Not stored: gone with the power. Stored: there.
  bench.power_on();
  bench.begin();
  EXPECT_EQ(bench.device.bit_rate, 250'000U);
  bench.send(0x7E5, lss(0x04, 1));
  bench.send(0x7E5, {0x13, 0, 4, 0, 0, 0, 0, 0});
  bench.send(0x7E5, lss(0x17));
  bench.poll();
  bench.power_on();
  bench.begin();
  EXPECT_EQ(bench.device.bit_rate, 125'000U);
  EXPECT_EQ(bench.read(0x2402, 2), 4U);
}

TEST(Lss, AMovingAxisStaysOnTheBus) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  bench.send(0x7E5, lss(0x04, 1));
  bench.send(0x7E5, {0x13, 0, 2, 0, 0, 0, 0, 0});
  bench.send(0x7E5, lss(0x15, 0xFFFF));
  bench.run_ms(2);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x6F, 0x27U) << "it answers, and at once";
  EXPECT_EQ(bench.device.bit_rate, 250'000U);
}

TEST(Lss, NothingIsStoredWhileTheDriveIsEnabled) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  bench.send(0x7E5, lss(0x04, 1));
  bench.poll();
  bench.all();
  for (const bool enabled : {true, false}) {
    const auto before = bench.flash.bytes;
    bench.send(0x7E5, {0x17, 0, 0, 0, 0, 0, 0, 0});
    bench.poll();
    const auto answers = bench.all_with(0x7E4);
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0], (Data{0x17, static_cast<std::uint8_t>(enabled ? 2 : 0), 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(bench.flash.bytes == before, enabled);
    ASSERT_EQ(bench.write(0x6040, 0, 0, 2), 0U);
    bench.run_ms(2);
    bench.all();
  }
}

TEST(Lss, RefusesBitRatesThatThePortDoesNotOffer) {
  Bench bench;
  bench.device.fastest = 250'000;
  bench.send(0x7E5, lss(0x04, 1));
  bench.poll();
  bench.all();
  // Table 1 is another manufacturer's; index 5 is reserved, 9 automatic.
  for (const auto& [table, index, answer] :
       {std::array{0, 0, 1}, {0, 2, 1}, {0, 3, 0}, {0, 5, 1}, {0, 8, 0}, {0, 9, 1}, {1, 3, 1}}) {
    bench.send(0x7E5,
               {0x13, static_cast<std::uint8_t>(table), static_cast<std::uint8_t>(index), 0, 0, 0, 0, 0});
    bench.poll();
    EXPECT_EQ(bench.all_with(0x7E4), (std::vector<Data>{lss(0x13, static_cast<std::uint32_t>(answer))}))
        << index;
  }
}

}  // namespace
}  // namespace slipstack::can
