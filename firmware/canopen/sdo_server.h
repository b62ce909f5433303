// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "firmware/canopen/counter.h"
#include "firmware/canopen/dictionary.h"

namespace slipstack::canopen {

using SdoFrame = std::array<std::uint8_t, 8>;

/// CRC of block transfers: CCITT, polynomial 1021h, begin 0 (CiA 301, 7.2.4.3.16). Check value of
/// "123456789": 31C3h.
constexpr std::uint16_t sdo_crc(std::span<const std::uint8_t> bytes, std::uint16_t crc = 0) {
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ (byte << 8));
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint16_t>((crc & 0x8000) != 0 ? (crc << 1) ^ 0x1021 : crc << 1);
    }
  }
  return crc;
}

/// One SDO server (CiA 301, 7.2.4): expedited, segmented and block transfer both ways. At most one transfer
/// at a time; a new one from the master ends the one before. Nothing is kept of what is transferred but 8
/// bytes: values are taken when they are complete, domains go piece by piece to what stands behind the
/// dictionary.
///
/// Cost: a frame in, at most one frame out, and what the object costs; the parts of a block upload by next().
class SdoServer {
 public:
  static constexpr std::uint32_t kTimeout_us = 1'000'000;  ///< between two frames of a transfer
  static constexpr std::uint8_t kBlockSegments = 127;

  explicit SdoServer(Dictionary& dictionary) : dictionary_(dictionary) {}

  void reset() { state_ = State::kIdle; }
  std::uint32_t aborts() const { return aborts_; }

  /// A request; true: `out` is to be sent.
  bool receive(const SdoFrame& in, std::uint32_t now_us, SdoFrame& out) {
    last_us_ = now_us;
    out = {};
    if (state_ == State::kBlockDownload && in[0] != 0x80) return block_segment(in, out);
    if (in[0] == 0x80) {
      state_ = State::kIdle;
      return false;
    }
    switch (in[0] >> 5) {
      case 0:
        return state_ == State::kDownload ? download_segment(in, out) : unexpected(in, out);
      case 1:
        return begin_download(in, out);
      case 2:
        return begin_upload(in, out);
      case 3:
        return state_ == State::kUpload ? upload_segment(in, out) : unexpected(in, out);
      case 5:
        return block_upload(in, out);
      case 6:
        return block_download(in, out);
      default:
        return unexpected(in, out);
    }
  }

  /// The next frame of a block upload, and the time-out; true: `out` is to be sent. Call only when there is
  /// room to send.
  bool next(std::uint32_t now_us, SdoFrame& out) {
    if (state_ != State::kIdle && now_us - last_us_ > kTimeout_us) return abort(Abort::kTimeout, out);
    if (state_ != State::kBlockSending) return false;
    const std::uint32_t at = offset_ + 7U * sent_;
    out = {};
    const std::uint32_t count = std::min<std::uint32_t>(size_ - at, 7U);
    fetch(at, std::span(out).subspan(1, count));
    ++sent_;
    const bool last = at + count >= size_;
    out[0] = static_cast<std::uint8_t>(sent_ | (last ? 0x80U : 0U));
    last_us_ = now_us;
    if (last || sent_ == block_) state_ = State::kBlockWaiting;
    return true;
  }

  bool busy() const { return state_ != State::kIdle; }

 private:
  enum class State : std::uint8_t {
    kIdle,
    kDownload,
    kUpload,
    kBlockDownload,
    kBlockDownloadEnd,  // the last segment is there
    kBlockReady,        // block upload announced, the master has not started it
    kBlockSending,
    kBlockWaiting,  // for the acknowledgement
    kBlockEnding    // for the end
  };

  bool abort(Abort code, SdoFrame& out) {
    out = {};
    out[0] = 0x80;
    out[1] = static_cast<std::uint8_t>(index_);
    out[2] = static_cast<std::uint8_t>(index_ >> 8);
    out[3] = sub_;
    to_bytes(static_cast<std::uint32_t>(code), std::span(out).subspan(4));
    state_ = State::kIdle;
    count(aborts_);
    return true;
  }

