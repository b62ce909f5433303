// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "workbench/can/client/sdo_client.h"

// What several commands do with a drive on the bus. Every function throws UsageError, one line.
namespace slipstack::workbench {

/// Throws unless the node is a drive with our object dictionary (1018h:02).
void require_slipstack_drive(SdoClient& drive);

/// The drive is in operation enabled (6041h).
bool is_enabled(SdoClient& drive);

/// Applies what is staged (2140h:03), whose hash the drive must confirm, and waits until the tick has taken
/// it. Where the drive refuses: its result (2140h:04); what runs is then unchanged.
std::optional<std::uint32_t> apply_staged(SdoClient& drive, std::uint32_t hash);

/// Waits for a node that starts anew and does not answer meanwhile, 0.3 s at least. Throws UsageError where
/// it does not come back.
void wait_for_start(SdoClient& drive);

/// NMT reset communication: SYNC and PDOs as they are stored, or as delivered. Waits for the node; throws as
/// wait_for_start().
void restart_communication(SdoClient& drive);

/// Stores what is staged and the drive's other parameters (1010h:01).
void store_parameters(SdoClient& drive);

/// Inertia and payload of the model (2100h and the payload's), kg.
double model_mass_kg(SdoClient& drive);

/// Changes an object during the life of this, and restores it.
class RestoredObject {
 public:
  RestoredObject(SdoClient& drive, std::uint16_t index, std::uint8_t sub, int bytes)
      : drive_(drive), index_(index), sub_(sub), bytes_(bytes), before_(drive.read(index, sub)) {}
  RestoredObject(const RestoredObject&) = delete;
  RestoredObject& operator=(const RestoredObject&) = delete;
  ~RestoredObject();
  void set(std::uint32_t value) { drive_.write(index_, sub_, value, bytes_); }
  std::uint32_t before() const { return before_; }

 private:
  SdoClient& drive_;
  std::uint16_t index_;
  std::uint8_t sub_;
  int bytes_;
  std::uint32_t before_;
};

/// Changes objects one after the other, and restores them in the reverse order: a PDO is switched off before
/// its mapping changes and its mapping is whole before it is on again (CiA 301, 7.5.2.36), on the way back
/// too. Where the bus is gone what is left to be restored is `owed`; another one that is given it begins with
/// that.
class RestoredObjects {
 public:
  struct Before {
    std::uint16_t index;
    std::uint8_t sub;
    int bytes;
    std::uint32_t value;
  };
  explicit RestoredObjects(SdoClient& drive, std::vector<Before>* owed = nullptr);
  RestoredObjects(const RestoredObjects&) = delete;
  RestoredObjects& operator=(const RestoredObjects&) = delete;
  ~RestoredObjects();
  void set(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes);

 private:
  SdoClient& drive_;
  std::vector<Before>* owed_;
  std::vector<Before> changes_;
};

}  // namespace slipstack::workbench
