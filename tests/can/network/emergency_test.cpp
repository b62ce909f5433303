// SPDX-License-Identifier: Apache-2.0
// EMCY: every error code of CiA 301 table 26 that communication can cause here, its end, register and
// history.
#include "firmware/canopen/network/emergency.h"
#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

struct Told {
  std::uint16_t code;
  std::uint8_t bits;
  std::uint32_t detail;
};

std::vector<Told> described(Bench& bench) {
  std::vector<Told> messages;
  for (const Data& data : bench.all_with(0x085)) {
    EXPECT_EQ(data.size(), 8U);
    messages.push_back(
        {static_cast<std::uint16_t>(Bench::number(data, 0, 2)), data[2], Bench::number(data, 4)});
  }
  return messages;
}

// One message with the code, generic and communication error in the register, the code at the head of the
// history.
void expect_error(Bench& bench, std::uint16_t code, std::uint32_t detail) {
  const auto messages = described(bench);
  ASSERT_EQ(messages.size(), 1U) << std::hex << code;
  EXPECT_EQ(messages[0].code, code);
  EXPECT_EQ(messages[0].bits, 0x11) << std::hex << code;
  EXPECT_EQ(messages[0].detail, detail);
  EXPECT_EQ(bench.read(0x1001, 0), 0x11U);
  EXPECT_GE(bench.read(0x1003, 0), 1U);
  EXPECT_EQ(bench.read(0x1003, 1) & 0xFFFF, code);
}

// Error reset: 0000h, and an empty register. The history stays.
void expect_none(Bench& bench, std::uint16_t code) {
  const auto messages = described(bench);
  ASSERT_EQ(messages.size(), 1U) << std::hex << code;
  EXPECT_EQ(messages[0].code, 0U);
  EXPECT_EQ(messages[0].bits, 0U);
  EXPECT_EQ(bench.read(0x1001, 0), 0U);
  EXPECT_EQ(bench.read(0x1003, 1) & 0xFFFF, code);
}

TEST(Emcy, AnEmptyHistoryHasNoDataToRead) {
  Bench bench;
  EXPECT_EQ(bench.read(0x1003, 0), 0U);
  for (const std::uint8_t command : {std::uint8_t{0x40}, std::uint8_t{0xA4}}) {
    Data request = Bench::address(command, 0x1003, 1);
    if (command == 0xA4) request[4] = 127;
    const Data answer = bench.sdo(request);
    EXPECT_EQ(answer.at(0), 0x80);
    EXPECT_EQ(Bench::number(answer, 4), 0x08000024U);
  }
  bench.nmt(0x01);
  bench.send(0x205, {0x06});
  bench.run_ms(2);
  EXPECT_EQ(bench.read(0x1003, 1) & 0xFFFF, 0x8210U);
  EXPECT_EQ(Bench::number(bench.sdo(Bench::address(0x40, 0x1003, 2)), 4), 0x08000024U);
}

// As long as the queue to the port has no room a message waits; with room for one it goes.
TEST(Emcy, AMessageWaitsForRoomAndIsNotLost) {
  canopen::Emergency emergency;
  canopen::Outbox outbox;
  host::HostCanPort port{64}, other{64};
  other.connect(port);
  const CanFrame filler{.id = 0x285};
  while (outbox.room() > 0) outbox.push(filler);
  emergency.set(canopen::ErrorSource::kPassive, 0x8120, 0x12345678);
  for (std::uint32_t now_us = 0; now_us < 10000; now_us += 1000) emergency.step(now_us, 0x085, 0, outbox);
  EXPECT_EQ(outbox.lost(), 0U);
  outbox.clear();
  while (outbox.room() > 1) outbox.push(filler);
  emergency.step(11000, 0x085, 0, outbox);
  EXPECT_EQ(outbox.room(), 0U);
  emergency.step(12000, 0x085, 0, outbox);
  EXPECT_EQ(outbox.lost(), 0U) << "once";
  outbox.flush(port);
  CanFrame frame, last;
  while (other.receive(frame)) last = frame;
  EXPECT_EQ(last.id, 0x085U);
  EXPECT_EQ(last.data, (std::array<std::uint8_t, 8>{0x20, 0x81, 0x11, 5, 0x78, 0x56, 0x34, 0x12}));
}

