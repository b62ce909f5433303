// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/canopen/network/cob_id.h"
#include "firmware/canopen/node_parts.h"

namespace slipstack::canopen {

/// Access to the objects of the node: communication, storage and access lock;
/// those from 2000h on are the application's.
class NodeObjects final : public ObjectAccess {
 public:
  explicit NodeObjects(NodeParts& parts) : parts_(parts) {}

  std::uint32_t read(std::size_t row) override {
    const Object& object = kObjects[row];
    switch (object.index) {
      case 0x1001:
        return parts_.emergency.error_register();
      case 0x1003:
        return object.sub == 0 ? parts_.emergency.count() : parts_.emergency.history(object.sub);
      case 0x1010:
      case 0x1011:
        return 1;  // on command
      case 0x1018:
        return parts_.application.serial_number();
      case kLockIndex:
        return read_lock(object.sub);
      case kCountersIndex:
        return object.sub == 8 ? parts_.application.read(row) : read_counter(object.sub);
      default:
        return parts_.application.read(row);
    }
  }

  // The history has no entries yet (CiA 301, 7.5.2.4).
  Abort check_read(std::size_t row) override {
    const Object& object = kObjects[row];
    const bool none = object.index == 0x1003 && object.sub > parts_.emergency.count();
    if (none) return Abort::kNoData;
    return object.index < 0x2000 ? Abort::kNone : parts_.application.check_read(row);
  }

  Abort check(std::size_t row, std::uint32_t value) override {
    const Object& object = kObjects[row];
    if (object.storage != Storage::kVolatile && !parts_.may_write()) return Abort::kLocalControl;
    if (object.storage == Storage::kParameter && parts_.application.enabled()) return Abort::kDeviceState;
    if (object.index >= 0x6000) return parts_.application.check(row, value);
    if (is_pdo(object.index)) return parts_.pdos.check(row, value);
    switch (object.index) {
      case 0x1005:
      case 0x1014:
        return check_cob(object.index, parts_.dictionary.value(row), value);
      case 0x1010:
        return value == 0x65766173 ? store(object.sub) : Abort::kCannotStore;  // "save"
      case 0x1011:
        return value == 0x64616F6C ? restore(object.sub) : Abort::kCannotStore;  // "load"
      case 0x1016:
        return parts_.heartbeats.check(row, value);
      case 0x1019:
        if (value == 1) return Abort::kBadValue;  // reserved: a counter counts to 2 at the least
        return parts_.dictionary.value(kRow<0x1006>) != 0 ? Abort::kDeviceState : Abort::kNone;
      case kLockIndex:
        return check_lock(object.sub, value);
      case kProgramControlIndex:
        return parts_.may_write() ? parts_.application.check(row, value) : Abort::kLocalControl;
      default:
        return object.index < 0x2000 ? Abort::kNone : parts_.application.check(row, value);
    }
  }

  void written(std::size_t row, std::uint32_t value) override {
    const Object& object = kObjects[row];
    if (is_pdo(object.index)) return parts_.pdos.written(row);
    switch (object.index) {
      case 0x1003:
        return parts_.emergency.clear_history();
      case 0x1005:
      case 0x1006:
        parts_.sync_producer.restart(parts_.now_us);
        parts_.sync_producer.reset_counter();
        return;
      case 0x1016:
        return parts_.heartbeats.restart(row);
      case 0x1017:
        parts_.heartbeat_timer.restart(parts_.now_us);
        return;
      case kLockIndex:
        if (object.sub == 10) parts_.lock.set_in_use(value != 0);
        return;
      default:
        if (object.index >= 0x2000) parts_.application.written(row, value);
        return;
    }
  }

  void commit() override { parts_.application.commit(); }
  std::uint32_t tick() const override { return parts_.application.tick(); }

