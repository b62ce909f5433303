// SPDX-License-Identifier: Apache-2.0
#include "firmware/canopen/node.h"

#include <span>

namespace slipstack::canopen {

Node::Node(CanPort& port, RecordSlots& storage, Application& application)
    : parts_(port, storage, application, objects_) {}

void Node::start(std::uint8_t node, std::uint32_t now_us) {
  parts_.set.mount();
  parts_.set.load(parts_.dictionary, 0);
  const std::uint32_t stored = parts_.dictionary.value(kRow<kNodeIndex, 1>);
  const auto rate = static_cast<std::uint8_t>(parts_.dictionary.value(kRow<kNodeIndex, 2>));
  parts_.lss.begin(stored >= 1 && stored <= 127 ? static_cast<std::uint8_t>(stored) : node, rate);
  // A port that offers no rates has one from elsewhere.
  static_cast<void>(parts_.port.set_bit_rate(Lss::bits_per_s(rate)));
  reset_node(now_us);
}

void Node::poll(std::uint32_t now_us) {
  if (bit_rate_.under_way() && !bit_rate_.finished(now_us)) return stay_silent(now_us);
  parts_.outbox.flush(parts_.port);
  if (bus_.lost_bus(now_us)) enter(react_to_lost_connection(parts_, state_));
  CanFrame frame;
  for (int i = 0; i < kFramesPerPoll && !bit_rate_.under_way() && parts_.port.receive(frame); ++i) {
    count(parts_.received);
    take(frame, now_us);
  }
  parts_.application.step(now_us);
  if (bit_rate_.under_way()) return;
  if (parts_.node != Lss::kUnconfigured) step(now_us);
  parts_.outbox.flush(parts_.port);
}

// ---- frames in ----

void Node::take(const CanFrame& frame, std::uint32_t now_us) {
  if (frame.extended || frame.remote || frame.id > 0x7FF || frame.length > 8) {
    if (frame.length > 8) count(parts_.malformed);
    return;  // neither remote requests nor 29-bit identifiers are served
  }
  if (frame.id == Lss::kRequest) return take_lss(frame, now_us);
  if (parts_.node == Lss::kUnconfigured) return;
  if (frame.id == 0) return take_nmt(frame, now_us);
  if (frame.id == 0x600U + parts_.node) return take_sdo(frame, now_us);
  if (frame.id == (parts_.dictionary.value(kRow<0x1005>) & 0x7FF)) return take_sync(frame, now_us);
  if (is_own(frame.id)) return bus_.collision(frame.id, now_us);
  if (frame.id > 0x700 && frame.id < 0x780) {
    if (frame.length == 1) parts_.heartbeats.receive(static_cast<std::uint8_t>(frame.id & 0x7F), now_us);
    return;
  }
  if (state_ != NmtState::kOperational) return;
  const Pdos::Fit fit = parts_.pdos.receive(frame, now_us);
  if (fit == Pdos::Fit::kNotMapped) return;
  // 8210h: not processed due to length error; 8220h: length exceeded.
  if (fit != Pdos::Fit::kRight) count(parts_.malformed);
  const std::uint16_t code = fit == Pdos::Fit::kRight ? 0 : fit == Pdos::Fit::kTooShort ? 0x8210 : 0x8220;
  parts_.emergency.set(ErrorSource::kPdoLength, code, frame.id);
}

bool Node::is_own(std::uint32_t id) const {
  const std::uint32_t emergency = parts_.dictionary.value(kRow<0x1014>);
  return id == 0x580U + parts_.node || id == 0x700U + parts_.node ||
         ((emergency & kInvalidPdo) == 0 && id == (emergency & 0x7FF)) ||
         (state_ == NmtState::kOperational && parts_.pdos.sends(id));
}

void Node::take_nmt(const CanFrame& frame, std::uint32_t now_us) {
  if (frame.length != 2) return count(parts_.malformed);
  if (frame.data[1] != 0 && frame.data[1] != parts_.node) return;
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
      return count(parts_.malformed);
  }
}

