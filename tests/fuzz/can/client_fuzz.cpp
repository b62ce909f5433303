// SPDX-License-Identifier: Apache-2.0
// libFuzzer target: whatever a node answers, or somebody else in its name, the commands' master ends, says
// one line, and a log that it writes holds as many rows as it says.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

#include "workbench/can/commands/master.h"
#include "workbench/console/output.h"

namespace {

using namespace slipstack;
using namespace slipstack::workbench;

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "client_fuzz: %s\n", what);
  std::abort();
}

/// A node whose answers come from the input: echoes of the request's object with a command and data of the
/// input, segments in order, or frames of any kind. Silent when the input is used up.
class FuzzedBus final : public CanLink {
 public:
  explicit FuzzedBus(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  void send(const CanFrame& frame) override {
    require(frame.length <= 8 && frame.id <= 0x7FF && !frame.extended && !frame.remote, "sent no frame");
    require(++sent_ < 2'000'000, "sends for ever");
    if (frame.id == 0x605) request_ = frame;
  }
  bool receive(CanFrame& frame, int) override {
    if (bytes_.empty()) return false;
    frame = {};
    frame.id = 0x585;
    frame.length = 8;
    const std::uint8_t kind = byte();
    if (kind < 0xA0) {
      frame.data = request_.data;
      frame.data[0] = byte();
      for (std::size_t i = 4; i < 4U + (kind & 4U); ++i) frame.data[i] = byte();
    } else if (kind < 0xD0) {
      frame.data[0] = static_cast<std::uint8_t>(++segment_ % 128U | (byte() < 8 ? 0x80U : 0U));
      if (segment_ % 128U == 127U) segment_ = 0;
    } else if (kind < 0xE0) {
      segment_ = 0;
      return false;
    } else if (kind < 0xF0) {
      frame.id = 0x385;
      tick_ = static_cast<std::uint16_t>(tick_ + (byte() < 200 ? 100 : byte()));
      frame.data[0] = static_cast<std::uint8_t>(tick_);
      frame.data[1] = static_cast<std::uint8_t>(tick_ >> 8);
    } else {
      frame.id = (byte() & 1U) != 0 ? 0x585U : 0x385U;
      frame.length = static_cast<std::uint8_t>(byte() % 9U);
      frame.extended = byte() > 250;
      frame.remote = byte() > 250;
      for (std::uint8_t& one : frame.data) one = byte();
    }
    return true;
  }
  double stamp_s() const override { return 1e-3 * sent_; }
  std::string name() const override { return "fuzz"; }

 private:
  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t first = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return first;
  }
  std::span<const std::uint8_t> bytes_;
  CanFrame request_;
  unsigned segment_ = 0;
  std::uint16_t tick_ = 0;
  int sent_ = 0;
};

void check(const Recording& recording) {
  const std::size_t head = recording.log.find("time_s,");
  require(head != std::string::npos, "a log without a head");
  const auto rows =
      std::count(recording.log.begin() + static_cast<std::ptrdiff_t>(head), recording.log.end(), '\n');
  require(rows == static_cast<std::ptrdiff_t>(recording.samples) + 1, "not as many rows as it says");
}

void run(std::uint8_t what, SdoClient& client) {
  const Show quiet = [](const std::string&, double fraction) { require(!(fraction > 1.0), "more than all"); };
  switch (what % 6) {
    case 0:
      require(!drive_status(client).empty(), "no status");
      break;
    case 1:
      check(record_stream(client, 0.5, 100.0, quiet));
      break;
    case 2:
      check(record_trace(client, 1, quiet));
      break;
    case 3: {
      const auto data = client.upload(0x2310, 0, [](double f) { require(f >= 0.0 && f <= 1.0, "a share"); });
      require(!data.empty() && data.size() <= std::size_t{16} << 20, "an upload of any size");
      break;
    }
    case 4:
      client.download(0x2141, 0, std::vector<std::uint8_t>(1000, 7));
      break;
    default:
      deploy_model(client, Model{}, "m.toml", true, quiet);
      break;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  FuzzedBus bus(std::span(data, size).subspan(1));
  try {
    SdoClient client(bus, 5);
    run(data[0], client);
  } catch (const UsageError& error) {
    const std::string text = error.what();
    require(!text.empty() && text.find('\n') == std::string::npos, "a refusal is one line");
  }
  return 0;
}
