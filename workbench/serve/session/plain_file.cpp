// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/session/plain_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <system_error>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/log/input_file.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kLongestName = 120;  // of a file; file systems allow 255 bytes

}  // namespace

std::string read_whole(const std::filesystem::path& path, std::size_t most) {
  const std::string name = printable(path.string());
  const InputFile file(name, path);
  if (file.size() > most) {
    throw InputError(fmt::format("{}: {} bytes, more than {}", name, file.size(), most));
  }
  std::string content(file.size(), '\0');
  for (std::size_t done = 0; done < content.size();) {
    const std::size_t count = file.read_at(done, content.data() + done, content.size() - done);
    if (count == 0) throw InputError(name + ": the file became shorter while it was read");
    done += count;
  }
  return content;
}

std::string plain_name(const std::string& name, const std::string& otherwise) {
  std::string plain = printable(name);
  if (const std::size_t slash = plain.find_last_of("/\\"); slash != std::string::npos) {
    plain.erase(0, slash + 1);
  }
  std::replace_if(
      plain.begin(), plain.end(), [](char c) { return std::strchr(":*?\"<>|", c) != nullptr; }, '_');
  plain.erase(0, std::min(plain.find_first_not_of(". "), plain.size()));
  if (plain.size() > kLongestName) plain.erase(0, plain.size() - kLongestName);
  return plain.empty() ? otherwise : plain;
}

bool lies_in(const std::filesystem::path& folder, const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(path, error);
  if (error) return false;
  const std::filesystem::path root = std::filesystem::weakly_canonical(folder, error);
  if (error) return false;
  return std::mismatch(root.begin(), root.end(), whole.begin(), whole.end()).first == root.end();
}

}  // namespace slipstack::workbench
