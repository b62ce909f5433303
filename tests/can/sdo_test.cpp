// SPDX-License-Identifier: Apache-2.0
// Expedited and segmented transfer (CiA 301, 7.2.4.3.3 to 7.2.4.3.7), abort codes (table 22), time-outs.
#include <cmath>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

TEST(SdoExpedited, FramesOfTheStandard) {
  Bench bench;
  EXPECT_EQ(bench.sdo({0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0}),
            (Data{0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00}));
  EXPECT_EQ(bench.sdo({0x40, 0x01, 0x10, 0x00, 0, 0, 0, 0}), (Data{0x4F, 0x01, 0x10, 0x00, 0x00, 0, 0, 0}));
  EXPECT_EQ(bench.sdo({0x2B, 0x17, 0x10, 0x00, 0xE8, 0x03, 0, 0}),
            (Data{0x60, 0x17, 0x10, 0x00, 0, 0, 0, 0}));
  EXPECT_EQ(bench.sdo({0x40, 0x17, 0x10, 0x00, 0, 0, 0, 0}),
            (Data{0x4B, 0x17, 0x10, 0x00, 0xE8, 0x03, 0, 0}));
  // Size not indicated: the object's own.
  EXPECT_EQ(bench.sdo({0x22, 0x17, 0x10, 0x00, 0x64, 0, 0, 0}), (Data{0x60, 0x17, 0x10, 0x00, 0, 0, 0, 0}));
  EXPECT_EQ(bench.read(0x1017, 0), 100U);
  EXPECT_EQ(bench.read(0x1200, 1), 0x605U);
  EXPECT_EQ(bench.read(0x1018, 4), 0x12345678U);
}

TEST(SdoExpedited, AbortCodes) {
  Bench bench;
  const auto aborted = [&](const Data& request) {
    const Data answer = bench.sdo(request);
    EXPECT_EQ(answer.at(0), 0x80);
    EXPECT_TRUE(std::equal(answer.begin() + 1, answer.begin() + 4, request.begin() + 1));
    return Bench::number(answer, 4);
  };
  EXPECT_EQ(aborted(Bench::address(0x40, 0x3FFF, 0)), 0x06020000U);  // no object
  EXPECT_EQ(aborted(Bench::address(0x40, 0x1018, 9)), 0x06090011U);  // no sub-index
  EXPECT_EQ(aborted(Bench::address(0x40, 0x2400, 6)), 0x06010001U);  // write-only
  EXPECT_EQ(aborted(Bench::address(0x23, 0x1000, 0)), 0x06010002U);  // read-only
  EXPECT_EQ(aborted(Bench::address(0x23, 0x1017, 0)), 0x06070012U);  // too long
  EXPECT_EQ(aborted(Bench::address(0x2F, 0x1017, 0)), 0x06070013U);  // too short
  EXPECT_EQ(bench.write(0x1029, 1, 3, 1), 0x06090031U);              // too high
  EXPECT_EQ(bench.write_real(0x2000, 1, 0.0F), 0x06090032U);         // too low
  EXPECT_EQ(bench.write_real(0x2000, 1, std::nanf("")), 0x06090032U);
  EXPECT_EQ(aborted({0xE0, 0, 0x10, 0, 0, 0, 0, 0}), 0x05040001U);  // no such command
  EXPECT_EQ(aborted({0x60, 0, 0x10, 0, 0, 0, 0, 0}), 0x05040001U);  // a segment of nothing
  EXPECT_EQ(bench.read(0x2211, 4), 11U);
  // An abort of the master, and a frame of the wrong length, are not answered.
  EXPECT_TRUE(bench.sdo({0x80, 0, 0x10, 0, 0, 0, 0, 0}).empty());
  EXPECT_TRUE(bench.sdo({0x40, 0, 0x10, 0}).empty());
}

TEST(SdoSegmented, ReadsAName) {
  Bench bench;
  const Data begin = bench.sdo(Bench::address(0x40, 0x1008, 0));
  ASSERT_EQ(begin.at(0), 0x41);
  const std::uint32_t size = Bench::number(begin, 4);
  std::string name;
  std::uint8_t toggle = 0;
  for (;;) {
    const Data segment = bench.sdo({static_cast<std::uint8_t>(0x60 | toggle), 0, 0, 0, 0, 0, 0, 0});
    ASSERT_EQ(segment.at(0) & 0xF0, toggle);
    name.append(segment.begin() + 1, segment.end() - ((segment[0] >> 1) & 7));
    toggle ^= 0x10;
    if ((segment[0] & 1) != 0) break;
  }
  EXPECT_EQ(name.size(), size);
  EXPECT_EQ(name, "slipstack drive");
}

TEST(SdoSegmented, WritesAValueAndChecksTheToggle) {
  Bench bench;
  ASSERT_EQ(bench.sdo({0x21, 0x17, 0x10, 0, 2, 0, 0, 0}), Bench::address(0x60, 0x1017, 0));
  EXPECT_EQ(bench.sdo({0x0B, 0x2C, 0x01, 0, 0, 0, 0, 0}), (Data{0x20, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(bench.read(0x1017, 0), 300U);
  // Toggle wrong: nothing is taken.
  bench.sdo({0x21, 0x17, 0x10, 0, 2, 0, 0, 0});
  EXPECT_EQ(bench.sdo({0x1B, 0x00, 0x02, 0, 0, 0, 0, 0}), (Data{0x80, 0x17, 0x10, 0, 0, 0, 0x03, 0x05}));
  EXPECT_EQ(bench.read(0x1017, 0), 300U);
  // More, or less, than was announced.
  bench.sdo({0x21, 0x17, 0x10, 0, 2, 0, 0, 0});
  EXPECT_EQ(bench.sdo({0x01, 1, 2, 3, 4, 5, 6, 7}).at(0), 0x80);
  bench.sdo({0x21, 0x17, 0x10, 0, 2, 0, 0, 0});
  EXPECT_EQ(bench.sdo({0x0D, 1, 0, 0, 0, 0, 0, 0}).at(0), 0x80);
  EXPECT_EQ(bench.read(0x1017, 0), 300U);
}

TEST(SdoSegmented, AMasterThatDiesIsTimedOut) {
  Bench bench;
  bench.sdo(Bench::address(0x40, 0x1008, 0));
  bench.run_ms(990);
  EXPECT_TRUE(bench.all_with(0x585).empty());
  bench.run_ms(20);
  EXPECT_EQ(bench.all_with(0x585), (std::vector<Data>{{0x80, 0x08, 0x10, 0, 0, 0, 0x04, 0x05}}));
  EXPECT_EQ(bench.read(0x1000, 0), 0x00020192U);
}

}  // namespace
}  // namespace slipstack::can
