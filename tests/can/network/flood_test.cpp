// SPDX-License-Identifier: Apache-2.0
// A hostile bus: foreign frames at full load, random and mutated frames. Nothing stored changes, nothing
// crashes, the tick does not notice.
#include <random>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

TEST(Flood, AMillionForeignFrames) {
  Bench bench;
  bench.configure();
  ASSERT_EQ(bench.write(0x1010, 1, 0x65766173, 4), 0U);
  ASSERT_EQ(bench.write(0x1017, 0, 100, 2), 0U);
  bench.enable(1);
  const std::vector<std::byte> flash = bench.flash.bytes;
  const std::uint32_t hash = bench.read(0x2140, 2);
  const std::uint32_t received = bench.read(0x2211, 1);
  bench.all();
  std::mt19937 random(1);
  CanFrame frame;
  int heartbeats = 0;
  // 1 Mbit/s carries some 9 frames of 8 bytes in a millisecond.
  constexpr int kFrames = 1'000'000;
  for (int i = 0; i < kFrames; ++i) {
    do {
      frame.id = random() & 0x7FF;
    } while (frame.id == 0 || frame.id == 0x80 || frame.id == 0x605 || frame.id == 0x205 ||
             frame.id == 0x305 || frame.id == 0x405 || frame.id == 0x7E5);
    frame.extended = random() % 4 == 0;
    frame.length = static_cast<std::uint8_t>(random() % 9);
    bench.master.send(frame);
    if (i % 9 == 8) {
      bench.now_us += 1000;
      bench.node->poll(bench.now_us);
      if (i % 90 == 89) bench.loop->step();
      heartbeats += static_cast<int>(bench.all_with(0x705).size());
    }
  }
  bench.poll();
  EXPECT_NEAR(heartbeats, kFrames / 900.0, 3) << "the node's own duties go on";
  EXPECT_EQ(bench.read(0x2211, 1) - received, static_cast<std::uint32_t>(kFrames) + 1);
  EXPECT_EQ(bench.read(0x2211, 2), 0U);
  EXPECT_EQ(bench.flash.bytes, flash);
  EXPECT_EQ(bench.read(0x2140, 2), hash);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x6F, 0x27U);
}

// Frames as a broken or hostile master would send them: good ones with bits flipped, cut, and mere noise, to
// every identifier of the node. The signatures of 1010h and 1011h need 32 right bits: nothing is ever stored.
TEST(Flood, AMillionRandomAndMutatedFrames) {
  Bench bench;
  bench.configure();
  ASSERT_EQ(bench.write(0x1010, 1, 0x65766173, 4), 0U);
  const std::vector<std::byte> flash = bench.flash.bytes;
  const std::vector<std::pair<std::uint32_t, Data>> good = {
      {0x605, {0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0}},
      {0x605, {0x2B, 0x17, 0x10, 0x00, 0x10, 0x27, 0, 0}},
      {0x605, {0x40, 0x08, 0x10, 0x00, 0, 0, 0, 0}},
      {0x605, {0x60, 0, 0, 0, 0, 0, 0, 0}},
      {0x605, {0xA4, 0x41, 0x21, 0x00, 0x7F, 0, 0, 0}},
      {0x605, {0xA3, 0, 0, 0, 0, 0, 0, 0}},
      {0x605, {0xA2, 0x10, 0x7F, 0, 0, 0, 0, 0}},
      {0x605, {0xC6, 0x41, 0x21, 0x00, 4 * canopen::kModelWords & 0xFF, 4 * canopen::kModelWords >> 8, 0, 0}},
      {0x605, {0x01, 1, 2, 3, 4, 5, 6, 7}},
      {0x605, {0xC1, 0x34, 0x12, 0, 0, 0, 0, 0}},
      {0x605, {0x23, 0x00, 0x1A, 0x01, 0x20, 0, 0x64, 0x60}},
      {0x605, {0x2F, 0x00, 0x1A, 0x00, 0, 0, 0, 0}},
      {0x605, {0x23, 0x00, 0x18, 0x01, 0x85, 0x01, 0, 0x80}},
      {0x605, {0x23, 0x10, 0x10, 0x01, 0x73, 0x61, 0x76, 0}},
      {0x000, {0x01, 0x05}},
      {0x000, {0x81, 0x05}},
      {0x080, {0x01}},
      {0x205, {0x0F, 0x00, 0x08}},
      {0x305, {0x0F, 0x00, 0, 0, 0, 0}},
      {0x405, {0x0F, 0, 0x10, 0, 0, 0}},
      {0x701, {0x05}},
      {0x7E5, {0x04, 1, 0, 0, 0, 0, 0, 0}},
      {0x605, {0x23, 0x01, 0x21, 0x02, 0, 0, 0x80, 0x3F}},
      {0x605, {0x2F, 0x00, 0x23, 0x01, 0x01, 0, 0, 0}},
      {0x605, {0xA4, 0x10, 0x23, 0x00, 0x20, 0, 0, 0}}};
  std::mt19937 random(2);
  for (int i = 0; i < 1'000'000; ++i) {
    CanFrame frame;
    if (random() % 8 == 0) {
      frame.id = 0x600 + kNode;
      frame.length = 8;
      for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(random());
    } else {
      const auto& [id, data] = good[random() % good.size()];
      frame.id = id;
      frame.length = static_cast<std::uint8_t>(data.size());
      std::copy(data.begin(), data.end(), frame.data.begin());
      const unsigned flips = random() % 4;
      for (unsigned k = 0; k < flips; ++k)
        frame.data[random() % 8] ^= static_cast<std::uint8_t>(1U << (random() % 8));
      if (random() % 16 == 0) frame.length = static_cast<std::uint8_t>(random() % 9);
    }
    // Not the LSS command that stores the node id: it has no signature.
    if (frame.id == 0x7E5 && frame.data[0] == 0x17) continue;
    bench.master.send(frame);
    if (i % 4 == 3) {
      bench.now_us += 250;
      bench.node->poll(bench.now_us);
      while (bench.next()) {
      }
    }
    if (i % 50 == 0) bench.loop->step();
  }
  EXPECT_EQ(bench.flash.bytes, flash);
  bench.power_on();
  bench.begin();
  bench.run_ms(5);
  EXPECT_EQ(bench.read(0x1000, 0), 0x00020192U);
  EXPECT_FLOAT_EQ(bench.read_real(0x2000, 12), 5.0F);
}

}  // namespace
}  // namespace slipstack::can