  // A segment without a transfer, or a command that is none. What was under way is lost.
  bool unexpected(const SdoFrame& in, SdoFrame& out) {
    if (state_ == State::kIdle) take_address(in);
    return abort(Abort::kCommand, out);
  }

  void take_address(const SdoFrame& in) {
    index_ = static_cast<std::uint16_t>(in[1] | (in[2] << 8));
    sub_ = in[3];
  }

  // The object of a request.
  Abort find(const SdoFrame& in) {
    state_ = State::kIdle;
    take_address(in);
    row_ = find_row(index_, sub_);
    if (row_ != kNoRow) return Abort::kNone;
    return has_index(index_) ? Abort::kNoSubIndex : Abort::kNoObject;
  }
  const Object& object() const { return kObjects[row_]; }
  bool is_domain() const { return object().type == Type::kDomain; }

  void answer(std::uint8_t command, SdoFrame& out) const {
    out = {command, static_cast<std::uint8_t>(index_), static_cast<std::uint8_t>(index_ >> 8), sub_, 0, 0, 0,
           0};
  }

  // ---- upload ----

  // Finds the size and what to send.
  Abort prepare_upload(const SdoFrame& in) {
    Abort code = find(in);
    if (code != Abort::kNone) return code;
    if (!object().readable()) return Abort::kWriteOnly;
    code = dictionary_.behind().check_read(row_);
    if (code != Abort::kNone) return code;
    offset_ = 0;
    if (is_domain()) return dictionary_.behind().begin_upload(row_, size_);
    if (object().text != nullptr) {
      size_ = static_cast<std::uint32_t>(std::strlen(object().text));
      return Abort::kNone;
    }
    size_ = static_cast<std::uint32_t>(size_of(object().type));
    to_bytes(dictionary_.read(row_), value_);
    return Abort::kNone;
  }

  void fetch(std::uint32_t at, std::span<std::uint8_t> out) {
    if (is_domain()) {
      dictionary_.behind().upload(row_, at, out);
    } else if (object().text != nullptr) {
      std::memcpy(out.data(), object().text + at, out.size());
    } else {
      std::copy_n(value_.begin() + at, out.size(), out.begin());
    }
  }

  bool begin_upload(const SdoFrame& in, SdoFrame& out) {
    const Abort code = prepare_upload(in);
    if (code != Abort::kNone) return abort(code, out);
    if (size_ <= 4 && size_ > 0) {
      answer(static_cast<std::uint8_t>(0x43U | ((4U - size_) << 2)), out);
      fetch(0, std::span(out).subspan(4, size_));
      return true;
    }
    answer(0x41, out);
    to_bytes(size_, std::span(out).subspan(4));
    toggle_ = 0;
    state_ = State::kUpload;
    return true;
  }

  bool upload_segment(const SdoFrame& in, SdoFrame& out) {
    if ((in[0] & 0x10) != toggle_) return abort(Abort::kToggle, out);
    const std::uint32_t count = std::min<std::uint32_t>(size_ - offset_, 7U);
    fetch(offset_, std::span(out).subspan(1, count));
    offset_ += count;
    const bool last = offset_ == size_;
    out[0] = static_cast<std::uint8_t>(toggle_ | ((7U - count) << 1) | (last ? 1U : 0U));
    toggle_ ^= 0x10;
    if (last) state_ = State::kIdle;
    return true;
  }

  // ---- download ----

  Abort prepare_download(const SdoFrame& in, std::uint32_t size) {
    const Abort code = find(in);
    if (code != Abort::kNone) return code;
    if (!object().writable()) return Abort::kReadOnly;
    size_ = size;
    offset_ = 0;
    if (is_domain()) return dictionary_.behind().begin_download(row_, size);
    const auto wanted = static_cast<std::uint32_t>(size_of(object().type));
    if (size != 0 && size != wanted) return size > wanted ? Abort::kTooLong : Abort::kTooShort;
    return Abort::kNone;
  }

