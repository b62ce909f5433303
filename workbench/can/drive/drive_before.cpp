// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/drive/drive_before.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "firmware/canopen/model/staged_model.h"
#include "workbench/can/drive/drive_access.h"

namespace slipstack::workbench {
namespace {

using namespace slipstack::canopen;

/// Of the other objects that a commissioning changes.
struct Place {
  std::uint16_t index;
  std::uint8_t sub;
  int bytes;
};
constexpr Place kOthers[] = {
    {0x2403, 0, 2},           // command time-out
    {kScalesIndex, 2, 1},     // motor reversed
    {kDirectionIndex, 1, 1},  // check of the direction: whether,
    {kDirectionIndex, 3, 4},  // current
    {kDirectionIndex, 4, 4},  // and its rate
    {0x60C2, 1, 1},           // period of the set-points
    {0x60C2, 2, 1},
};

int bytes_of(Type type) {
  return type == Type::kReal32 ? 4 : 1;
}

}  // namespace

DriveBefore::DriveBefore(SdoClient& drive) {
  for (std::uint8_t sub = 1; sub <= kLastAxisSub; ++sub) {
    const Object& object = kObjects[find_row(kAxisIndex, sub)];
    entries_.push_back({kAxisIndex, sub, bytes_of(object.type), drive.read(kAxisIndex, sub)});
  }
  for (const Place& place : kOthers)
    entries_.push_back({place.index, place.sub, place.bytes, drive.read(place.index, place.sub)});
  model_ = drive.upload(kModelImageIndex, 0);
}

DriveBefore::DriveBefore(const nlohmann::json& kept) {
  for (const nlohmann::json& entry : kept.at("objects")) {
    entries_.push_back({entry.at(0).get<std::uint16_t>(), entry.at(1).get<std::uint8_t>(),
                        entry.at(2).get<int>(), entry.at(3).get<std::uint32_t>()});
  }
  model_ = kept.at("model").get<std::vector<std::uint8_t>>();
}

nlohmann::json DriveBefore::json() const {
  nlohmann::json objects = nlohmann::json::array();
  for (const Entry& entry : entries_)
    objects.push_back(nlohmann::json::array({entry.index, entry.sub, entry.bytes, entry.value}));
  return {{"objects", objects}, {"model", model_}};
}

std::uint32_t DriveBefore::value(std::uint16_t index, std::uint8_t sub) const {
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.index == index && entry.sub == sub;
  });
  return found == entries_.end() ? 0U : found->value;
}

double DriveBefore::real(std::uint16_t index, std::uint8_t sub) const {
  return static_cast<double>(std::bit_cast<float>(value(index, sub)));
}

void DriveBefore::set_motor_reversed(bool reversed) {
  for (Entry& entry : entries_) {
    if (entry.index == kScalesIndex && entry.sub == 2) entry.value = reversed ? 1U : 0U;
  }
}

void DriveBefore::restore_objects(SdoClient& drive,
                                  const std::function<bool(std::uint16_t, std::uint8_t)>& left) const {
  for (const Entry& entry : entries_) {
    if (left(entry.index, entry.sub) || drive.read(entry.index, entry.sub) == entry.value) continue;
    drive.write(entry.index, entry.sub, entry.value, entry.bytes);
  }
}

void DriveBefore::restore(SdoClient& drive) const {
  restore_objects(drive, [](std::uint16_t, std::uint8_t) { return false; });
  drive.download(kModelImageIndex, 0, model_);
  // Without a model it had none in force, and refuses this.
  static_cast<void>(apply_staged(drive, drive.read(kModelIndex, 1)));
}

}  // namespace slipstack::workbench
