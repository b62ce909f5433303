// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/update/image_header.h"

namespace slipstack::workbench {

/// One program of an update file, linked for one slot.
struct UpdateImage {
  update::ImageHeader header;
  std::vector<std::uint8_t> program;
};

/// An update file (docs/firmware-update.md): a program for each slot.
struct UpdateFile {
  std::string name;
  std::vector<UpdateImage> images;

  /// The one that is linked for a slot; nullptr if there is none.
  const UpdateImage* at(std::uint32_t address) const;
};

/// Reads and checks a file. Throws UsageError, one line.
UpdateFile read_update_file(const std::string& path);

/// The same of bytes; `name` is for messages.
UpdateFile parse_update_file(const std::string& bytes, const std::string& name);

/// What is sent of an image from `offset` on: its header, and the rest of its program.
std::vector<std::uint8_t> transfer_of(const UpdateImage& image, std::uint32_t offset);

}  // namespace slipstack::workbench
