// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "firmware/canopen/access_lock.h"
#include "firmware/canopen/counter.h"
#include "firmware/canopen/dictionary.h"
#include "firmware/canopen/emergency.h"
#include "firmware/canopen/heartbeat.h"
#include "firmware/canopen/lss.h"
#include "firmware/canopen/outbox.h"
#include "firmware/canopen/parameter_set.h"
#include "firmware/canopen/pdo.h"
#include "firmware/canopen/sdo_server.h"
#include "hal/include/can_port.h"

namespace slipstack::canopen {

/// What the node serves: the objects from 2000h on, and what communication means to it.
class Application : public Behind {
 public:
  /// Parameters in the dictionary are new: after a start or a reset.
  virtual void reset(Dictionary& dictionary) = 0;
  /// Once in every poll.
  virtual void step(std::uint32_t now_us) = 0;
  /// The error code of the active fault, 0 if there is none.
  virtual std::uint16_t error_code() = 0;
  virtual bool enabled() = 0;
  /// A SYNC came, and what PDOs held until then has been taken.
  virtual void synchronise() = 0;
  /// Bus-off, a lost heartbeat, NMT stop: act after 6007h.
  virtual void connection_lost() = 0;
  virtual void set_operational(bool operational) = 0;
  virtual std::uint32_t serial_number() const = 0;

 protected:
  ~Application() = default;
};

/// A CANopen device (CiA 301): NMT, heartbeat, SDO, PDO, SYNC, EMCY, LSS, stored parameters, access lock.
///
/// poll() from the main loop, never from the tick: at most kFramesPerPoll frames are taken from the port and
/// kBlockFramesPerPoll segments of a block upload sent; time is passed in, in us modulo 2^32.
class Node final : private Behind {
 public:
  static constexpr int kFramesPerPoll = 16;
  static constexpr int kBlockFramesPerPoll = 8;
  static constexpr std::uint32_t kBusOffWait_us = 100'000;  ///< before the port recovers
  static constexpr std::uint32_t kEventHeld_us =
      1'000'000;  ///< how long a lost frame, or another's, is an error

  Node(CanPort& port, SlotLog& storage, Application& application)
      : port_(port),
        application_(application),
        set_(storage),
        dictionary_(*this),
        sdo_(dictionary_),
        pdos_(dictionary_),
        heartbeats_(dictionary_) {}

  /// At the start: reads what is stored. `node`: the id if none is stored, FFh to wait for LSS.
  void start(std::uint8_t node, std::uint32_t now_us) {
    set_.mount();
    set_.load(dictionary_, 0);
    const std::uint32_t stored = dictionary_.value(kRow<kNodeIndex, 1>);
    const auto rate = static_cast<std::uint8_t>(dictionary_.value(kRow<kNodeIndex, 2>));
    lss_.begin(stored >= 1 && stored <= 127 ? static_cast<std::uint8_t>(stored) : node, rate);
    // A port that offers no rates has one from elsewhere.
    static_cast<void>(port_.set_bit_rate(Lss::bits_per_s(rate)));
    reset_node(now_us);
  }

  void poll(std::uint32_t now_us) {
    if (switching_ != Switching::kNo && !switched(now_us)) return stay_silent(now_us);
    outbox_.flush(port_);
    watch_bus(now_us);
    CanFrame frame;
    for (int i = 0; i < kFramesPerPoll && switching_ == Switching::kNo && port_.receive(frame); ++i) {
      count(received_);
      take(frame, now_us);
    }
    application_.step(now_us);
    if (switching_ != Switching::kNo) return;
    if (node_ != Lss::kUnconfigured) step(now_us);
    outbox_.flush(port_);
  }

  NmtState state() const { return state_; }
  std::uint8_t id() const { return node_; }
  Dictionary& dictionary() { return dictionary_; }
  const AccessLock& lock() const { return lock_; }

 private:
  // ---- frames in ----

