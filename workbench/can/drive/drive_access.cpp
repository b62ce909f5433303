// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/drive/drive_access.h"

#include <exception>
#include <string>

#include "firmware/canopen/telemetry/trace.h"

namespace slipstack::workbench {

using namespace slipstack::canopen;

void require_slipstack_drive(SdoClient& drive) {
  if (drive.read(0x1018, 2) != kProductCode) drive.fail("is not a slipstack drive (1018h:02)");
}

bool is_enabled(SdoClient& drive) {
  return (drive.read(0x6041, 0) & 0x6F) == 0x27;
}

std::optional<std::uint32_t> apply_staged(SdoClient& drive, std::uint32_t hash) {
  if (drive.try_write(kModelIndex, 3, hash, 4) != 0) return drive.read(kModelIndex, 4);
  for (int i = 0; drive.read(kModelIndex, 5) != 0; ++i) {
    if (i == 1000) drive.fail("the tick does not take what was applied; does it run?");
  }
  return {};
}

void wait_for_start(SdoClient& drive) {
  constexpr int kStart_ms = 300;  // before the node is asked
  CanFrame frame;
  for (int i = 0; i < kStart_ms; ++i) static_cast<void>(drive.link().receive(frame, 1));
  drive.await_node();
}

void restart_communication(SdoClient& drive) {
  drive.nmt(0x82);
  wait_for_start(drive);
}

void store_parameters(SdoClient& drive) {
  constexpr std::uint32_t kSave = 0x65766173;  // "save" in the order of the bytes
  drive.write(0x1010, 1, kSave, 4);
}

double model_mass_kg(SdoClient& drive) {
  // 2100h is inertia; payload stands after it in the catalogue.
  double mass_kg = 0.0;
  for (std::uint16_t i = 0; i < kEffectCount; ++i) {
    const std::size_t row = find_row(static_cast<std::uint16_t>(kEffectIndex + i), 0);
    const std::string title = kObjects[row].object;
    if (title != Inertia<float>::text.title && title != PayloadMass<float>::text.title) continue;
    const auto index = static_cast<std::uint16_t>(kEffectIndex + i);
    if (drive.read(index, 1) != 0) mass_kg += drive.read_real(index, 2);
  }
  return mass_kg;
}

RestoredObject::~RestoredObject() {
  try {
    drive_.try_write(index_, sub_, before_, bytes_);
  } catch (const std::exception&) {  // the bus is gone: nothing can be restored
  }
}

void RestoredObjects::set(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes) {
  changes_.push_back({index, sub, bytes, drive_.read(index, sub)});
  drive_.write(index, sub, value, bytes);
}

RestoredObjects::RestoredObjects(SdoClient& drive, std::vector<Before>* owed) : drive_(drive), owed_(owed) {
  if (owed_ == nullptr) return;
  for (const Before& one : *owed_) drive_.try_write(one.index, one.sub, one.value, one.bytes);
  owed_->clear();
}

RestoredObjects::~RestoredObjects() {
  try {
    for (; !changes_.empty(); changes_.pop_back()) {
      const Before& one = changes_.back();
      drive_.try_write(one.index, one.sub, one.value, one.bytes);
    }
  } catch (const std::exception&) {  // the bus is gone, and each further object would wait for its answer
    if (owed_ != nullptr) owed_->assign(changes_.rbegin(), changes_.rend());
  }
}

}  // namespace slipstack::workbench
