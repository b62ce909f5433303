// SPDX-License-Identifier: Apache-2.0
// PDOs: transmission types, SYNC, inhibit and event time, mapping at run time (CiA 301, 7.2.2, 7.5.2.35 to
// 38).
#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

// The procedure of the standard: PDO off, no mapping, entries, count, PDO on.
void map(Bench& bench, std::uint16_t comm, std::uint32_t cob, const std::vector<std::uint32_t>& entries) {
  if (comm >= 0x1800) cob |= 0x40000000U;  // no remote requests
  const auto mapping = static_cast<std::uint16_t>(comm + 0x200);
  ASSERT_EQ(bench.write(comm, 1, cob | 0x80000000U, 4), 0U);
  ASSERT_EQ(bench.write(mapping, 0, 0, 1), 0U);
  std::uint8_t sub = 0;
  for (const std::uint32_t entry : entries) ASSERT_EQ(bench.write(mapping, ++sub, entry, 4), 0U);
  ASSERT_EQ(bench.write(mapping, 0, sub, 1), 0U);
  ASSERT_EQ(bench.write(comm, 1, cob, 4), 0U);
}

// Masters that watch the statusword by time find it in time.
TEST(Pdo, TheStatuswordComesEvery100msWithoutAnyChange) {
  Bench bench;
  bench.nmt(0x01);
  bench.run_ms(5);
  bench.all();
  bench.run_ms(1000);
  EXPECT_EQ(bench.all_with(0x185).size(), 10U);
}

TEST(Pdo, DefaultsOnTheWire) {
  Bench bench;
  bench.all();
  bench.nmt(0x01);
  // TPDO 1 once on entering operational: statusword (not ready, remote), no mode, no error.
  EXPECT_EQ(bench.all_with(0x185), (std::vector<Data>{{0x00, 0x02, 0x00, 0x00, 0x00}}));
  bench.send(0x080, {});
  bench.poll();
  const auto second = bench.all_with(0x285);
  ASSERT_EQ(second.size(), 1U);
  ASSERT_EQ(second[0].size(), 8U);
  EXPECT_EQ(static_cast<std::int32_t>(Bench::number(second[0], 2)), bench.read_signed(0x6064, 0));
}

TEST(Pdo, NothingOutsideOperational) {
  Bench bench;
  bench.all();
  bench.send(0x080, {});
  bench.send(0x205, {0x06, 0x00, 0x08});
  bench.run_ms(20);
  EXPECT_TRUE(bench.all().empty());
  EXPECT_EQ(bench.read(0x6060, 0), 0U);
}

TEST(Pdo, ReceiveEventDrivenAtOnceSynchronousAtSync) {
  Bench bench;
  bench.nmt(0x01);
  bench.send(0x205, {0x06, 0x00, 0x08});
  bench.poll();
  EXPECT_EQ(bench.read(0x6040, 0), 6U);
  EXPECT_EQ(bench.read(0x6060, 0), 8U);
  bench.send(0x305, {0x06, 0x00, 0x10, 0x27, 0, 0});
  bench.poll();
  EXPECT_EQ(bench.read(0x607A, 0), 0U) << "held until SYNC";
  bench.send(0x080, {});
  bench.poll();
  EXPECT_EQ(bench.read(0x607A, 0), 10000U);
}

// 0 to 240: at SYNC; 254 and 255: at once; between them is nothing (CiA 301, 7.5.2.35).
TEST(Pdo, TransmissionTypesOfTheStandard) {
  for (std::uint32_t type = 0; type <= 255; ++type) {
    if (type > 5 && type < 235) continue;
    Bench bench;
    const bool exists = type <= 240 || type >= 254;
    ASSERT_EQ(bench.write(0x1401, 2, type, 1), exists ? 0U : 0x06090030U) << type;
    ASSERT_EQ(bench.write(0x1801, 2, type, 1), exists ? 0U : 0x06090030U) << type;
    if (!exists) continue;
    bench.nmt(0x01);
    bench.run_ms(2);
    bench.send(0x305, {0x06, 0x00, 0x10, 0x27, 0, 0});
    bench.poll();
    EXPECT_EQ(bench.read(0x607A, 0), type <= 240 ? 0U : 10000U) << type;
    bench.all();
    int syncs = 0;
    for (; syncs < 300 && bench.all_with(0x285).empty(); ++syncs) {
      bench.send(0x080, {});
      bench.poll();
    }
    EXPECT_EQ(bench.read(0x607A, 0), 10000U) << type;
    if (type > 0 && type <= 240) {
      EXPECT_EQ(syncs, static_cast<int>(type));
    }
  }
}