  void take(const CanFrame& frame, std::uint32_t now_us) {
    if (frame.extended || frame.remote || frame.id > 0x7FF || frame.length > 8) {
      if (frame.length > 8) count(malformed_);
      return;  // neither remote requests nor 29-bit identifiers are served
    }
    if (frame.id == Lss::kRequest) return take_lss(frame, now_us);
    if (node_ == Lss::kUnconfigured) return;
    if (frame.id == 0) return take_nmt(frame, now_us);
    if (frame.id == 0x600U + node_) return take_sdo(frame, now_us);
    if (frame.id == (dictionary_.value(kRow<0x1005>) & 0x7FF)) return take_sync(frame, now_us);
    if (is_own(frame.id)) {
      emergency_.set(ErrorSource::kCollision, 0x8150, frame.id);
      collision_us_ = now_us;
      return;
    }
    if (frame.id > 0x700 && frame.id < 0x780) {
      if (frame.length == 1) heartbeats_.receive(static_cast<std::uint8_t>(frame.id & 0x7F), now_us);
      return;
    }
    if (state_ != NmtState::kOperational) return;
    const Pdos::Fit fit = pdos_.receive(frame, now_us);
    if (fit == Pdos::Fit::kNobodys) return;
    // 8210h: not processed due to length error; 8220h: length exceeded.
    if (fit != Pdos::Fit::kRight) count(malformed_);
    const std::uint16_t code = fit == Pdos::Fit::kRight ? 0 : fit == Pdos::Fit::kTooShort ? 0x8210 : 0x8220;
    emergency_.set(ErrorSource::kPdoLength, code, frame.id);
  }

  // Identifiers that only this node may send: somebody else has its node id, or one of its PDOs'.
  bool is_own(std::uint32_t id) const {
    const std::uint32_t emergency = dictionary_.value(kRow<0x1014>);
    return id == 0x580U + node_ || id == 0x700U + node_ ||
           ((emergency & kInvalidPdo) == 0 && id == (emergency & 0x7FF)) ||
           (state_ == NmtState::kOperational && pdos_.sends(id));
  }

  void take_nmt(const CanFrame& frame, std::uint32_t now_us) {
    if (frame.length != 2) return count(malformed_);
    if (frame.data[1] != 0 && frame.data[1] != node_) return;
    switch (frame.data[0]) {
      case 1:
        return enter(NmtState::kOperational);
      case 2:
        return enter(NmtState::kStopped);
      case 128:
        return enter(NmtState::kPreOperational);
      case 129:
        return reset_node(now_us);
      case 130:
        return reset_communication(now_us);
      default:
        return count(malformed_);
    }
  }

  void take_sdo(const CanFrame& frame, std::uint32_t now_us) {
    if (frame.length != 8) return count(malformed_);
    if (state_ == NmtState::kStopped) return;
    now_us_ = now_us;
    SdoFrame out;
    if (sdo_.receive(frame.data, now_us, out)) send_sdo(out);
  }
  void send_sdo(const SdoFrame& out) { outbox_.push(0x580U + node_, out); }

  void take_sync(const CanFrame& frame, std::uint32_t now_us) {
    // 8240h: unexpected SYNC data length. By 1019h there is a counter or there is none; without one where it
    // is expected, and with one where it is not, SYNC is still SYNC.
    const bool counted = dictionary_.value(kRow<0x1019>) > 1;
    const bool right = frame.length == (counted ? 1 : 0);
    emergency_.set(ErrorSource::kSyncLength, right ? 0 : 0x8240, frame.length);
    if (frame.length > 1) return count(malformed_);
    sync(right && counted ? frame.data[0] : std::uint8_t{0}, now_us);
  }
  void sync(std::uint8_t counter, std::uint32_t now_us) {
    if (state_ != NmtState::kOperational) return;
    pdos_.sync(counter, now_us, outbox_);
    application_.synchronise();
  }

