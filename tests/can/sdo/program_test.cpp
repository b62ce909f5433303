// SPDX-License-Identifier: Apache-2.0
// 1F50h, 1F51h, 1F56h, 1F57h (CiA 302-3) and 2410h, frame by frame: order of the commands, refusals with
// their abort codes, the restart, the trial.
#include <cstring>
#include <functional>
#include <random>

#include "firmware/update/boot_choice.h"
#include "hal/host/program_memory.h"
#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr std::uint32_t kDriven = 0x08000022;

// CRC-32 as zlib's documents have it, bit by bit.
std::uint32_t crc_of(const Data& data) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (const std::uint8_t byte : data) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xEDB88320U : crc >> 1U;
  }
  return ~crc;
}

Data program_of(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  Data data(size);
  for (std::uint8_t& byte : data) byte = static_cast<std::uint8_t>(random());
  return data;
}

struct ImageWords {
  std::uint32_t product = 0x534C4B31;
  std::uint32_t board = 0x54534F48;
  std::uint32_t address = 0x08047000;
  std::uint32_t crc_error = 0;
};

Data image_of(const Data& program, const ImageWords& with = {}) {
  Data image;
  const auto put = [&](std::uint32_t word) {
    for (int i = 0; i < 4; ++i) image.push_back(static_cast<std::uint8_t>(word >> (8 * i)));
  };
  for (const std::uint32_t word : {0x49504C53U, 1U, 0U, with.product, with.board, 0x00010002U, with.address,
                                   static_cast<std::uint32_t>(program.size()),
                                   crc_of(program) ^ with.crc_error, 0U, 0U, 0U, 0U, 0U, 0U}) {
    put(word);
  }
  put(crc_of(image));
  for (const std::uint8_t byte : program) image.push_back(byte);
  return image;
}

class ProgramBench : public Bench {
 public:
  ProgramBench() : Bench(false) {
    programs = &memory_of_programs;
    old_one = program_of(999, 1);
    Data first = image_of(old_one, {.address = 0x08007000});
    for (std::size_t i = 0; i < 64; ++i) memory_of_programs.slots[0].bytes[i] = std::byte{first[i]};
    const std::array<std::uint32_t, 2> mark = {1, ~1U};
    std::memcpy(&memory_of_programs.slots[0].bytes[64], mark.data(), 8);
    for (std::size_t i = 0; i < old_one.size(); ++i) {
      memory_of_programs.slots[0].bytes[512 + i] = std::byte{old_one[i]};
    }
    const std::array<std::uint32_t, 2> note = {0x43000001, ~0x43000001U};
    std::memcpy(memory_of_programs.pages_of_notes[0].bytes.data(), note.data(), 8);
    running = memory_of_programs.slots[0].bytes;
    power_on();
    begin();
  }
  ~ProgramBench() {
    EXPECT_TRUE(memory_of_programs.slots[0].bytes == running) << "the running program was touched";
  }
  ProgramBench(const ProgramBench&) = delete;
  ProgramBench& operator=(const ProgramBench&) = delete;

  std::uint32_t control(std::uint32_t command) { return write(0x1F51, 1, command, 1); }
  void clear() {
    ASSERT_EQ(control(3), 0U);
    EXPECT_EQ(read(0x1F57, 1) & 1U, 1U) << "takes its time";
    for (int i = 0; i < 200 && (read(0x1F57, 1) & 1U) != 0; ++i) run_ms(1);
    ASSERT_EQ(read(0x1F57, 1), 0U);
  }
  /// Segmented download of a domain; the abort code.
  std::uint32_t download(const Data& data) {
    Data start = address(0x21, 0x1F50, 1);
    for (std::size_t i = 0; i < 4; ++i) start[4 + i] = static_cast<std::uint8_t>(data.size() >> (8 * i));
    Data reply = sdo(start);
    std::uint8_t toggle = 0;
    for (std::size_t at = 0; reply.at(0) != 0x80 && at < data.size(); at += 7) {
      const std::size_t count = std::min<std::size_t>(7, data.size() - at);
      Data segment(8);
      const bool last = at + 7 >= data.size();
      segment[0] = static_cast<std::uint8_t>(toggle | (7 - count) << 1 | (last ? 1 : 0));
      std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(at), count, segment.begin() + 1);
      if (before_last && last) before_last();
      reply = sdo(segment);
      toggle ^= 0x10;
    }
    return reply.at(0) == 0x80 ? number(reply, 4) : 0;
  }
  std::uint32_t cleared_download(const Data& data) {
    clear();
    return download(data);
  }

  host::HostProgramMemory memory_of_programs;
  Data old_one;
  std::vector<std::byte> running;
  std::function<void()> before_last;
};

