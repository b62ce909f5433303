// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/commands/master.h"

#include <fmt/format.h>

#include <bit>
#include <vector>

#include "firmware/canopen/model/staged_model.h"
#include "firmware/control/supervision/state_machine.h"
#include "firmware/effects/model_hash.h"
#include "workbench/base/text.h"
#include "workbench/can/drive/drive_access.h"
#include "workbench/can/drive/drive_words.h"
#include "workbench/console/output.h"

namespace slipstack::workbench {
namespace {

using namespace slipstack::canopen;

std::vector<std::uint8_t> image_of(const ModelParameters& parameters) {
  std::vector<std::uint8_t> image;
  model_words(parameters, [&image](std::size_t row, std::uint32_t word) {
    if (check_bounds(kObjects[row], word) != Abort::kNone) {
      throw UsageError(fmt::format("the model's {} ({:04X}h:{:02X}) is out of the drive's bounds",
                                   kObjects[row].name, kObjects[row].index, kObjects[row].sub));
    }
    for (int i = 0; i < 4; ++i) image.push_back(static_cast<std::uint8_t>(word >> (8 * i)));
  });
  return image;
}

std::uint32_t word_at(const std::vector<std::uint8_t>& image, std::size_t word) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(image[4 * word + i]) << (8 * i);
  return value;
}

double value_of(const Object& object, std::uint32_t word) {
  return object.type == Type::kReal32 ? static_cast<double>(std::bit_cast<float>(word))
                                      : static_cast<double>(word);
}

// Firmware from before the watch of hunting has no such object; the rest of its status is worth showing.
std::string hunting_status(SdoClient& drive) {
  try {
    return hunting_words(drive.read(kHuntingIndex, 2), drive.read(kHuntingIndex, 3));
  } catch (const SdoAbort& abort) {
    if (!abort.of_missing_object()) throw;
    return "not watched: this firmware is older than the watch of hunting";
  }
}

}  // namespace

std::string deploy_model(SdoClient& drive, const Model& model, const std::string& name, bool store,
                         const Show& show) {
  const TargetParameters parameters = target_parameters(model.target_terms);
  const std::uint32_t hash = model_hash(parameters);
  const std::vector<std::uint8_t> image = image_of(parameters);
  show("ask the drive", -1.0);
  require_slipstack_drive(drive);
  if (is_enabled(drive)) drive.fail("is enabled; disable the drive before a model is deployed");
  const std::uint32_t before = drive.read(kModelIndex, 2);
  drive.download(kModelImageIndex, 0, image, [&](double f) { show("stage", f); });
  if (drive.upload(kModelImageIndex, 0, [&](double f) { show("read back", f); }) != image ||
      drive.read(kModelIndex, 1) != hash) {
    drive.fail("what was staged reads back differently; nothing was applied");
  }
  if (const auto refused = apply_staged(drive, hash)) {
    drive.fail(fmt::format("the drive does not take the model (result {}, 2140h:04); the old one runs on",
                           *refused));
  }
  const std::uint32_t active = drive.read(kModelIndex, 2);
  if (active != hash) drive.fail(fmt::format("the active model is {:08x}, not {:08x}", active, hash));
  if (store) {
    show("store", -1.0);
    store_parameters(drive);
  }
  return fmt::format(
      "model      {}, hash {:08x}\nnode       {} on {}\nstaged     {} bytes, read back the same\napplied    "
      "between two ticks; active before: {:08x}\nstored     {}\n",
      printable(name), hash, drive.node(), printable(drive.link().name()), image.size(), before,
      store ? "yes" : "no (--no-store): gone with the next reset");
}

std::vector<ModelDifference> differences_from_drive(SdoClient& drive, const Model& model, const Show& show) {
  const std::vector<std::uint8_t> wanted = image_of(target_parameters(model.target_terms));
  require_slipstack_drive(drive);
  const std::vector<std::uint8_t> held =
      drive.upload(kModelImageIndex, 0, [&](double f) { show("read the drive's model", f); });
  if (held.size() != wanted.size()) drive.fail("holds a model of another size; update its firmware first");
  std::vector<ModelDifference> differences;
  for (std::size_t i = 0; i < kModelImageRows.size(); ++i) {
    const Object& object = kObjects[kModelImageRows[i]];
    const std::uint32_t on_drive = word_at(held, i);
    const std::uint32_t in_model = word_at(wanted, i);
    if (on_drive == in_model) continue;
    differences.push_back({object.name, object.unit, object.index, object.sub, value_of(object, on_drive),
                           value_of(object, in_model)});
  }
  return differences;
}

std::string drive_status(SdoClient& drive) {
  require_slipstack_drive(drive);
  const std::uint32_t word = drive.read(0x6041, 0);
  const std::uint32_t error = drive.read(0x603F, 0);
  std::string text = fmt::format("node       {} on {}, serial {:08x}\n", drive.node(),
                                 printable(drive.link().name()), drive.read(0x1018, 4));
  text += fmt::format("state      {} (statusword {:04x}h), mode {}\n", state_name(word), word,
                      static_cast<std::int32_t>(static_cast<std::int8_t>(drive.read(0x6061, 0))));
  text += fmt::format(
      "error      {}\n",
      error == 0 ? "none"
                 : fmt::format("{:04x}h, {}", error, error_words(static_cast<std::uint16_t>(error))));
  text += fmt::format("position   {} counts\n", static_cast<std::int32_t>(drive.read(0x6063, 0)));
  text += fmt::format("residual   {:.4g} N\n", drive.read_real(kObserverIndex, 3));
  text += fmt::format("hunting    {}\n", hunting_status(drive));
  text += fmt::format("model      active {:08x}, staged {:08x}\n", drive.read(kModelIndex, 2),
                      drive.read(kModelIndex, 1));
  text +=
      fmt::format("tick       {} ticks, {} late\n", drive.read(kTimingIndex, 4), drive.read(kTimingIndex, 3));
  text += fmt::format("CAN        {} frames in, {} lost, {} malformed, {} aborts\n",
                      drive.read(kCountersIndex, 1), drive.read(kCountersIndex, 2),
                      drive.read(kCountersIndex, 3), drive.read(kCountersIndex, 4));
  text += fmt::format("stored     {} times; erasures {} and {}\n", drive.read(kCountersIndex, 9),
                      drive.read(kCountersIndex, 10), drive.read(kCountersIndex, 11));
  const std::uint32_t lock = drive.read(kLockIndex, 1);
  text += fmt::format("lock       {}\n", lock == 0   ? "off: anybody on the bus may write"
                                         : lock == 1 ? "locked"
                                                     : "open");
  return text;
}

}  // namespace slipstack::workbench
