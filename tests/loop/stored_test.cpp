// SPDX-License-Identifier: Apache-2.0
// Parameters stored by the emulated controller, over its CAN, are there after a reset and after a power
// cycle.
#include <gtest/gtest.h>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "firmware/app/lockstep/link_service.h"
#include "firmware/control/supervision/state_machine.h"
#include "sim_host/loop/emulated_board.h"
#include "tests/loop/image.h"

namespace slipstack::loop {
namespace {

constexpr std::size_t kMarker = 8;  // ahead of the pages: hal/mps2/memory_flash.h
constexpr std::size_t kPages = PlantMemory::kFlashPages * PlantMemory::kFlashPageBytes;

// The board with node 127 and a master on its SLCAN line; the master's frames are written from CiA 301.
class Board {
 public:
  explicit Board(const std::string& machine, const std::vector<std::byte>& pages = {})
      : path_(::testing::TempDir() + "slipstack-stored-" + std::to_string(getpid())),
        board_(machine, image_of(machine), {.can = "unix:" + path_ + ",server=on,wait=off", .pages = pages}),
        line_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(connect(line_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    board_.link().period = 1000;
    board_.link().encoder_valid = 1;
    board_.link().current_valid = 1;
  }
  ~Board() {
    close(line_);
    unlink(path_.c_str());
  }
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;

  /// Sends a line and ticks until what comes back contains `expected`; from there on.
  std::string ask(const std::string& line, const std::string& expected) {
    heard_.clear();
    EXPECT_EQ(write(line_, line.data(), line.size()), static_cast<ssize_t>(line.size()));
    const auto begin = std::chrono::steady_clock::now();
    std::size_t at = std::string::npos;
    while ((at = heard_.find(expected)) == std::string::npos || heard_.find('\r', at) == std::string::npos) {
      if (std::chrono::steady_clock::now() - begin > std::chrono::seconds(60)) {
        ADD_FAILURE() << line << " is answered by " << heard_;
        return {};
      }
      ticks(20);
      char part[256];
      const ssize_t got = recv(line_, part, sizeof part, MSG_DONTWAIT);
      if (got > 0) heard_.append(part, static_cast<std::size_t>(got));
    }
    return heard_.substr(at);
  }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) board_.tick();
  }

  /// Expedited download of `bytes` bytes; true when it was taken.
  bool set(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes = 4) {
    const int command = 0x23 | ((4 - bytes) << 2);
    return ask(sdo(command, index, sub, value), "t5FF8").substr(5, 2) == "60";
  }
  bool set(std::uint16_t index, std::uint8_t sub, float value) {
    return set(index, sub, std::bit_cast<std::uint32_t>(value));
  }
  /// Expedited upload of four bytes.
  std::uint32_t get(std::uint16_t index, std::uint8_t sub) {
    const std::string answer = ask(sdo(0x40, index, sub, 0), "t5FF8");
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4 && answer.size() >= 21; ++i) {
      value |= static_cast<std::uint32_t>(std::stoul(answer.substr(13 + 2 * i, 2), nullptr, 16)) << (8 * i);
    }
    return value;
  }

  PlantLink& link() { return board_.link(); }
  std::vector<std::byte> pages() {
    const std::span<std::byte> all = board_.flash().subspan(kMarker, kPages);
    return {all.begin(), all.end()};
  }

 private:
  static std::string sdo(int command, std::uint16_t index, std::uint8_t sub, std::uint32_t value) {
    char text[32];
    std::snprintf(text, sizeof text, "t67F8%02X%02X%02X%02X%02X%02X%02X%02X\r", command, index & 0xFF,
                  index >> 8, sub, value & 0xFF, (value >> 8) & 0xFF, (value >> 16) & 0xFF, value >> 24);
    return text;
  }

  std::string path_;
  sim::EmulatedBoard board_;
  int line_;
  std::string heard_;
};

