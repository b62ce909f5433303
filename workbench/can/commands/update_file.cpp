// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/commands/update_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

/// Far more than any part has: what is larger is something else.
constexpr std::streamsize kLargestFile = 16 << 20;

[[noreturn]] void no_update(const std::string& name, const std::string& why) {
  throw UsageError(
      fmt::format("{}: {}; wanted: the .update file that the build makes", printable(name), why));
}

}  // namespace

const UpdateImage* UpdateFile::at(std::uint32_t address) const {
  const auto found = std::find_if(images.begin(), images.end(),
                                  [&](const UpdateImage& image) { return image.header.address == address; });
  return found == images.end() ? nullptr : &*found;
}

UpdateFile parse_update_file(const std::string& bytes, const std::string& name) {
  UpdateFile file{name, {}};
  if (bytes.empty()) no_update(name, "the file is empty");
  for (std::size_t at = 0; at < bytes.size();) {
    update::HeaderBytes head;
    UpdateImage image;
    if (bytes.size() - at < head.size()) no_update(name, "cut short");
    std::memcpy(head.data(), bytes.data() + at, head.size());
    if (!update::from_bytes(head, image.header) || image.header.magic != update::ImageHeader::kMagic) {
      no_update(name, at == 0 ? "not an update file" : "damaged");
    }
    at += head.size();
    if (bytes.size() - at < image.header.size || image.header.size == 0) no_update(name, "cut short");
    image.program.assign(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                         bytes.begin() + static_cast<std::ptrdiff_t>(at + image.header.size));
    at += image.header.size;
    if (crc32(std::as_bytes(std::span(image.program))) != image.header.crc) {
      no_update(name, "damaged: a program is not the one that its header names");
    }
    file.images.push_back(std::move(image));
  }
  return file;
}

UpdateFile read_update_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) no_update(path, "cannot be read");
  if (file.tellg() > kLargestFile) no_update(path, "far too large");
  file.seekg(0);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) no_update(path, "cannot be read");
  return parse_update_file(bytes, path);
}

std::vector<std::uint8_t> transfer_of(const UpdateImage& image, std::uint32_t offset) {
  update::ImageHeader header = image.header;
  if (offset > 0) {
    header.magic = update::ImageHeader::kContinue;
    header.offset = offset;
  }
  const update::HeaderBytes head = update::to_bytes(header);
  std::vector<std::uint8_t> bytes;
  bytes.reserve(head.size() + image.program.size() - offset);
  for (const std::byte byte : head) bytes.push_back(std::to_integer<std::uint8_t>(byte));
  for (std::size_t i = offset; i < image.program.size(); ++i) bytes.push_back(image.program[i]);
  return bytes;
}

}  // namespace slipstack::workbench
