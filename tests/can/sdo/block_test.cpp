// SPDX-License-Identifier: Apache-2.0
// Block transfer both ways (CiA 301, 7.2.4.3.9 to 7.2.4.3.16).
#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include "tests/can/bench.h"
#include "tests/can/sdo/block_master.h"

namespace slipstack::can {
namespace {

Data floats(const std::vector<float>& values) {
  Data data;
  for (const float value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (int i = 0; i < 4; ++i) data.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
  }
  return data;
}

// A master's block download; the answer to its end.
Data block_download(
    Bench& bench, std::uint16_t index, const Data& data, std::uint16_t crc,
    const std::function<bool(int)>& drop = [](int) { return false; }) {
  Data request = Bench::address(0xC6, index, 0);
  for (std::size_t i = 0; i < 4; ++i) request[4 + i] = static_cast<std::uint8_t>(data.size() >> (8 * i));
  const Data begin = bench.sdo(request);
  EXPECT_EQ(begin.at(0), 0xA4);
  std::uint8_t block = begin.at(4);
  std::size_t at = 0;
  int sent = 0;
  while (at < data.size()) {
    std::uint8_t number = 0;
    Data answer;
    for (std::size_t from = at; number < block && from < data.size(); from += 7) {
      Data frame(8, 0);
      frame[0] = ++number;
      const std::size_t count = std::min<std::size_t>(7, data.size() - from);
      std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(from), count, frame.begin() + 1);
      if (from + 7 >= data.size()) frame[0] |= 0x80;
      // The last of a block always arrives: without it the server would wait.
      if (number != block && (frame[0] & 0x80) == 0 && drop(sent++)) continue;
      bench.send(0x605, frame);
      bench.poll();
    }
    const auto answers = bench.all_with(0x585);
    EXPECT_EQ(answers.size(), 1U);
    if (answers.size() != 1 || answers[0][0] != 0xA2) return answers.empty() ? Data{} : answers[0];
    at += 7U * answers[0][1];
    block = answers[0][2];
  }
  const auto unused = static_cast<std::uint8_t>((7 - data.size() % 7) % 7);
  return bench.sdo({static_cast<std::uint8_t>(0xC1 | (unused << 2)), static_cast<std::uint8_t>(crc),
                    static_cast<std::uint8_t>(crc >> 8), 0, 0, 0, 0, 0});
}

TEST(SdoCrc, CheckValue) {
  const std::string text = "123456789";
  EXPECT_EQ(crc_by_division(Data(text.begin(), text.end())), 0x31C3);
}

TEST(SdoBlock, TraceOfFourThousandSamplesThroughALossyLine) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  EXPECT_GE(bench.read(0x2300, 9), 4000U);
  ASSERT_EQ(bench.write(0x607A, 0, 30000, 4), 0U);
  ASSERT_EQ(bench.write(0x2300, 1, 1, 1), 0U);
  ASSERT_EQ(bench.write(0x6040, 0, 0x1F, 2), 0U);
  bench.run_ms(500);
  ASSERT_EQ(bench.read(0x2300, 2), 3U);
  const std::uint32_t samples = bench.read(0x2300, 8);
  ASSERT_EQ(samples, 4096U);
  std::mt19937 random(4);
  const Data clean = block_upload(bench, 0x2310, 127, [](int) { return false; });
  ASSERT_EQ(clean.size(), 48 + 12 * samples);
  const Data lossy = block_upload(bench, 0x2310, 20, [&](int) { return random() % 13 == 0; });
  EXPECT_EQ(lossy, clean);
  EXPECT_EQ(Bench::number(clean, 0), 0x52544C53U);
  EXPECT_EQ(Bench::number(clean, 8), samples);
  // Tick, encoder, motor and mass as they were set; the image is over with its end.
  const ControlSet& set = bench.loop->controller().parameters();
  const Data scales =
      floats({set.axis.tick_s, set.axis.encoder_resolution_m, set.axis.motor_constant_N_per_A, set.mass_kg});
  EXPECT_TRUE(std::equal(scales.begin(), scales.end(), clean.begin() + 16));
  EXPECT_EQ(bench.sdo({0xA1, 0, 0, 0, 0, 0, 0, 0}).at(0), 0x80);
  // The axis moved under way, to 30 mm from where it stood at 100 mm.
  std::int32_t first = 0, last = 0;
  std::memcpy(&first, &clean[48], 4);
  std::memcpy(&last, &clean[48 + 12 * (samples - 1)], 4);
  EXPECT_LT(last - first, -5000);
}

