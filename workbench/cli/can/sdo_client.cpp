// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/can/sdo_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "workbench/cli/output.h"
#include "workbench/log/text.h"

namespace slipstack::workbench {
namespace {

constexpr int kPatience_ms = 1000;
constexpr std::uint8_t kBlock = 127;

std::array<std::uint8_t, 8> request(std::uint8_t command, std::uint16_t index, std::uint8_t sub,
                                    std::uint32_t data = 0) {
  return {command,
          static_cast<std::uint8_t>(index & 0xFF),
          static_cast<std::uint8_t>(index >> 8),
          sub,
          static_cast<std::uint8_t>(data & 0xFF),
          static_cast<std::uint8_t>(data >> 8 & 0xFF),
          static_cast<std::uint8_t>(data >> 16 & 0xFF),
          static_cast<std::uint8_t>(data >> 24)};
}

std::uint32_t number(const std::uint8_t* bytes, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value |= static_cast<std::uint32_t>(bytes[i]) << (8 * i);
  return value;
}

std::uint16_t crc_of(const std::vector<std::uint8_t>& data) {
  unsigned crc = 0;
  for (const std::uint8_t byte : data) {
    crc ^= static_cast<unsigned>(byte) << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000U) != 0 ? (crc << 1 ^ 0x1021U) & 0xFFFFU : crc << 1;
  }
  return static_cast<std::uint16_t>(crc);
}

}  // namespace

std::string abort_text(std::uint32_t code) {
  switch (code) {
    case 0x05040000:
      return "the transfer timed out";
    case 0x06010002:
      return "the object is read-only";
    case 0x06020000:
    case 0x06090011:
      return "there is no such object; is it a slipstack drive?";
    case 0x06090030:
    case 0x06090031:
    case 0x06090032:
      return "the value is out of its bounds";
    case 0x06060000:
      return "the flash of the drive failed";
    case 0x08000021:
      return "the access lock is closed; open it with the key first";
    case 0x08000022:
      return "not in this state of the drive; disable it first";
    default:
      return "refused";
  }
}

void SdoClient::refuse(std::uint16_t index, std::uint8_t sub, std::uint32_t code) const {
  throw UsageError(fmt::format("node {}: object {:04X}h:{:02X}: {} (abort {:08X}h)", node_, index, sub,
                               abort_text(code), code));
}

void SdoClient::send(const Frame& data) {
  CanFrame frame;
  frame.id = 0x600U + node_;
  frame.length = 8;
  frame.data = data;
  link_.send(frame);
}

// A foreign frame takes a tenth of a millisecond of the patience, as it does of a bus at 1 Mbit/s: frames of
// others never keep this waiting for ever.
bool SdoClient::next(Frame& data, int timeout_ms) {
  constexpr int kSlice_ms = 10;
  CanFrame frame;
  for (int left_us = 1000 * timeout_ms; left_us > 0;) {
    if (!link_.receive(frame, kSlice_ms)) {
      left_us -= 1000 * kSlice_ms;
      continue;
    }
    left_us -= 100;
    if (frame.id != 0x580U + node_ || frame.extended || frame.remote || frame.length != 8) continue;
    data = frame.data;
    return true;
  }
  return false;
}

void SdoClient::drain() {
  CanFrame frame;
  for (int i = 0; i < 10000 && link_.receive(frame, 0); ++i) {
  }
}

SdoClient::Frame SdoClient::answer(std::uint16_t index, std::uint8_t sub) {
  Frame frame;
  if (!next(frame, kPatience_ms)) {
    throw UsageError(fmt::format("node {} does not answer on {}; check its id, the bit rate and the cable",
                                 node_, printable(link_.name())));
  }
  if (frame[0] == 0x80) refuse(index, sub, number(&frame[4], 4));
  return frame;
}

