// SPDX-License-Identifier: Apache-2.0
// libFuzzer target: whatever bytes come on the serial line, in whatever pieces and however slowly the other
// side listens, the SLCAN port takes only frames of CAN, answers in its own alphabet, and sends on what it
// has taken so that another port reads the same.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <string_view>

#include "hal/mps2/slcan.h"

namespace {

using slipstack::CanFrame;

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "slcan_fuzz: %s\n", what);
  std::abort();
}

struct Line {
  std::deque<std::uint8_t> in;
  std::deque<std::uint8_t> out;
  std::size_t room = 0;  // bytes that the other side still takes
  int reads = 0;

  bool read(std::uint8_t& byte) {
    ++reads;
    if (in.empty()) return false;
    byte = in.front();
    in.pop_front();
    return true;
  }
  bool write(std::uint8_t byte) {
    if (room == 0) return false;
    --room;
    out.push_back(byte);
    return true;
  }
};

using Port = slipstack::mps2::SlcanPort<Line>;

// A second port reads what the first one wrote.
void check_round_trip(const CanFrame& frame) {
  Line line;
  line.room = 1000;
  Port port(line);
  require(port.send(frame), "a frame that was received cannot be sent");
  Line other;
  other.in = line.out;
  other.room = 1000;
  Port reader(other);
  CanFrame again;
  require(reader.receive(again), "a frame that was sent cannot be received");
  CanFrame expected = frame;
  for (std::size_t i = frame.remote ? 0 : frame.length; i < 8; ++i) expected.data[i] = 0;
  require(again == expected, "a frame is another one after a round trip");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::string_view kAlphabet = "0123456789ABCDEFtTrRzZVNF\r\a";
  Line line;
  Port port(line);
  // A byte of length and room before each piece.
  std::size_t at = 0;
  while (at < size) {
    const std::uint8_t shape = data[at++];
    for (int i = shape & 0x3F; i > 0 && at < size; --i) line.in.push_back(data[at++]);
    line.room += (shape & 0xC0) == 0 ? 0U : 64U << (shape >> 6);
    for (;;) {
      line.reads = 0;
      CanFrame frame;
      const bool got = port.receive(frame);
      require(line.reads <= Port::kBytesPerCall, "one call reads more than it may");
      if (got) {
        require(frame.length <= 8 && frame.id <= (frame.extended ? 0x1FFFFFFFU : 0x7FFU),
                "what was received is no frame");
        check_round_trip(frame);
        port.send(frame);
      }
      if (!got && line.in.empty()) break;
    }
  }
  for (const std::uint8_t byte : line.out) {
    require(kAlphabet.find(static_cast<char>(byte)) != std::string_view::npos, "an answer in no alphabet");
  }
  return 0;
}