class Stored : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (std::system("command -v qemu-system-arm >/dev/null 2>&1") != 0 ||
        !std::filesystem::is_regular_file(image_of(GetParam()))) {
      GTEST_SKIP() << "no emulator or no image " << image_of(GetParam());
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Boards, Stored, ::testing::Values("mps2-an386", "mps2-an500"),
                         [](const auto& own) { return own.param == "mps2-an386" ? "CortexM4" : "CortexM7"; });

TEST_P(Stored, TheModelIsTheSameAfterAResetAndAPowerCycle) {
  std::vector<std::byte> pages;
  std::uint32_t hash = 0;
  {
    Board board(GetParam());
    board.ticks(10);
    EXPECT_EQ(board.link().state, static_cast<std::uint32_t>(DriveState::kNotReadyToSwitchOn)) << "no model";
    // 2100h: inertia of 35 kg; 2101h: two elements.
    ASSERT_TRUE(board.set(0x2100, 1, 1U, 1));
    ASSERT_TRUE(board.set(0x2100, 2, 35.0F));
    ASSERT_TRUE(board.set(0x2101, 1, 1U, 1));
    ASSERT_TRUE(board.set(0x2101, 2, 1.5e6F));
    ASSERT_TRUE(board.set(0x2101, 3, 2.5e5F));
    ASSERT_TRUE(board.set(0x2101, 12, 3.0e-6F));
    ASSERT_TRUE(board.set(0x2101, 13, 2.0e-5F));
    hash = board.get(0x2140, 1);
    ASSERT_TRUE(board.set(0x2140, 3, hash));
    board.ticks(20);
    ASSERT_EQ(board.link().model_hash, hash);
    const std::vector<std::byte> before = board.pages();
    ASSERT_TRUE(board.set(0x1010, 1, 0x65766173U)) << "save";
    EXPECT_NE(board.pages(), before);
    // Staged, but neither applied nor stored.
    ASSERT_TRUE(board.set(0x2100, 2, 20.0F));
    ASSERT_NE(board.get(0x2140, 1), hash);
    board.ask("t00028100\r", "t77F100");
    board.ticks(20);
    EXPECT_EQ(board.get(0x2140, 1), hash) << "after a reset of the node";
    EXPECT_EQ(board.get(0x2140, 2), hash);
    pages = board.pages();
  }
  ASSERT_TRUE(std::any_of(pages.begin(), pages.end(), [](std::byte b) { return b != std::byte{0xFF}; }));
  Board again(GetParam(), pages);
  again.ticks(50);
  EXPECT_EQ(again.link().model_hash, hash) << "after a power cycle";
  EXPECT_EQ(again.link().state, static_cast<std::uint32_t>(DriveState::kSwitchOnDisabled));
  EXPECT_EQ(again.get(0x2101, 13), std::bit_cast<std::uint32_t>(2.0e-5F));
}

// Flash with nothing in it, and with a record of which a byte has changed: the defaults, which give no model.
TEST_P(Stored, ADamagedRecordIsNotTaken) {
  std::vector<std::byte> pages;
  {
    Board board(GetParam());
    ASSERT_TRUE(board.set(0x2100, 1, 1U, 1));
    ASSERT_TRUE(board.set(0x2100, 2, 35.0F));
    ASSERT_TRUE(board.set(0x1010, 1, 0x65766173U));
    pages = board.pages();
  }
  const auto first =
      std::find_if(pages.begin(), pages.end(), [](std::byte b) { return b != std::byte{0xFF}; });
  ASSERT_NE(first, pages.end());
  *(first + 100) ^= std::byte{0x10};
  Board again(GetParam(), pages);
  again.ticks(50);
  EXPECT_EQ(again.get(0x2100, 2), 0U);
  EXPECT_EQ(again.link().state, static_cast<std::uint32_t>(DriveState::kNotReadyToSwitchOn));
}

}  // namespace
}  // namespace slipstack::loop