void Node::take_sdo(const CanFrame& frame, std::uint32_t now_us) {
  if (frame.length != 8) return count(parts_.malformed);
  if (state_ == NmtState::kStopped) return;
  parts_.now_us = now_us;
  SdoFrame out;
  if (parts_.sdo.receive(frame.data, now_us, out)) send_sdo(out);
}

void Node::take_sync(const CanFrame& frame, std::uint32_t now_us) {
  // 8240h: unexpected SYNC data length. By 1019h there is a counter or there is none; without one where it
  // is expected, and with one where it is not, SYNC is still SYNC.
  const bool counted = parts_.dictionary.value(kRow<0x1019>) > 1;
  const bool right = frame.length == (counted ? 1 : 0);
  parts_.emergency.set(ErrorSource::kSyncLength, right ? 0 : 0x8240, frame.length);
  if (frame.length > 1) return count(parts_.malformed);
  sync(right && counted ? frame.data[0] : std::uint8_t{0}, now_us);
}

void Node::sync(std::uint8_t counter, std::uint32_t now_us) {
  if (state_ != NmtState::kOperational) return;
  parts_.pdos.sync(counter, now_us, parts_.outbox);
  parts_.application.synchronise(parts_.pdos);
}

void Node::take_lss(const CanFrame& frame, std::uint32_t now_us) {
  if (frame.length != 8) return count(parts_.malformed);
  Lss::Wish wish = Lss::Wish::kNothing;
  SdoFrame out;
  const Lss::Device device{{{kVendorId, kProductCode, kRevision, parts_.application.serial_number()}},
                           parts_.node,
                           parts_.may_write(),
                           parts_.port};
  const bool answer = parts_.lss.receive(frame.data, device, out, wish);
  if (wish == Lss::Wish::kStore && parts_.application.enabled()) {
    out[1] = 2;  // flash may hold the processor up
  } else if (wish == Lss::Wish::kStore) {
    parts_.dictionary.set(kRow<kNodeIndex, 1>, parts_.lss.node());
    parts_.dictionary.set(kRow<kNodeIndex, 2>, parts_.lss.bit_rate());
    if (parts_.set.save(parts_.dictionary, parts_.node, Group::kNode) != StoreStatus::kOk) out[1] = 2;
  } else if (wish == Lss::Wish::kActivateBitRate && !parts_.application.enabled()) {
    // Not in motion: during two delays no master could stop the axis.
    bit_rate_.begin(now_us);
  }
  if (answer) parts_.outbox.push(Lss::kResponse, out);
  // A node without an id that has got one boots when it is no longer configured (CiA 305, 6.3.3).
  if (parts_.node == Lss::kUnconfigured && !parts_.lss.configuring() &&
      parts_.lss.node() != Lss::kUnconfigured) {
    reset_communication(parts_.now_us);
  }
}

void Node::stay_silent(std::uint32_t now_us) {
  parts_.now_us = now_us;
  CanFrame frame;
  for (int i = 0; i < kFramesPerPoll && parts_.port.receive(frame); ++i) {
  }
  parts_.application.step(now_us);
}

// ---- states ----

void Node::enter(NmtState state) {
  if (state == state_) return;
  const bool was_operational = state_ == NmtState::kOperational;
  state_ = state;
  parts_.application.set_operational(state == NmtState::kOperational);
  if (state == NmtState::kOperational) {
    parts_.pdos.restart();
    parts_.sync_producer.reset_counter();
  } else if (was_operational && state == NmtState::kStopped) {
    parts_.application.connection_lost();
  }
  if (state == NmtState::kStopped) parts_.sdo.reset();
}

void Node::reset_node(std::uint32_t now_us) {
  const std::uint8_t node = parts_.lss.node() == Lss::kUnconfigured ? std::uint8_t{0} : parts_.lss.node();
  parts_.dictionary.set_defaults(node);
  parts_.set.load(parts_.dictionary, node);
  parts_.application.reset(parts_.dictionary);
  reset_communication(now_us);
}