  Abort take(std::span<const std::uint8_t> bytes) {
    if (size_ != 0 && offset_ + bytes.size() > size_) return Abort::kTooLong;
    if (is_domain()) {
      const Abort code = dictionary_.behind().download(row_, offset_, bytes);
      if (code != Abort::kNone) return code;
    } else {
      if (offset_ + bytes.size() > size_of(object().type)) return Abort::kTooLong;
      std::copy(bytes.begin(), bytes.end(), value_.begin() + offset_);
    }
    offset_ += static_cast<std::uint32_t>(bytes.size());
    return Abort::kNone;
  }

  // The value is complete.
  Abort finish() {
    state_ = State::kIdle;
    if (size_ != 0 && offset_ != size_) return Abort::kLength;
    if (is_domain()) return dictionary_.behind().end_download(row_, offset_);
    const std::size_t wanted = size_of(object().type);
    if (offset_ != wanted) return Abort::kTooShort;
    return dictionary_.write(row_, from_bytes(object().type, std::span(value_).first(wanted)));
  }

  bool begin_download(const SdoFrame& in, SdoFrame& out) {
    const bool expedited = (in[0] & 0x02) != 0;
    const bool sized = (in[0] & 0x01) != 0;
    const std::uint32_t data = from_bytes(Type::kU32, std::span(in).subspan(4));
    Abort code = Abort::kNone;
    if (expedited) {
      code = prepare_download(in, sized ? 4U - ((in[0] >> 2) & 3U) : 0U);
      if (code == Abort::kNone) {
        const std::size_t count = size_ != 0 ? size_ : (is_domain() ? 4 : size_of(object().type));
        code = take(std::span(in).subspan(4, count));
      }
      if (code == Abort::kNone) code = finish();
    } else {
      code = prepare_download(in, sized ? data : 0U);
    }
    if (code != Abort::kNone) return abort(code, out);
    answer(0x60, out);
    toggle_ = 0;
    if (!expedited) state_ = State::kDownload;
    return true;
  }

  bool download_segment(const SdoFrame& in, SdoFrame& out) {
    if ((in[0] & 0x10) != toggle_) return abort(Abort::kToggle, out);
    Abort code = take(std::span(in).subspan(1, 7U - ((in[0] >> 1) & 7U)));
    if (code == Abort::kNone && (in[0] & 1) != 0) code = finish();
    if (code != Abort::kNone) return abort(code, out);
    out[0] = static_cast<std::uint8_t>(0x20 | toggle_);
    toggle_ ^= 0x10;
    return true;
  }

  // ---- block download ----

  bool block_download(const SdoFrame& in, SdoFrame& out) {
    if ((in[0] & 1) != 0) return block_download_end(in, out);
    const bool sized = (in[0] & 2) != 0;
    const std::uint32_t size = sized ? from_bytes(Type::kU32, std::span(in).subspan(4)) : 0;
    const Abort code = prepare_download(in, size);
    if (code != Abort::kNone) return abort(code, out);
    check_ = (in[0] & 4) != 0;
    crc_ = 0;
    sent_ = 0;
    held_ = false;
    state_ = State::kBlockDownload;
    answer(0xA4, out);
    out[4] = kBlockSegments;
    return true;
  }

  // Segments in order are taken, the first one missing ends what can be taken of this block. How many bytes
  // of the last one count is known at the end only: it is held back.
  bool block_segment(const SdoFrame& in, SdoFrame& out) {
    const std::uint8_t number = in[0] & 0x7F;
    const bool last = (in[0] & 0x80) != 0;
    if (number == 0) return abort(Abort::kSequence, out);
    if (number == sent_ + 1) {
      const Abort code = held_ ? take_held(7) : Abort::kNone;
      if (code != Abort::kNone) return abort(code, out);
      ++sent_;
      std::copy(in.begin() + 1, in.end(), segment_.begin());
      held_ = true;
      if (last) state_ = State::kBlockDownloadEnd;
    }
    if (!last && number != kBlockSegments) return false;
    out = {0xA2, sent_, kBlockSegments, 0, 0, 0, 0, 0};
    sent_ = 0;
    return true;
  }

