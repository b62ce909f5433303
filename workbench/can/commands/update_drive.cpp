// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/commands/update_drive.h"

#include <fmt/format.h>

#include <optional>

#include "firmware/canopen/objects/program_objects.h"
#include "firmware/update/boot_choice.h"
#include "firmware/update/program_writer.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

using namespace slipstack::canopen;
using update::SlotState;
using update::UpdateFault;

constexpr int kTransfers = 5;         // a bus on which all of them break off needs another cure
constexpr int kPoll_ms = 200;         // of what takes its time
constexpr int kClear_polls = 50;      // 112 pages of 22 ms are 2.5 s (DS12288)
constexpr int kRestart_polls = 1500;  // three starts of a minute each, and what lies between them
constexpr std::uint32_t kStart = 1;
constexpr std::uint32_t kClear = 3;

std::string fault_text(UpdateFault fault) {
  switch (fault) {
    case UpdateFault::kNotCleared:
      return "its slot was not cleared; does another master update it?";
    case UpdateFault::kFormat:
      return "what arrived is not an update";
    case UpdateFault::kWrongDevice:
      return "the program is for another product or board";
    case UpdateFault::kNotForSlot:
      return "no program of the file is linked for its spare slot";
    case UpdateFault::kTooLarge:
      return "the program does not fit its slot";
    case UpdateFault::kCutShort:
      return "the transfer ended too early";
    case UpdateFault::kChecksum:
      return "the program in its flash has a wrong checksum";
    case UpdateFault::kFlash:
      return "its flash failed";
    case UpdateFault::kOnTrial:
      return "the program that runs is still on trial; wait until it has reported in";
    case UpdateFault::kNoProgram:
      return "nothing was loaded that could be started";
    default:
      return "it refused";
  }
}

std::string version_text(std::uint32_t version) {
  return fmt::format("{}.{}", version >> 16U, version & 0xFFFFU);
}

class Update {
 public:
  Update(SdoClient& drive, const UpdateFile& file, const Show& show)
      : drive_(drive), file_(file), show_(show) {}

  std::string run() {
    show_("ask the drive", -1.0);
    before_ = identify();
    if (const UpdateImage* same = file_.at(running_address());
        same != nullptr && before_ == same->header.crc) {
      return fmt::format("program    {}, CRC {:08x}: runs already\n", version_text(same->header.version),
                         before_);
    }
    choose();
    for (int tries = 0; !transfer(); ++tries) {
      if (tries + 1 == kTransfers)
        fail(fmt::format("the transfer broke off {} times; is the bus well?", kTransfers));
    }
    start();
    await_report();
    return fmt::format(
        "program    {}, {} bytes, CRC {:08x}\nslot       {}\nstate      has reported in, confirmed\n",
        version_text(image_->header.version), image_->program.size(), image_->header.crc,
        drive_.read(kUpdateIndex, 1));
  }

 private:
  [[noreturn]] void fail(const std::string& why) const { drive_.fail(why); }
  UpdateFault fault() { return static_cast<UpdateFault>(drive_.read(kUpdateIndex, 9)); }
  void wait() {
    CanFrame frame;
    drive_.link().receive(frame, kPoll_ms);
  }

  // Whether it is a drive of ours that can be updated; the CRC of what it runs.
  std::uint32_t identify() {
    if (drive_.read(0x1018, 1) != update::kVendorId || drive_.read(0x1018, 2) != update::kProductCode) {
      fail("is not a slipstack drive (1018h:01, 1018h:02)");
    }
    spare_address_ = drive_.read(kUpdateIndex, 5);
    if (spare_address_ == 0) fail("its board has no slots for programs; flash it with toolchain/flash");
    return drive_.read(kProgramIdentityIndex, 1);
  }
  // The file names an address for each slot: the running one is that which is not spare.
  std::uint32_t running_address() const {
    for (const UpdateImage& image : file_.images) {
      if (image.header.address != spare_address_) return image.header.address;
    }
    return spare_address_;
  }

  // Everything that can be refused is refused before anything is erased.
  void choose() {
    const std::uint32_t board = drive_.read(kUpdateIndex, 6);
    for (const UpdateImage& image : file_.images) {
      if (!update::is_for(image.header, board)) {
        fail(fmt::format("{} is for another product or board", printable(file_.name)));
      }
    }
    image_ = file_.at(spare_address_);
    if (image_ == nullptr) {
      fail(fmt::format("{} has no program for its spare slot ({:08x}h)", printable(file_.name),
                       spare_address_));
    }
  }

