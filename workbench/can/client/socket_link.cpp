// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/client/socket_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <utility>

#include "hal/socketcan/socket_can.h"
#include "workbench/base/text.h"
#include "workbench/console/output.h"

namespace slipstack::workbench {
namespace {

class SocketLink final : public CanLink {
 public:
  SocketLink(const std::string& interface, std::string called)
      : name_(interface), called_(std::move(called)) {
    const std::string error = socket_.open(interface);
    if (!error.empty()) throw UsageError(fmt::format("{} {}: {}", called_, printable(interface), error));
  }
  void send(const CanFrame& frame) override {
    for (int i = 0; i < 100; ++i) {
      if (socket_.send(frame)) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // the transmit queue is full
    }
    throw UsageError(fmt::format("{} {}: no frame goes out; is the interface up, and is another node there?",
                                 called_, printable(name_)));
  }
  bool receive(CanFrame& frame, int timeout_ms) override {
    if (socket_.receive(frame)) return true;
    return socket_.wait(timeout_ms) && socket_.receive(frame);
  }
  void listen_to(std::span<const std::uint32_t> ids) override { socket_.listen_to(ids); }
  double stamp_s() const override { return socket_.stamp_s(); }
  std::string name() const override { return name_; }

 private:
  std::string name_;
  std::string called_;
  SocketCan socket_;
};

}  // namespace

std::unique_ptr<CanLink> open_link(const std::string& interface, const std::string& called) {
  return std::make_unique<SocketLink>(interface, called);
}

std::vector<std::string> can_interfaces() {
  constexpr int kCan = 280;  // ARPHRD_CAN of linux/if_arp.h
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/sys/class/net", error)) {
    int type = 0;
    if (std::ifstream(entry.path() / "type") >> type && type == kCan) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace slipstack::workbench