  void take_lss(const CanFrame& frame, std::uint32_t now_us) {
    if (frame.length != 8) return count(malformed_);
    Lss::Wish wish = Lss::Wish::kNothing;
    SdoFrame out;
    const Lss::Device device{
        {{kVendorId, kProductCode, kRevision, application_.serial_number()}}, node_, may_write(), port_};
    const bool answer = lss_.receive(frame.data, device, out, wish);
    if (wish == Lss::Wish::kStore) {
      dictionary_.set(kRow<kNodeIndex, 1>, lss_.node());
      dictionary_.set(kRow<kNodeIndex, 2>, lss_.bit_rate());
      if (set_.save(dictionary_, node_, Group::kNode) != StoreStatus::kOk) out[1] = 2;
    } else if (wish == Lss::Wish::kActivateBitRate && !application_.enabled()) {
      // Not in motion: for two delays nobody could stop the axis.
      // What waited goes out in the old rate or not at all.
      outbox_.flush(port_);
      outbox_.clear();
      switching_ = Switching::kBefore;
      switch_us_ = now_us;
    }
    if (answer) outbox_.push(Lss::kResponse, out);
    // A node without an id that has got one boots when it is no longer configured (CiA 305, 6.3.3).
    if (node_ == Lss::kUnconfigured && !lss_.configuring() && lss_.node() != Lss::kUnconfigured) {
      reset_communication(now_us_);
    }
  }

  // ---- change of bit rate (CiA 305, activate bit timing) ----

  // After the delay every node changes, and after a second one they talk again: nobody hears two rates.
  bool switched(std::uint32_t now_us) {
    const std::uint32_t delay_us = lss_.switch_delay_ms() * 1000U;
    if (now_us - switch_us_ < delay_us) return false;
    if (switching_ == Switching::kBefore) {
      static_cast<void>(port_.set_bit_rate(Lss::bits_per_s(lss_.bit_rate())));
      switching_ = Switching::kAfter;
      switch_us_ = now_us;
      if (delay_us > 0) return false;
    }
    switching_ = Switching::kNo;
    return true;
  }
  // Nothing is sent, and what comes in is nobody's.
  void stay_silent(std::uint32_t now_us) {
    now_us_ = now_us;
    CanFrame frame;
    for (int i = 0; i < kFramesPerPoll && port_.receive(frame); ++i) {
    }
    application_.step(now_us);
  }

  // ---- states ----

  void enter(NmtState state) {
    if (state == state_) return;
    const bool was_operational = state_ == NmtState::kOperational;
    state_ = state;
    application_.set_operational(state == NmtState::kOperational);
    if (state == NmtState::kOperational) {
      pdos_.restart();
      sync_counter_ = 0;
    } else if (was_operational && state == NmtState::kStopped) {
      application_.connection_lost();
    }
    if (state == NmtState::kStopped) sdo_.reset();
  }

  void reset_node(std::uint32_t now_us) {
    const std::uint8_t node = lss_.node() == Lss::kUnconfigured ? std::uint8_t{0} : lss_.node();
    dictionary_.set_defaults(node);
    set_.load(dictionary_, node);
    application_.reset(dictionary_);
    reset_communication(now_us);
  }

  void reset_communication(std::uint32_t now_us) {
    now_us_ = now_us;
    const bool was_operational = state_ == NmtState::kOperational;
    node_ = lss_.node();
    lss_.begin(node_, lss_.bit_rate());
    if (was_operational) {
      application_.set_operational(false);
      application_.connection_lost();
    }
    load_communication();
    sdo_.reset();
    heartbeats_.reset();
    emergency_.reset_communication();
    frames_lost_ = port_.status().frames_lost;
    pdos_.load();
    pdos_.restart();
    outbox_.clear();
    lock_.set_in_use(dictionary_.value(kRow<kLockIndex, 10>) != 0);
    state_ = NmtState::kInitialising;
    if (node_ == Lss::kUnconfigured) return;
    const std::uint8_t boot_up = 0;
    outbox_.push(0x700U + node_, std::span(&boot_up, 1));
    last_heartbeat_us_ = now_us;
    state_ = NmtState::kPreOperational;
  }

  // Objects 1000h to 1FFFh as stored; the others keep their values.
  void load_communication() {
    Dictionary fresh(*this);
    const std::uint8_t node = node_ == Lss::kUnconfigured ? std::uint8_t{0} : node_;
    fresh.set_defaults(node);
    set_.load(fresh, node);
    for (std::size_t row = 0; row < kObjectCount && kObjects[row].index < 0x2000; ++row) {
      dictionary_.set(row, fresh.value(row));
    }
  }

  // ---- time ----

