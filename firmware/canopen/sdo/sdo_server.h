// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "firmware/canopen/network/counter.h"
#include "firmware/canopen/objects/dictionary.h"
#include "firmware/canopen/sdo/sdo_access.h"
#include "firmware/canopen/sdo/sdo_block.h"

namespace slipstack::canopen {

using SdoFrame = std::array<std::uint8_t, 8>;

/// One SDO server (CiA 301, 7.2.4): expedited, segmented and block transfer both ways. At most one transfer
/// at a time; a new one from the master ends the one before.
///
/// Cost: a frame in, at most one frame out, and what the object costs; the segments of a block upload by
/// next().
class SdoServer {
 public:
  static constexpr std::uint32_t kTimeout_us = 1'000'000;  ///< between two frames of a transfer

  explicit SdoServer(Dictionary& dictionary) : object_(dictionary) {}

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
    const std::uint32_t at = object_.offset() + 7U * sent_;
    out = {};
    const std::uint32_t count = std::min<std::uint32_t>(object_.size() - at, 7U);
    object_.copy(at, std::span(out).subspan(1, count));
    ++sent_;
    const bool last = at + count >= object_.size();
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
    answer(0x80, out);
    to_bytes(static_cast<std::uint32_t>(code), std::span(out).subspan(4));
    state_ = State::kIdle;
    count(aborts_);
    return true;
  }

  // A segment without a transfer, or a command that is none. What was under way is lost.
  bool unexpected(const SdoFrame& in, SdoFrame& out) {
    if (state_ == State::kIdle) object_.set_address(index_of(in), in[3]);
    return abort(Abort::kCommand, out);
  }

  static std::uint16_t index_of(const SdoFrame& in) {
    return static_cast<std::uint16_t>(in[1] | (in[2] << 8));
  }

  void answer(std::uint8_t command, SdoFrame& out) const {
    out = {command};
    to_bytes(object_.index(), std::span(out).subspan(1, 2));
    out[3] = object_.sub();
  }

  // ---- upload ----

  Abort open_upload(const SdoFrame& in) {
    state_ = State::kIdle;
    return object_.begin_upload(index_of(in), in[3]);
  }

  bool begin_upload(const SdoFrame& in, SdoFrame& out) {
    const Abort code = open_upload(in);
    if (code != Abort::kNone) return abort(code, out);
    const std::uint32_t size = object_.size();
    if (size <= 4 && size > 0) {
      answer(static_cast<std::uint8_t>(0x43U | ((4U - size) << 2)), out);
      object_.read(std::span(out).subspan(4, size));
      return true;
    }
    answer(0x41, out);
    to_bytes(size, std::span(out).subspan(4));
    toggle_ = 0;
    state_ = State::kUpload;
    return true;
  }

  bool upload_segment(const SdoFrame& in, SdoFrame& out) {
    if ((in[0] & 0x10) != toggle_) return abort(Abort::kToggle, out);
    const std::uint32_t count = std::min<std::uint32_t>(object_.remaining(), 7U);
    object_.read(std::span(out).subspan(1, count));
    const bool last = object_.remaining() == 0;
    out[0] = static_cast<std::uint8_t>(toggle_ | ((7U - count) << 1) | (last ? 1U : 0U));
    toggle_ ^= 0x10;
    if (last) state_ = State::kIdle;
    return true;
  }

  // ---- download ----

  Abort open_download(const SdoFrame& in, std::uint32_t size) {
    state_ = State::kIdle;
    return object_.begin_download(index_of(in), in[3], size);
  }
  Abort finish() {
    state_ = State::kIdle;
    return object_.finish_download();
  }

  bool begin_download(const SdoFrame& in, SdoFrame& out) {
    const bool expedited = (in[0] & 0x02) != 0;
    const bool sized = (in[0] & 0x01) != 0;
    const std::uint32_t data = from_bytes(Type::kU32, std::span(in).subspan(4));
    Abort code = Abort::kNone;
    if (expedited) {
      code = open_download(in, sized ? 4U - ((in[0] >> 2) & 3U) : 0U);
      if (code == Abort::kNone) {
        code = object_.write(std::span(in).subspan(4, object_.expedited_size()));
      }
      if (code == Abort::kNone) code = finish();
    } else {
      code = open_download(in, sized ? data : 0U);
    }
    if (code != Abort::kNone) return abort(code, out);
    answer(0x60, out);
    toggle_ = 0;
    if (!expedited) state_ = State::kDownload;
    return true;
  }

