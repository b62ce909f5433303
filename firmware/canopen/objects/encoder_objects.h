// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/objects/dictionary.h"
#include "hal/include/absolute_encoder.h"

namespace slipstack::canopen {

/// The interface of the encoder as it stands in 2503h.
inline EncoderInterface staged_encoder(const Dictionary& dictionary) {
  return {static_cast<EncoderInterface::Kind>(dictionary.value(kRow<kEncoderIndex, 1>)),
          static_cast<std::uint8_t>(dictionary.value(kRow<kEncoderIndex, 2>)),
          static_cast<std::uint8_t>(dictionary.value(kRow<kEncoderIndex, 3>))};
}

/// 2503h: the kind of encoder, and what came of its frames. A board without the interface has an incremental
/// one.
class EncoderObjects {
 public:
  explicit EncoderObjects(const AbsoluteEncoder* encoder) : encoder_(encoder) {}

  std::uint32_t read(std::uint8_t sub) const {
    if (encoder_ == nullptr) return 0;
    const FrameCounters counters = encoder_->counters();
    switch (sub) {
      case 4:
        return counters.silent;
      case 5:
        return counters.bad_crc;
      case 6:
        return counters.errors;
      case 7:
        return counters.warnings;
      default:
        return counters.warning ? 1U : 0U;
    }
  }

  Abort check(const Dictionary& dictionary, std::uint8_t sub, std::uint32_t value) const {
    if (encoder_ == nullptr && sub == 1 && value != 0) return Abort::kUnsupportedAccess;
    EncoderInterface wanted = staged_encoder(dictionary);
    if (sub == 2) wanted.position_bits = static_cast<std::uint8_t>(value);
    if (sub == 3) wanted.dropped_bits = static_cast<std::uint8_t>(value);
    return valid(wanted) ? Abort::kNone : Abort::kBadValue;
  }

 private:
  const AbsoluteEncoder* encoder_;
};

}  // namespace slipstack::canopen
