// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "workbench/base/errors.h"
#include "workbench/can/client/can_link.h"

namespace slipstack::workbench {

/// The node refused a transfer or ended it.
class SdoAbort : public UsageError {
 public:
  SdoAbort(std::uint8_t node, std::uint16_t index, std::uint8_t sub, std::uint32_t code);
  /// Not the object refused: frames were lost on the way (CiA 301 table 22).
  bool of_transport() const { return code_ >> 24U == 0x05; }
  /// The node has no object with this index (CiA 301 table 22).
  bool of_missing_object() const { return code_ == 0x06020000; }

 private:
  std::uint32_t code_;
};

/// An SDO client (CiA 301, 7.2.4): expedited for values, block transfer for domains.
/// Throws UsageError, one line, when the node does not answer or refuses.
///
/// A node has one server: where several clients of this program ask it from different threads, each on a link
/// of its own, they share a mutex `turn`, which is held for the length of a transfer.
class SdoClient {
 public:
  SdoClient(CanLink& link, std::uint8_t node, std::mutex* turn = nullptr)
      : link_(link), node_(node), turn_(turn) {
    listen_also_to({});
  }

  /// Beside the server's answers, frames with these identifiers are received.
  void listen_also_to(std::initializer_list<std::uint32_t> ids) {
    std::vector<std::uint32_t> all(ids);
    all.push_back(0x580U + node_);
    link_.listen_to(all);
  }

  /// Before the first request: waits for a node that is still starting, 3 s at most.
  void await_node();

  std::uint32_t read(std::uint16_t index, std::uint8_t sub);
  double read_real(std::uint16_t index, std::uint8_t sub);
  void write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes);
  void write_real(std::uint16_t index, std::uint8_t sub, double value);
  /// The same, but a refusal is returned as abort code and not thrown; 0 when accepted.
  std::uint32_t try_write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes);

  using Watch = std::function<void(double fraction)>;
  /// Block upload; segments that are lost are requested again, and the whole up to two times more where it
  /// timed out or its checksum is wrong. `watch` begins anew with each.
  std::vector<std::uint8_t> upload(std::uint16_t index, std::uint8_t sub, const Watch& watch = {});
  void download(std::uint16_t index, std::uint8_t sub, const std::vector<std::uint8_t>& data,
                const Watch& watch = {});

  void nmt(std::uint8_t command);
  std::uint8_t node() const { return node_; }
  CanLink& link() { return link_; }

  /// Throws UsageError: "node N: why".
  [[noreturn]] void fail(const std::string& why) const;

 private:
  using Frame = std::array<std::uint8_t, 8>;
  std::unique_lock<std::mutex> take_turn() const {
    return turn_ != nullptr ? std::unique_lock(*turn_) : std::unique_lock<std::mutex>();
  }
  void send(const Frame& data);
  [[noreturn]] void silent(const char* hint) const;
  Frame answer(std::uint16_t index, std::uint8_t sub);
  bool next(Frame& data, int timeout_ms);
  bool next_of(Frame& frame, int timeout_ms, std::uint16_t index, std::uint8_t sub);
  void drain();
  std::optional<std::vector<std::uint8_t>> upload_once(std::uint16_t index, std::uint8_t sub,
                                                       const Watch& watch);
  void take_block(std::vector<std::uint8_t>& data, std::uint16_t index, std::uint8_t sub);
  std::uint8_t send_block(const std::vector<std::uint8_t>& data, std::size_t at, std::uint8_t block);
  void expect(const Frame& frame, std::uint8_t mask, std::uint8_t command, std::uint16_t index,
              std::uint8_t sub) const;
  [[noreturn]] void wrong(std::uint16_t index, std::uint8_t sub) const;
  [[noreturn]] void refuse(std::uint16_t index, std::uint8_t sub, std::uint32_t code) const;

  CanLink& link_;
  std::uint8_t node_;
  std::mutex* turn_;
};

/// The meaning of an abort code (CiA 301 table 22).
std::string abort_text(std::uint32_t code);

}  // namespace slipstack::workbench