TEST(Program, ANewOneIsLoadedStartedAndReportsIn) {
  ProgramBench bench;
  const Data program = program_of(5000, 2);
  EXPECT_EQ(bench.read(0x1F51, 1), 1U);
  EXPECT_EQ(bench.read(0x1F56, 1), crc_of(bench.old_one));
  EXPECT_EQ(bench.read(0x2410, 1), 1U);
  EXPECT_EQ(bench.read(0x2410, 2), 2U) << "confirmed";
  EXPECT_EQ(bench.read(0x2410, 5), 0x08047000U);
  EXPECT_EQ(bench.control(0), 0U);
  EXPECT_EQ(bench.cleared_download(image_of(program)), 0U);
  EXPECT_EQ(bench.read(0x2410, 4), crc_of(program));
  EXPECT_EQ(bench.control(1), 0U);
  EXPECT_FALSE(bench.memory_of_programs.restarted) << "the answer goes first";
  bench.run_ms(100);
  ASSERT_TRUE(bench.memory_of_programs.restarted);
  bench.memory_of_programs.restarted = false;
  ASSERT_EQ(update::decide(bench.memory_of_programs), 1U);

  bench.memory_of_programs.runs = 1;
  bench.power_on();
  bench.begin();
  EXPECT_EQ(bench.read(0x1F56, 1), crc_of(program));
  EXPECT_EQ(bench.read(0x2410, 1), 2U);
  EXPECT_EQ(bench.read(0x2410, 2), 1U) << "on trial";
  EXPECT_EQ(bench.control(3), kDriven) << "no further update before it has reported in";
  EXPECT_EQ(bench.read(0x2410, 9), static_cast<std::uint32_t>(update::UpdateFault::kOnTrial));
  EXPECT_EQ(bench.read(0x1F57, 1) & 0xFFU, 7U << 1U);
  for (int i = 0; i < 5100; ++i) {
    bench.run_ms(1);
    bench.drive->watch_trial(bench.now_us, bench.node->takes_part());
  }
  EXPECT_EQ(bench.read(0x2410, 2), 2U);
}

TEST(Program, AnAloneNodeDoesNotReportIn) {
  ProgramBench bench;
  bench.all();
  bench.run_ms(2);
  EXPECT_TRUE(bench.node->takes_part());
  for (const CanBusState state : {CanBusState::kPassive, CanBusState::kOff}) {
    bench.device.bus.state = state;
    EXPECT_FALSE(bench.node->takes_part());
  }
  bench.device.bus.state = CanBusState::kWarning;
  EXPECT_TRUE(bench.node->takes_part());
}

TEST(Program, RefusalsHaveACodeAndAReason) {
  const Data program = program_of(300, 3);
  const auto refused = [&](const Data& file, update::UpdateFault reason, std::uint32_t flash_error) {
    ProgramBench bench;
    const std::uint32_t code = bench.cleared_download(file);
    EXPECT_EQ(bench.read(0x2410, 9), static_cast<std::uint32_t>(reason));
    EXPECT_EQ(bench.read(0x1F57, 1), flash_error << 1U | static_cast<std::uint32_t>(reason) << 16U);
    EXPECT_EQ(bench.control(1), 0x08000024U) << "nothing to be started";
    return code;
  };
  using Fault = update::UpdateFault;
  EXPECT_EQ(refused(image_of(program, {.product = 1}), Fault::kWrongDevice, 63), 0x06040043U);
  EXPECT_EQ(refused(image_of(program, {.board = 1}), Fault::kWrongDevice, 63), 0x06040043U);
  EXPECT_EQ(refused(image_of(program, {.crc_error = 1}), Fault::kChecksum, 3), 0x08000020U);
  EXPECT_EQ(refused(image_of(program, {.address = 0x08007000}), Fault::kNotForSlot, 6), 0x08000020U);
  EXPECT_EQ(refused(image_of(program_of(112 * 2048 - 511, 4)), Fault::kTooLarge, 6), 0x06070012U);
  EXPECT_EQ(refused(program_of(200, 5), Fault::kFormat, 2), 0x08000020U);
  Data shorter = image_of(program);
  shorter.resize(shorter.size() - 1);
  EXPECT_EQ(refused(shorter, Fault::kCutShort, 3), 0x06070013U);
}