// Type 0: with SYNC, but only what has changed since it was sent last (CiA 301, 7.5.2.37).
TEST(Pdo, AcyclicAtSyncOnlyWhatHasChanged) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1801, 2, 0, 1), 0U);
  bench.nmt(0x01);
  const auto syncs = [&](int number) {
    bench.all();
    for (int i = 0; i < number; ++i) bench.send(0x080, {});
    bench.poll();
    return bench.all_with(0x285).size();
  };
  EXPECT_LE(syncs(3), 1U);
  for (int change = 0; change < 5; ++change) {
    EXPECT_EQ(syncs(4), 0U) << "nothing has changed";
    // The position, by the axis.
    bench.loop->plant.reset(0.1 + 1e-3 * (change + 1));
    bench.run_ms(2);
    EXPECT_EQ(syncs(1), 1U) << change;
  }
}

// CiA 301, table 40: what is restricted is no CAN-ID of a PDO.
TEST(Pdo, IdentifiersThatTheStandardKeeps) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1402, 1, 0x80000000U, 4), 0U);
  for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
    const bool restricted = id <= 0x07F || (id >= 0x101 && id <= 0x180) || (id >= 0x581 && id <= 0x5FF) ||
                            (id >= 0x601 && id <= 0x67F) || id >= 0x6E0;
    // 700h itself belongs to nobody.
    if (id == 0x700) continue;
    ASSERT_EQ(bench.write(0x1402, 1, id, 4), restricted ? 0x06090030U : 0U) << std::hex << id;
    ASSERT_EQ(bench.write(0x1402, 1, 0x80000000U | id, 4), 0U) << std::hex << id;
  }
}

// What lies behind the length of a frame is none of it: a controller leaves there what was before.
TEST(Pdo, ACounterThatIsNotThereIsNotRead) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1801, 1, 0xC0000285, 4), 0U);
  ASSERT_EQ(bench.write(0x1801, 2, 1, 1), 0U);
  ASSERT_EQ(bench.write(0x1801, 6, 2, 1), 0U);  // begins at the SYNC with counter 2
  ASSERT_EQ(bench.write(0x1801, 1, 0x40000285, 4), 0U);
  const auto sent = [&](std::uint8_t length, std::uint8_t behind) {
    bench.nmt(0x80);
    bench.nmt(0x01);
    bench.all();
    CanFrame sync;
    sync.id = 0x080;
    sync.length = length;
    sync.data[0] = behind;
    EXPECT_TRUE(bench.master.send(sync));
    bench.poll();
    return !bench.all_with(0x285).empty();
  };
  const bool without = sent(0, 0);
  EXPECT_EQ(sent(0, 2), without);
  EXPECT_EQ(sent(0, 7), without);
  ASSERT_EQ(bench.write(0x1019, 0, 6, 1), 0U);
  EXPECT_TRUE(sent(1, 2));
  EXPECT_FALSE(sent(1, 3));
}

TEST(Pdo, TooShortIsNotTakenAndTold) {
  Bench bench;
  bench.nmt(0x01);
  bench.all();
  bench.send(0x205, {0x06, 0x00});
  bench.run_ms(2);
  const auto emergency = bench.all_with(0x085);
  ASSERT_EQ(emergency.size(), 1U);
  EXPECT_EQ(Bench::number(emergency[0], 0, 2), 0x8210U);
  EXPECT_EQ(bench.read(0x6040, 0), 0U);
  // A value that the object refuses is counted; its neighbours are taken.
  bench.send(0x205, {0x06, 0x00, 0x55});
  bench.run_ms(1);
  EXPECT_EQ(bench.read(0x6040, 0), 6U);
  EXPECT_EQ(bench.read(0x6060, 0), 0U);
  EXPECT_EQ(bench.read(0x2211, 7), 1U);
}