TEST(Emcy, OverrunIsToldOnceForALossThatGoesOn) {
  Bench bench;
  bench.all();
  for (int i = 0; i < 500; ++i) {
    ++bench.device.bus.frames_lost;
    bench.run_ms(2);
  }
  expect_error(bench, 0x8110, 0);
  bench.run_ms(990);
  EXPECT_TRUE(described(bench).empty());
  bench.run_ms(15);
  expect_none(bench, 0x8110);
}

TEST(Emcy, ErrorPassiveForAsLongAsItLasts) {
  Bench bench;
  bench.all();
  bench.device.bus.state = CanBusState::kWarning;
  bench.run_ms(5);
  EXPECT_TRUE(described(bench).empty()) << "a warning is no error";
  bench.device.bus.state = CanBusState::kPassive;
  bench.run_ms(5);
  expect_error(bench, 0x8120, 0);
  bench.device.bus.state = CanBusState::kWarning;
  bench.run_ms(5);
  expect_none(bench, 0x8120);
}

TEST(Emcy, EachOfSeveralNodesThatAreLost) {
  Bench bench;
  for (std::uint8_t i = 1; i <= 4; ++i) {
    ASSERT_EQ(bench.write(0x1016, i, (std::uint32_t{10} + i) << 16 | 20U * i, 4), 0U);
  }
  ASSERT_EQ(bench.write(0x1029, 1, 1, 1), 0U);
  bench.nmt(0x01);
  for (std::uint32_t node = 11; node <= 14; ++node) bench.send(0x700 + node, {0x05});
  bench.poll();
  bench.all();
  for (std::uint32_t node = 11; node <= 14; ++node) {
    bench.run_ms(21);
    const auto messages = described(bench);
    ASSERT_EQ(messages.size(), 1U) << node;
    EXPECT_EQ(messages[0].code, 0x8130U);
    EXPECT_EQ(messages[0].detail, node);
  }
  EXPECT_EQ(bench.read(0x1003, 0), 4U);
  for (std::uint32_t node = 11; node <= 14; ++node) {
    EXPECT_TRUE(described(bench).empty()) << "one is still lost";
    bench.send(0x700 + node, {0x05});
    bench.run_ms(1);
  }
  expect_none(bench, 0x8130);
}

TEST(Emcy, CollisionWithWhatOnlyThisNodeSends) {
  for (const std::uint32_t id : {0x585U, 0x705U, 0x085U, 0x185U, 0x285U}) {
    Bench bench;
    bench.nmt(0x01);
    bench.run_ms(20);
    bench.all();
    bench.send(id, {0x05});
    bench.run_ms(2);
    expect_error(bench, 0x8150, id);
    bench.run_ms(1010);
    expect_none(bench, 0x8150);
  }
  // Not in use: another's.
  Bench bench;
  bench.nmt(0x01);
  bench.run_ms(20);
  bench.all();
  bench.send(0x385, {0x05});
  bench.send(0x586, {0x05});
  bench.send(0x706, {0x05});
  bench.run_ms(2);
  EXPECT_TRUE(described(bench).empty());
}

TEST(Emcy, PdoTooShortAndTooLong) {
  Bench bench;
  bench.nmt(0x01);
  bench.all();
  bench.send(0x205, {0x06, 0x00});
  bench.run_ms(2);
  expect_error(bench, 0x8210, 0x205);
  EXPECT_EQ(bench.read(0x6060, 0), 0U);
  bench.send(0x205, {0x06, 0x00, 0x08, 0x77});  // the tail is nobody's
  bench.run_ms(2);
  expect_error(bench, 0x8220, 0x205);
  EXPECT_EQ(bench.read(0x6060, 0), 8U) << "taken all the same";
  bench.send(0x205, {0x06, 0x00, 0x01});
  bench.run_ms(2);
  expect_none(bench, 0x8220);
  EXPECT_EQ(bench.read(0x6060, 0), 1U);
}

