// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/include/can_port.h"

namespace slipstack::mps2 {

/// A serial line; neither call waits.
template <class S>
concept SerialLine = requires(S line, std::uint8_t byte) {
  { line.read(byte) } -> std::same_as<bool>;   // false: nothing has come
  { line.write(byte) } -> std::same_as<bool>;  // false: no room
};

/// CAN frames as text on a serial line: the ASCII protocol of the Lawicel CANUSB that slcand and others
/// speak.
///
///   tiiildd..  TiiiiiiiiLdd..  riiil  RiiiiiiiiL    a frame, 11 or 29 bits, data or remote request
///   O C                                             open and close; open from the start
///   Sn sxxxx                                        bit rate of the host's end of the bus
///   V N F                                           version, serial number, status flags
///
/// There is no bus, but a bit rate at either end: when both are known and differ, no frame passes, and those
/// of the host count as lost.
///
/// Each line ends with CR and is answered, by CR or by BEL for what is none of these. Whatever comes in, work
/// and memory are bounded: a line that is too long is dropped to its end and counted.
template <SerialLine Line>
class SlcanPort final : public CanPort {
 public:
  static constexpr std::size_t kLongestLine = 26;  // T, 8 digits, length, 16 digits
  static constexpr std::size_t kTransmitBytes = 512;
  static constexpr int kBytesPerCall = 64;

  explicit SlcanPort(Line& line) : line_(line) {}

  bool send(const CanFrame& frame) override {
    flush();
    const std::uint32_t highest = frame.extended ? 0x1FFFFFFFU : 0x7FFU;
    if (!open_ || frame.length > 8 || frame.id > highest || room() <= kLongestLine) return false;
    if (!rates_agree()) return true;  // out on the wire, where no other node can decode it
    put(letter_of(frame));
    put_hex(frame.id, frame.extended ? 8 : 3);
    put_hex(frame.length, 1);
    for (std::size_t i = 0; i < frame.length && !frame.remote; ++i) put_hex(frame.data[i], 2);
    put('\r');
    flush();
    return true;
  }

  /// Reads at most kBytesPerCall bytes from the line.
  bool receive(CanFrame& frame) override {
    flush();
    std::uint8_t byte = 0;
    for (int i = 0; i < kBytesPerCall && line_.read(byte); ++i) {
      if (byte != '\r') {
        collect(static_cast<char>(byte));
        continue;
      }
      const std::optional<CanFrame> found = end_of_line();
      flush();
      if (!found) continue;
      frame = *found;
      return true;
    }
    return false;
  }

  CanBusStatus status() const override {
    CanBusStatus status;
    status.state = open_ ? CanBusState::kActive : CanBusState::kOff;
    status.frames_lost = lines_refused_;
    return status;
  }
  void recover() override { open_ = true; }
  bool offers_bit_rate(std::uint32_t bits_per_s) const override {
    return std::find(kBitRates.begin(), kBitRates.end(), bits_per_s) != kBitRates.end();
  }
  bool set_bit_rate(std::uint32_t bits_per_s) override {
    if (!offers_bit_rate(bits_per_s)) return false;
    own_bit_rate_ = bits_per_s;
    return true;
  }

  /// Lines that were no command and no frame.
  std::uint32_t lines_refused() const { return lines_refused_; }

