// SPDX-License-Identifier: Apache-2.0
// Every object of the axis reaches a parameter of its own, and none is left out.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdio>
#include <map>
#include <new>
#include <set>
#include <string>

#include "firmware/canopen/model/staged_model.h"
#include "tests/can/bench.h"

namespace slipstack::can {
namespace {
using namespace slipstack::canopen;  // NOLINT(google-build-using-namespace)

using Bytes = std::array<std::byte, sizeof(AxisParameters)>;

// Not inlined: what is in the bytes before is none of the compiler's business.
[[gnu::noinline]] void put(const Dictionary& dictionary, std::byte* place) {
  static_cast<void>(new (place) AxisParameters(staged_axis(dictionary)));
}

// The parameters that the dictionary holds, byte by byte; what lies between them is zero.
Bytes staged(const Dictionary& dictionary) {
  alignas(AxisParameters) Bytes place;
  place.fill(std::byte{0});
  put(dictionary, place.data());
  return place;
}

std::string sub_index_of(const Object& object) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04X:%02X", object.index, object.sub);
  return text.data();
}

TEST(StagedAxis, EveryObjectIsAParameterOfItsOwn) {
  Bench bench;
  Dictionary& dictionary = bench.node->dictionary();
  // What of these records is no parameter of the axis: 2012h:05 and 2503h:04 to 08 are readings, 2503h:01 to
  // 03 the board's, 2501h:05 the hash of the scales that have passed, 2504h:05 and 09 readings, 2404h:02 too.
  const std::set<std::uint16_t> records{0x2000, 0x2010, 0x2012, 0x2404, 0x2501,
                                        0x2502, 0x2503, 0x2504, 0x6075};
  const std::set<std::string> others{"2501:05", "2503:01", "2503:02", "2503:03"};
  std::map<std::set<std::size_t>, std::string> seen;
  int parameters = 0;
  for (std::size_t row = 0; row < kObjects.size(); ++row) {
    const Object& object = kObjects[row];
    if (!records.contains(object.index) || object.access != Access::kReadWrite) continue;
    const std::uint32_t before = dictionary.value(row);
    const Bytes was = staged(dictionary);
    // Every bit of it other than it was, so that an upper half or a sign counts too.
    std::uint32_t other = ~before;
    if (object.type == Type::kReal32)
      other = std::bit_cast<std::uint32_t>(std::bit_cast<float>(before) + 1.25F);
    if (object.type == Type::kBoolean) other = before == 0 ? 1 : 0;
    dictionary.set(row, other);
    const Bytes now = staged(dictionary);
    dictionary.set(row, before);
    std::set<std::size_t> changed;
    for (std::size_t i = 0; i < was.size(); ++i) {
      if (was[i] != now[i]) changed.insert(i);
    }
    const std::string name = sub_index_of(object);
    if (others.contains(name)) continue;
    EXPECT_FALSE(changed.empty()) << name << " reaches nothing";
    ++parameters;
    for (const auto& [bytes, earlier] : seen) {
      for (const std::size_t byte : changed) {
        EXPECT_FALSE(bytes.contains(byte)) << name << " and " << earlier << " are the same parameter";
      }
    }
    seen[changed] = name;
  }
  EXPECT_GT(parameters, 60);
}

// What the bus has in another unit than the axis: 6075h in mA.
TEST(StagedAxis, OtherUnitsAreThoseOfTheBus) {
  Bench bench;
  for (const std::uint32_t rated_mA : {1000U, 4321U, 20000U}) {
    ASSERT_EQ(bench.write(0x6075, 0, rated_mA, 4), 0U);
    EXPECT_FLOAT_EQ(staged_axis(bench.node->dictionary()).motor_rated_A,
                    1e-3F * static_cast<float>(rated_mA));
  }
}

}  // namespace
}  // namespace slipstack::can
