// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

// A register that behaves: stands for the volatile word in the blocks of hal/stm32g474/registers.h.
namespace slipstack::stm32g474::test {

struct SimWord {
  std::uint32_t value = 0;
  // What a read gives, from what is stored; may change the device.
  std::function<std::uint32_t(std::uint32_t)> on_read;
  // What a write does; without it the value is stored.
  std::function<void(SimWord&, std::uint32_t)> on_write;
  std::uint32_t writes = 0;

  // Converts as a volatile word does.
  operator std::uint32_t() const {  // NOLINT(google-explicit-constructor)
    return on_read ? on_read(value) : value;
  }
  SimWord& operator=(std::uint32_t written) {
    ++writes;
    if (on_write) {
      on_write(*this, written);
    } else {
      value = written;
    }
    return *this;
  }
};

// The bits written as 1 go to 0.
inline void clear_by_one(SimWord& word) {
  word.on_write = [](SimWord& self, std::uint32_t written) { self.value &= ~written; };
}

// The bits written as 0 go to 0; writing 1 does nothing.
inline void clear_by_zero(SimWord& word) {
  word.on_write = [](SimWord& self, std::uint32_t written) { self.value &= written; };
}

// Writes to several registers, in their order.
class Journal {
 public:
  struct Write {
    std::string name;
    std::uint32_t value;
  };

  // Notes every write to the word; what it did before it still does.
  void watch(SimWord& word, const std::string& name) {
    auto before = word.on_write;
    word.on_write = [this, name, before](SimWord& self, std::uint32_t written) {
      writes_.push_back({name, written});
      if (before) {
        before(self, written);
      } else {
        self.value = written;
      }
    };
  }

  const std::vector<Write>& writes() const { return writes_; }

  // Index of the first write to `name` with all bits of `mask` as in `bits`; -1 when there is none.
  int first(const std::string& name, std::uint32_t mask, std::uint32_t bits) const {
    for (std::size_t i = 0; i < writes_.size(); ++i) {
      if (writes_[i].name == name && (writes_[i].value & mask) == bits) return static_cast<int>(i);
    }
    return -1;
  }

 private:
  std::vector<Write> writes_;
};

}  // namespace slipstack::stm32g474::test
