// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "workbench/log/byte_source.h"

namespace slipstack::workbench {

// An open regular file. Anything else is refused: a pipe or a device might never end.
class InputFile {
 public:
  // `name` stands for the file in error messages. Throws InputError.
  InputFile(std::string name, const std::filesystem::path& path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::size_t size() const { return size_; }
  // Reads at most `capacity` bytes from `offset` on and returns their number; 0 only at the end. May be
  // called from any thread.
  std::size_t read_at(std::size_t offset, char* buffer, std::size_t capacity) const;

 private:
  std::string name_;
  int descriptor_ = -1;
  std::size_t size_ = 0;
};

// The bytes of a file from an offset to its end.
class FileSource final : public ByteSource {
 public:
  FileSource(const InputFile& file, std::size_t offset) : file_(file), offset_(offset) {}
  std::size_t read(char* buffer, std::size_t capacity) override {
    const std::size_t count = file_.read_at(offset_, buffer, capacity);
    offset_ += count;
    return count;
  }

 private:
  const InputFile& file_;
  std::size_t offset_;
};

}  // namespace slipstack::workbench