TEST(Pdo, MappingAtRunTime) {
  Bench bench;
  const std::uint32_t counts = 0x60640020, residual = 0x22000320, ticks = 0x22100510;
  EXPECT_EQ(bench.write(0x1A00, 1, counts, 4), 0x06010000U) << "while the PDO is in use";
  EXPECT_EQ(bench.write(0x1800, 3, 5, 2), 0x06010000U);
  ASSERT_EQ(bench.write(0x1800, 1, 0xC0000185, 4), 0U);
  EXPECT_EQ(bench.write(0x1A00, 1, counts, 4), 0x06010000U) << "while objects are mapped";
  ASSERT_EQ(bench.write(0x1A00, 0, 0, 1), 0U);
  EXPECT_EQ(bench.write(0x1A00, 1, 0x60640010, 4), 0x06040041U);  // wrong length
  EXPECT_EQ(bench.write(0x1A00, 1, 0x20000120, 4), 0x06040041U);  // not mappable
  EXPECT_EQ(bench.write(0x1A00, 1, 0x5FFF0020, 4), 0x06020000U);
  EXPECT_EQ(bench.write(0x1A00, 1, 0x2200FF20, 4), 0x06090011U);
  EXPECT_EQ(bench.write(0x1A00, 0, 9, 1), 0x06090031U);
  ASSERT_EQ(bench.write(0x1A00, 1, counts, 4), 0U);
  ASSERT_EQ(bench.write(0x1A00, 2, residual, 4), 0U);
  ASSERT_EQ(bench.write(0x1A00, 3, ticks, 4), 0U);
  EXPECT_EQ(bench.write(0x1A00, 0, 3, 1), 0x06040042U);  // 80 bits
  ASSERT_EQ(bench.write(0x1A00, 0, 2, 1), 0U);
  EXPECT_EQ(bench.write(0x1800, 1, 0x40000581, 4), 0x06090030U);  // an SDO's identifier
  EXPECT_EQ(bench.write(0x1800, 1, 0x60000185, 4), 0x06090030U);  // 29 bits
  EXPECT_EQ(bench.write(0x1800, 2, 252, 1), 0x06090030U);         // remote requests
  ASSERT_EQ(bench.write(0x1800, 2, 1, 1), 0U);
  ASSERT_EQ(bench.write(0x1800, 1, 0x40000199, 4), 0U);
  bench.nmt(0x01);
  bench.run_ms(3);
  bench.all();
  bench.send(0x080, {});
  bench.poll();
  const auto sent = bench.all_with(0x199);
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(Bench::number(sent[0], 0), bench.read(0x6064, 0));
  EXPECT_EQ(Bench::number(sent[0], 4), bench.read(0x2200, 3));
}

TEST(Pdo, EveryNthSyncAndStartValue) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1801, 1, 0xC0000285, 4), 0U);
  ASSERT_EQ(bench.write(0x1801, 2, 3, 1), 0U);
  ASSERT_EQ(bench.write(0x1019, 0, 6, 1), 0U);
  ASSERT_EQ(bench.write(0x1801, 6, 2, 1), 0U);  // begins at the SYNC with counter 2
  ASSERT_EQ(bench.write(0x1801, 1, 0x40000285, 4), 0U);
  bench.nmt(0x01);
  bench.all();
  std::vector<int> when;
  for (int i = 0; i < 12; ++i) {
    bench.send(0x080, {static_cast<std::uint8_t>(i % 6 + 1)});
    bench.poll();
    if (!bench.all_with(0x285).empty()) when.push_back(i + 1);
  }
  EXPECT_EQ(when, (std::vector<int>{2, 5, 8, 11}));
}

