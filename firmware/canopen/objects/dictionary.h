// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "firmware/canopen/objects/object_table.h"

namespace slipstack::canopen {

/// Why an SDO transfer ended (CiA 301 table 22).
enum class Abort : std::uint32_t {
  kNone = 0,
  kToggle = 0x05030000,
  kTimeout = 0x05040000,
  kCommand = 0x05040001,
  kBlockSize = 0x05040002,
  kSequence = 0x05040003,
  kCrc = 0x05040004,
  kOutOfMemory = 0x05040005,
  kUnsupportedAccess = 0x06010000,
  kWriteOnly = 0x06010001,
  kReadOnly = 0x06010002,
  kNoObject = 0x06020000,
  kNotMappable = 0x06040041,
  kMappingTooLong = 0x06040042,
  kIncompatible = 0x06040043,
  kHardware = 0x06060000,
  kLength = 0x06070010,
  kTooLong = 0x06070012,
  kTooShort = 0x06070013,
  kNoSubIndex = 0x06090011,
  kBadValue = 0x06090030,
  kTooHigh = 0x06090031,
  kTooLow = 0x06090032,
  kGeneral = 0x08000000,
  kCannotStore = 0x08000020,
  kLocalControl = 0x08000021,
  kDeviceState = 0x08000022,
  kNoData = 0x08000024,
};

/// The device as the dictionary sees it: reads live objects, checks and acts on what is written. Called
/// outside the tick, each in bounded time.
class ObjectAccess {
 public:
  /// The value of a live object.
  virtual std::uint32_t read(std::size_t row) = 0;
  /// Whether there is something to be read now.
  virtual Abort check_read(std::size_t) { return Abort::kNone; }
  /// Whether a value, within its bounds, may be taken now. `over_pdo`: no master waits for the answer.
  virtual Abort check(std::size_t row, std::uint32_t value) = 0;
  /// A value was taken.
  virtual void written(std::size_t row, std::uint32_t value) = 0;
  /// All values that came together were written: the device acts on them, in one tick.
  virtual void commit() {}
  /// The number of the last tick: values read under the same number belong together.
  virtual std::uint32_t tick() const { return 0; }

  /// Domains: begin an upload (size out) or a download (size in, 0 if the master does not say).
  virtual Abort begin_upload(std::size_t row, std::uint32_t& size) = 0;
  virtual void upload(std::size_t row, std::uint32_t offset, std::span<std::uint8_t> out) = 0;
  virtual Abort begin_download(std::size_t row, std::uint32_t size) = 0;
  virtual Abort download(std::size_t row, std::uint32_t offset, std::span<const std::uint8_t> in) = 0;
  /// All of it is there, in order and with a right checksum: until now nothing has changed.
  virtual Abort end_download(std::size_t row, std::uint32_t size) = 0;

 protected:
  ~ObjectAccess() = default;
};

/// Whether `value` lies within the bounds of an object; kTooHigh or kTooLow if not. NaN is too low.
constexpr Abort check_bounds(const Object& object, std::uint32_t value) {
  if (object.type == Type::kReal32) {
    const float number = std::bit_cast<float>(value);
    if (!(number >= std::bit_cast<float>(object.low))) return Abort::kTooLow;
    return number <= std::bit_cast<float>(object.high) ? Abort::kNone : Abort::kTooHigh;
  }
  if (object.type == Type::kI8 || object.type == Type::kI16 || object.type == Type::kI32) {
    const auto number = static_cast<std::int32_t>(value);
    if (number < static_cast<std::int32_t>(object.low)) return Abort::kTooLow;
    return number <= static_cast<std::int32_t>(object.high) ? Abort::kNone : Abort::kTooHigh;
  }
  if (value < object.low) return Abort::kTooLow;
  return value <= object.high ? Abort::kNone : Abort::kTooHigh;
}

/// The values of all objects: one word each, whatever the type.
class Dictionary {
 public:
  explicit Dictionary(ObjectAccess& access) : access_(access) { set_defaults(0); }

  /// Every value to its default in the table, for this node id.
  void set_defaults(std::uint8_t node) {
    for (std::size_t row = 0; row < kObjectCount; ++row) values_[row] = default_of(row, node);
  }
  static std::uint32_t default_of(std::size_t row, std::uint8_t node) {
    return kObjects[row].initial + (kObjects[row].plus_node ? node : 0U);
  }

  /// The value in memory, without asking the device.
  std::uint32_t value(std::size_t row) const { return values_[row]; }
  float real(std::size_t row) const { return std::bit_cast<float>(values_[row]); }
  void set(std::size_t row, std::uint32_t value) { values_[row] = value; }

  /// What a master sees.
  std::uint32_t read(std::size_t row) { return kObjects[row].live ? access_.read(row) : values_[row]; }

  /// What a master writes.
  Abort write(std::size_t row, std::uint32_t value) {
    const Abort abort = put(row, value);
    if (abort != Abort::kNone) return abort;
    announce(row);
    access_.commit();
    return abort;
  }
  /// The first half of a write: the value is in the dictionary, and the device has not acted on it yet.
  Abort put(std::size_t row, std::uint32_t value) {
    const Object& object = kObjects[row];
    if (!object.writable()) return Abort::kReadOnly;
    Abort abort = check_bounds(object, value);
    if (abort == Abort::kNone) abort = access_.check(row, value);
    if (abort == Abort::kNone) values_[row] = value;
    return abort;
  }
  /// The second half: the device takes it over. After the last of the values that came together, commit().
  void announce(std::size_t row) { access_.written(row, values_[row]); }

  ObjectAccess& access() { return access_; }

 private:
  ObjectAccess& access_;
  std::array<std::uint32_t, kObjectCount> values_{};
};

/// Little-endian bytes to the word of a type, by sign.
constexpr std::uint32_t from_bytes(Type type, std::span<const std::uint8_t> bytes) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < bytes.size() && i < 4; ++i)
    word |= static_cast<std::uint32_t>(bytes[i]) << (8 * i);
  if (type == Type::kI8) return static_cast<std::uint32_t>(static_cast<std::int8_t>(word & 0xFF));
  if (type == Type::kI16) return static_cast<std::uint32_t>(static_cast<std::int16_t>(word & 0xFFFF));
  return word;
}

constexpr void to_bytes(std::uint32_t word, std::span<std::uint8_t> out) {
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = i < 4 ? static_cast<std::uint8_t>(word >> (8 * i)) : std::uint8_t{0};
  }
}

}  // namespace slipstack::canopen