  Abort take_held(std::size_t count) {
    held_ = false;
    const std::span<const std::uint8_t> bytes(segment_.data(), count);
    crc_ = sdo_crc(bytes, crc_);
    return take(bytes);
  }

  bool block_download_end(const SdoFrame& in, SdoFrame& out) {
    if (state_ != State::kBlockDownloadEnd) return unexpected(in, out);
    Abort code = take_held(7U - ((in[0] >> 2) & 7U));
    if (code == Abort::kNone && check_ && from_bytes(Type::kU16, std::span(in).subspan(1, 2)) != crc_) {
      code = Abort::kCrc;
    }
    if (code == Abort::kNone) code = finish();
    if (code != Abort::kNone) return abort(code, out);
    out[0] = 0xA1;
    return true;
  }

  // ---- block upload ----

  bool block_upload(const SdoFrame& in, SdoFrame& out) {
    switch (in[0] & 3) {
      case 0:
        return block_upload_begin(in, out);
      case 1:
        if (state_ != State::kBlockEnding) return unexpected(in, out);
        state_ = State::kIdle;
        return false;
      case 2:
        return block_acknowledged(in, out);
      default:
        if (state_ != State::kBlockReady) return unexpected(in, out);
        sent_ = 0;
        state_ = State::kBlockSending;
        return false;
    }
  }

  bool block_upload_begin(const SdoFrame& in, SdoFrame& out) {
    const Abort code = prepare_upload(in);
    if (code != Abort::kNone) return abort(code, out);
    block_ = in[4];
    if (block_ == 0 || block_ > kBlockSegments) return abort(Abort::kBlockSize, out);
    if (in[5] != 0 && size_ <= in[5]) return begin_upload(in, out);  // the master's threshold
    crc_ = 0;
    state_ = State::kBlockReady;
    answer(0xC6, out);
    to_bytes(size_, std::span(out).subspan(4));
    return true;
  }

  bool block_acknowledged(const SdoFrame& in, SdoFrame& out) {
    // An acknowledgement may overtake what is still to be sent of the block: the master missed a segment.
    if (state_ != State::kBlockWaiting && state_ != State::kBlockSending) return unexpected(in, out);
    if (in[1] > sent_) return abort(Abort::kSequence, out);
    if (in[2] == 0 || in[2] > kBlockSegments) return abort(Abort::kBlockSize, out);
    const std::uint32_t end = std::min<std::uint32_t>(offset_ + 7U * in[1], size_);
    std::array<std::uint8_t, 7> bytes;
    while (offset_ < end) {
      const std::uint32_t count = std::min<std::uint32_t>(end - offset_, 7U);
      fetch(offset_, std::span(bytes).first(count));
      crc_ = sdo_crc(std::span(bytes).first(count), crc_);
      offset_ += count;
    }
    block_ = in[2];
    sent_ = 0;
    if (offset_ < size_ || (size_ == 0 && in[1] == 0)) {
      state_ = State::kBlockSending;
      return false;
    }
    const std::uint32_t rest = size_ == 0 ? 0 : (size_ - 1) % 7 + 1;
    out[0] = static_cast<std::uint8_t>(0xC1 | ((7U - rest) << 2));
    to_bytes(crc_, std::span(out).subspan(1, 2));
    state_ = State::kBlockEnding;
    return true;
  }

  Dictionary& dictionary_;
  State state_ = State::kIdle;
  std::uint16_t index_ = 0;
  std::uint8_t sub_ = 0;
  std::size_t row_ = 0;
  std::uint8_t toggle_ = 0;
  std::uint8_t block_ = 0;
  std::uint8_t sent_ = 0;  ///< segments of this block, either way
  bool held_ = false;
  bool check_ = false;
  std::uint16_t crc_ = 0;
  std::uint32_t size_ = 0;
  std::uint32_t offset_ = 0;
  std::uint32_t last_us_ = 0;
  std::uint32_t aborts_ = 0;
  std::array<std::uint8_t, 8> value_{};
  std::array<std::uint8_t, 7> segment_{};
};

}  // namespace slipstack::canopen
