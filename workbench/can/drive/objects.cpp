// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/drive/objects.h"

#include <fmt/format.h>

#include <bit>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <thread>

#include "firmware/canopen/objects/object_table.h"
#include "workbench/base/text.h"
#include "workbench/console/output.h"

namespace slipstack::workbench {
namespace {

using canopen::Object;
using canopen::Type;

[[noreturn]] void malformed(const std::string& request) {
  throw UsageError(
      fmt::format("{}: wanted INDEX[:SUB][=VALUE], as 6041 or 2500:03=1.2, or reset", printable(request)));
}

std::optional<unsigned long> hexadecimal(const std::string& text) {
  if (text.empty() || text.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
    return std::nullopt;
  return std::strtoul(text.c_str(), nullptr, 16);
}

const Object& object_of(const std::string& place, const std::string& request) {
  const std::size_t colon = place.find(':');
  const auto index = hexadecimal(place.substr(0, colon));
  const auto sub = colon == std::string::npos ? std::optional{0UL} : hexadecimal(place.substr(colon + 1));
  if (!index || !sub || *index > 0xFFFF || *sub > 0xFF) malformed(request);
  const std::size_t row =
      canopen::find_row(static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*sub));
  if (row == canopen::kNoRow) {
    throw UsageError(fmt::format("{}: no such object (docs/object-dictionary.md)", printable(request)));
  }
  return canopen::kObjects[row];
}

bool is_signed(Type type) {
  return type == Type::kI8 || type == Type::kI16 || type == Type::kI32;
}

// Decimal; hexadecimal with an h behind it; or the signatures of 1010h and 1011h.
std::uint32_t word_of(const Object& object, const std::string& text, const std::string& request) {
  if (text == "save") return 0x65766173;
  if (text == "load") return 0x64616F6C;
  char* end = nullptr;
  errno = 0;
  if (object.type == Type::kReal32) {
    const float number = std::strtof(text.c_str(), &end);
    if (text.empty() || *end != '\0') malformed(request);
    return std::bit_cast<std::uint32_t>(number);
  }
  const bool hex = text.size() > 1 && text.back() == 'h';
  if (hex) {
    const auto number = hexadecimal(text.substr(0, text.size() - 1));
    if (!number || *number > 0xFFFFFFFF) malformed(request);
    return static_cast<std::uint32_t>(*number);
  }
  const long long number = std::strtoll(text.c_str(), &end, 10);
  if (text.empty() || *end != '\0' || errno != 0 || number < INT32_MIN || number > UINT32_MAX)
    malformed(request);
  return static_cast<std::uint32_t>(number);
}

std::string value_text(const Object& object, std::uint32_t word) {
  if (object.type == Type::kReal32) return fmt::format("{:.6g}", std::bit_cast<float>(word));
  const std::size_t bits = 8 * canopen::size_of(object.type);
  if (is_signed(object.type)) {
    const auto shift = static_cast<unsigned>(32 - bits);
    return fmt::format("{}", static_cast<std::int32_t>(word << shift) >> shift);
  }
  // Words whose bits have meanings.
  if (object.index == 0x6040 || object.index == 0x6041 || object.index == 0x603F)
    return fmt::format("{:04X}h", word);
  return fmt::format("{}", word);
}

std::string unit_text(const Object& object) {
  if (*object.unit == '\0') return "";
  return object.scale == 1.0F ? fmt::format(" {}", object.unit)
                              : fmt::format(" x {:.7g} {}", object.scale, object.unit);
}

}  // namespace

std::string access_object(SdoClient& drive, const std::string& request) {
  if (request == "reset") {
    drive.nmt(0x81);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    drive.await_node();
    return "node reset\n";
  }
  const std::size_t equals = request.find('=');
  const Object& object = object_of(request.substr(0, equals), request);
  const std::size_t bytes = canopen::size_of(object.type);
  if (bytes == 0) throw UsageError(fmt::format("{}: not a number", printable(request)));
  const std::string name = fmt::format("{:04X}h:{:02X} {}", object.index, object.sub, object.name);
  if (equals != std::string::npos) {
    const std::uint32_t word = word_of(object, request.substr(equals + 1), request);
    drive.write(object.index, object.sub, word, static_cast<int>(bytes));
    return fmt::format("{} := {}{}\n", name, request.substr(equals + 1), unit_text(object));
  }
  return fmt::format("{} = {}{}\n", name, value_text(object, drive.read(object.index, object.sub)),
                     unit_text(object));
}

}  // namespace slipstack::workbench