TEST(Program, NotWithoutClearing) {
  ProgramBench bench;
  EXPECT_EQ(bench.download(image_of(program_of(20, 1))), 0x08000022U);
  EXPECT_EQ(bench.read(0x1F57, 1) & 0xFFU, 4U << 1U);
  EXPECT_EQ(bench.control(1), 0x08000024U);
  EXPECT_EQ(bench.control(4), 0x06090031U);
}

TEST(Program, NothingWhileTheDriveIsEnabled) {
  ProgramBench bench;
  const Data image = image_of(program_of(200, 3));
  bench.configure();
  bench.clear();
  ASSERT_EQ(bench.control(3), 0U);
  bench.enable(1);
  const auto spare = bench.memory_of_programs.slots[1].bytes;
  for (const std::uint32_t command : {0U, 1U, 2U, 3U}) EXPECT_EQ(bench.control(command), kDriven) << command;
  EXPECT_EQ(bench.read(0x1F57, 1) & 1U, 1U) << "erasing waits";
  bench.run_ms(300);
  EXPECT_EQ(bench.read(0x1F57, 1) & 1U, 1U);
  EXPECT_EQ(bench.download(image), kDriven);
  EXPECT_TRUE(bench.memory_of_programs.slots[1].bytes == spare);
  EXPECT_FALSE(bench.memory_of_programs.restarted);
}

TEST(Program, EnabledInTheMiddleOfATransfer) {
  ProgramBench bench;
  bench.configure();
  bench.clear();
  // By PDO, as SDO is busy: 6, 7, 15 to 6040h.
  bench.nmt(1);
  bench.before_last = [&] {
    for (const std::uint8_t word : {std::uint8_t{6}, std::uint8_t{7}, std::uint8_t{15}}) {
      bench.send(0x205, {word, 0, 1});
      bench.run_ms(2);
    }
  };
  EXPECT_EQ(bench.download(image_of(program_of(200, 3))), kDriven);
  bench.before_last = nullptr;
  EXPECT_EQ(bench.read(0x6041, 0) & 0x6F, 0x27U);
  EXPECT_EQ(bench.control(1), kDriven);
}

// Enabled between 1F51h = 1 and the restart: the axis is not dropped.
TEST(Program, NoRestartOfADrivenAxis) {
  ProgramBench bench;
  bench.configure();
  ASSERT_EQ(bench.control(2), 0U);
  bench.enable(1);
  bench.run_ms(200);
  EXPECT_FALSE(bench.memory_of_programs.restarted);
}

TEST(Program, TheFileMayHoldAnImageForEachSlot) {
  ProgramBench bench;
  const Data mine = program_of(20'000, 6);
  Data file = image_of(program_of(7001, 7), {.address = 0x08007000});
  for (const std::uint8_t byte : image_of(mine)) file.push_back(byte);
  EXPECT_EQ(bench.cleared_download(file), 0U);
  EXPECT_EQ(bench.read(0x2410, 4), crc_of(mine));
}

TEST(Program, ABoardWithoutSlotsSaysSo) {
  Bench bench;
  EXPECT_EQ(bench.write(0x1F51, 1, 3, 1), 0x06010000U);
  EXPECT_EQ(bench.sdo(Bench::address(0x21, 0x1F50, 1)).at(0), 0x80);
  EXPECT_EQ(bench.read(0x1F56, 1), 0U);
  EXPECT_EQ(bench.read(0x2410, 5), 0U);
}

TEST(Program, TheAccessLockHoldsItToo) {
  ProgramBench bench;
  bench.clear();
  ASSERT_EQ(bench.write(0x2400, 10, 1, 1), 0U);
  EXPECT_EQ(bench.control(3), 0x08000021U);
  EXPECT_EQ(bench.control(1), 0x08000021U);
  EXPECT_EQ(bench.download(image_of(program_of(20, 1))), 0x08000021U);
}

}  // namespace
}  // namespace slipstack::can
