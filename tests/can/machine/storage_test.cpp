// SPDX-License-Identifier: Apache-2.0
// 1010h and 1011h over a power cut.
#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr std::uint32_t kSave = 0x65766173;  // "save"
constexpr std::uint32_t kLoad = 0x64616F6C;  // "load"

void again(Bench& bench) {
  bench.power_on();
  bench.begin();
}

TEST(Store, SignatureAndGroups) {
  Bench bench;
  EXPECT_EQ(bench.read(0x1010, 1), 1U);
  ASSERT_EQ(bench.write(0x1017, 0, 70, 2), 0U);
  ASSERT_EQ(bench.write_real(0x2000, 5, 33.0F), 0U);
  ASSERT_EQ(bench.write(0x6081, 0, 4321, 4), 0U);
  EXPECT_EQ(bench.write(0x1010, 1, kSave + 1, 4), 0x08000020U);
  again(bench);
  EXPECT_EQ(bench.read(0x1017, 0), 1000U) << "nothing was stored";
  ASSERT_EQ(bench.write(0x1017, 0, 70, 2), 0U);
  ASSERT_EQ(bench.write_real(0x2000, 5, 33.0F), 0U);
  ASSERT_EQ(bench.write(0x6081, 0, 4321, 4), 0U);
  ASSERT_EQ(bench.write(0x1010, 2, kSave, 4), 0U);
  again(bench);
  EXPECT_EQ(bench.read(0x1017, 0), 70U);
  EXPECT_EQ(bench.read_real(0x2000, 5), 40.0F) << "another group";
  EXPECT_EQ(bench.read(0x6081, 0), 100000U);
  ASSERT_EQ(bench.write_real(0x2000, 5, 33.0F), 0U);
  ASSERT_EQ(bench.write(0x1010, 4, kSave, 4), 0U);
  again(bench);
  EXPECT_EQ(bench.read(0x1017, 0), 70U);
  EXPECT_EQ(bench.read_real(0x2000, 5), 33.0F);
  ASSERT_EQ(bench.write(0x1011, 2, kLoad, 4), 0U);
  EXPECT_EQ(bench.read(0x1017, 0), 70U) << "until the next reset";
  bench.nmt(0x81);
  EXPECT_EQ(bench.read(0x1017, 0), 1000U);
  EXPECT_EQ(bench.read_real(0x2000, 5), 33.0F);
}

// Firmware of another version has another table: the node stays at its place on the bus, the rest is as
// delivered.
TEST(Store, ARecordOfAnotherTableGivesNodeIdAndBitRateOnly) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1017, 0, 70, 2), 0U);
  bench.send(0x7E5, {0x04, 1, 0, 0, 0, 0, 0, 0});
  bench.send(0x7E5, {0x11, 77, 0, 0, 0, 0, 0, 0});
  bench.send(0x7E5, {0x13, 0, 4, 0, 0, 0, 0, 0});
  bench.send(0x7E5, {0x17, 0, 0, 0, 0, 0, 0, 0});
  bench.poll();
  ASSERT_EQ(bench.write(0x1010, 1, kSave, 4), 0U);
  RecordSlots log(bench.flash);
  ASSERT_EQ(log.mount(), StoreStatus::kOk);
  std::vector<std::byte> record(2048);
  std::size_t size = 0;
  ASSERT_EQ(log.load(record, size), StoreStatus::kOk);
  record.resize(size);
  record[0] ^= std::byte{1};  // the fingerprint
  const auto start = [&](std::size_t bytes) {
    record.resize(bytes);
    RecordSlots fresh(bench.flash);
    fresh.mount();
    EXPECT_EQ(fresh.store(record), StoreStatus::kOk);
    again(bench);
    return bench.node->id();
  };
  EXPECT_EQ(start(size), 77);
  EXPECT_EQ(bench.node->dictionary().value(canopen::kRow<canopen::kNodeIndex, 2>), 4U);
  EXPECT_EQ(bench.node->dictionary().value(canopen::kRow<0x1017>), 1000U);
  EXPECT_EQ(start(size - 8), 77);
  EXPECT_EQ(start(size - 8), 77) << "a table with less";
  EXPECT_EQ(start(12), kNode) << "too short to hold them";
  record.resize(size);
  record[4] ^= std::byte{1};
  EXPECT_EQ(start(size), kNode) << "no record of ours";
}

TEST(Store, PdoMappingAndIdentifiersComeBack) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1800, 1, 0xC0000185, 4), 0U);
  ASSERT_EQ(bench.write(0x1A00, 0, 0, 1), 0U);
  ASSERT_EQ(bench.write(0x1A00, 1, 0x60640020, 4), 0U);
  ASSERT_EQ(bench.write(0x1A00, 0, 1, 1), 0U);
  ASSERT_EQ(bench.write(0x1800, 1, 0x40000185, 4), 0U);
  ASSERT_EQ(bench.write(0x1010, 1, kSave, 4), 0U);
  again(bench);
  bench.nmt(0x01);
  const auto sent = bench.all_with(0x185);
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].size(), 4U);
}

TEST(Store, AModelComesBackAndRuns) {
  Bench bench;
  bench.configure();
  const std::uint32_t hash = bench.read(0x2140, 2);
  ASSERT_EQ(bench.write(0x1010, 1, kSave, 4), 0U);
  again(bench);
  bench.run_ms(2);
  EXPECT_EQ(bench.read(0x2140, 2), hash);
  bench.enable(1);
}

// The whole way from an SDO to flash, cut at every byte: the old set or the new one.
TEST(Store, PowerCutAtEveryByte) {
  Bench bench;
  ASSERT_EQ(bench.write(0x1017, 0, 70, 2), 0U);
  ASSERT_EQ(bench.write_real(0x2000, 5, 33.0F), 0U);
  ASSERT_EQ(bench.write(0x1010, 1, kSave, 4), 0U);
  const host::HostNonvolatile stored = bench.flash;
  bool finished = false;
  for (std::size_t bytes = 0; !finished; bytes += 1) {
    bench.flash = stored;
    again(bench);
    bench.write(0x1017, 0, 80, 2);
    bench.write_real(0x2000, 5, 44.0F);
    bench.flash.bytes_until_power_fails = bytes;
    finished = bench.write(0x1010, 1, kSave, 4) == 0;
    bench.flash.bytes_until_power_fails = static_cast<std::size_t>(-1);
    again(bench);
    const std::uint32_t heartbeat = bench.read(0x1017, 0);
    const float gain = bench.read_real(0x2000, 5);
    ASSERT_TRUE((heartbeat == 70 && gain == 33.0F) || (heartbeat == 80 && gain == 44.0F)) << bytes;
    ASSERT_EQ(heartbeat == 80, finished || heartbeat == 80);
    ASSERT_LT(bytes, 5000U);
  }
}

}  // namespace
}  // namespace slipstack::can
