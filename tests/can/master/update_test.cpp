// SPDX-License-Identifier: Apache-2.0
// `slipstack update` on a cable to a host node with two program slots: success, a bus that fails in between,
// a program that does not come up, and every refusal.
#include "workbench/can/commands/update_drive.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

#include "sim_host/log/draw.h"
#include "workbench/base/errors.h"
#include "workbench/can/host_node/updatable_drive.h"

namespace slipstack::workbench {
namespace {

/// The master's end of a cable; while it waits, the drive's time passes.
class UpdateCable final : public CanLink {
 public:
  UpdateCable(host::HostCanPort& port, UpdatableDrive& drive) : port_(port), drive_(drive) {}
  void send(const CanFrame& frame) override {
    ++sent;
    if (lose && lose(sent)) return;
    port_.send(frame);
  }
  bool receive(CanFrame& frame, int timeout_ms) override {
    for (int tick = 0; tick <= 10 * timeout_ms; ++tick) {
      while (port_.receive(frame)) {
        if (frame.id == 0x585 && !(deaf && deaf(sent))) return true;
      }
      if (timeout_ms > 0) drive_.step();
      if (timeout_ms > 0 && each_tick) each_tick();
    }
    return false;
  }
  std::string name() const override { return "cable"; }

  std::size_t sent = 0;
  std::function<bool(std::size_t)> lose;  // frames to the drive, by number
  std::function<bool(std::size_t)> deaf;  // frames from it
  std::function<void()> each_tick;

 private:
  host::HostCanPort& port_;
  UpdatableDrive& drive_;
};

std::vector<std::uint8_t> random_host_program(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> program(size);
  for (auto& byte : program) byte = static_cast<std::uint8_t>(random());
  return program;
}

UpdateFile file_for(const std::array<std::vector<std::uint8_t>, 2>& programs,
                    std::uint32_t board = host::HostProgramMemory::kBoardId) {
  UpdateFile file{"new.update", {}};
  for (std::size_t slot = 0; slot < 2; ++slot) {
    UpdateImage image;
    image.program = programs[slot];
    image.header.board = board;
    image.header.version = 0x00020007;
    image.header.address = host::HostProgramMemory::kAddresses[slot];
    image.header.size = static_cast<std::uint32_t>(image.program.size());
    image.header.crc = crc32(std::as_bytes(std::span(image.program)));
    file.images.push_back(std::move(image));
  }
  return file;
}

UpdateFile random_file(std::size_t size = 20'000, unsigned seed = 1) {
  return file_for({random_host_program(size, seed), random_host_program(size + 13, seed + 1)});
}

struct UpdateDesk {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 4);
  host::HostNonvolatile flash{2, 2048, 8};
  host::HostCanPort device{4096};
  host::HostCanPort port{4096};
  UpdatableDrive drive;
  UpdateCable link;
  SdoClient client;