// Identifier, type and SYNC start value make another PDO of it, which is sent once; its times do not.
TEST(Pdo, WhatMakesItAnotherPdoSendsItAnew) {
  Bench bench;
  map(bench, 0x1800, 0x185, {0x60610008});  // nothing that changes
  ASSERT_EQ(bench.write(0x1800, 5, 0, 2), 0U);
  bench.nmt(0x01);
  bench.run_ms(5);
  const auto sent_after = [&](std::uint8_t sub, std::uint32_t value, std::size_t bytes) {
    bench.all();
    Data request = Bench::address(bytes == 4 ? 0x23 : bytes == 2 ? 0x2B : 0x2F, 0x1800, sub);
    for (std::size_t i = 0; i < bytes; ++i) request[4 + i] = static_cast<std::uint8_t>(value >> (8 * i));
    bench.send(0x605, request);
    bench.run_ms(5);
    std::size_t sent = 0;
    for (const Message& message : bench.all()) {
      if (message.id == 0x185) ++sent;
      if (message.id == 0x585) {
        EXPECT_EQ(message.data.at(0), 0x60) << int{sub};
      }
    }
    return sent;
  };
  EXPECT_EQ(sent_after(5, 1000, 2), 0U) << "event time";
  EXPECT_EQ(sent_after(2, 255, 1), 1U) << "type";
  EXPECT_EQ(sent_after(2, 254, 1), 1U) << "and back";
  EXPECT_EQ(sent_after(1, 0x40000185, 4), 1U) << "identifier";
  EXPECT_EQ(sent_after(1, 0xC0000185, 4), 0U) << "off";
  EXPECT_EQ(sent_after(3, 10, 2), 0U) << "inhibit time";
  EXPECT_EQ(sent_after(1, 0x40000185, 4), 1U) << "on";
}

TEST(Pdo, InhibitAndEventTime) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1800, 1, 0xC0000185, 4), 0U);
  ASSERT_EQ(bench.write(0x1800, 3, 500, 2), 0U);  // 50 ms
  ASSERT_EQ(bench.write(0x1800, 5, 200, 2), 0U);  // 200 ms
  ASSERT_EQ(bench.write(0x1A00, 0, 0, 1), 0U);
  ASSERT_EQ(bench.write(0x1A00, 1, 0x22100510, 4), 0U);  // changes with every tick
  ASSERT_EQ(bench.write(0x1A00, 0, 1, 1), 0U);
  ASSERT_EQ(bench.write(0x1800, 1, 0x40000185, 4), 0U);
  bench.nmt(0x01);
  bench.all();
  bench.run_ms(1000);
  EXPECT_EQ(bench.all_with(0x185).size(), 20U) << "no faster than the inhibit time";
  // An object that does not change: the event timer.
  map(bench, 0x1800, 0x185, {0x60610008});
  bench.all();
  bench.run_ms(1000);
  const std::size_t sent = bench.all_with(0x185).size();
  EXPECT_GE(sent, 5U);
  EXPECT_LE(sent, 6U);
}

TEST(Pdo, DummyEntriesSkipBytes) {
  Bench bench;
  map(bench, 0x1403, 0x505, {0x00060010, 0x00050008, 0x60400010});
  bench.nmt(0x01);
  bench.send(0x505, {0xAA, 0xBB, 0xCC, 0x06, 0x00});
  bench.poll();
  EXPECT_EQ(bench.read(0x6040, 0), 6U);
}

// 0001h to 0007h are the basic types; what is beside them is no object.
TEST(Pdo, DummyEntriesAreThoseOfTheBasicTypes) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1403, 1, 0x80000505, 4), 0U);
  ASSERT_EQ(bench.write(0x1603, 0, 0, 1), 0U);
  for (const std::uint32_t type : {1U, 2U, 3U, 4U, 5U, 6U, 7U}) {
    const std::uint32_t bits = type == 4 || type == 7 ? 32U : (type == 3 || type == 6 ? 16U : 8U);
    EXPECT_EQ(bench.write(0x1603, 1, (type << 16) | bits, 4), 0U) << type;
  }
  for (const std::uint32_t type : {0U, 8U})
    EXPECT_NE(bench.write(0x1603, 1, (type << 16) | 32U, 4), 0U) << type;
}