  void step(std::uint32_t now_us) {
    now_us_ = now_us;
    emergency_.set(ErrorSource::kDrive, application_.error_code());
    step_heartbeats(now_us);
    step_sync(now_us);
    watch_frames(now_us);
    SdoFrame out;
    for (int i = 0; i < kBlockFramesPerPoll && outbox_.room() > 8; ++i) {
      if (!sdo_.next(now_us, out)) break;
      send_sdo(out);
    }
    if (state_ == NmtState::kStopped) return;
    emergency_.step(now_us, dictionary_.value(kRow<0x1014>), dictionary_.value(kRow<0x1015>), outbox_);
    if (state_ == NmtState::kOperational) pdos_.step(now_us, outbox_);
  }

  void step_heartbeats(std::uint32_t now_us) {
    const std::uint32_t period_us = dictionary_.value(kRow<0x1017>) * 1000U;
    if (period_us != 0 && now_us - last_heartbeat_us_ >= period_us) {
      // Kept on its grid, unless polls were missing for a whole period.
      last_heartbeat_us_ =
          now_us - last_heartbeat_us_ < 2 * period_us ? last_heartbeat_us_ + period_us : now_us;
      const auto state = static_cast<std::uint8_t>(state_);
      outbox_.push(0x700U + node_, std::span(&state, 1));
    }
    const std::uint8_t lost = heartbeats_.step(now_us);
    if (lost != 0) {
      emergency_.set(ErrorSource::kHeartbeat, 0x8130, lost);
      communication_failed();
    } else if (!heartbeats_.any_lost()) {
      emergency_.set(ErrorSource::kHeartbeat, 0);
    }
  }

  void step_sync(std::uint32_t now_us) {
    const std::uint32_t cob = dictionary_.value(kRow<0x1005>);
    const std::uint32_t period_us = dictionary_.value(kRow<0x1006>);
    const bool producing = (cob & 0x40000000) != 0 && period_us != 0 && state_ != NmtState::kStopped;
    if (!producing || now_us - last_sync_us_ < period_us) return;
    last_sync_us_ = now_us - last_sync_us_ < 2 * period_us ? last_sync_us_ + period_us : now_us;
    const auto overflow = static_cast<std::uint8_t>(dictionary_.value(kRow<0x1019>));
    std::uint8_t counter = 0;
    if (overflow > 1)
      counter = sync_counter_ =
          sync_counter_ >= overflow ? std::uint8_t{1} : static_cast<std::uint8_t>(sync_counter_ + 1);
    outbox_.push(cob & 0x7FF, std::span(&counter, overflow > 1 ? 1 : 0));
    sync(counter, now_us);
  }

  // Bus-off: a while later the port is asked to come back, which takes 128 x 11 recessive bits (ISO 11898-1).
  void watch_bus(std::uint32_t now_us) {
    const CanBusState bus = port_.status().state;
    if (bus == CanBusState::kOff) {
      if (!bus_off_) {
        bus_off_ = true;
        bus_off_us_ = now_us;
        count(bus_offs_);
        outbox_.clear();
        communication_failed();
      } else if (now_us - bus_off_us_ >= kBusOffWait_us) {
        bus_off_us_ = now_us;
        port_.recover();
      }
    } else if (bus_off_) {
      bus_off_ = false;
      // 8140h: recovered from bus-off.
      emergency_.set(ErrorSource::kBusOff, 0x8140);
      emergency_.set(ErrorSource::kBusOff, 0);
    }
  }

  // Events rather than states: the error is gone when there was none for a while.
  void watch_frames(std::uint32_t now_us) {
    const CanBusStatus bus = port_.status();
    // 8110h: CAN overrun.
    if (bus.frames_lost != frames_lost_) {
      frames_lost_ = bus.frames_lost;
      overrun_us_ = now_us;
      emergency_.set(ErrorSource::kOverrun, 0x8110);
    } else if (now_us - overrun_us_ >= kEventHeld_us) {
      emergency_.set(ErrorSource::kOverrun, 0);
    }
    // 8150h: CAN-ID collision.
    if (now_us - collision_us_ >= kEventHeld_us) emergency_.set(ErrorSource::kCollision, 0);
    // 8120h: CAN in error passive mode.
    emergency_.set(ErrorSource::kPassive, bus.state == CanBusState::kPassive ? 0x8120 : 0);
    // 8250h: RPDO time-out.
    const std::uint8_t late = state_ == NmtState::kOperational ? pdos_.late(now_us) : std::uint8_t{0};
    emergency_.set(ErrorSource::kPdoTimeout, late != 0 ? 0x8250 : 0, late);
  }

