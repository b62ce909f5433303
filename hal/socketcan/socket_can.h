// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <span>
#include <string>

#include "hal/include/can_port.h"

namespace slipstack {

/// A CAN interface of Linux (AF_CAN, raw): classic frames, error frames, filters, the kernel's time stamps.
/// No call waits but wait().
///
/// Bus-off is left by the kernel (`ip link set can0 type can restart-ms 100`), which alone may: recover()
/// only notes that it is awaited.
class SocketCan final : public CanPort {
 public:
  SocketCan() = default;
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;
  ~SocketCan() { close(); }

  /// Empty when it worked, else one line.
  std::string open(const std::string& interface) {
    close();
    if (interface.empty() || interface.size() >= IFNAMSIZ) return "no name of a CAN interface";
    socket_ = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (socket_ < 0) return "this kernel has no CAN sockets (load the modules can, can_raw and vcan)";
    ifreq request{};
    std::memcpy(request.ifr_name, interface.c_str(), interface.size());
    if (::ioctl(socket_, SIOCGIFINDEX, &request) < 0) {
      close();
      return "there is no such interface; `ip link` lists them";
    }
    const can_err_mask_t errors = CAN_ERR_BUSOFF | CAN_ERR_CRTL | CAN_ERR_RESTARTED | CAN_ERR_LOSTARB;
    const int on = 1;
    ::setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors);
    ::setsockopt(socket_, SOL_SOCKET, SO_TIMESTAMP, &on, sizeof on);
    ::setsockopt(socket_, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = request.ifr_ifindex;
    if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) < 0) {
      std::string reason = std::strerror(errno);
      close();
      return reason;
    }
    return {};
  }

  /// Only these 11-bit identifiers from now on; none: all.
  void listen_to(std::span<const std::uint32_t> ids) {
    can_filter filters[16] = {};
    const std::size_t count = ids.size() < 16 ? ids.size() : 16;
    for (std::size_t i = 0; i < count; ++i) filters[i] = {ids[i], CAN_SFF_MASK | CAN_EFF_FLAG};
    if (count == 0) filters[0] = {0, 0};
    ::setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_FILTER, filters,
                 static_cast<socklen_t>((count == 0 ? 1 : count) * sizeof(can_filter)));
  }

  bool send(const CanFrame& frame) override {
    can_frame raw{};
    raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) | (frame.remote ? CAN_RTR_FLAG : 0U);
    raw.can_dlc = frame.length;
    std::memcpy(raw.data, frame.data.data(), sizeof raw.data);
    return ::write(socket_, &raw, sizeof raw) == static_cast<ssize_t>(sizeof raw);
  }

  bool receive(CanFrame& frame) override {
    for (int i = 0; i < 16; ++i) {  // error frames in between are taken in
      can_frame raw{};
      alignas(cmsghdr) char control[128];
      iovec part{&raw, sizeof raw};
      msghdr message{};
      message.msg_iov = &part;
      message.msg_iovlen = 1;
      message.msg_control = control;
      message.msg_controllen = sizeof control;
      const ssize_t got = ::recvmsg(socket_, &message, 0);
      if (got != static_cast<ssize_t>(sizeof raw)) {
        down_ = got < 0 && errno != EAGAIN && errno != EINTR;
        return false;
      }
      down_ = false;
      take_ancillary(message);
      if ((raw.can_id & CAN_ERR_FLAG) != 0) {
        take_error(raw);
        continue;
      }
      frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
      frame.remote = (raw.can_id & CAN_RTR_FLAG) != 0;
      frame.id = raw.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
      frame.length = raw.can_dlc < 8 ? raw.can_dlc : std::uint8_t{8};
      std::memcpy(frame.data.data(), raw.data, sizeof raw.data);
      return true;
    }
    return false;
  }

  /// Waits for a frame; false after `timeout_ms`.
  bool wait(int timeout_ms) const {
    pollfd entry{socket_, POLLIN, 0};
    return ::poll(&entry, 1, timeout_ms) > 0;
  }

  CanBusStatus status() const override { return status_; }
  void recover() override {}
  /// When the kernel took the last frame in, seconds since 1970.
  double stamp_s() const { return stamp_s_; }
  /// The interface went away or is down.
  bool down() const { return down_; }

 private:
  void close() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }

  void take_ancillary(msghdr& message) {
    for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
      if (part->cmsg_level != SOL_SOCKET) continue;
      if (part->cmsg_type == SO_TIMESTAMP) {
        timeval time{};
        std::memcpy(&time, CMSG_DATA(part), sizeof time);
        stamp_s_ = static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
      } else if (part->cmsg_type == SO_RXQ_OVFL) {
        std::memcpy(&status_.frames_lost, CMSG_DATA(part), sizeof status_.frames_lost);
      }
    }
  }

  // linux/can/error.h.
  void take_error(const can_frame& raw) {
    if ((raw.can_id & CAN_ERR_BUSOFF) != 0) status_.state = CanBusState::kOff;
    if ((raw.can_id & CAN_ERR_RESTARTED) != 0) status_.state = CanBusState::kActive;
    if ((raw.can_id & CAN_ERR_CRTL) != 0) {
      const unsigned what = raw.data[1];
      if ((what & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
        status_.state = CanBusState::kPassive;
      } else if ((what & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) {
        status_.state = CanBusState::kWarning;
      } else if ((what & CAN_ERR_CRTL_ACTIVE) != 0) {
        status_.state = CanBusState::kActive;
      }
      status_.transmit_errors = raw.data[6];
      status_.receive_errors = raw.data[7];
    }
  }

  int socket_ = -1;
  bool down_ = false;
  double stamp_s_ = 0.0;
  CanBusStatus status_;
};

}  // namespace slipstack
