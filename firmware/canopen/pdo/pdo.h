// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/canopen/network/cob_id.h"
#include "firmware/canopen/network/outbox.h"
#include "firmware/canopen/objects/dictionary.h"
#include "firmware/canopen/pdo/pdo_map.h"

namespace slipstack::canopen {

/// The four RPDOs and four TPDOs (CiA 301, 7.2.2). What they are is read from the dictionary; activate()
/// after a change of it.
class Pdos {
 public:
  explicit Pdos(Dictionary& dictionary) : dictionary_(dictionary) {}

  /// Takes all mappings from the dictionary: after a start, or a reset of communication.
  void load() {
    for (std::uint8_t n = 0; n < kPdoCount; ++n) {
      receive_[n] = {};
      transmit_[n] = {};
      static_cast<void>(build(n, true, dictionary_.value(map_row(n, true))));
      static_cast<void>(build(n, false, dictionary_.value(map_row(n, false))));
    }
  }

  /// Whether a value may be written to a communication or mapping object of a PDO.
  Abort check(std::size_t row, std::uint32_t value) {
    const Object& object = kObjects[row];
    const bool receive = object.index < 0x1800;
    const auto n = static_cast<std::uint8_t>(object.index & 0xFF);
    if ((object.index & 0x0200) != 0) return check_mapping(n, receive, object.sub, value);
    const bool off = (dictionary_.value(cob_row(n, receive)) & kInvalidPdo) != 0;
    if (object.sub == 1) {
      if ((value & 0x3FFFF800) != 0) return Abort::kBadValue;  // 11-bit identifiers only
      if (!receive && (value & kNoRemote) == 0) return Abort::kBadValue;
      if ((value & kInvalidPdo) != 0) return Abort::kNone;
      if (!off && ((value ^ dictionary_.value(row)) & 0x7FF) != 0) return Abort::kBadValue;
      // 180h is TPDO 1 of no node.
      return is_restricted(value & 0x7FF) ? Abort::kBadValue : Abort::kNone;
    }
    if (object.sub == 2) {
      // 241 to 251 are reserved; remote requests (252, 253) are not served.
      return value > 240 && value < 254 ? Abort::kBadValue : Abort::kNone;
    }
    if (object.sub == 3 || object.sub == 6) return off ? Abort::kNone : Abort::kUnsupportedAccess;
    return Abort::kNone;
  }

  /// A value was written to such an object.
  void written(std::size_t row) {
    const Object& object = kObjects[row];
    const auto n = static_cast<std::uint8_t>(object.index & 0xFF);
    const bool receive = object.index < 0x1800;
    if ((object.index & 0x0200) != 0) {
      if (object.sub == 0) static_cast<void>(build(n, receive, dictionary_.value(row)));
    } else if (!receive && (object.sub == 1 || object.sub == 2 || object.sub == 6)) {
      transmit_[n].restart();
    } else if (receive) {
      receive_[n].held = receive_[n].watched = false;
    }
  }

  /// How a frame fitted what is mapped (CiA 301, 7.2.2.5.1): a longer one is taken, without its tail.
  enum class Fit : std::uint8_t { kNotMapped, kRight, kTooShort, kTooLong };

  /// A frame in operational.
  Fit receive(const CanFrame& frame, std::uint32_t now_us) {
    Fit fit = Fit::kNotMapped;
    for (std::uint8_t n = 0; n < kPdoCount; ++n) {
      const std::size_t row = cob_row(n, true);
      const std::uint32_t cob = dictionary_.value(row);
      if ((cob & kInvalidPdo) != 0 || (cob & 0x7FF) != frame.id) continue;
      Receive& pdo = receive_[n];
      if (frame.length < pdo.map.bytes()) {
        fit = Fit::kTooShort;
        continue;
      }
      if (fit != Fit::kTooShort) fit = frame.length > pdo.map.bytes() ? Fit::kTooLong : Fit::kRight;
      pdo.last_us = now_us;
      pdo.watched = true;
      if (dictionary_.value(row + 1) <= 240) {
        pdo.data = frame.data;
        pdo.held = true;  // until SYNC
      } else {
        const std::uint8_t taken = pdo.map.unpack(dictionary_, frame.data, refused_);
        pdo.map.announce(dictionary_, taken);
        dictionary_.access().commit();
      }
    }
    return fit;
  }

  /// The first RPDO, 1 to 4, that has not come for longer than its event timer since it last did; 0: none.
  std::uint8_t late(std::uint32_t now_us) {
    for (std::uint8_t n = 0; n < kPdoCount; ++n) {
      const std::size_t row = cob_row(n, true);
      const std::uint32_t limit_us = dictionary_.value(row + 2) * 1000U;
      if (limit_us == 0 || (dictionary_.value(row) & kInvalidPdo) != 0) receive_[n].watched = false;
      if (receive_[n].watched && now_us - receive_[n].last_us > limit_us) {
        return static_cast<std::uint8_t>(n + 1);
      }
    }
    return 0;
  }

  /// SYNC: what was received takes effect, then what is due is sent.
  void sync(std::uint8_t counter, std::uint32_t now_us, Outbox& out) {
    for (Receive& pdo : receive_) {
      pdo.taken = pdo.held ? pdo.map.unpack(dictionary_, pdo.data, refused_) : std::uint8_t{0};
      pdo.held = false;
    }
    for (const Receive& pdo : receive_) pdo.map.announce(dictionary_, pdo.taken);
    dictionary_.access().commit();
    for (std::uint8_t n = 0; n < kPdoCount; ++n) {
      const std::uint32_t type = dictionary_.value(cob_row(n, false) + 1);
      if (type > 240 || !enabled(n)) continue;
      Transmit& pdo = transmit_[n];
      if (!pdo.started && !starts(n, type, counter)) continue;
      if (type == 0) {
        if (changed(n)) send(n, now_us, out);
      } else if (++pdo.syncs >= type) {
        pdo.syncs = 0;
        send(n, now_us, out);
      }
    }
  }

