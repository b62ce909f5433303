// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "tests/can/bench.h"

// A master's end of SDO block transfer, written from CiA 301, 7.2.4.3.9 to 7.2.4.3.16.
namespace slipstack::can {

// CRC-16 of the standard, by another way than the node's: polynomial division of the message times x^16.
inline std::uint16_t crc_by_division(const Data& data) {
  std::uint32_t rest = 0;
  for (std::size_t i = 0; i < 8 * (data.size() + 2); ++i) {
    const unsigned bit = i / 8 < data.size() ? (data[i / 8] >> (7 - i % 8)) & 1U : 0U;
    rest = (rest << 1) | bit;
    if ((rest & 0x10000) != 0) rest ^= 0x11021;
  }
  return static_cast<std::uint16_t>(rest);
}

// A master's block upload; `drop` says which segments (counted over all) are lost on the way.
inline Data block_upload(Bench& bench, std::uint16_t index, std::uint8_t block,
                         const std::function<bool(int)>& drop) {
  Data request = Bench::address(0xA4, index, 0);
  request[4] = block;
  const Data begin = bench.sdo(request);
  EXPECT_EQ(begin.at(0) & 0xE3, 0xC2) << int{begin.at(0)};  // size indicated
  const std::uint32_t size = Bench::number(begin, 4);
  Data data;
  bench.send(0x605, {0xA3, 0, 0, 0, 0, 0, 0, 0});
  int segments = 0;
  std::uint8_t good = 0;
  for (int patience = 0; patience < 100000; ++patience) {
    bench.run_ms(1);
    for (const Data& frame : bench.all_with(0x585)) {
      if ((frame[0] & 0xE3) == 0xC1 && data.size() >= size) {
        const std::size_t unused = (frame[0] >> 2) & 7;
        data.erase(data.end() - static_cast<std::ptrdiff_t>(unused), data.end());
        EXPECT_EQ(data.size(), size);
        EXPECT_EQ(Bench::number(frame, 1, 2), crc_by_division(data));
        bench.send(0x605, {0xA1, 0, 0, 0, 0, 0, 0, 0});
        bench.poll();
        return data;
      }
      const std::uint8_t number = frame[0] & 0x7F;
      const bool last = (frame[0] & 0x80) != 0;
      if (!drop(segments++) && number == good + 1) {
        good = number;
        data.insert(data.end(), frame.begin() + 1, frame.end());
      }
      if (last || number == block) {
        bench.send(0x605, {0xA2, good, block, 0, 0, 0, 0, 0});
        good = 0;
      }
    }
  }
  ADD_FAILURE() << "no end";
  return {};
}

}  // namespace slipstack::can
