// SPDX-License-Identifier: Apache-2.0
// Holds every address, offset, field and interrupt number of hal/stm32g474/registers.def against the part's
// tables.
#include "hal/stm32g474/registers.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

namespace slipstack::stm32g474 {
namespace {

std::filesystem::path tables() {
  const char* const variable = std::getenv("SLIPSTACK_SHARED");
  const std::filesystem::path root = variable != nullptr ? variable : SLIPSTACK_SOURCE_DIR "/../shared";
  return root / "data" / "stm32g474";
}

// Rows of a CSV file without its header.
std::vector<std::vector<std::string>> rows_of(const std::string& name) {
  std::ifstream file(tables() / name);
  std::vector<std::vector<std::string>> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::vector<std::string> cells;
    std::stringstream cells_of_line(line);
    for (std::string cell; std::getline(cells_of_line, cell, ',');) cells.push_back(cell);
    rows.push_back(cells);
  }
  return rows;
}

std::uint32_t number(const std::string& text) {
  return static_cast<std::uint32_t>(std::stoul(text, nullptr, 0));
}

#define SKIP_WITHOUT_TABLES() \
  if (!std::filesystem::exists(tables() / "registers.csv")) GTEST_SKIP() << "SKIP: no tables in " << tables()

// NOLINTBEGIN(bugprone-macro-parentheses): the arguments are names and literals.
struct Named {
  std::string name;
  std::uint32_t value;
};

TEST(Registers, AddressesAreThoseOfThePart) {
  SKIP_WITHOUT_TABLES();
  std::map<std::string, std::uint32_t> table;
  for (const auto& row : rows_of("registers.csv")) {
    if (row[0] == "base") table[row[1]] = number(row[3]);
  }
  const std::vector<Named> ours = {
#define SLIPSTACK_BASE(peripheral, address) {#peripheral, k##peripheral##_BASE},
#define SLIPSTACK_BASE_NOT_TABLED(peripheral, address)
#include "hal/stm32g474/registers.def"
  };
  ASSERT_GE(ours.size(), 19U);
  for (const Named& base : ours) {
    ASSERT_TRUE(table.contains(base.name)) << base.name;
    EXPECT_EQ(base.value, table[base.name]) << base.name;
  }
}

TEST(Registers, OffsetsAreThoseOfThePart) {
  SKIP_WITHOUT_TABLES();
  std::map<std::string, std::uint32_t> table;
  for (const auto& row : rows_of("registers.csv")) {
    if (row[0] == "register") table[row[1] + "." + row[2]] = number(row[3]);
  }
  const std::vector<Named> ours = {
#define SLIPSTACK_REGISTER(block, member, peripheral, name, offset) \
  {#peripheral "." #name, offsetof(block<std::uint32_t>, member)},
#define SLIPSTACK_REGISTER_NOT_TABLED(block, member, peripheral, name, offset)
#include "hal/stm32g474/registers.def"
  };
  ASSERT_GE(ours.size(), 150U);
  for (const Named& entry : ours) {
    ASSERT_TRUE(table.contains(entry.name)) << entry.name;
    EXPECT_EQ(entry.value, table[entry.name]) << entry.name;
  }
}

// A member without a line in registers.def would be checked by nothing.
TEST(Registers, EveryMemberOfEveryBlockIsInTheTable) {
  std::set<std::string> listed;
#define SLIPSTACK_REGISTER(block, member, peripheral, name, offset) listed.insert(#block "." #member);
#include "hal/stm32g474/registers.def"
  std::ifstream header(SLIPSTACK_SOURCE_DIR "/hal/stm32g474/registers.h");
  ASSERT_TRUE(header);
  const std::regex block_line("struct (\\w+) \\{");
  const std::regex member_line("  Word (\\w+)(\\[\\d+\\])?;.*");
  std::string block;
  std::size_t members = 0;
  for (std::string line; std::getline(header, line);) {
    std::smatch match;
    if (std::regex_match(line, match, block_line)) block = match[1];
    if (!std::regex_match(line, match, member_line)) continue;
    if (block.starts_with("Can") || match[1].str().starts_with("reserved")) continue;  // message RAM
    ++members;
    EXPECT_TRUE(listed.contains(block + "." + match[1].str())) << block << "." << match[1];
  }
  EXPECT_EQ(members, listed.size());
}

TEST(Registers, FieldsAreThoseOfThePart) {
  SKIP_WITHOUT_TABLES();
  std::map<std::string, std::pair<std::uint32_t, std::uint32_t>> table;
  for (const auto& row : rows_of("bits.csv")) table[row[0]] = {number(row[1]), number(row[2])};
  const std::vector<std::tuple<std::string, Field>> ours = {
#define SLIPSTACK_FIELD(peripheral, register_name, field, position, mask) \
  {#peripheral "_" #register_name "_" #field, k##peripheral##_##register_name##_##field},
#define SLIPSTACK_FIELD_NOT_TABLED(peripheral, register_name, field, position, mask)
#include "hal/stm32g474/registers.def"
  };
  ASSERT_GE(ours.size(), 200U);
  for (const auto& [name, field] : ours) {
    ASSERT_TRUE(table.contains(name)) << name;
    EXPECT_EQ(field.position, table[name].first) << name;
    EXPECT_EQ(field.mask, table[name].second) << name;
  }
}

// What is marked as missing in the tables must be missing, or it escapes the comparison.
TEST(Registers, OnlyWhatIsMissingInTheTablesIsExcused) {
  SKIP_WITHOUT_TABLES();
  std::set<std::string> table;
  for (const auto& row : rows_of("bits.csv")) table.insert(row[0]);
  const std::vector<std::string> excused = {
#define SLIPSTACK_FIELD(peripheral, register_name, field, position, mask)
#define SLIPSTACK_FIELD_NOT_TABLED(peripheral, register_name, field, position, mask) \
#peripheral "_" #register_name "_" #field,
#include "hal/stm32g474/registers.def"
  };
  EXPECT_EQ(excused.size(), 14U);
  for (const std::string& name : excused) EXPECT_FALSE(table.contains(name)) << name;
  std::set<std::string> places;
  for (const auto& row : rows_of("registers.csv")) places.insert(row[1] + "." + row[2]);
  const std::vector<std::string> excused_places = {
#define SLIPSTACK_BASE(peripheral, address)
#define SLIPSTACK_BASE_NOT_TABLED(peripheral, address) #peripheral ".",
#define SLIPSTACK_REGISTER(block, member, peripheral, name, offset)
#define SLIPSTACK_REGISTER_NOT_TABLED(block, member, peripheral, name, offset) #peripheral "." #name,
#define SLIPSTACK_FIELD(peripheral, register_name, field, position, mask)
#define SLIPSTACK_FIELD_NOT_TABLED(peripheral, register_name, field, position, mask)
#include "hal/stm32g474/registers.def"
  };
  EXPECT_EQ(excused_places.size(), 21U);
  for (const std::string& name : excused_places) EXPECT_FALSE(places.contains(name)) << name;
}

TEST(Registers, InterruptNumbersAreThoseOfThePart) {
  SKIP_WITHOUT_TABLES();
  std::map<std::string, std::uint32_t> table;
  for (const auto& row : rows_of("interrupts.csv")) {
    if (!row[1].starts_with("-")) table[row[0]] = number(row[1]);
  }
  std::uint32_t highest = 0;
  for (const auto& [name, irq] : table) highest = std::max(highest, irq);
  EXPECT_EQ(highest, 101U) << "startup.cpp has 102 vectors";
  const std::vector<Named> ours = {
#define SLIPSTACK_INTERRUPT(name, number) {#name "_IRQn", k##name##_IRQ},
#include "hal/stm32g474/registers.def"
  };
  ASSERT_EQ(ours.size(), 3U);
  for (const Named& interrupt : ours) {
    ASSERT_TRUE(table.contains(interrupt.name)) << interrupt.name;
    EXPECT_EQ(interrupt.value, table[interrupt.name]) << interrupt.name;
  }
}

// NOLINTEND(bugprone-macro-parentheses)

TEST(Registers, FieldsInPiecesTakeTheirBitsInOrder) {
  EXPECT_EQ(kTIM_SMCR_SMS(3), 0x00000003U);
  EXPECT_EQ(kTIM_SMCR_SMS(8), 0x00010000U);  // the fourth bit lies at 16
  EXPECT_EQ(kTIM_CCMR2_OC4M(7), 0x00007000U);
  EXPECT_EQ(kTIM_CCMR2_OC4M(15), 0x01007000U);
  EXPECT_EQ(kTIM_CR2_MMS2(7), 0x00700000U);
}

TEST(Registers, FieldsReadWhatTheyPlace) {
  for (const Field& field : {kFDCAN_NBTP_NTSEG1, kADC_JSQR_JSQ1, kRCC_PLLCFGR_PLLN, kFLASH_CR_PNB}) {
    for (std::uint32_t value = 0; value <= field.max(); ++value) {
      ASSERT_EQ(field.read(field.place(value)), value);
      ASSERT_EQ(field.place(value) & ~field.mask, 0U);
    }
  }
}

}  // namespace
}  // namespace slipstack::stm32g474