  /// Whether the last SYNC took an object from an RPDO.
  bool took_at_sync(std::size_t row) const {
    for (const Receive& pdo : receive_) {
      if (pdo.map.took(row, pdo.taken)) return true;
    }
    return false;
  }

  /// Event-driven TPDOs: on change, and by the event timer; never within the inhibit time.
  void step(std::uint32_t now_us, Outbox& out) {
    for (std::uint8_t n = 0; n < kPdoCount; ++n) {
      const std::size_t row = cob_row(n, false);
      if (!enabled(n) || dictionary_.value(row + 1) < 254) continue;
      Transmit& pdo = transmit_[n];
      const std::uint32_t since_us = now_us - pdo.last_us;
      if (pdo.sent_once && since_us < dictionary_.value(row + 2) * 100U) continue;
      const std::uint32_t event_us = dictionary_.value(row + 3) * 1000U;
      const bool due = event_us != 0 && pdo.sent_once && since_us >= event_us;
      if (due || !pdo.sent_once || changed(n)) send(n, now_us, out);
    }
  }

  /// Entering operational: every event-driven TPDO is sent once.
  void restart() {
    for (Transmit& pdo : transmit_) pdo.restart();
    for (Receive& pdo : receive_) pdo.held = pdo.watched = false;
  }

  /// Whether a TPDO in use has this identifier.
  bool sends(std::uint32_t id) const {
    for (std::uint8_t n = 0; n < kPdoCount; ++n) {
      if (enabled(n) && (dictionary_.value(cob_row(n, false)) & 0x7FF) == id) return true;
    }
    return false;
  }

  std::uint32_t refused() const { return refused_; }

 private:
  struct Receive {
    PdoMap map;
    std::array<std::uint8_t, 8> data{};
    std::uint32_t last_us = 0;
    std::uint8_t taken = 0;  // by the last SYNC, a bit for each entry
    bool held = false;
    bool watched = false;  // came once, since it is in use with an event timer
  };
  struct Transmit {
    PdoMap map;
    std::array<std::uint8_t, 8> last{};
    std::uint32_t last_us = 0;
    std::uint32_t syncs = 0;
    bool started = false;
    bool sent_once = false;
    void restart() {
      syncs = 0;
      started = sent_once = false;
    }
  };

  // Sub-index 1 of the communication record; 2 follows, then in an RPDO 5, in a TPDO 3, 5 and 6.
  static std::size_t cob_row(std::uint8_t n, bool receive) {
    return receive ? kRow<0x1400, 1> + std::size_t{4} * n : kRow<0x1800, 1> + std::size_t{6} * n;
  }
  static std::size_t map_row(std::uint8_t n, bool receive) {
    return (receive ? kRow<0x1600> : kRow<0x1A00>)+std::size_t{kMappedLargest + 1U} * n;
  }

  bool enabled(std::uint8_t n) const {
    return (dictionary_.value(cob_row(n, false)) & kInvalidPdo) == 0 && transmit_[n].map.bytes() > 0;
  }

  Abort check_mapping(std::uint8_t n, bool receive, std::uint8_t sub, std::uint32_t value) {
    if ((dictionary_.value(cob_row(n, receive)) & kInvalidPdo) == 0) return Abort::kUnsupportedAccess;
    if (sub != 0) {
      if (dictionary_.value(map_row(n, receive)) != 0) return Abort::kUnsupportedAccess;
      return value == 0 ? Abort::kNone : PdoMap::check_entry(value, receive);
    }
    PdoMap trial;
    const auto all = entries(n, receive);
    return trial.build(std::span(all).first(value), receive);
  }

  std::array<std::uint32_t, kMappedLargest> entries(std::uint8_t n, bool receive) const {
    std::array<std::uint32_t, kMappedLargest> all;
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = dictionary_.value(map_row(n, receive) + 1 + i);
    return all;
  }

  Abort build(std::uint8_t n, bool receive, std::uint32_t count) {
    const auto all = entries(n, receive);
    PdoMap& map = receive ? receive_[n].map : transmit_[n].map;
    return map.build(std::span(all).first(count <= kMappedLargest ? count : 0U), receive);
  }

  // With a SYNC start value, the first SYNC that counts is the one with this counter.
  bool starts(std::uint8_t n, std::uint32_t type, std::uint8_t counter) {
    const std::uint32_t start = dictionary_.value(cob_row(n, false) + 4);
    if (start != 0 && counter != 0 && counter != start) return false;
    transmit_[n].started = true;
    if (start != 0 && counter != 0 && type != 0) transmit_[n].syncs = type - 1;
    return true;
  }

  bool changed(std::uint8_t n) {
    std::array<std::uint8_t, 8> now{};
    transmit_[n].map.pack(dictionary_, now);
    return !transmit_[n].sent_once || now != transmit_[n].last;
  }

  void send(std::uint8_t n, std::uint32_t now_us, Outbox& out) {
    Transmit& pdo = transmit_[n];
    std::array<std::uint8_t, 8> now{};
    pdo.map.pack(dictionary_, now);
    if (!out.push(dictionary_.value(cob_row(n, false)) & 0x7FF, std::span(now).first(pdo.map.bytes())))
      return;
    pdo.last = now;
    pdo.last_us = now_us;
    pdo.sent_once = true;
  }

  Dictionary& dictionary_;
  std::array<Receive, kPdoCount> receive_;
  std::array<Transmit, kPdoCount> transmit_;
  std::uint32_t refused_ = 0;
};

}  // namespace slipstack::canopen