std::uint32_t SdoClient::read(std::uint16_t index, std::uint8_t sub) {
  drain();
  send(request(0x40, index, sub));
  const Frame frame = answer(index, sub);
  if ((frame[0] & 0xE3) != 0x43 || number(&frame[1], 2) != index || frame[3] != sub) {
    throw UsageError(fmt::format("node {}: a wrong answer to {:04X}h:{:02X}; do two masters talk to it?",
                                 node_, index, sub));
  }
  return number(&frame[4], 4U - (frame[0] >> 2 & 3U));
}

float SdoClient::read_real(std::uint16_t index, std::uint8_t sub) {
  return std::bit_cast<float>(read(index, sub));
}

std::uint32_t SdoClient::try_write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes) {
  drain();
  send(request(static_cast<std::uint8_t>(0x23 | (4 - bytes) << 2), index, sub, value));
  Frame frame;
  if (!next(frame, kPatience_ms)) return static_cast<std::uint32_t>(answer(index, sub)[0]);
  return frame[0] == 0x80 ? number(&frame[4], 4) : 0;
}

void SdoClient::write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes) {
  const std::uint32_t code = try_write(index, sub, value, bytes);
  if (code != 0) refuse(index, sub, code);
}

std::vector<std::uint8_t> SdoClient::upload(std::uint16_t index, std::uint8_t sub, const Watch& watch) {
  drain();
  send(request(0xA4, index, sub, kBlock));
  const std::uint32_t size = [&] {
    const Frame begin = answer(index, sub);
    return number(&begin[4], 4);
  }();
  send({0xA3});
  std::vector<std::uint8_t> data;
  data.reserve(size + 7);
  std::uint8_t good = 0;
  for (;;) {
    const Frame frame = answer(index, sub);
    if (good == 0 && data.size() >= size) {  // the end
      data.resize(size);
      send({0xA1});
      if (number(&frame[1], 2) != crc_of(data)) {
        throw UsageError(fmt::format("node {}: the checksum of {:04X}h is wrong; try again", node_, index));
      }
      return data;
    }
    const std::uint8_t place = frame[0] & 0x7F;
    if (place == good + 1) {
      good = place;
      data.insert(data.end(), frame.begin() + 1, frame.end());
    }
    if ((frame[0] & 0x80) != 0 || place == kBlock) {
      send({0xA2, good, kBlock});
      good = 0;
      if (watch) watch(static_cast<double>(data.size()) / size);
    }
  }
}

void SdoClient::download(std::uint16_t index, std::uint8_t sub, const std::vector<std::uint8_t>& data,
                         const Watch& watch) {
  drain();
  send(request(0xC6, index, sub, static_cast<std::uint32_t>(data.size())));
  std::uint8_t block = answer(index, sub)[4];
  std::size_t at = 0;
  while (at < data.size()) {
    std::uint8_t place = 0;
    for (std::size_t from = at; place < block && from < data.size(); from += 7) {
      Frame frame{};
      frame[0] = ++place;
      const std::size_t count = std::min<std::size_t>(7, data.size() - from);
      std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(from), count, frame.begin() + 1);
      if (from + 7 >= data.size()) frame[0] |= 0x80;
      send(frame);
    }
    const Frame taken = answer(index, sub);
    at += std::size_t{7} * taken[1];
    block = taken[2];
    if (watch) watch(std::min(1.0, static_cast<double>(at) / static_cast<double>(data.size())));
  }
  const std::uint16_t crc = crc_of(data);
  const auto unused = static_cast<std::uint8_t>((7 - data.size() % 7) % 7);
  send({static_cast<std::uint8_t>(0xC1 | unused << 2), static_cast<std::uint8_t>(crc & 0xFF),
        static_cast<std::uint8_t>(crc >> 8)});
  answer(index, sub);
}

void SdoClient::nmt(std::uint8_t command) {
  CanFrame frame;
  frame.id = 0;
  frame.length = 2;
  frame.data = {command, node_};
  link_.send(frame);
}

}  // namespace slipstack::workbench
