// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/objects/dictionary.h"

namespace slipstack::canopen {

class Pdos;

/// What the node serves: the objects from 2000h on, and what communication means to it.
class Application : public ObjectAccess {
 public:
  /// Parameters in the dictionary are new: after a start or a reset.
  virtual void reset(Dictionary& dictionary) = 0;
  /// Once in every poll.
  virtual void step(std::uint32_t now_us) = 0;
  /// The error code of the active fault, 0 if there is none.
  virtual std::uint16_t error_code() = 0;
  /// What hunts and does not stop the axis, for the emergency message FF01h: its detail, 0 without.
  virtual std::uint32_t warning() = 0;
  virtual bool enabled() = 0;
  /// A SYNC came, and what PDOs held until then has been taken: `pdos` knows which objects.
  virtual void synchronise(const Pdos& pdos) = 0;
  /// Bus-off, a lost heartbeat, NMT stop: act after 6007h.
  virtual void connection_lost() = 0;
  /// What the node sends is not acknowledged (error passive): nobody hears it. In every poll.
  virtual void unheard() = 0;
  virtual void set_operational(bool operational) = 0;
  virtual std::uint32_t serial_number() const = 0;

 protected:
  ~Application() = default;
};

}  // namespace slipstack::canopen
