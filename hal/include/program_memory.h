// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "hal/include/nonvolatile.h"

namespace slipstack {

/// Flash for programs: two slots, of which one runs. What the running program may write lies where writing
/// does not hold the processor up (on a part with two banks: in the bank that does not run). Used outside the
/// tick.
class ProgramMemory {
 public:
  static constexpr std::size_t kSlots = 2;

  /// 0 or 1.
  virtual std::size_t running() const = 0;
  /// Which board: an image says for which it is made.
  virtual std::uint32_t board() const = 0;
  /// Where a slot begins: an image is linked for one of them.
  virtual std::uint32_t address(std::size_t slot) const = 0;
  /// The pages of a slot, to be read: bytes that cannot be read are reported and do no harm.
  virtual const Nonvolatile& program(std::size_t slot) const = 0;
  /// The pages of the slot that does not run, to be written.
  virtual Nonvolatile& spare() = 0;
  /// A page for notes about a slot. That of the running one may be written.
  virtual Nonvolatile& notes(std::size_t slot) = 0;
  /// As after power comes: the boot loader decides anew what runs. Motor off first.
  virtual void restart() = 0;

 protected:
  ~ProgramMemory() = default;
};

}  // namespace slipstack
