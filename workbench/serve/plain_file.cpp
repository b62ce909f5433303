// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/plain_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/log/input_file.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kLongestName = 120;  // of a file; file systems allow 255 bytes

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw UsageError(fmt::format("{}: {}", printable(path.string()), std::strerror(error)));
}

void write_all(int descriptor, const std::string& content) {
  for (std::size_t done = 0; done < content.size();) {
    const ssize_t count = ::write(descriptor, content.data() + done, content.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw std::system_error(errno, std::generic_category());
    done += static_cast<std::size_t>(count);
  }
  if (::fsync(descriptor) != 0) throw std::system_error(errno, std::generic_category());
}

}  // namespace

void write_whole(const std::filesystem::path& path, const std::string& content) {
  static std::atomic<unsigned> number{0};
  const std::filesystem::path beside =
      path.parent_path() / fmt::format(".{}.{}.{}", path.filename().string(), ::getpid(), number++);
  const int descriptor = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) fail(path, errno);
  int error = 0;
  try {
    write_all(descriptor, content);
  } catch (const std::system_error& failure) {
    error = failure.code().value();
  }
  ::close(descriptor);
  if (error == 0 && std::rename(beside.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return;
  ::unlink(beside.c_str());
  fail(path, error);
}

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
