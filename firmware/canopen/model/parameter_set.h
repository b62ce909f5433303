// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "firmware/canopen/objects/dictionary.h"
#include "firmware/storage/record_slots.h"

namespace slipstack::canopen {

/// Sub-indices of 1010h and 1011h, and the node's own settings, which LSS stores.
enum class Group : std::uint8_t { kAll = 1, kCommunication, kApplication, kManufacturer, kNode };

/// Stored values as one record of the slot log: a fingerprint of the table, node id and bit rate, then a word
/// for each stored object. Of a record of another table, as firmware of another version writes it, only node
/// id and bit rate are taken: the node stays where its master looks for it.
class ParameterSet {
 public:
  static constexpr std::size_t kWords = [] {
    std::size_t count = 0;
    for (const Object& object : kObjects) count += object.storage != Storage::kVolatile ? 1U : 0U;
    return count;
  }();
  static constexpr std::size_t kHeadWords = 4;  // fingerprint, mark, node id, bit rate
  static constexpr std::size_t kBytes = 4 * (kWords + kHeadWords);

  explicit ParameterSet(RecordSlots& log) : log_(log) {}

  /// Finds the record. Afterwards load() gives the values.
  void mount() {
    set_defaults();
    std::size_t size = 0;
    if (log_.mount() != StoreStatus::kOk) return;
    if (log_.load(std::as_writable_bytes(std::span(record_)), size) != StoreStatus::kOk || size != kBytes ||
        record_[0] != kFingerprint) {
      set_defaults();
      take_node();
    }
  }

  /// Stored values into the dictionary, up to the row `end`; a value out of bounds is replaced by the
  /// default.
  void load(Dictionary& dictionary, std::uint8_t node, std::size_t end = kObjectCount) const {
    std::size_t word = kHeadWords;
    for (std::size_t row = 0; row < end; ++row) {
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

  const RecordSlots& log() const { return log_; }

  /// Whether the newest record of a log is of this table.
  static bool reads(const RecordSlots& log) {
    std::array<std::uint32_t, 1> first;
    return log.load_begin(std::as_writable_bytes(std::span(first))) && first[0] == kFingerprint;
  }

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
    std::array<std::uint32_t, kWords + kHeadWords> made = record_;
    std::size_t word = kHeadWords;
    for (std::size_t row = 0; row < kObjectCount; ++row) {
      if (kObjects[row].storage == Storage::kVolatile) continue;
      if (belongs(kObjects[row], group)) made[word] = value_of(row);
      ++word;
    }
    made[2] = made[kNodeWord];
    made[3] = made[kNodeWord + 1];
    const StoreStatus status = log_.store(std::as_bytes(std::span(made)));
    if (status == StoreStatus::kOk) record_ = made;
    return status;
  }

  // Where 2402h:01 stands in the record; 2402h:02 follows.
  static constexpr std::size_t kNodeWord = [] {
    std::size_t word = kHeadWords;
    for (std::size_t row = 0; row < kRow<kNodeIndex, 1>; ++row) {
      word += kObjects[row].storage != Storage::kVolatile ? 1U : 0U;
    }
    return word;
  }();
  static_assert(kRow<kNodeIndex, 2> == kRow<kNodeIndex, 1> + 1);

  void take_node() {
    std::array<std::uint32_t, kHeadWords> head;
    if (!log_.load_begin(std::as_writable_bytes(std::span(head))) || head[1] != kNodeMark) return;
    record_[2] = record_[kNodeWord] = head[2];
    record_[3] = record_[kNodeWord + 1] = head[3];
  }

  void set_defaults() {
    record_[0] = kFingerprint;
    record_[1] = kNodeMark;
    std::size_t word = kHeadWords;
    for (const Object& object : kObjects) {
      if (object.storage != Storage::kVolatile) record_[word++] = object.initial;
    }
    record_[2] = record_[kNodeWord];
    record_[3] = record_[kNodeWord + 1];
  }

  static constexpr std::uint32_t kNodeMark = 0x45444F4E;  // "NODE"

  RecordSlots& log_;
  std::array<std::uint32_t, kWords + kHeadWords> record_{};
};

}  // namespace slipstack::canopen
