// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <vector>

#include "hal/stm32g474/flash_pages.h"
#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474::test {

// The flash interface and its 512 KiB, as RM0440 describes them.
struct SimulatedFlash {
  Flash<SimWord> registers;
  CarefulRead careful;
  std::vector<std::uint32_t> words = std::vector<std::uint32_t>(kFlashBytes / 4, 0xFFFFFFFF);
  std::set<std::uint32_t> torn;       // double words whose code is wrong
  std::set<std::uint32_t> read_only;  // double words that do not take what is written
  std::uint32_t keys = 0;
  bool key_works = true;
  std::uint32_t busy_reads = 0;
  std::uint32_t busy_for = 3;
  bool stuck = false;
  bool erases = true;
  std::uint32_t error_at_end = 0;           // an error flag that the next command raises
  std::vector<std::uint32_t> erased_pages;  // 0 ... 255
  std::uint32_t programmed = 0;
  std::set<std::uint32_t> written_banks;
  bool misused = false;
  bool cached_access = false;
  bool unexpected_nmi = false;
  bool half = false;
  std::uint32_t half_address = 0;
  std::uint32_t half_word = 0;

  struct Memory {
    SimulatedFlash& flash;
    std::uint32_t read_word(std::uint32_t address) { return flash.read_word(address); }
    void write_word(std::uint32_t address, std::uint32_t value) { flash.write_word(address, value); }
  } memory{*this};

  SimulatedFlash(const SimulatedFlash&) = delete;
  SimulatedFlash& operator=(const SimulatedFlash&) = delete;
  SimulatedFlash() {
    registers.acr.value = 0x704;
    registers.optr.value = 1U << 22U;
    registers.cr.value = 0xC0000000;
    registers.keyr.on_write = [this](SimWord&, std::uint32_t written) {
      if (keys == 0 && written == 0x45670123) {
        keys = 1;
      } else if (keys == 1 && written == 0xCDEF89AB && key_works) {
        registers.cr.value &= ~(1U << 31U);
        keys = 0;
      } else if (key_works) {
        misused = true;  // the part would fault and stay locked until reset
      }
    };
    registers.cr.on_write = [this](SimWord& self, std::uint32_t written) {
      if ((self.value >> 31U) != 0 && written != self.value) {
        misused = true;
        return;
      }
      if (busy_reads > 0) misused = true;
      self.value = written & ~(1U << 16U);
      if ((written & (1U << 16U)) != 0) erase(written);
    };
    registers.sr.on_read = [this](std::uint32_t value) {
      if (stuck) return value | 1U << 16U;
      if (busy_reads > 0) {
        --busy_reads;
        return value | 1U << 16U;
      }
      return value;
    };
    registers.sr.on_write = [](SimWord& self, std::uint32_t written) { self.value &= ~written; };
    registers.eccr.on_write = [](SimWord& self, std::uint32_t written) {
      self.value &= ~(written & 0xF0000000U);
    };
  }

  void finish() {
    busy_reads = busy_for;
    registers.sr.value |= error_at_end != 0 ? error_at_end : 1U;
  }

  void erase(std::uint32_t command) {
    if ((command & 2U) == 0 || (registers.acr.value & (1U << 10U)) != 0) misused = true;
    const std::uint32_t page = (command >> 3U & 0x7FU) + ((command & 1U << 11U) != 0 ? 128 : 0);
    erased_pages.push_back(page);
    if (erases && error_at_end == 0) {
      for (std::uint32_t i = 0; i < 512; ++i) words[page * 512 + i] = 0xFFFFFFFF;
      for (std::uint32_t i = 0; i < 256; ++i) torn.erase(kFlashBegin + page * 2048 + 8 * i);
    }
    finish();
  }

  std::uint32_t& word_at(std::uint32_t address) { return words.at((address - kFlashBegin) / 4); }

  std::uint32_t read_word(std::uint32_t address) {
    EXPECT_EQ(address % 4, 0U);
    if ((registers.acr.value & (1U << 10U)) != 0) cached_access = true;
    if (torn.contains(address & ~7U)) {
      registers.eccr.value |= 1U << 31U;
      if (!on_flash_nmi(registers, careful)) unexpected_nmi = true;
    }
    return word_at(address);
  }

  void write_word(std::uint32_t address, std::uint32_t value) {
    if ((registers.cr.value & 1U) == 0 || busy_reads > 0) misused = true;
    if (!half) {
      if (address % 8 != 0) misused = true;
      half = true;
      half_address = address;
      half_word = value;
      return;
    }
    half = false;
    if (address != half_address + 4) misused = true;
    ++programmed;
    written_banks.insert(bank_of(half_address));
    const bool blank =
        word_at(half_address) == 0xFFFFFFFF && word_at(address) == 0xFFFFFFFF && !torn.contains(half_address);
    if (!blank && (half_word != 0 || value != 0)) {
      registers.sr.value |= 1U << 3U;  // PROGERR
    } else if (error_at_end == 0 && !read_only.contains(half_address)) {
      word_at(half_address) = half_word;
      word_at(address) = value;
    }
    finish();
  }

  void expect_at_rest() const {
    EXPECT_FALSE(misused);
    EXPECT_FALSE(cached_access);
    EXPECT_FALSE(unexpected_nmi);
    EXPECT_EQ(registers.acr.value, 0x704U) << "the cache must be back as it was";
    EXPECT_FALSE(careful.reading);
  }
};

}  // namespace slipstack::stm32g474::test