TEST(SdoBlock, ModelImageIsTakenWholeOrNotAtAll) {
  Bench bench;
  bench.configure();
  const Data image = block_upload(bench, 0x2141, 127, [](int) { return false; });
  ASSERT_EQ(image.size() % 4, 0U);
  const std::uint32_t active = bench.read(0x2140, 2);
  EXPECT_EQ(bench.read(0x2140, 1), active);

  Data other = image;
  const Data mass = floats({12.5F});
  std::copy(mass.begin(), mass.end(), other.begin() + 4);  // the gain of inertia
  EXPECT_EQ(block_download(bench, 0x2141, other, static_cast<std::uint16_t>(crc_by_division(other) ^ 1)),
            (Data{0x80, 0x41, 0x21, 0, 0x04, 0, 0x04, 0x05}));
  EXPECT_EQ(bench.read(0x2140, 1), active) << "a wrong checksum changes nothing";

  Data bad = other;
  const Data nan = floats({std::nanf("")});
  std::copy(nan.begin(), nan.end(), bad.end() - 4);
  EXPECT_EQ(block_download(bench, 0x2141, bad, crc_by_division(bad)).at(0), 0x80);
  EXPECT_EQ(bench.read(0x2140, 1), active) << "one value out of bounds, and none is taken";

  // Half of it, then the master is gone.
  Data request = Bench::address(0xC6, 0x2141, 0);
  for (std::size_t i = 0; i < 4; ++i) request[4 + i] = static_cast<std::uint8_t>(other.size() >> (8 * i));
  bench.sdo(request);
  for (std::uint8_t i = 1; i < 20; ++i) bench.send(0x605, {i, 1, 2, 3, 4, 5, 6, 7});
  bench.run_ms(1100);
  EXPECT_EQ(bench.read(0x2140, 1), active);

  std::mt19937 random(9);
  EXPECT_EQ(
      block_download(bench, 0x2141, other, crc_by_division(other), [&](int) { return random() % 5 == 0; }),
      (Data{0xA1, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_NE(bench.read(0x2140, 1), active);
  EXPECT_EQ(bench.read(0x2140, 2), active) << "staged is not active";
  EXPECT_FLOAT_EQ(bench.read_real(0x2100, 2), 12.5F);
  EXPECT_EQ(bench.write(0x2140, 3, active, 4), 0x06090030U) << "the hash of another model applies nothing";
  EXPECT_EQ(bench.write(0x2140, 3, bench.read(0x2140, 1), 4), 0U);
  bench.run_ms(2);
  EXPECT_EQ(bench.read(0x2140, 2), bench.read(0x2140, 1));
  EXPECT_FLOAT_EQ(bench.loop->controller().parameters().mass_kg, 12.5F);
}

TEST(SdoBlock, ErrorsOfTheProtocol) {
  Bench bench;
  Data request = Bench::address(0xA4, 0x2141, 0);
  for (const int size : {0, 128, 255}) {
    request[4] = static_cast<std::uint8_t>(size);
    EXPECT_EQ(Bench::number(bench.sdo(request), 4), 0x05040002U);  // invalid block size
  }
  request[4] = 10;
  bench.sdo(request);
  bench.send(0x605, {0xA3, 0, 0, 0, 0, 0, 0, 0});
  bench.poll();
  bench.poll();
  EXPECT_EQ(bench.all_with(0x585).size(), 10U);
  EXPECT_EQ(Bench::number(bench.sdo({0xA2, 11, 10, 0, 0, 0, 0, 0}), 4), 0x05040003U);  // more than was sent
  EXPECT_EQ(bench.sdo({0xC1, 0, 0, 0, 0, 0, 0, 0}).at(0), 0x80);                       // end of nothing
  // Small objects may come expedited: threshold.
  Data small = Bench::address(0xA4, 0x1000, 0);
  small[4] = 10;
  small[5] = 20;
  EXPECT_EQ(bench.sdo(small), (Data{0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00}));
}

}  // namespace
}  // namespace slipstack::can