 private:
  // S0 to S8.
  static constexpr std::array<std::uint32_t, 9> kBitRates = {10'000,  20'000,  50'000,  100'000,  125'000,
                                                             250'000, 500'000, 800'000, 1'000'000};
  bool rates_agree() const {
    return own_bit_rate_ == 0 || host_bit_rate_ == 0 || own_bit_rate_ == host_bit_rate_;
  }

  static constexpr char kBell = '\a';

  static char letter_of(const CanFrame& frame) {
    return frame.remote ? (frame.extended ? 'R' : 'r') : (frame.extended ? 'T' : 't');
  }

  void collect(char byte) {
    // Some hosts end a line with LF as well.
    if (byte == '\n' && length_ == 0) return;
    if (length_ < text_.size()) text_[length_] = byte;
    if (length_ <= text_.size()) ++length_;
  }

  std::optional<CanFrame> end_of_line() {
    const std::size_t length = length_;
    length_ = 0;
    if (length == 0) {
      answer({});
      return {};
    }
    if (length <= text_.size()) {
      const std::span<const char> text(text_.data(), length);
      const std::optional<CanFrame> frame = parse_frame(text);
      if (frame && open_ && rates_agree()) {
        const std::array<char, 1> taken = {frame->extended ? 'Z' : 'z'};
        answer(taken);
        return frame;
      }
      if (!frame && command(text)) return {};
    }
    if (lines_refused_ != 0xFFFFFFFF) ++lines_refused_;
    if (room() > 0) put(kBell);
    return {};
  }

  static std::optional<std::uint32_t> hex(std::span<const char> digits) {
    std::uint32_t value = 0;
    for (const char c : digits) {
      std::uint32_t digit = 0;
      if (c >= '0' && c <= '9') {
        digit = static_cast<std::uint32_t>(c - '0');
      } else if (c >= 'A' && c <= 'F') {
        digit = static_cast<std::uint32_t>(c - 'A') + 10;
      } else if (c >= 'a' && c <= 'f') {
        digit = static_cast<std::uint32_t>(c - 'a') + 10;
      } else {
        return {};
      }
      value = value << 4U | digit;
    }
    return value;
  }

  static std::optional<CanFrame> parse_frame(std::span<const char> text) {
    CanFrame frame;
    frame.extended = text[0] == 'T' || text[0] == 'R';
    frame.remote = text[0] == 'r' || text[0] == 'R';
    if (!frame.extended && !frame.remote && text[0] != 't') return {};
    const std::size_t digits = frame.extended ? 8 : 3;
    if (text.size() < digits + 2) return {};
    const auto id = hex(text.subspan(1, digits));
    const auto length = hex(text.subspan(digits + 1, 1));
    if (!id || !length || *length > 8 || *id > (frame.extended ? 0x1FFFFFFFU : 0x7FFU)) return {};
    const std::size_t data = frame.remote ? 0 : *length;
    if (text.size() != digits + 2 + 2 * data) return {};
    frame.id = *id;
    frame.length = static_cast<std::uint8_t>(*length);
    for (std::size_t i = 0; i < data; ++i) {
      const auto byte = hex(text.subspan(digits + 2 + 2 * i, 2));
      if (!byte) return {};
      frame.data[i] = static_cast<std::uint8_t>(*byte);
    }
    return frame;
  }

  // False: not a command.
  bool command(std::span<const char> text) {
    switch (text[0]) {
      case 'O':
      case 'C':
        if (text.size() != 1) return false;
        open_ = text[0] == 'O';
        answer({});
        return true;
      case 'S':
        if (text.size() != 2 || text[1] < '0' || text[1] > '8') return false;
        host_bit_rate_ = kBitRates[static_cast<std::size_t>(text[1] - '0')];
        answer({});
        return true;
      case 's':
        if (text.size() != 5 || !hex(text.subspan(1))) return false;
        host_bit_rate_ = 0;  // registers of a part that is not here
        answer({});
        return true;
      case 'V':
        return answer_with(text, {'V', '1', '0', '1', '3'});
      case 'N':
        return answer_with(text, {'N', '0', '0', '0', '1'});
      case 'F':
        return answer_with(text, {'F', '0', '0'});
      default:
        return false;
    }
  }
  template <std::size_t N>
  bool answer_with(std::span<const char> text, const char (&words)[N]) {
    if (text.size() != 1) return false;
    answer(words);
    return true;
  }

  // An answer for which there is no room is dropped: the host does not read its terminal then.
  void answer(std::span<const char> text) {
    if (room() < text.size() + 1) return;
    for (const char c : text) put(c);
    put('\r');
  }

  std::size_t room() const { return kTransmitBytes - (end_ - begin_); }
  void put(char c) { out_[end_++ % kTransmitBytes] = static_cast<std::uint8_t>(c); }
  void put_hex(std::uint32_t value, int digits) {
    for (int i = digits - 1; i >= 0; --i) put("0123456789ABCDEF"[(value >> (4 * i)) & 0xFU]);
  }
  void flush() {
    while (begin_ != end_ && line_.write(out_[begin_ % kTransmitBytes])) ++begin_;
  }

  Line& line_;
  bool open_ = true;
  std::uint32_t own_bit_rate_ = 0;  // 0: not said
  std::uint32_t host_bit_rate_ = 0;
  std::uint32_t lines_refused_ = 0;
  std::size_t length_ = 0;  // of the line so far; more than text_ holds: too long
  std::array<char, kLongestLine> text_{};
  std::size_t begin_ = 0;  // of what waits in out_; both count on for ever, modulo a power of two
  std::size_t end_ = 0;
  std::array<std::uint8_t, kTransmitBytes> out_{};
};

}  // namespace slipstack::mps2
