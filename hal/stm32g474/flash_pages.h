// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "hal/include/nonvolatile.h"
#include "hal/stm32g474/flash_map.h"
#include "hal/stm32g474/registers.h"

// Pages of the flash, erased and written by the program that runs. RM0440, Embedded flash memory (FLASH) for
// category 3 devices: dual-bank mode, page erase sequence, standard programming, ECC.
//
// A program is given pages of the other bank only (flash_map.h), so that the processor goes on while a page
// is erased (22 ms) or written (82 us for 8 bytes; DS12288, flash memory characteristics): the tick is not
// held up.
namespace slipstack::stm32g474 {

// When power fails while 8 bytes are written, their error-correcting code may be wrong in two bits or more:
// reading them raises the NMI, which cannot be masked. Reads of these pages are therefore announced
// here, and the NMI's handler (on_flash_nmi) takes such an error as the answer to the read and not as a fault
// of the controller.
struct CarefulRead {
  volatile bool reading = false;
  volatile bool failed = false;
};

// For the NMI's handler: true when it was an uncorrectable error of an announced read, which is now noted and
// cleared.
template <class Word>
bool on_flash_nmi(Flash<Word>& flash, CarefulRead& careful) {
  if ((flash.eccr & kFLASH_ECCR_ECCD.mask) == 0 || !careful.reading) return false;
  careful.failed = true;
  set_bits(flash.eccr, kFLASH_ECCR_ECCD(1));  // clears by writing 1
  return true;
}

// Memory: `std::uint32_t read_word(std::uint32_t address)`, complete with its NMI, if any, when it returns;
// and `void write_word(std::uint32_t address, std::uint32_t value)`.
template <class FlashBlock, class Memory>
class FlashPages final : public Nonvolatile {
 public:
  FlashPages(FlashBlock& flash, Memory& memory, CarefulRead& careful, FlashRegion region)
      : flash_(flash), memory_(memory), careful_(careful), region_(region) {}

  std::size_t page_count() const override { return region_.pages; }
  std::size_t page_size() const override { return kFlashPageBytes; }
  std::size_t write_unit() const override { return kUnit; }

  // kDeviceError: at least one byte cannot be read (power failed while it was written); `out` is then not to
  // be used.
  NonvolatileStatus read(std::size_t page, std::size_t offset, std::span<std::byte> out) const override {
    if (!inside(page, offset, out.size())) return NonvolatileStatus::kOutOfRange;
    const CacheOff cache_off(flash_);  // a cached word would hide its error
    bool readable = true;
    for (std::size_t done = 0; done < out.size();) {
      const std::uint32_t address = address_of(page, offset + done);
      const std::uint32_t within = address % 4;
      std::uint32_t word = 0;
      if (!read_word(address - within, word)) readable = false;
      std::byte bytes[4];
      std::memcpy(bytes, &word, 4);
      for (std::size_t i = within; i < 4 && done < out.size(); ++i, ++done) out[done] = bytes[i];
    }
    return readable ? NonvolatileStatus::kOk : NonvolatileStatus::kDeviceError;
  }

  // About 90 us for every 8 bytes. kNotErased: nothing was written. Every unit is read back.
  NonvolatileStatus write(std::size_t page, std::size_t offset, std::span<const std::byte> data) override {
    if (!inside(page, offset, data.size())) return NonvolatileStatus::kOutOfRange;
    if (offset % kUnit != 0 || data.size() % kUnit != 0) return NonvolatileStatus::kMisaligned;
    const CacheOff cache_off(flash_);
    if (!erased(address_of(page, offset), data.size())) return NonvolatileStatus::kNotErased;
    if (!unlock()) return NonvolatileStatus::kDeviceError;
    bool good = true;
    for (std::size_t done = 0; done < data.size() && good; done += kUnit) {
      std::uint32_t words[2];
      std::memcpy(words, data.data() + done, kUnit);
      good = program(address_of(page, offset + done), words);
    }
    lock();
    return good ? NonvolatileStatus::kOk : NonvolatileStatus::kDeviceError;
  }

  // About 22 ms. The page is read afterwards: what is not blank is an error.
  NonvolatileStatus erase(std::size_t page) override {
    if (page >= region_.pages) return NonvolatileStatus::kOutOfRange;
    const CacheOff cache_off(flash_);
    if (!unlock()) return NonvolatileStatus::kDeviceError;
    const std::uint32_t number = region_.first_page + static_cast<std::uint32_t>(page);
    const std::uint32_t command =
        kFLASH_CR_PER(1) | kFLASH_CR_BKER.place(region_.bank) | kFLASH_CR_PNB.place(number);
    flash_.cr = command;
    flash_.cr = command | kFLASH_CR_STRT(1);
    const bool good = finished();
    flash_.cr = 0;
    lock();
    return good && erased(address_of(page, 0), kFlashPageBytes) ? NonvolatileStatus::kOk
                                                                : NonvolatileStatus::kDeviceError;
  }

