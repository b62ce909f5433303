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

// A transfer that is under way: operational and pre-operational are nothing to it, stopped ends it.
TEST(SdoSegmented, ATransferEndsWhereTheNodeIsStopped) {
  for (const std::uint8_t through : {std::uint8_t{0x01}, std::uint8_t{0x02}}) {
    Bench bench;
    bench.nmt(0x80);
    ASSERT_EQ(bench.sdo(Bench::address(0x40, 0x1008, 0)).at(0), 0x41);
    bench.nmt(through);
    if (through == 0x02) bench.nmt(0x80);
    const Data segment = bench.sdo({0x60, 0, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(segment.at(0) == 0x80, through == 0x02) << int{through};
  }
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

TEST(SdoBlock, AnEndOrAStartWithoutAnUploadIsRefused) {
  for (const std::uint8_t command : {std::uint8_t{0xA1}, std::uint8_t{0xA3}}) {
    Bench bench;
    const Data answer = bench.sdo({command, 0, 0, 0, 0, 0, 0, 0});
    ASSERT_EQ(answer.size(), 8U) << int{command} << ": no answer";
    EXPECT_EQ(answer[0], 0x80);
    EXPECT_EQ(Bench::number(answer, 4), 0x05040001U);
  }
}

TEST(SdoSegmented, AResetOfTheCommunicationEndsATransfer) {
  Bench bench;
  ASSERT_EQ(bench.sdo(Bench::address(0x40, 0x1008, 0)).at(0), 0x41);
  bench.nmt(0x82);
  bench.run_ms(5);
  bench.all();
  EXPECT_EQ(bench.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}).at(0), 0x80) << "the next segment of what is over";
  bench.run_ms(2000);
  EXPECT_TRUE(bench.all_with(0x585).empty()) << "no time-out of what is over";
}

constexpr auto kImageLow = static_cast<std::uint8_t>(4 * canopen::kModelWords);
constexpr auto kImageHigh = static_cast<std::uint8_t>(4 * canopen::kModelWords >> 8);

// Every state in which a transfer can be left: after the frames of one row.
struct Left {
  const char* where;
  std::uint32_t index;
  std::vector<Data> frames;
};
const std::vector<Left> kLeft = {
    {"segmented download, nothing sent", 0x2000, {{0x21, 0x00, 0x20, 5, 4, 0, 0, 0}}},
    {"segmented download, half", 0x2000, {{0x20, 0x00, 0x20, 5, 0, 0, 0, 0}, {0x0A, 1, 2, 0, 0, 0, 0, 0}}},
    {"segmented upload, announced", 0x1008, {{0x40, 0x08, 0x10, 0, 0, 0, 0, 0}}},
    {"segmented upload, half", 0x1008, {{0x40, 0x08, 0x10, 0, 0, 0, 0, 0}, {0x60, 0, 0, 0, 0, 0, 0, 0}}},
    {"block download, announced", 0x2141, {{0xC6, 0x41, 0x21, 0, kImageLow, kImageHigh, 0, 0}}},
    {"block download, two segments",
     0x2141,
     {{0xC6, 0x41, 0x21, 0, kImageLow, kImageHigh, 0, 0},
      {1, 1, 2, 3, 4, 5, 6, 7},
      {2, 1, 2, 3, 4, 5, 6, 7}}},
    {"block download, not ended", 0x2141, {{0xC0, 0x41, 0x21, 0, 0, 0, 0, 0}, {0x81, 1, 2, 3, 4, 5, 6, 7}}},
    {"block upload, announced", 0x2141, {{0xA4, 0x41, 0x21, 0, 4, 0, 0, 0}}},
    {"block upload, no acknowledgement",
     0x2141,
     {{0xA4, 0x41, 0x21, 0, 4, 0, 0, 0}, {0xA3, 0, 0, 0, 0, 0, 0, 0}}},
    {"block upload, next block",
     0x2141,
     {{0xA4, 0x41, 0x21, 0, 4, 0, 0, 0}, {0xA3, 0, 0, 0, 0, 0, 0, 0}, {0xA2, 4, 6, 0, 0, 0, 0, 0}}}};

void leave(Bench& bench, const Left& left) {
  for (const Data& frame : left.frames) {
    bench.send(0x605, frame);
    bench.run_ms(2);
  }
}

TEST(SdoTimeout, AMasterThatDiesInAnyStateIsToldOnceAndNothingIsTaken) {
  for (const Left& left : kLeft) {
    Bench bench;
    const std::uint32_t staged = bench.read(0x2140, 1);
    const std::uint32_t gain = bench.read(0x2000, 5);
    leave(bench, left);
    bench.run_ms(980);
    bench.all();
    bench.run_ms(40);
    const auto described = bench.all_with(0x585);
    const auto low = static_cast<std::uint8_t>(left.index);
    const auto high = static_cast<std::uint8_t>(left.index >> 8);
    ASSERT_EQ(described.size(), 1U) << left.where;
    EXPECT_EQ(described[0], (Data{0x80, low, high, left.frames[0][3], 0, 0, 0x04, 0x05})) << left.where;
    bench.run_ms(3000);
    EXPECT_TRUE(bench.all_with(0x585).empty()) << left.where;
    EXPECT_EQ(bench.read(0x2140, 1), staged) << left.where;
    EXPECT_EQ(bench.read(0x2000, 5), gain) << left.where;
  }
}

TEST(SdoTimeout, AnotherRequestEndsWhatWasLeft) {
  for (const Left& left : kLeft) {
    Bench bench;
    leave(bench, left);
    // A block download takes any frame but an abort as a segment: the next master aborts first.
    bench.send(0x605, {0x80, 0, 0, 0, 0, 0, 0, 0});
    bench.run_ms(1);
    bench.all();
    EXPECT_EQ(bench.read(0x1000, 0), 0x00020192U) << left.where;
    bench.run_ms(2000);
    EXPECT_TRUE(bench.all_with(0x585).empty()) << left.where << ": no time-out of what is over";
  }
}

TEST(SdoSegmented, ChecksTheToggleOfAnUpload) {
  Bench bench;
  bench.sdo(Bench::address(0x40, 0x1008, 0));
  EXPECT_EQ(bench.sdo({0x70, 0, 0, 0, 0, 0, 0, 0}), (Data{0x80, 0x08, 0x10, 0, 0, 0, 0x03, 0x05}));
  bench.sdo(Bench::address(0x40, 0x1008, 0));
  EXPECT_EQ(bench.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}).at(0) & 0xF0, 0x00);
  EXPECT_EQ(bench.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}), (Data{0x80, 0x08, 0x10, 0, 0, 0, 0x03, 0x05}));
}

}  // namespace
}  // namespace slipstack::can