  bool download_segment(const SdoFrame& in, SdoFrame& out) {
    if ((in[0] & 0x10) != toggle_) return abort(Abort::kToggle, out);
    Abort code = object_.write(std::span(in).subspan(1, 7U - ((in[0] >> 1) & 7U)));
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
    const Abort code = open_download(in, size);
    if (code != Abort::kNone) return abort(code, out);
    incoming_.begin((in[0] & 4) != 0);
    state_ = State::kBlockDownload;
    answer(0xA4, out);
    out[4] = kBlockSegments;
    return true;
  }

  bool block_segment(const SdoFrame& in, SdoFrame& out) {
    const std::uint8_t number = in[0] & 0x7F;
    const bool last = (in[0] & 0x80) != 0;
    if (number == 0) return abort(Abort::kSequence, out);
    bool in_order = false;
    const Abort code = incoming_.add(object_, number, std::span(in).subspan<1, kSegmentBytes>(), in_order);
    if (code != Abort::kNone) return abort(code, out);
    if (last && in_order) state_ = State::kBlockDownloadEnd;
    if (!last && number != kBlockSegments) return false;
    out = {0xA2, incoming_.end_block(), kBlockSegments, 0, 0, 0, 0, 0};
    return true;
  }

  bool block_download_end(const SdoFrame& in, SdoFrame& out) {
    if (state_ != State::kBlockDownloadEnd) return unexpected(in, out);
    const auto crc = static_cast<std::uint16_t>(from_bytes(Type::kU16, std::span(in).subspan(1, 2)));
    Abort code = incoming_.end(object_, kSegmentBytes - ((in[0] >> 2) & 7U), crc);
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
    const Abort code = open_upload(in);
    if (code != Abort::kNone) return abort(code, out);
    block_ = in[4];
    if (block_ == 0 || block_ > kBlockSegments) return abort(Abort::kBlockSize, out);
    if (in[5] != 0 && object_.size() <= in[5]) return begin_upload(in, out);  // the master's threshold
    crc_ = 0;
    state_ = State::kBlockReady;
    answer(0xC6, out);
    to_bytes(object_.size(), std::span(out).subspan(4));
    return true;
  }

  bool block_acknowledged(const SdoFrame& in, SdoFrame& out) {
    // An acknowledgement may overtake what is still to be sent of the block: the master missed a segment.
    if (state_ != State::kBlockWaiting && state_ != State::kBlockSending) return unexpected(in, out);
    if (in[1] > sent_) return abort(Abort::kSequence, out);
    if (in[2] == 0 || in[2] > kBlockSegments) return abort(Abort::kBlockSize, out);
    const std::uint32_t size = object_.size();
    const std::uint32_t end = std::min<std::uint32_t>(object_.offset() + 7U * in[1], size);
    std::array<std::uint8_t, 7> bytes;
    while (object_.offset() < end) {
      const auto segment = std::span(bytes).first(std::min<std::uint32_t>(end - object_.offset(), 7U));
      object_.read(segment);
      crc_ = sdo_crc(segment, crc_);
    }
    block_ = in[2];
    sent_ = 0;
    if (object_.remaining() > 0 || (size == 0 && in[1] == 0)) {
      state_ = State::kBlockSending;
      return false;
    }
    const std::uint32_t last = size == 0 ? 0 : (size - 1) % 7 + 1;
    out[0] = static_cast<std::uint8_t>(0xC1 | ((7U - last) << 2));
    to_bytes(crc_, std::span(out).subspan(1, 2));
    state_ = State::kBlockEnding;
    return true;
  }

  SdoAccess object_;
  State state_ = State::kIdle;
  std::uint8_t toggle_ = 0;
  std::uint8_t block_ = 0;
  std::uint8_t sent_ = 0;  ///< segments of this block of an upload
  std::uint16_t crc_ = 0;  ///< of an upload
  BlockDownload incoming_;
  std::uint32_t last_us_ = 0;
  std::uint32_t aborts_ = 0;
};

}  // namespace slipstack::canopen