 private:
  static constexpr std::size_t kUnit = 8;
  // 24.5 ms at most for a page (DS12288), 6 cycles or more a poll at 170 MHz: this is 94 ms at least.
  static constexpr std::uint32_t kPolls = 4'000'000;
  static constexpr std::uint32_t kErrors =
      kFLASH_SR_OPERR.mask | kFLASH_SR_PROGERR.mask | kFLASH_SR_WRPERR.mask | kFLASH_SR_PGAERR.mask |
      kFLASH_SR_SIZERR.mask | kFLASH_SR_PGSERR.mask | kFLASH_SR_MISERR.mask | kFLASH_SR_FASTERR.mask |
      kFLASH_SR_RDERR.mask | kFLASH_SR_OPTVERR.mask;

  // The data cache is off while flash is written, erased, or read with care, and comes back empty: it does
  // not see what changes below it.
  class CacheOff {
   public:
    explicit CacheOff(FlashBlock& flash) : flash_(flash), was_on_((flash.acr & kFLASH_ACR_DCEN.mask) != 0) {
      clear_bits(flash_.acr, kFLASH_ACR_DCEN.mask);
    }
    CacheOff(const CacheOff&) = delete;
    CacheOff& operator=(const CacheOff&) = delete;
    ~CacheOff() {
      set_bits(flash_.acr, kFLASH_ACR_DCRST(1));
      clear_bits(flash_.acr, kFLASH_ACR_DCRST.mask);
      if (was_on_) set_bits(flash_.acr, kFLASH_ACR_DCEN(1));
    }

   private:
    FlashBlock& flash_;
    bool was_on_;
  };

  bool inside(std::size_t page, std::size_t offset, std::size_t size) const {
    return page < region_.pages && offset <= kFlashPageBytes && size <= kFlashPageBytes - offset;
  }

  std::uint32_t address_of(std::size_t page, std::size_t offset) const {
    return region_.begin() + static_cast<std::uint32_t>(page * kFlashPageBytes + offset);
  }

  // False when the word's code has more than one wrong bit.
  bool read_word(std::uint32_t address, std::uint32_t& word) const {
    careful_.failed = false;
    careful_.reading = true;
    word = memory_.read_word(address);
    careful_.reading = false;
    return !careful_.failed;
  }

  bool erased(std::uint32_t address, std::size_t size) const {
    for (std::uint32_t at = 0; at < size; at += 4) {
      std::uint32_t word = 0;
      if (!read_word(address + at, word) || word != 0xFFFFFFFF) return false;
    }
    return true;
  }

  // In single-bank mode (an option byte) pages are twice as large and elsewhere: refused.
  bool unlock() {
    if ((flash_.optr & kFLASH_OPTR_DBANK.mask) == 0) return false;
    if (!wait_for(flash_.sr, kFLASH_SR_BSY.mask, 0, kPolls)) return false;
    if ((flash_.cr & kFLASH_CR_LOCK.mask) != 0) {
      flash_.keyr = 0x45670123;
      flash_.keyr = 0xCDEF89AB;
    }
    if ((flash_.cr & kFLASH_CR_LOCK.mask) != 0) return false;
    flash_.sr = kErrors | kFLASH_SR_EOP.mask;  // clears by writing 1: old errors forbid a new command
    return true;
  }

  void lock() { flash_.cr = kFLASH_CR_LOCK(1); }

  bool program(std::uint32_t address, const std::uint32_t (&words)[2]) {
    flash_.cr = kFLASH_CR_PG(1);
    memory_.write_word(address, words[0]);
    memory_.write_word(address + 4, words[1]);
    const bool good = finished();
    flash_.cr = 0;
    std::uint32_t stored[2] = {0, 0};
    const bool readable = read_word(address, stored[0]) && read_word(address + 4, stored[1]);
    return good && readable && stored[0] == words[0] && stored[1] == words[1];
  }

  // Waits for the end of the command. Clears its flags.
  bool finished() {
    const bool ended = wait_for(flash_.sr, kFLASH_SR_BSY.mask, 0, kPolls);
    const std::uint32_t errors = flash_.sr & kErrors;
    flash_.sr = kErrors | kFLASH_SR_EOP.mask;
    return ended && errors == 0;
  }

  FlashBlock& flash_;
  Memory& memory_;
  CarefulRead& careful_;
  FlashRegion region_;
};

}  // namespace slipstack::stm32g474