TEST(Emcy, SyncOfAnotherLength) {
  Bench bench;
  bench.nmt(0x01);
  bench.run_ms(20);
  bench.all();
  bench.send(0x080, {1});
  bench.run_ms(2);
  const std::size_t taken = bench.all().size();
  EXPECT_EQ(taken, 3U) << "TPDO 2 and 4: it is a SYNC all the same; and one EMCY";
  bench.send(0x080, {});
  bench.run_ms(2);
  expect_none(bench, 0x8240);
  bench.send(0x080, {1, 2});
  bench.run_ms(2);
  EXPECT_EQ(bench.read(0x1003, 1) & 0xFFFF, 0x8240U);
  // With a counter that is expected.
  ASSERT_EQ(bench.write(0x1019, 0, 10, 1), 0U);
  bench.run_ms(2);
  bench.all();
  bench.send(0x080, {1});
  bench.run_ms(2);
  expect_none(bench, 0x8240);
  bench.send(0x080, {});
  bench.run_ms(2);
  expect_error(bench, 0x8240, 0);
}

TEST(Emcy, AnRpdoThatFailsToCome) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1400, 5, 50, 2), 0U);
  bench.nmt(0x01);
  bench.all();
  bench.run_ms(200);
  EXPECT_TRUE(described(bench).empty()) << "not watched before it came once";
  for (int i = 0; i < 10; ++i) {
    bench.send(0x205, {0x06, 0x00, 0x08});
    bench.run_ms(49);
  }
  EXPECT_TRUE(described(bench).empty());
  bench.run_ms(4);
  expect_error(bench, 0x8250, 1);
  bench.send(0x205, {0x06, 0x00, 0x08});
  bench.run_ms(2);
  expect_none(bench, 0x8250);
  bench.nmt(0x80);
  bench.run_ms(200);
  EXPECT_TRUE(described(bench).empty()) << "there are no PDOs in this state";
  bench.nmt(0x01);
  bench.run_ms(200);
  EXPECT_TRUE(described(bench).empty());
  EXPECT_EQ(bench.write(0x1400, 3, 5, 2), 0x06090011U) << "an RPDO has no inhibit time";
}

TEST(Emcy, OneErrorGoneAndAnotherLeft) {
  Bench bench;
  bench.nmt(0x01);
  bench.all();
  bench.send(0x205, {0x06});
  bench.device.bus.state = CanBusState::kPassive;
  bench.run_ms(2);
  EXPECT_EQ(described(bench).size(), 2U);
  bench.device.bus.state = CanBusState::kActive;
  bench.run_ms(2);
  const auto left = described(bench);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].code, 0x8210U) << "the one that is still there";
  EXPECT_EQ(left[0].bits, 0x11);
}

TEST(Emcy, AResetOfCommunicationBeginsAnew) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1015, 0, 10000, 2), 0U);  // 1 s: some are waiting
  bench.nmt(0x01);
  for (int i = 0; i < 5; ++i) {
    bench.send(0x205, {0x06});
    bench.send(0x205, {0x06, 0, 0});
  }
  bench.run_ms(5);
  EXPECT_NE(bench.read(0x1001, 0) | bench.read(0x1003, 0), 0U);
  bench.nmt(0x82);
  bench.all();
  bench.run_ms(3000);
  EXPECT_TRUE(described(bench).empty());
  EXPECT_EQ(bench.read(0x1001, 0), 0U);
  EXPECT_EQ(bench.read(0x1003, 0), 5U) << "the history is cleared by writing 0 to it";
}

}  // namespace
}  // namespace slipstack::can