  // Error behaviour 1029h, and 6007h.
  void communication_failed() {
    lock_.close();
    application_.connection_lost();
    const std::uint32_t behaviour = dictionary_.value(kRow<0x1029, 1>);
    if (behaviour == 2) {
      enter(NmtState::kStopped);
    } else if (behaviour == 0 && state_ == NmtState::kOperational) {
      enter(NmtState::kPreOperational);
    }
  }

  // ---- behind the dictionary ----

  bool may_write() const { return lock_.allows_writing(); }

  static bool is_pdo(std::uint16_t index) { return index >= 0x1400 && index < 0x1C00; }

  std::uint32_t read(std::size_t row) override {
    const Object& object = kObjects[row];
    switch (object.index) {
      case 0x1001:
        return emergency_.error_register();
      case 0x1003:
        return object.sub == 0 ? emergency_.count() : emergency_.history(object.sub);
      case 0x1010:
      case 0x1011:
        return 1;  // on command
      case 0x1018:
        return application_.serial_number();
      case kLockIndex:
        return read_lock(object.sub);
      case kCountersIndex:
        return object.sub == 8 ? application_.read(row) : read_counter(object.sub);
      default:
        return application_.read(row);
    }
  }

  // The history has no entries yet (CiA 301, 7.5.2.4).
  Abort check_read(std::size_t row) override {
    const Object& object = kObjects[row];
    const bool none = object.index == 0x1003 && object.sub > emergency_.count();
    return none ? Abort::kNoData : Abort::kNone;
  }

  std::uint32_t read_counter(std::uint8_t sub) const {
    const SlotLog& log = set_.log();
    const std::array<std::uint32_t, 12> counters = {0,
                                                    received_,
                                                    port_.status().frames_lost,
                                                    malformed_,
                                                    sdo_.aborts(),
                                                    outbox_.lost(),
                                                    bus_offs_,
                                                    pdos_.refused(),
                                                    0,
                                                    log.sequence(),
                                                    log.erasures(0),
                                                    log.erasures(1)};
    return counters[sub];
  }

  std::uint32_t read_lock(std::uint8_t sub) {
    switch (sub) {
      case 1:
        return static_cast<std::uint32_t>(lock_.state());
      case 2:
        return static_cast<std::uint32_t>(
            lock_.challenge(key(), (static_cast<std::uint64_t>(now_us_) << 32) ^ received_));
      case 3:
        return static_cast<std::uint32_t>(lock_.last_challenge() >> 32);
      default:
        return dictionary_.value(kRow<kLockIndex, 10>);
    }
  }
  AccessLock::Key key() const {
    AccessLock::Key words;
    for (std::size_t i = 0; i < 4; ++i) words[i] = dictionary_.value(kRow<kLockIndex, 6> + i);
    return words;
  }

