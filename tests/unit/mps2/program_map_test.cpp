// SPDX-License-Identifier: Apache-2.0
// The linker scripts and the test of the boot loader name the addresses of hal/mps2/program_map.h, whose
// banks are those of the part.
#include "hal/mps2/program_map.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <regex>
#include <string>
#include <vector>

#include "firmware/update/image_header.h"
#include "hal/stm32g474/flash_map.h"
#include "tests/unit/project_text.h"

namespace slipstack::mps2 {
namespace {

constexpr auto kHeaderBytes = static_cast<std::uint32_t>(update::kHeaderBlock);

// The numbers that the groups of a pattern find.
std::vector<std::uint32_t> numbers(const std::string& path, const std::string& pattern) {
  const std::string text = project_text(path);
  std::smatch found;
  if (!std::regex_search(text, found, std::regex(pattern))) {
    ADD_FAILURE() << path << " has nothing of the form " << pattern;
    return {};
  }
  std::vector<std::uint32_t> all;
  for (std::size_t i = 1; i < found.size(); ++i) {
    all.push_back(static_cast<std::uint32_t>(std::stoul(found[i], nullptr, 0)));
  }
  return all;
}

using Numbers = std::vector<std::uint32_t>;

TEST(ProgramMap, IsThatOfThePartsBanks) {
  EXPECT_EQ(kProgramPageBytes, stm32g474::kFlashPageBytes);
  EXPECT_EQ(kProgramBankBytes, stm32g474::kFlashBankBytes);
  EXPECT_EQ(kSlotPage, stm32g474::slot_in(0).first_page);
  EXPECT_EQ(kSlotPages, stm32g474::slot_in(0).pages);
  EXPECT_EQ(kNotesPage, stm32g474::notes_in(0).first_page);
  EXPECT_EQ(program_page(1, 3), kProgramFlash + kProgramBankBytes + 3 * kProgramPageBytes);
  EXPECT_GE(kProgramFlash, kPsram);
  EXPECT_LT(kProgramSupply, kPsram + kPsramBytes);
}

TEST(ProgramMap, TheLinkerScriptsHaveItsAddresses) {
  EXPECT_EQ(numbers("toolchain/ld/mps2-an386.ld", R"(PSRAM \(rw\) *: ORIGIN = (0x\w+), LENGTH = (\d+)M\s)"),
            (Numbers{kPsram, kPsramBytes >> 20}));
  for (const std::uint32_t bank : {0U, 1U}) {
    const std::string script = "toolchain/ld/mps2-an386_slot" + std::to_string(bank + 1) + ".ld";
    EXPECT_EQ(numbers(script, R"(FLASH \(rx\) *: ORIGIN = (0x\w+), LENGTH = (\d+)K - (\d+)\s)"),
              (Numbers{program_page(bank, kSlotPage) + kHeaderBytes, kSlotPages * kProgramPageBytes / 1024,
                       kHeaderBytes}));
    // Working memory of a program ends where the flash begins.
    EXPECT_EQ(numbers(script, R"(PSRAM \(rw\) *: ORIGIN = (0x\w+), LENGTH = (\d+)M\s)"),
              (Numbers{kPsram, (kProgramFlash - kPsram) >> 20}));
  }
}

// check_boot.py counts from the begin of the PSRAM.
TEST(ProgramMap, TheTestOfTheBootLoaderHasItsAddresses) {
  const std::string script = "tests/boot/check_boot.py";
  EXPECT_EQ(numbers(script, R"(\nPSRAM, PSRAM_BYTES = (0x\w+), (\d+) << 20\n)"),
            (Numbers{kPsram, kPsramBytes >> 20}));
  EXPECT_EQ(numbers(script, R"(\nFLASH = (0x\w+)\n)"), Numbers{kProgramFlash - kPsram});
  EXPECT_EQ(numbers(script, R"(\nPAGE, BANK = (\d+), (\d+) \* (\d+)\n)"),
            (Numbers{kProgramPageBytes, kProgramBankBytes / kProgramPageBytes, kProgramPageBytes}));
  EXPECT_EQ(numbers(script, R"(\nSLOT = \[FLASH \+ (\d+) \* PAGE, FLASH \+ BANK \+ (\d+) \* PAGE\]\n)"),
            (Numbers{kSlotPage, kSlotPage}));
  EXPECT_EQ(numbers(script, R"(\nNOTES = \[FLASH \+ BANK \+ (\d+) \* PAGE, FLASH \+ (\d+) \* PAGE\]\n)"),
            (Numbers{kNotesPage, kNotesPage}));
  const Numbers behind = numbers(
      script,
      R"(\nSUPPLY, ORDERS, FILE = FLASH \+ 2 \* BANK, FLASH \+ 2 \* BANK \+ (\d+), FLASH \+ (0x\w+)\n)");
  EXPECT_EQ(
      behind,
      numbers("tests/boot/program.cpp",
              R"(kOrders = mps2::kProgramSupply \+ (\d+);\n.*kFile = mps2::kProgramFlash \+ (0x\w+);)"));
}

}  // namespace
}  // namespace slipstack::mps2