// CiA 301 leaves remote requests to the device, and CiA's application note 802 advises against them: bit 30
// of the COB-IDs says that this one has none, transmission types 252 and 253 are refused, and so is node
// guarding.
TEST(Remote, RequestsAreSaidToBeUnsupportedAndAreIgnored) {
  Bench bench;
  for (std::uint16_t pdo = 0x1800; pdo < 0x1804; ++pdo) {
    const std::uint32_t cob = bench.read(pdo, 1);
    EXPECT_NE(cob & 0x40000000U, 0U);
    EXPECT_EQ(bench.write(pdo, 1, cob & ~0x40000000U, 4), 0x06090030U);
    EXPECT_EQ(bench.read(pdo, 1), cob);
    for (const std::uint32_t type : {252U, 253U}) EXPECT_EQ(bench.write(pdo, 2, type, 1), 0x06090030U);
  }
  for (const std::uint16_t guarding : {std::uint16_t{0x100C}, std::uint16_t{0x100D}}) {
    EXPECT_EQ(bench.write(guarding, 0, 10, 1), 0x06020000U);
  }
  ASSERT_EQ(bench.write(0x1017, 0, 0, 2), 0U);
  ASSERT_EQ(bench.write(0x1800, 5, 0, 2), 0U);  // on change only
  bench.nmt(0x01);
  bench.run_ms(20);
  const std::uint32_t malformed = bench.read(0x2211, 3);
  bench.all();
  for (std::uint32_t id = 0; id <= 0x7FF; ++id) bench.request(id, static_cast<std::uint8_t>(id % 9));
  for (int i = 0; i < 200; ++i) bench.run_ms(1);
  EXPECT_EQ(bench.all(), std::vector<Message>{}) << "no PDO, no heartbeat, no SDO, no SYNC";
  EXPECT_EQ(bench.node->state(), canopen::NmtState::kOperational);
  EXPECT_EQ(bench.read(0x2211, 3), malformed);
}

// The identifier of a PDO that is on stays; the same one may be written again, and another one once it is
// off.
TEST(Pdo, TheIdentifierChangesOnlyWhileItIsOff) {
  for (const std::uint16_t pdo : {std::uint16_t{0x1400}, std::uint16_t{0x1802}}) {
    Bench bench;
    const std::uint32_t is = bench.read(pdo, 1) & 0x7FFFFFFFU;
    ASSERT_EQ(bench.write(pdo, 1, is, 4), 0U);
    EXPECT_EQ(bench.write(pdo, 1, is + 0x11, 4), 0x06090030U) << std::hex << pdo;
    EXPECT_EQ(bench.write(pdo, 1, is, 4), 0U);
    EXPECT_EQ(bench.write(pdo, 1, is | 0x80000000U, 4), 0U);
    EXPECT_EQ(bench.write(pdo, 1, is + 0x11, 4), 0U);
    EXPECT_EQ(bench.read(pdo, 1) & 0x7FFFFFFFU, is + 0x11);
  }
}

// Every third SYNC from the one whose counter is the start value (CiA 301, 7.5.2.38, sub-index 06h).
TEST(Pdo, SyncsCountFromTheStartValue) {
  for (const std::uint32_t start : {0U, 5U}) {
    Bench bench;
    ASSERT_EQ(bench.write(0x1019, 0, 240, 1), 0U);
    ASSERT_EQ(bench.write(0x1801, 1, 0xC0000285U, 4), 0U);
    ASSERT_EQ(bench.write(0x1801, 2, 3, 1), 0U);
    ASSERT_EQ(bench.write(0x1801, 6, start, 1), 0U);
    ASSERT_EQ(bench.write(0x1801, 1, 0x40000285U, 4), 0U);
    bench.nmt(0x01);
    bench.run_ms(5);
    bench.all();
    std::vector<int> sent;
    for (int counter = 1; counter <= 20; ++counter) {
      bench.send(0x080, {static_cast<std::uint8_t>(counter)});
      bench.run_ms(2);
      if (!bench.all_with(0x285).empty()) sent.push_back(counter);
    }
    EXPECT_EQ(sent, start == 0 ? (std::vector<int>{3, 6, 9, 12, 15, 18})
                               : (std::vector<int>{5, 8, 11, 14, 17, 20}));
  }
}

}  // namespace
}  // namespace slipstack::can