  Abort begin_upload(std::size_t row, std::uint32_t& size) override {
    return parts_.application.begin_upload(row, size);
  }
  void upload(std::size_t row, std::uint32_t offset, std::span<std::uint8_t> out) override {
    parts_.application.upload(row, offset, out);
  }
  Abort begin_download(std::size_t row, std::uint32_t size) override {
    if (!parts_.may_write()) return Abort::kLocalControl;
    if (parts_.application.enabled()) return Abort::kDeviceState;
    return parts_.application.begin_download(row, size);
  }
  Abort download(std::size_t row, std::uint32_t offset, std::span<const std::uint8_t> in) override {
    return parts_.application.download(row, offset, in);
  }
  Abort end_download(std::size_t row, std::uint32_t size) override {
    if (!parts_.may_write()) return Abort::kLocalControl;
    if (parts_.application.enabled()) return Abort::kDeviceState;
    return parts_.application.end_download(row, size);
  }

 private:
  static bool is_pdo(std::uint16_t index) { return index >= 0x1400 && index < 0x1C00; }

  std::uint32_t read_counter(std::uint8_t sub) const {
    const RecordSlots& log = parts_.set.log();
    const std::array<std::uint32_t, 12> counters = {0,
                                                    parts_.received,
                                                    parts_.port.status().frames_lost,
                                                    parts_.malformed,
                                                    parts_.sdo.aborts(),
                                                    parts_.outbox.lost(),
                                                    parts_.bus_offs,
                                                    parts_.pdos.refused(),
                                                    0,
                                                    log.sequence(),
                                                    log.erasures(0),
                                                    log.erasures(1)};
    return counters[sub];
  }

  std::uint32_t read_lock(std::uint8_t sub) {
    switch (sub) {
      case 1:
        return static_cast<std::uint32_t>(parts_.lock.state());
      case 2:
        return static_cast<std::uint32_t>(parts_.lock.challenge(
            key(), (static_cast<std::uint64_t>(parts_.now_us) << 32) ^ parts_.received));
      case 3:
        return static_cast<std::uint32_t>(parts_.lock.last_challenge() >> 32);
      default:
        return parts_.dictionary.value(kRow<kLockIndex, 10>);
    }
  }
  AccessLock::Key key() const {
    AccessLock::Key words;
    for (std::size_t i = 0; i < 4; ++i) words[i] = parts_.dictionary.value(kRow<kLockIndex, 6> + i);
    return words;
  }

  static Abort check_cob(std::uint16_t index, std::uint32_t now, std::uint32_t value) {
    const std::uint32_t flags = index == 0x1005 ? 0x40000000U : kInvalidPdo;
    if ((value & ~(flags | 0x7FFU)) != 0) return Abort::kBadValue;
    // While it is in use, the identifier stays.
    const bool in_use = index == 0x1005 ? (now & flags) != 0 : (now & flags) == 0;
    const bool stays = index == 0x1005 ? (value & flags) != 0 : (value & flags) == 0;
    if (in_use && stays && ((now ^ value) & 0x7FF) != 0) return Abort::kBadValue;
    return is_restricted(value & 0x7FF) ? Abort::kBadValue : Abort::kNone;
  }

  Abort store(std::uint8_t sub) {
    if (!parts_.may_write()) return Abort::kLocalControl;
    if (parts_.application.enabled()) return Abort::kDeviceState;  // flash may hold the processor up
    return parts_.set.save(parts_.dictionary, parts_.node, static_cast<Group>(sub)) == StoreStatus::kOk
               ? Abort::kNone
               : Abort::kHardware;
  }
  Abort restore(std::uint8_t sub) {
    if (!parts_.may_write()) return Abort::kLocalControl;
    if (parts_.application.enabled()) return Abort::kDeviceState;
    return parts_.set.restore(static_cast<Group>(sub)) == StoreStatus::kOk ? Abort::kNone : Abort::kHardware;
  }

  Abort check_lock(std::uint8_t sub, std::uint32_t value) {
    if (sub != 5) return Abort::kNone;
    const std::uint64_t response =
        parts_.dictionary.value(kRow<kLockIndex, 4>) | (static_cast<std::uint64_t>(value) << 32);
    return parts_.lock.respond(key(), response, parts_.now_us) ? Abort::kNone : Abort::kLocalControl;
  }

  NodeParts& parts_;
};

}  // namespace slipstack::canopen
