// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/client/sdo_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "workbench/base/text.h"
#include "workbench/console/output.h"

namespace slipstack::workbench {
namespace {

constexpr int kPatience_ms = 1000;
constexpr std::uint8_t kBlock = 127;
/// Larger than any object of a drive; a larger size is an error.
constexpr std::uint32_t kLargest = 16U << 20;
/// Number of blocks without new data after which a transfer is aborted.
constexpr int kTries = 10;
/// Without a segment for so long, what has come of a block is acknowledged: its last segments were lost, and
/// the server waits, itself for no longer than a second.
constexpr int kSegmentPatience_ms = 200;
/// An upload that timed out, or came over wrong, changed nothing, and is asked for again.
constexpr int kUploads = 3;
constexpr const char* kCheckTheBus = "check its id, the bit rate and the cable";

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

SdoAbort::SdoAbort(std::uint8_t node, std::uint16_t index, std::uint8_t sub, std::uint32_t code)
    : UsageError(fmt::format("node {}: object {:04X}h:{:02X}: {} (abort {:08X}h)", node, index, sub,
                             abort_text(code), code)),
      code_(code) {}

void SdoClient::refuse(std::uint16_t index, std::uint8_t sub, std::uint32_t code) const {
  throw SdoAbort(node_, index, sub, code);
}

void SdoClient::send(const Frame& data) {
  CanFrame frame;
  frame.id = 0x600U + node_;
  frame.length = 8;
  frame.data = data;
  link_.send(frame);
}

// A foreign frame reduces the remaining time by a tenth of a millisecond, its duration at 1 Mbit/s, so that
// the traffic of others cannot extend the wait without limit.
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

// Answers to others that share the node, too: a block transfer of a whole trace is 10 000 frames.
void SdoClient::drain() {
  constexpr int kMost = 1 << 17;
  CanFrame frame;
  for (int i = 0; i < kMost && link_.receive(frame, 0); ++i) {
  }
}

void SdoClient::silent(const char* hint) const {
  throw UsageError(fmt::format("node {} does not answer on {}; {}", node_, printable(link_.name()), hint));
}

// A request to a node that does not listen yet is lost. Six of them fit the queue of a bus on which nobody
// acknowledges a frame (10 frames in Linux).
void SdoClient::await_node() {
  constexpr int kRequests = 6;
  constexpr int kEvery_ms = 500;
  constexpr int kDuplicates_ms = 20;
  Frame frame;
  for (int i = 0; i < kRequests; ++i) {
    const auto turn = take_turn();
    send(request(0x40, 0x1000, 0));
    if (!next(frame, kEvery_ms)) continue;
    while (next(frame, kDuplicates_ms)) {
    }
    return;
  }
  silent("is it running? If so, check its id, the bit rate and the cable");
}

// False without a frame in this time; an abort is thrown.
bool SdoClient::next_of(Frame& frame, int timeout_ms, std::uint16_t index, std::uint8_t sub) {
  if (!next(frame, timeout_ms)) return false;
  if (frame[0] == 0x80) refuse(index, sub, number(&frame[4], 4));
  return true;
}

SdoClient::Frame SdoClient::answer(std::uint16_t index, std::uint8_t sub) {
  Frame frame;
  if (!next_of(frame, kPatience_ms, index, sub)) silent(kCheckTheBus);
  return frame;
}

void SdoClient::wrong(std::uint16_t index, std::uint8_t sub) const {
  throw UsageError(fmt::format("node {}: a wrong answer to {:04X}h:{:02X}; do two masters talk to it?", node_,
                               index, sub));
}

// The answer is to this request, and its command under `mask` is this one.
void SdoClient::expect(const Frame& frame, std::uint8_t mask, std::uint8_t command, std::uint16_t index,
                       std::uint8_t sub) const {
  if ((frame[0] & mask) != command || number(&frame[1], 2) != index || frame[3] != sub) wrong(index, sub);
}

std::uint32_t SdoClient::read(std::uint16_t index, std::uint8_t sub) {
  const auto turn = take_turn();
  drain();
  send(request(0x40, index, sub));
  const Frame frame = answer(index, sub);
  expect(frame, 0xE3, 0x43, index, sub);
  return number(&frame[4], 4U - (frame[0] >> 2 & 3U));
}

double SdoClient::read_real(std::uint16_t index, std::uint8_t sub) {
  return static_cast<double>(std::bit_cast<float>(read(index, sub)));
}

void SdoClient::write_real(std::uint16_t index, std::uint8_t sub, double value) {
  write(index, sub, std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4);
}

void SdoClient::fail(const std::string& why) const {
  throw UsageError(fmt::format("node {}: {}", node_, why));
}

std::uint32_t SdoClient::try_write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes) {
  const auto turn = take_turn();
  drain();
  send(request(static_cast<std::uint8_t>(0x23 | (4 - bytes) << 2), index, sub, value));
  Frame frame;
  if (!next(frame, kPatience_ms)) return static_cast<std::uint32_t>(answer(index, sub)[0]);
  if (frame[0] == 0x80) return number(&frame[4], 4);
  expect(frame, 0xFF, 0x60, index, sub);
  return 0;
}

void SdoClient::write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes) {
  const std::uint32_t code = try_write(index, sub, value, bytes);
  if (code != 0) refuse(index, sub, code);
}

