// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "firmware/canopen/dictionary.h"
#include "firmware/storage/slot_log.h"

namespace slipstack::canopen {

/// Sub-indices of 1010h and 1011h, and the node's own settings, which LSS stores.
enum class Group : std::uint8_t { kAll = 1, kCommunication, kApplication, kManufacturer, kNode };

/// Stored values as one record of the slot log: a fingerprint of the table, then a word for each stored
/// object. A record of another table is not taken.
class ParameterSet {
 public:
  static constexpr std::size_t kWords = [] {
    std::size_t count = 0;
    for (const Object& object : kObjects) count += object.storage != Storage::kVolatile ? 1U : 0U;
    return count;
  }();
  static constexpr std::size_t kBytes = 4 * (kWords + 1);

  explicit ParameterSet(SlotLog& log) : log_(log) {}

  /// Finds the record. Afterwards load() gives the values.
  void mount() {
    set_defaults();
    std::size_t size = 0;
    if (log_.mount() != StoreStatus::kOk) return;
    if (log_.load(std::as_writable_bytes(std::span(record_)), size) != StoreStatus::kOk || size != kBytes ||
        record_[0] != kFingerprint) {
      set_defaults();
    }
  }

  /// Stored values into the dictionary; a value out of bounds is replaced by the default.
  void load(Dictionary& dictionary, std::uint8_t node) const {
    std::size_t word = 1;
    for (std::size_t row = 0; row < kObjectCount; ++row) {
      if (kObjects[row].storage == Storage::kVolatile) continue;
      std::uint32_t value = record_[word++];
      if (kObjects[row].plus_node) value += node;
      const bool good = check_bounds(kObjects[row], value) == Abort::kNone;
      dictionary.set(row, good ? value : Dictionary::default_of(row, node));
    }
  }

  /// Stores what the dictionary holds of a group; of the others what was stored before.
  StoreStatus save(const Dictionary& dictionary, std::uint8_t node, Group group) {
    return change(group, [&](std::size_t row) {
      return dictionary.value(row) - (kObjects[row].plus_node ? node : 0U);
    });
  }
  /// Stores the defaults of a group: they come into force with the next reset.
  StoreStatus restore(Group group) {
    return change(group, [](std::size_t row) { return kObjects[row].initial; });
  }

  const SlotLog& log() const { return log_; }

 private:
  static constexpr std::uint32_t kFingerprint = [] {
    std::uint32_t hash = 2166136261U;
    for (const Object& object : kObjects) {
      if (object.storage == Storage::kVolatile) continue;
      const std::array<std::uint32_t, 4> bytes = {object.index & 0xFFU,
                                                  static_cast<std::uint32_t>(object.index >> 8U), object.sub,
                                                  static_cast<std::uint32_t>(object.type)};
      for (const std::uint32_t byte : bytes) {
        hash = (hash ^ byte) * 16777619U;
      }
    }
    return hash;
  }();

  static bool belongs(const Object& object, Group group) {
    const bool node = object.index == kNodeIndex;
    switch (group) {
      case Group::kAll:
        return !node;
      case Group::kCommunication:
        return object.index < 0x2000;
      case Group::kApplication:
        return object.index >= 0x6000;
      case Group::kManufacturer:
        return object.index >= 0x2000 && object.index < 0x6000 && !node;
      default:
        return node;
    }
  }

  template <class ValueOf>
  StoreStatus change(Group group, ValueOf&& value_of) {
    std::array<std::uint32_t, kWords + 1> made = record_;
    std::size_t word = 1;
    for (std::size_t row = 0; row < kObjectCount; ++row) {
      if (kObjects[row].storage == Storage::kVolatile) continue;
      if (belongs(kObjects[row], group)) made[word] = value_of(row);
      ++word;
    }
    const StoreStatus status = log_.store(std::as_bytes(std::span(made)));
    if (status == StoreStatus::kOk) record_ = made;
    return status;
  }

  void set_defaults() {
    record_[0] = kFingerprint;
    std::size_t word = 1;
    for (const Object& object : kObjects) {
      if (object.storage != Storage::kVolatile) record_[word++] = object.initial;
    }
  }

  SlotLog& log_;
  std::array<std::uint32_t, kWords + 1> record_{};
};

}  // namespace slipstack::canopen
