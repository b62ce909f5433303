// SPDX-License-Identifier: Apache-2.0
// Every object of the table, one by one, mapped into a TPDO and into an RPDO: what travels is the value, and
// what may not be mapped is refused with the right code (CiA 301, 7.4.7.1 table 22).
#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

using canopen::kObjects;
using canopen::Mapping;
using canopen::Object;

constexpr std::uint32_t kNotMappable = 0x06040041;

std::string name_of(const Object& object) {
  char text[16];
  std::snprintf(text, sizeof text, "%04Xh:%02X", object.index, object.sub);
  return text;
}

std::uint32_t bits_of(const Object& object) {
  return static_cast<std::uint32_t>(8 * canopen::size_of(object.type));
}
std::uint32_t entry_of(const Object& object, std::uint32_t bits) {
  return static_cast<std::uint32_t>(object.index) << 16 | static_cast<std::uint32_t>(object.sub) << 8 | bits;
}

bool may(const Object& object, Mapping way) {
  return object.mapping == way || object.mapping == Mapping::kBoth;
}

/// A PDO with this one object; the abort code of the entry.
std::uint32_t map_one(Bench& bench, std::uint16_t comm, std::uint32_t cob, std::uint32_t entry,
                      std::uint8_t type) {
  const auto mapping = static_cast<std::uint16_t>(comm + 0x200);
  EXPECT_EQ(bench.write(comm, 1, cob | 0x80000000U, 4), 0U);
  EXPECT_EQ(bench.write(comm, 2, type, 1), 0U);
  EXPECT_EQ(bench.write(mapping, 0, 0, 1), 0U);
  const std::uint32_t code = bench.write(mapping, 1, entry, 4);
  if (code != 0) return code;
  EXPECT_EQ(bench.write(mapping, 0, 1, 1), 0U);
  EXPECT_EQ(bench.write(comm, 1, cob, 4), 0U);
  return 0;
}

TEST(Mapping, EveryObjectIntoATpdo) {
  // Readings of what is not wired are refused.
  host::HostAnalogueInputs inputs;
  Bench bench(false);
  bench.analogue = &inputs;
  bench.power_on();
  bench.begin();
  EXPECT_EQ(bench.write_real(0x2504, 1, 100.0F), 0U);
  EXPECT_EQ(bench.write_real(0x2504, 6, 20.0F), 0U);
  bench.configure();
  bench.enable(1);
  bench.nmt(0x01);
  // A move under way, then a poll without a tick between what PDO and SDO say.
  bench.write(0x607A, 0, 150000, 4);
  bench.write(0x6040, 0, 0x1F, 2);
  bench.run_ms(60);
  int sent = 0;
  int not_zero = 0;
  for (const Object& object : kObjects) {
    const std::uint32_t bits = bits_of(object);
    const std::uint32_t code = map_one(bench, 0x1803, 0x40000485, entry_of(object, bits), 1);
    if (!may(object, Mapping::kTransmit)) {
      EXPECT_EQ(code, kNotMappable) << name_of(object);
      continue;
    }
    ASSERT_EQ(code, 0U) << name_of(object);
    bench.run_ms(1);
    bench.all();
    bench.send(0x080, {});
    bench.poll();
    const auto data = bench.all_with(0x485);
    ASSERT_EQ(data.size(), 1U) << name_of(object);
    ASSERT_EQ(data[0].size(), bits / 8) << name_of(object);
    std::uint32_t value = Bench::number(data[0], 0, bits / 8);
    if (object.index == 0x2211 && object.sub == 1) ++value;  // frames received: the request is one more
    EXPECT_EQ(value, bench.read(object.index, object.sub)) << name_of(object);
    ++sent;
    not_zero += value != 0 ? 1 : 0;
    // Another length than the object has.
    for (const std::uint32_t wrong : {bits - 1, bits + 8, 0U, 64U}) {
      EXPECT_EQ(map_one(bench, 0x1803, 0x40000485, entry_of(object, wrong), 1),
                wrong == 0 && bits == 0 ? 0U : kNotMappable)
          << name_of(object) << ' ' << wrong;
    }
  }
  EXPECT_GT(sent, 70) << "the issue: observer outputs, residual, timing, counters, all mappable";
  EXPECT_GT(not_zero, 30) << "a comparison of zeros would show little";
}

// A value within the bounds that the object does not have yet, found from the table.
std::uint32_t other_value(const Object& object, std::uint32_t now) {
  if (object.index == 0x6060) return now == 8 ? 1 : 8;
  if (object.index == 0x6040) return 0x0006;
  return now + 1 <= object.high ? now + 1 : object.low;
}

TEST(Mapping, EveryObjectIntoAnRpdo) {
  Bench bench;
  ASSERT_EQ(bench.write(0x2013, 1, 7, 1), 0U);  // without a terminal 60B8h is refused
  bench.configure();
  bench.nmt(0x01);
  int taken = 0;
  for (const Object& object : kObjects) {
    const std::uint32_t bits = bits_of(object);
    for (const std::uint8_t type : {std::uint8_t{1}, std::uint8_t{255}}) {
      const std::uint32_t code = map_one(bench, 0x1403, 0x505, entry_of(object, bits), type);
      if (!may(object, Mapping::kReceive)) {
        EXPECT_EQ(code, kNotMappable) << name_of(object);
        continue;
      }
      ASSERT_EQ(code, 0U) << name_of(object);
      const std::uint32_t before = bench.read(object.index, object.sub);
      const std::uint32_t wanted = other_value(object, before);
      Data data;
      for (std::uint32_t i = 0; i < bits / 8; ++i)
        data.push_back(static_cast<std::uint8_t>(wanted >> (8 * i)));
      bench.send(0x505, data);
      bench.poll();
      if (type == 1) {
        EXPECT_EQ(bench.read(object.index, object.sub), before) << name_of(object) << " before SYNC";
        bench.send(0x080, {});
        bench.poll();
      }
      EXPECT_EQ(bench.read(object.index, object.sub), wanted) << name_of(object);
      ++taken;
    }
  }
  EXPECT_GE(taken, 2 * 7) << "controlword, mode, targets, profile, offset";
  EXPECT_EQ(bench.read(0x2211, 7), 0U) << "no value was refused";
}

// Eight objects at most, and 64 bits.
TEST(Mapping, FullPdos) {
  Bench bench;
  bench.nmt(0x01);
  ASSERT_EQ(bench.write(0x1803, 1, 0xC0000485, 4), 0U);
  ASSERT_EQ(bench.write(0x1A03, 0, 0, 1), 0U);
  for (std::uint8_t i = 1; i <= 8; ++i) ASSERT_EQ(bench.write(0x1A03, i, 0x10010008, 4), 0U);
  EXPECT_EQ(bench.write(0x1A03, 9, 0x10010008, 4), 0x06090011U);
  ASSERT_EQ(bench.write(0x1A03, 0, 8, 1), 0U);
  ASSERT_EQ(bench.write(0x1A03, 0, 0, 1), 0U);
  ASSERT_EQ(bench.write(0x1A03, 8, 0x60410010, 4), 0U);
  EXPECT_EQ(bench.write(0x1A03, 0, 8, 1), 0x06040042U) << "72 bits";
  EXPECT_EQ(bench.read(0x1A03, 0), 0U);
  ASSERT_EQ(bench.write(0x1A03, 0, 7, 1), 0U);
}

}  // namespace
}  // namespace slipstack::can