  // Of a block that the drive refused, the rest is still on its way, and each frame of it is answered.
  void await_silence() {
    constexpr int kSilence_ms = 100;
    constexpr int kMost = 1000;
    CanFrame frame;
    for (int i = 0; i < kMost && drive_.link().receive(frame, kSilence_ms); ++i) {
    }
  }

  // What was refused for a reason of the drive's ends the update with that reason.
  [[noreturn]] void refused(const SdoAbort& error) {
    await_silence();
    const UpdateFault reason = fault();
    if (reason != UpdateFault::kNone) fail(fault_text(reason));
    throw error;
  }

  void clear() {
    const std::uint32_t code = drive_.try_write(kProgramControlIndex, 1, kClear, 1);
    if (code != 0) refused(SdoAbort(drive_.node(), kProgramControlIndex, 1, code));
    for (int polls = 0; (drive_.read(kFlashStatusIndex, 1) & 1U) != 0; ++polls) {
      if (polls == kClear_polls) fail("does not end to clear its slot; is it enabled?");
      show_("clear the slot", static_cast<double>(polls) / kClear_polls);
      wait();
    }
    if (const UpdateFault reason = fault(); reason != UpdateFault::kNone) fail(fault_text(reason));
  }

  // One transfer, from where the last one broke off if that was of the same program. False: it broke off.
  bool transfer() {
    try {
      std::uint32_t offset = 0;
      if (drive_.read(kUpdateIndex, 8) == image_->header.crc) offset = drive_.read(kUpdateIndex, 7);
      if (offset == 0) clear();
      const double size = static_cast<double>(image_->program.size());
      drive_.download(kProgramDataIndex, 1, transfer_of(*image_, offset),
                      [&](double part) { show_("transfer", (offset + part * (size - offset)) / size); });
      return true;
    } catch (const SdoAbort& error) {
      if (!error.of_transport()) refused(error);
      await_silence();
    } catch (const UsageError&) {
      await_bus();
    }
    return false;
  }
  // Half a minute for a cable that was pulled, or a bus that was off.
  void await_bus() {
    constexpr int kTimes = 10;
    for (int i = 1; i <= kTimes; ++i) {
      try {
        return drive_.await_node();
      } catch (const UsageError&) {
        if (i == kTimes) throw;
        wait();
      }
    }
  }

  void start() {
    const std::uint32_t code = drive_.try_write(kProgramControlIndex, 1, kStart, 1);
    if (code != 0) refused(SdoAbort(drive_.node(), kProgramControlIndex, 1, code));
  }

  std::optional<std::uint32_t> try_read(std::uint16_t index, std::uint8_t sub) {
    try {
      return drive_.read(index, sub);
    } catch (const UsageError&) {
      return std::nullopt;
    }
  }

  void await_report() {
    bool seen = false;
    for (int polls = 0; polls < kRestart_polls; ++polls) {
      wait();
      show_(seen ? "wait until it reports in" : "restart", -1.0);
      const std::optional<std::uint32_t> crc = try_read(kProgramIdentityIndex, 1);
      const std::optional<std::uint32_t> state = crc ? try_read(kUpdateIndex, 2) : std::nullopt;
      if (!state) continue;
      if (*crc == image_->header.crc) {
        seen = true;
        if (*state == static_cast<std::uint32_t>(SlotState::kConfirmed)) return;
      } else if (try_read(kUpdateIndex, 3) == static_cast<std::uint32_t>(SlotState::kGivenUp)) {
        fail("the new program did not report in; the one before is back");
      }
    }
    fail(seen ? "the new program runs and is not confirmed; is the drive enabled?"
              : "did not come back; if its stored node id is lost, it answers as 127");
  }

  SdoClient& drive_;
  const UpdateFile& file_;
  const Show& show_;
  std::uint32_t before_ = 0;
  std::uint32_t spare_address_ = 0;
  const UpdateImage* image_ = nullptr;
};

}  // namespace

std::string update_drive(SdoClient& drive, const UpdateFile& file, const Show& show) {
  return Update(drive, file, show).run();
}

}  // namespace slipstack::workbench
