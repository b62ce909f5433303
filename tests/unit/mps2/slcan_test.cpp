// SPDX-License-Identifier: Apache-2.0
#include "hal/mps2/slcan.h"

#include <gtest/gtest.h>

#include <deque>
#include <random>
#include <string>
#include <vector>

namespace slipstack::mps2 {
namespace {

// A serial line of which the test holds the other end.
struct TestLine {
  std::deque<std::uint8_t> in;
  std::string out;
  std::size_t room = static_cast<std::size_t>(-1);

  bool read(std::uint8_t& byte) {
    if (in.empty()) return false;
    byte = in.front();
    in.pop_front();
    return true;
  }
  bool write(std::uint8_t byte) {
    if (out.size() >= room) return false;
    out += static_cast<char>(byte);
    return true;
  }
  void type(const std::string& text) { in.insert(in.end(), text.begin(), text.end()); }
};

std::vector<CanFrame> everything(SlcanPort<TestLine>& port, const TestLine& line) {
  std::vector<CanFrame> frames;
  CanFrame frame;
  while (!line.in.empty()) {
    if (port.receive(frame)) frames.push_back(frame);
  }
  return frames;
}

CanFrame random_frame(std::mt19937& random) {
  CanFrame frame;
  frame.extended = random() % 2 == 0;
  frame.remote = random() % 4 == 0;
  frame.id = static_cast<std::uint32_t>(random()) & (frame.extended ? 0x1FFFFFFFU : 0x7FFU);
  frame.length = static_cast<std::uint8_t>(random() % 9);
  for (std::size_t i = 0; i < frame.length && !frame.remote; ++i) {
    frame.data[i] = static_cast<std::uint8_t>(random());
  }
  return frame;
}

// As the protocol's manual writes them.
TEST(Slcan, WritesFramesAsTheManualDoes) {
  TestLine line;
  SlcanPort port(line);
  EXPECT_TRUE(port.send({.id = 0x123, .length = 3, .data = {0x11, 0xAB, 0x00}}));
  EXPECT_TRUE(port.send({.id = 0x1ABCDEF0, .length = 0, .extended = true}));
  EXPECT_TRUE(port.send({.id = 0x7FF, .length = 8, .remote = true}));
  EXPECT_EQ(line.out, "t123311AB00\rT1ABCDEF00\rr7FF8\r");
}

TEST(Slcan, WhatOneEndSendsTheOtherReceives) {
  std::mt19937 random(7);
  for (int round = 0; round < 2000; ++round) {
    TestLine here, there;
    SlcanPort sender(here);
    SlcanPort receiver(there);
    std::vector<CanFrame> sent;
    for (int i = 0; i < 5; ++i) {
      sent.push_back(random_frame(random));
      ASSERT_TRUE(sender.send(sent.back()));
    }
    there.type(here.out);
    ASSERT_EQ(everything(receiver, there), sent);
    ASSERT_EQ(receiver.lines_refused(), 0U);
  }
}

TEST(Slcan, AnswersCommands) {
  TestLine line;
  SlcanPort port(line);
  line.type("\rV\rN\rF\rS8\rs031C\rO\rt0011FF\r");
  EXPECT_EQ(everything(port, line).size(), 1U);
  EXPECT_EQ(line.out, "\rV1013\rN0001\rF00\r\r\r\rz\r");
  line.out.clear();
  line.type("C\rt0011FF\r");
  EXPECT_TRUE(everything(port, line).empty());
  EXPECT_EQ(line.out, "\r\a");
  EXPECT_EQ(port.status().state, CanBusState::kOff);
  EXPECT_FALSE(port.send({.id = 1}));
  port.recover();
  EXPECT_TRUE(port.send({.id = 1}));
}

TEST(Slcan, FramesPassWhenBothEndsHaveTheSameBitRate) {
  TestLine line;
  SlcanPort port(line);
  EXPECT_FALSE(port.set_bit_rate(123'456));
  ASSERT_TRUE(port.set_bit_rate(250'000));
  line.type("t0010\r");
  EXPECT_EQ(everything(port, line).size(), 1U) << "the host has not said its own";
  line.type("S6\rt0010\r");
  EXPECT_TRUE(everything(port, line).empty());
  EXPECT_EQ(port.status().frames_lost, 1U);
  line.out.clear();
  EXPECT_TRUE(port.send({.id = 1}));
  EXPECT_EQ(line.out, "") << "sent, and understood by nobody";
  ASSERT_TRUE(port.set_bit_rate(500'000));
  line.type("t0010\r");
  EXPECT_EQ(everything(port, line).size(), 1U);
  EXPECT_TRUE(port.send({.id = 1}));
  EXPECT_EQ(line.out, "z\rt0010\r");
}

TEST(Slcan, RefusesWhatIsNoFrame) {
  for (const char* wrong :
       {"t",     "t12",      "t123",       "t1239",      "t123G",  "t12311",   "t1231111", "t8001FF",
        "tXYZ0", "T1234567", "T200000000", "T1FFFFFFF9", "r12381", "R1234567", "x",        "S",
        "S9",    "S88",      "s",          "s12345",     "OO",     "t1230 ",   " t1230",   "t123-"}) {
    TestLine line;
    SlcanPort port(line);
    line.type(std::string(wrong) + "\r");
    EXPECT_TRUE(everything(port, line).empty()) << wrong;
    EXPECT_EQ(line.out, "\a") << wrong;
    EXPECT_EQ(port.lines_refused(), 1U) << wrong;
    // The next line is read as if nothing had been.
    line.type("t1230\r");
    EXPECT_EQ(everything(port, line).size(), 1U) << wrong;
  }
}

TEST(Slcan, ALineWithoutEndTakesNoMemoryAndIsForgottenAtItsEnd) {
  TestLine line;
  SlcanPort port(line);
  for (int i = 0; i < 1000; ++i) {
    line.type(std::string(1000, 't'));
    EXPECT_TRUE(everything(port, line).empty());
  }
  line.type("\rt1230\r");
  EXPECT_EQ(everything(port, line).size(), 1U);
  EXPECT_EQ(port.lines_refused(), 1U);
}

// Good frames with bytes changed, dropped and doubled: never more frames than lines, and every one a frame.
TEST(Slcan, MutatedInputIsHarmless) {
  std::mt19937 random(11);
  std::size_t received = 0;
  for (int round = 0; round < 20000; ++round) {
    TestLine source;
    SlcanPort sender(source);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(sender.send(random_frame(random)));
    std::string text = source.out;
    for (std::uint32_t i = 0; i < 1 + random() % 4; ++i) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.erase(at, 1);
          break;
        case 2:
          text.insert(at, 1, text[at]);
          break;
        default:
          text.insert(at, random() % 40, static_cast<char>(random()));
      }
      if (text.empty()) text = "\r";
    }
    TestLine line;
    SlcanPort port(line);
    line.type(text);
    const auto frames = everything(port, line);
    received += frames.size();
    ASSERT_LE(frames.size(), static_cast<std::size_t>(std::count(text.begin(), text.end(), '\r')));
    for (const CanFrame& frame : frames) {
      ASSERT_LE(frame.length, 8);
      ASSERT_LE(frame.id, frame.extended ? 0x1FFFFFFFU : 0x7FFU);
    }
  }
  EXPECT_GT(received, 20000U);
  EXPECT_LT(received, 60000U);
}

TEST(Slcan, AFullLineLosesNothingThatItHasTaken) {
  TestLine line;
  line.room = 0;
  SlcanPort port(line);
  std::string expected;
  std::size_t taken = 0;
  while (port.send({.id = 0x100, .length = 2, .data = {1, 2}})) {
    expected += "t10020102\r";
    ASSERT_LT(++taken, 1000U);
  }
  EXPECT_GT(taken, 40U);
  line.room = static_cast<std::size_t>(-1);
  CanFrame frame;
  EXPECT_FALSE(port.receive(frame));
  EXPECT_EQ(line.out, expected);
  EXPECT_FALSE(port.send({.id = 0x800}));
  EXPECT_FALSE(port.send({.id = 0x100, .length = 9}));
}

}  // namespace
}  // namespace slipstack::mps2