  Abort check(std::size_t row, std::uint32_t value) override {
    const Object& object = kObjects[row];
    if (object.storage != Storage::kVolatile && !may_write()) return Abort::kLocalControl;
    if (object.storage == Storage::kParameter && application_.enabled()) return Abort::kDeviceState;
    if (object.index >= 0x6000) return application_.check(row, value);
    if (is_pdo(object.index)) return pdos_.check(row, value);
    switch (object.index) {
      case 0x1005:
      case 0x1014:
        return check_cob(object.index, dictionary_.value(row), value);
      case 0x1010:
        return value == 0x65766173 ? store(object.sub) : Abort::kCannotStore;  // "save"
      case 0x1011:
        return value == 0x64616F6C ? restore(object.sub) : Abort::kCannotStore;  // "load"
      case 0x1016:
        return heartbeats_.check(row, value);
      case 0x1019:
        if (value == 1) return Abort::kBadValue;  // reserved: a counter counts to 2 at the least
        return dictionary_.value(kRow<0x1006>) != 0 ? Abort::kDeviceState : Abort::kNone;
      case kLockIndex:
        return check_lock(object.sub, value);
      default:
        return object.index < 0x2000 ? Abort::kNone : application_.check(row, value);
    }
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
    if (!may_write()) return Abort::kLocalControl;
    if (application_.enabled()) return Abort::kDeviceState;  // flash may hold the processor up
    return set_.save(dictionary_, node_, static_cast<Group>(sub)) == StoreStatus::kOk ? Abort::kNone
                                                                                      : Abort::kHardware;
  }
  Abort restore(std::uint8_t sub) {
    if (!may_write()) return Abort::kLocalControl;
    if (application_.enabled()) return Abort::kDeviceState;
    return set_.restore(static_cast<Group>(sub)) == StoreStatus::kOk ? Abort::kNone : Abort::kHardware;
  }

  Abort check_lock(std::uint8_t sub, std::uint32_t value) {
    if (sub != 5) return Abort::kNone;
    const std::uint64_t response =
        dictionary_.value(kRow<kLockIndex, 4>) | (static_cast<std::uint64_t>(value) << 32);
    return lock_.respond(key(), response, now_us_) ? Abort::kNone : Abort::kLocalControl;
  }

  void written(std::size_t row, std::uint32_t value) override {
    const Object& object = kObjects[row];
    if (is_pdo(object.index)) return pdos_.written(row);
    switch (object.index) {
      case 0x1003:
        return emergency_.clear_history();
      case 0x1005:
      case 0x1006:
        last_sync_us_ = now_us_;
        sync_counter_ = 0;
        return;
      case 0x1016:
        return heartbeats_.restart(row);
      case 0x1017:
        last_heartbeat_us_ = now_us_;
        return;
      case kLockIndex:
        if (object.sub == 10) lock_.set_in_use(value != 0);
        return;
      default:
        if (object.index >= 0x2000) application_.written(row, value);
        return;
    }
  }

  Abort begin_upload(std::size_t row, std::uint32_t& size) override {
    return application_.begin_upload(row, size);
  }
  void upload(std::size_t row, std::uint32_t offset, std::span<std::uint8_t> out) override {
    application_.upload(row, offset, out);
  }
  Abort begin_download(std::size_t row, std::uint32_t size) override {
    if (!may_write()) return Abort::kLocalControl;
    if (application_.enabled()) return Abort::kDeviceState;
    return application_.begin_download(row, size);
  }
  Abort download(std::size_t row, std::uint32_t offset, std::span<const std::uint8_t> in) override {
    return application_.download(row, offset, in);
  }
  Abort end_download(std::size_t row, std::uint32_t size) override {
    if (!may_write()) return Abort::kLocalControl;
    if (application_.enabled()) return Abort::kDeviceState;
    return application_.end_download(row, size);
  }

  CanPort& port_;
  Application& application_;
  ParameterSet set_;
  Dictionary dictionary_;
  SdoServer sdo_;
  Pdos pdos_;
  HeartbeatConsumer heartbeats_;
  Emergency emergency_;
  Lss lss_;
  AccessLock lock_;
  Outbox outbox_;
  NmtState state_ = NmtState::kInitialising;
  std::uint8_t node_ = Lss::kUnconfigured;
  std::uint8_t sync_counter_ = 0;
  enum class Switching : std::uint8_t { kNo, kBefore, kAfter };
  Switching switching_ = Switching::kNo;
  std::uint32_t switch_us_ = 0;
  bool bus_off_ = false;
  std::uint32_t bus_off_us_ = 0;
  std::uint32_t bus_offs_ = 0;
  std::uint32_t now_us_ = 0;
  std::uint32_t last_heartbeat_us_ = 0;
  std::uint32_t last_sync_us_ = 0;
  std::uint32_t received_ = 0;
  std::uint32_t malformed_ = 0;
  std::uint32_t frames_lost_ = 0;
  std::uint32_t overrun_us_ = 0;
  std::uint32_t collision_us_ = 0;
};

}  // namespace slipstack::canopen