void Node::reset_communication(std::uint32_t now_us) {
  parts_.now_us = now_us;
  const bool was_operational = state_ == NmtState::kOperational;
  parts_.node = parts_.lss.node();
  parts_.lss.begin(parts_.node, parts_.lss.bit_rate());
  if (was_operational) {
    parts_.application.set_operational(false);
    parts_.application.connection_lost();
  }
  load_communication();
  parts_.sdo.reset();
  parts_.heartbeats.reset();
  parts_.emergency.reset_communication();
  bus_.reset();
  parts_.pdos.load();
  parts_.pdos.restart();
  parts_.outbox.clear();
  parts_.lock.set_in_use(parts_.dictionary.value(kRow<kLockIndex, 10>) != 0);
  state_ = NmtState::kInitialising;
  if (parts_.node == Lss::kUnconfigured) return;
  const std::uint8_t boot_up = 0;
  parts_.outbox.push(0x700U + parts_.node, std::span(&boot_up, 1));
  parts_.heartbeat_timer.restart(now_us);
  state_ = NmtState::kPreOperational;
}

void Node::load_communication() {
  constexpr std::size_t kEnd = kRow<kAxisIndex>;
  static_assert(kObjects[kEnd - 1].index < 0x2000 && kObjects[kEnd].index == 0x2000);
  const std::uint8_t node = parts_.node == Lss::kUnconfigured ? std::uint8_t{0} : parts_.node;
  for (std::size_t row = 0; row < kEnd; ++row) {
    parts_.dictionary.set(row, Dictionary::default_of(row, node));
  }
  parts_.set.load(parts_.dictionary, node, kEnd);
}

// ---- time ----

void Node::step(std::uint32_t now_us) {
  parts_.now_us = now_us;
  parts_.emergency.set(ErrorSource::kDrive, parts_.application.error_code());
  // FF01h: of the device; the axis hunts (2202h).
  const std::uint32_t hunting = parts_.application.warning();
  parts_.emergency.set(ErrorSource::kHunting, hunting != 0 ? 0xFF01 : 0, hunting);
  step_heartbeats(now_us);
  step_sync(now_us);
  if (bus_.watch_frames(now_us, state_ == NmtState::kOperational)) parts_.application.connection_lost();
  SdoFrame out;
  for (int i = 0; i < kBlockFramesPerPoll && parts_.outbox.room() > 8; ++i) {
    if (!parts_.sdo.next(now_us, out)) break;
    send_sdo(out);
  }
  if (state_ == NmtState::kStopped) return;
  parts_.emergency.step(now_us, parts_.dictionary.value(kRow<0x1014>), parts_.dictionary.value(kRow<0x1015>),
                        parts_.outbox);
  if (state_ == NmtState::kOperational) parts_.pdos.step(now_us, parts_.outbox);
}

void Node::step_heartbeats(std::uint32_t now_us) {
  if (parts_.heartbeat_timer.due(now_us, parts_.dictionary.value(kRow<0x1017>) * 1000U)) {
    const auto state = static_cast<std::uint8_t>(state_);
    parts_.outbox.push(0x700U + parts_.node, std::span(&state, 1));
  }
  const std::uint8_t lost = parts_.heartbeats.step(now_us);
  if (lost != 0) {
    parts_.emergency.set(ErrorSource::kHeartbeat, 0x8130, lost);
    enter(react_to_lost_connection(parts_, state_));
  } else if (!parts_.heartbeats.any_lost()) {
    parts_.emergency.set(ErrorSource::kHeartbeat, 0);
  }
}

void Node::step_sync(std::uint32_t now_us) {
  std::uint8_t counter = 0;
  if (state_ == NmtState::kStopped) return;
  if (parts_.sync_producer.step(parts_.dictionary, now_us, parts_.outbox, counter)) sync(counter, now_us);
}

}  // namespace slipstack::canopen
