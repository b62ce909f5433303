// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/output.h"

#include <fmt/format.h>
#include <unistd.h>

namespace slipstack::workbench {

Outputs::~Outputs() {
  for (const File& file : files_) {
    std::error_code ignored;
    if (!file.temporary.empty()) std::filesystem::remove(file.temporary, ignored);
  }
}

void Outputs::claim(const std::string& path) {
  if (path.empty()) return;
  const std::filesystem::path place(path);
  std::error_code error;
  if (std::filesystem::is_directory(place, error)) {
    throw UsageError(fmt::format("{}: is a directory; name a file to write", path));
  }
  for (const File& file : files_) {
    if (file.path == place) throw UsageError(fmt::format("{}: named for two outputs; name two files", path));
  }
  std::filesystem::path temporary = place;
  temporary += fmt::format(".{}.part", getpid());
  if (!std::ofstream(temporary)) {
    throw UsageError(
        fmt::format("{}: cannot be written; name a file in a folder that exists and is yours", path));
  }
  files_.push_back({place, temporary, {}});
}

void Outputs::set(const std::string& path, std::string content) {
  for (File& file : files_) {
    if (file.path == std::filesystem::path(path)) file.content = std::move(content);
  }
}

void Outputs::commit() {
  for (const File& file : files_) {
    std::ofstream stream(file.temporary, std::ios::binary);
    stream << file.content;
    stream.close();
    if (!stream)
      throw std::runtime_error(
          fmt::format("{}: could not be written; is the disk full?", file.path.string()));
  }
  for (File& file : files_) {
    std::filesystem::rename(file.temporary, file.path);
    file.temporary.clear();
  }
}

}  // namespace slipstack::workbench