std::vector<std::uint8_t> SdoClient::upload(std::uint16_t index, std::uint8_t sub, const Watch& watch) {
  const auto turn = take_turn();
  for (int left = kUploads - 1;; --left) {
    try {
      if (auto data = upload_once(index, sub, watch)) return std::move(*data);
      if (left == 0) {
        throw UsageError(fmt::format("node {}: the checksum of {:04X}h is wrong; try again", node_, index));
      }
    } catch (const SdoAbort& abort) {
      if (!abort.of_transport() || left == 0) throw;
    }
  }
}

// Nothing where the checksum is wrong, or its frame was lost.
std::optional<std::vector<std::uint8_t>> SdoClient::upload_once(std::uint16_t index, std::uint8_t sub,
                                                                const Watch& watch) {
  drain();
  send(request(0xA4, index, sub, kBlock));
  const Frame begin = answer(index, sub);
  expect(begin, 0xFB, 0xC2, index, sub);  // with its size, with a checksum or without
  const std::uint32_t size = number(&begin[4], 4);
  if (size == 0 || size > kLargest) wrong(index, sub);
  send({0xA3});
  std::vector<std::uint8_t> data;
  data.reserve(size + 7 * kBlock);
  while (data.size() < size) {
    take_block(data, index, sub);
    if (watch) watch(std::min(1.0, static_cast<double>(data.size()) / size));
  }
  Frame end;
  if (!next_of(end, kPatience_ms, index, sub)) return {};
  if ((end[0] & 0xE3) != 0xC1) wrong(index, sub);
  data.resize(size);
  send({0xA1});
  if ((begin[0] & 0x04) != 0 && number(&end[1], 2) != crc_of(data)) return {};
  return data;
}

// One block of segments: those in order are accepted, the others requested again, lost ones at its end too.
void SdoClient::take_block(std::vector<std::uint8_t>& data, std::uint16_t index, std::uint8_t sub) {
  bool silent_all_along = true;
  for (int tries = 0; tries < kTries; ++tries) {
    std::uint8_t good = 0;
    Frame frame;
    for (int frames = 0; frames < kBlock && next_of(frame, kSegmentPatience_ms, index, sub); ++frames) {
      silent_all_along = false;
      const std::uint8_t place = frame[0] & 0x7F;
      if (place == 0) wrong(index, sub);
      if (place == good + 1) {
        good = place;
        data.insert(data.end(), frame.begin() + 1, frame.end());
      }
      if ((frame[0] & 0x80) != 0 || place == kBlock) break;
    }
    send({0xA2, good, kBlock});
    if (good > 0) return;
  }
  if (silent_all_along) silent(kCheckTheBus);
  throw UsageError(fmt::format("node {}: {:04X}h:{:02X} does not come over; the transfer was given up", node_,
                               index, sub));
}

void SdoClient::download(std::uint16_t index, std::uint8_t sub, const std::vector<std::uint8_t>& data,
                         const Watch& watch) {
  const auto turn = take_turn();
  drain();
  send(request(0xC6, index, sub, static_cast<std::uint32_t>(data.size())));
  const Frame begin = answer(index, sub);
  expect(begin, 0xFB, 0xA0, index, sub);
  std::uint8_t block = begin[4];
  std::size_t at = 0;
  for (int tries = 0; at < data.size(); ++tries) {
    if (block == 0 || block > kBlock) wrong(index, sub);
    if (tries == kTries) {
      throw UsageError(fmt::format("node {}: {:04X}h:{:02X} does not go over; the transfer was given up",
                                   node_, index, sub));
    }
    const std::uint8_t sent = send_block(data, at, block);
    const Frame taken = answer(index, sub);
    if (taken[0] != 0xA2 || taken[1] > sent) wrong(index, sub);
    if (taken[1] > 0) tries = -1;
    at += std::size_t{7} * taken[1];
    block = taken[2];
    if (watch) watch(std::min(1.0, static_cast<double>(at) / static_cast<double>(data.size())));
  }
  const std::uint16_t crc = crc_of(data);
  const auto unused = static_cast<std::uint8_t>((7 - data.size() % 7) % 7);
  send({static_cast<std::uint8_t>(0xC1 | unused << 2), static_cast<std::uint8_t>(crc & 0xFF),
        static_cast<std::uint8_t>(crc >> 8)});
  if (answer(index, sub)[0] != 0xA1) wrong(index, sub);
}

// At most `block` segments from `at` on; how many.
std::uint8_t SdoClient::send_block(const std::vector<std::uint8_t>& data, std::size_t at,
                                   std::uint8_t block) {
  std::uint8_t place = 0;
  for (std::size_t from = at; place < block && from < data.size(); from += 7) {
    Frame frame{};
    frame[0] = ++place;
    const std::size_t count = std::min<std::size_t>(7, data.size() - from);
    std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(from), count, frame.begin() + 1);
    if (from + 7 >= data.size()) frame[0] |= 0x80;
    send(frame);
  }
  return place;
}

void SdoClient::nmt(std::uint8_t command) {
  CanFrame frame;
  frame.id = 0;
  frame.length = 2;
  frame.data = {command, node_};
  link_.send(frame);
}

}  // namespace slipstack::workbench