  UpdateDesk()
      : drive([this](ProgramMemory& programs) {
          return std::make_unique<SimulatedDrive>(bench.axis, device, flash, 5, 4, Wiring{}, &programs);
        }),
        link(port, drive),
        client(link, 5) {
    port.connect(device);
    for (int i = 0; i < 20; ++i) drive.step();
  }
  std::string update(const UpdateFile& file) {
    return update_drive(client, file, [](const std::string&, double) {});
  }
  /// The line of a refusal.
  std::string refusal(const UpdateFile& file) {
    try {
      update(file);
    } catch (const UsageError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "taken";
  }
  void enable() {
    client.write(0x6060, 0, 1, 1);
    for (const std::uint32_t word : {6U, 7U, 15U}) {
      client.write(0x6040, 0, word, 2);
      for (int i = 0; i < 20; ++i) drive.step();
    }
  }
};

TEST(Update, ThereAndBackAgain) {
  UpdateDesk desk;
  const std::uint32_t stored = desk.client.read(0x2211, 9);
  std::uint32_t slot = 1;
  for (unsigned round = 0; round < 4; ++round) {
    const UpdateFile file = random_file(150'000 + 100 * round, 10 * round);
    const std::string text = desk.update(file);
    slot = 3 - slot;
    EXPECT_NE(text.find(fmt::format("slot       {}", slot)), std::string::npos) << text;
    EXPECT_NE(text.find("confirmed"), std::string::npos) << text;
    EXPECT_EQ(desk.client.read(0x1F56, 1), file.images[slot - 1].header.crc);
    EXPECT_NE(desk.update(file).find("runs already"), std::string::npos);
  }
  EXPECT_EQ(desk.client.read(0x2211, 9), stored) << "the parameters are those of before";
}

TEST(Update, AProgramThatCrashesIsGivenUp) {
  UpdateDesk desk;
  const std::uint32_t before = desk.client.read(0x1F56, 1);
  UpdateFile file = random_file();
  for (UpdateImage& image : file.images) {
    std::copy(UpdatableDrive::kCrash.begin(), UpdatableDrive::kCrash.end(), image.program.begin());
    image.header.crc = crc32(std::as_bytes(std::span(image.program)));
  }
  EXPECT_EQ(desk.refusal(file), "node 5: the new program did not report in; the one before is back");
  EXPECT_EQ(desk.client.read(0x1F56, 1), before);
  EXPECT_NE(desk.update(random_file()).find("confirmed"), std::string::npos) << "and the next one is taken";
}

TEST(Update, GoesOnAfterABusThatWasAway) {
  for (const std::size_t at : {500U, 2000U, 2800U}) {
    UpdateDesk desk;
    const std::size_t begun = desk.link.sent;
    int away_ticks = 50'000;  // 5 s
    const auto away = [&](std::size_t sent) { return sent - begun > at && away_ticks > 0; };
    desk.link.lose = away;
    desk.link.deaf = away;
    desk.link.each_tick = [&] { away_ticks -= away(desk.link.sent) ? 1 : 0; };
    EXPECT_NE(desk.update(random_file()).find("confirmed"), std::string::npos) << at;
    // 20 013 bytes are 2 860 segments: had it begun anew, there would be all of them twice.
    std::size_t needed = 0;
    {
      UpdateDesk undisturbed;
      const std::size_t first = undisturbed.link.sent;
      undisturbed.update(random_file());
      needed = undisturbed.link.sent - first;
    }
    EXPECT_LT(desk.link.sent - begun, needed + 200) << at;
    EXPECT_GT(desk.link.sent - begun, 2860U);
  }
}

TEST(Update, SingleLostFramesCostNothingMuch) {
  UpdateDesk desk;
  std::mt19937 random(3);
  bool transfer = false;
  desk.link.lose = [&](std::size_t sent) { return transfer && sent % 97 == 13; };
  const UpdateFile file = random_file();
  const auto show = [&](const std::string& stage, double) { transfer = stage == "transfer"; };
  EXPECT_NE(update_drive(desk.client, file, show).find("confirmed"), std::string::npos);
}

TEST(Update, ABusThatStaysAwayIsOneLine) {
  UpdateDesk desk;
  bool transfer = false;
  desk.link.lose = [&](std::size_t) { return transfer; };
  const UpdateFile file = random_file();
  const auto show = [&](const std::string& stage, double) { transfer = transfer || stage == "transfer"; };
  try {
    update_drive(desk.client, file, show);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("does not answer"), std::string::npos) << error.what();
  }
}

TEST(Update, RefusesBeforeAnythingIsErased) {
  UpdateDesk desk;
  EXPECT_EQ(desk.update(random_file()).find("program"), 0U);
  const auto erased = desk.drive.memory().slots[0].bytes;
  EXPECT_NE(desk.refusal(file_for({random_host_program(9, 1), random_host_program(9, 2)}, 0x34373447))
                .find("for another product or board"),
            std::string::npos);
  UpdateFile one_slot = random_file(100, 50);
  one_slot.images.erase(one_slot.images.begin());
  EXPECT_NE(desk.refusal(one_slot).find("has no program for its spare slot"), std::string::npos);
  desk.enable();
  EXPECT_NE(desk.refusal(random_file(100, 60)).find("disable it first"), std::string::npos);
  EXPECT_TRUE(desk.drive.memory().slots[0].bytes == erased);
}

TEST(Update, SaysWhatTheDriveRefused) {
  UpdateDesk desk;
  EXPECT_EQ(desk.refusal(random_file(112 * 2048)), "node 5: the program does not fit its slot");
  desk.drive.memory().slots[1].bytes_until_power_fails = 3000;
  EXPECT_EQ(desk.refusal(random_file()), "node 5: its flash failed");
}

TEST(Update, EnabledInTheMiddleEndsIt) {
  UpdateDesk desk;
  bool transfer = false;
  const UpdateFile file = random_file();
  const auto show = [&](const std::string& stage, double fraction) {
    if (stage != "transfer" || fraction < 0.5 || transfer) return;
    transfer = true;  // another master, by its own means
    canopen::Dictionary& dictionary = desk.drive.drive()->node().dictionary();
    dictionary.write(canopen::kRow<0x6060>, 1);
    for (const std::uint32_t word : {6U, 7U, 15U}) {
      dictionary.write(canopen::kRow<0x6040>, word);
      for (int i = 0; i < 20; ++i) desk.drive.step();
    }
  };
  try {
    update_drive(desk.client, file, show);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("disable it first"), std::string::npos) << error.what();
  }
  EXPECT_NE(desk.refusal(file).find("disable it first"), std::string::npos);
}

std::string text_of(const UpdateFile& file) {
  std::string text;
  for (const UpdateImage& image : file.images) {
    for (const std::uint8_t byte : transfer_of(image, 0)) text.push_back(static_cast<char>(byte));
  }
  return text;
}

TEST(UpdateFiles, AreReadBackAndDamageIsSeen) {
  const UpdateFile file = random_file(300);
  const std::string text = text_of(file);
  const UpdateFile back = parse_update_file(text, "f");
  ASSERT_EQ(back.images.size(), 2U);
  EXPECT_EQ(back.images[1].program, file.images[1].program);
  EXPECT_EQ(back.images[1].header.version, 0x00020007U);
  for (std::size_t bit = 0; bit < 8 * text.size(); bit += 3) {
    std::string damaged = text;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ 1 << bit % 8);
    EXPECT_THROW(parse_update_file(damaged, "f"), UsageError) << bit;
  }
  for (std::size_t size = 0; size < text.size(); ++size) {
    if (size == 64 + file.images[0].program.size()) continue;  // one image is a file too
    EXPECT_THROW(parse_update_file(text.substr(0, size), "f"), UsageError) << size;
  }
  EXPECT_THROW(read_update_file("/nonesuch/x.update"), UsageError);
}

}  // namespace
}  // namespace slipstack::workbench
