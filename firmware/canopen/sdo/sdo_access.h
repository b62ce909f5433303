// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "firmware/canopen/objects/dictionary.h"

namespace slipstack::canopen {

/// The object that an SDO transfer reads or writes, byte by byte. Nothing is kept of what is transferred but
/// 8 bytes: values are written when they are complete, domains go part by part to the device.
class SdoAccess {
 public:
  explicit SdoAccess(Dictionary& dictionary) : dictionary_(dictionary) {}

  std::uint16_t index() const { return index_; }
  std::uint8_t sub() const { return sub_; }
  void set_address(std::uint16_t index, std::uint8_t sub) {
    index_ = index;
    sub_ = sub;
  }

  /// Bytes of the whole transfer; 0: not stated by the master.
  std::uint32_t size() const { return size_; }
  /// Bytes read or written so far.
  std::uint32_t offset() const { return offset_; }
  std::uint32_t remaining() const { return size_ - offset_; }

  // ---- upload ----

  /// Finds the object, its size and what to send.
  Abort begin_upload(std::uint16_t index, std::uint8_t sub) {
    Abort code = find(index, sub);
    if (code != Abort::kNone) return code;
    if (!object().readable()) return Abort::kWriteOnly;
    code = dictionary_.access().check_read(row_);
    if (code != Abort::kNone) return code;
    if (is_domain()) return dictionary_.access().begin_upload(row_, size_);
    if (object().text != nullptr) {
      size_ = static_cast<std::uint32_t>(std::strlen(object().text));
      return Abort::kNone;
    }
    size_ = static_cast<std::uint32_t>(size_of(object().type));
    to_bytes(dictionary_.read(row_), value_);
    return Abort::kNone;
  }

  /// Bytes from `at` on, wherever the transfer has come to.
  void copy(std::uint32_t at, std::span<std::uint8_t> out) const {
    if (is_domain()) {
      dictionary_.access().upload(row_, at, out);
    } else if (object().text != nullptr) {
      std::memcpy(out.data(), object().text + at, out.size());
    } else {
      std::copy_n(value_.begin() + at, out.size(), out.begin());
    }
  }
  /// The next bytes.
  void read(std::span<std::uint8_t> out) {
    copy(offset_, out);
    offset_ += static_cast<std::uint32_t>(out.size());
  }

  // ---- download ----

  /// `size`: as the master states it, 0 if it does not.
  Abort begin_download(std::uint16_t index, std::uint8_t sub, std::uint32_t size) {
    const Abort code = find(index, sub);
    if (code != Abort::kNone) return code;
    if (!object().writable()) return Abort::kReadOnly;
    size_ = size;
    if (is_domain()) return dictionary_.access().begin_download(row_, size);
    const auto wanted = static_cast<std::uint32_t>(size_of(object().type));
    if (size != 0 && size != wanted) return size > wanted ? Abort::kTooLong : Abort::kTooShort;
    return Abort::kNone;
  }

  /// Bytes of an expedited download whose size the master does not state.
  std::uint32_t expedited_size() const {
    if (size_ != 0) return size_;
    return is_domain() ? 4U : static_cast<std::uint32_t>(size_of(object().type));
  }

  Abort write(std::span<const std::uint8_t> bytes) {
    if (size_ != 0 && offset_ + bytes.size() > size_) return Abort::kTooLong;
    if (is_domain()) {
      const Abort code = dictionary_.access().download(row_, offset_, bytes);
      if (code != Abort::kNone) return code;
    } else {
      if (offset_ + bytes.size() > size_of(object().type)) return Abort::kTooLong;
      std::copy(bytes.begin(), bytes.end(), value_.begin() + offset_);
    }
    offset_ += static_cast<std::uint32_t>(bytes.size());
    return Abort::kNone;
  }

  /// All bytes are there: the value takes effect.
  Abort finish_download() {
    if (size_ != 0 && offset_ != size_) return Abort::kLength;
    if (is_domain()) return dictionary_.access().end_download(row_, offset_);
    const std::size_t wanted = size_of(object().type);
    if (offset_ != wanted) return Abort::kTooShort;
    return dictionary_.write(row_, from_bytes(object().type, std::span(value_).first(wanted)));
  }

 private:
  Abort find(std::uint16_t index, std::uint8_t sub) {
    set_address(index, sub);
    offset_ = 0;
    row_ = find_row(index, sub);
    if (row_ != kNoRow) return Abort::kNone;
    return has_index(index) ? Abort::kNoSubIndex : Abort::kNoObject;
  }
  const Object& object() const { return kObjects[row_]; }
  bool is_domain() const { return object().type == Type::kDomain; }

  Dictionary& dictionary_;
  std::uint16_t index_ = 0;
  std::uint8_t sub_ = 0;
  std::size_t row_ = 0;
  std::uint32_t size_ = 0;
  std::uint32_t offset_ = 0;
  std::array<std::uint8_t, 8> value_{};
};

}  // namespace slipstack::canopen
