// SPDX-License-Identifier: Apache-2.0
// The linker scripts and toolchain/check-image name the addresses of hal/stm32g474/flash_map.h.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <regex>
#include <string>

#include "firmware/update/image_header.h"
#include "hal/stm32g474/flash_map.h"
#include "tests/unit/project_text.h"

namespace slipstack::stm32g474 {
namespace {

constexpr auto kHeaderBytes = static_cast<std::uint32_t>(update::kHeaderBlock);

struct Memory {
  std::uint32_t begin;
  std::uint32_t bytes;
};

/// The line FLASH of a linker script: "ORIGIN = 0x08007200, LENGTH = 224K - 512".
Memory flash_of(const std::string& script) {
  const std::string text = project_text("toolchain/ld/" + script);
  std::smatch found;
  const std::regex line(R"(FLASH \(rx\) *: ORIGIN = (0x[0-9A-F]+), LENGTH = (\d+)K(?: - (\d+))?)");
  if (!std::regex_search(text, found, line)) {
    ADD_FAILURE() << script << " has no line of this form";
    return {};
  }
  const auto number = [&](std::size_t i) {
    return found[i].matched ? static_cast<std::uint32_t>(std::stoul(found[i], nullptr, 0)) : 0U;
  };
  return {number(1), number(2) * 1024 - number(3)};
}

TEST(MemoryMap, TheLinkerScriptsHaveTheAddressesOfTheFlashMap) {
  const Memory boot = flash_of("stm32g474_boot.ld");
  EXPECT_EQ(boot.begin, kBootLoader.begin());
  EXPECT_EQ(boot.bytes, kBootLoader.pages * kFlashPageBytes);
  for (const std::uint32_t bank : {0U, 1U}) {
    const Memory slot = flash_of(bank == 0 ? "stm32g474_slot1.ld" : "stm32g474_slot2.ld");
    EXPECT_EQ(slot.begin, slot_in(bank).begin() + kHeaderBytes);
    EXPECT_EQ(slot.bytes, slot_in(bank).pages * kFlashPageBytes - kHeaderBytes);
  }
  const Memory alone = flash_of("stm32g474.ld");
  EXPECT_EQ(alone.begin, kFlashBegin);
  EXPECT_LE(alone.bytes, parameters_in(0).begin() - kFlashBegin)
      << "an image without boot loader reaches the parameters";
}

TEST(MemoryMap, TheCheckOfImagesHasTheAddressesOfTheFlashMap) {
  const std::string text = project_text("toolchain/check-image");
  const auto has = [&](const std::string& line) { return text.find(line) != std::string::npos; };
  EXPECT_TRUE(has("PARAMETER_BYTES = " + std::to_string(parameters_in(0).pages) + " * " +
                  std::to_string(kFlashPageBytes)));
  EXPECT_TRUE(has("SLOT_PROGRAM_BYTES = " + std::to_string(slot_in(0).pages * kFlashPageBytes / 1024) +
                  " * 1024 - " + std::to_string(kHeaderBytes)));
  for (const std::uint32_t bank : {0U, 1U}) {
    std::array<char, 32> place{};
    std::snprintf(place.data(), place.size(), "0x%08X: SLOT_PROGRAM_BYTES",
                  static_cast<unsigned>(slot_in(bank).begin() + kHeaderBytes));
    EXPECT_TRUE(has(place.data())) << place.data();
  }
}

}  // namespace
}  // namespace slipstack::stm32g474
