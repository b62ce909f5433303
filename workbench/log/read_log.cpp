// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "workbench/log/assemble.h"
#include "workbench/log/byte_source.h"
#include "workbench/log/csv.h"
#include "workbench/log/log.h"
#include "workbench/log/mat.h"
#include "workbench/log/text.h"

namespace slipstack::workbench {
namespace {

std::string reason(int error) {
  return std::generic_category().message(error);
}

// An open regular file. Anything else is refused: a pipe or a device might never end.
class InputFile final : public ByteSource {
 public:
  InputFile(std::string name, const std::filesystem::path& path) : name_(std::move(name)) {
    struct stat status {};
    // Asked before opening: to open some devices is to act on them.
    if (::stat(path.c_str(), &status) != 0) {
      throw InputError(name_ + ": cannot be opened: " + reason(errno) + "; check the path");
    }
    if (S_ISDIR(status.st_mode)) throw InputError(name_ + ": is a directory; name a log file");
    if (!S_ISREG(status.st_mode)) {
      throw InputError(name_ + ": is not a regular file; copy its content to a file first");
    }
    size_ = static_cast<std::size_t>(status.st_size);
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor_ < 0) {
      throw InputError(name_ + ": cannot be opened: " + reason(errno) + "; check its permissions");
    }
  }
  ~InputFile() override { ::close(descriptor_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::size_t size() const { return size_; }

  std::size_t read(char* buffer, std::size_t capacity) override {
    for (;;) {
      const ssize_t count = ::read(descriptor_, buffer, capacity);
      if (count >= 0) return static_cast<std::size_t>(count);
      if (errno != EINTR) throw InputError(name_ + ": cannot be read: " + reason(errno) + "; copy it again");
    }
  }

  // The first bytes, without moving the reading position.
  std::size_t peek(char* buffer, std::size_t capacity) const {
    const ssize_t count = ::pread(descriptor_, buffer, capacity, 0);
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

 private:
  std::string name_;
  int descriptor_ = -1;
  std::size_t size_ = 0;
};

Log read_file(const std::string& name, const std::filesystem::path& path) {
  InputFile file(name, path);
  if (file.size() == 0) throw InputError(name + ": the file is empty; record a log into it");
  std::array<char, kMatHeaderSize> head{};
  const std::size_t count = file.peek(head.data(), head.size());
  if (looks_like_mat({head.data(), count})) return assemble_log(read_mat(name, file, file.size()));
  return assemble_log(read_csv(name, file));
}

}  // namespace

Log read_log(const std::filesystem::path& path) {
  const std::string name = printable(path.string());
  try {
    Log log = read_file(name, path);
    log.path = path.string();
    return log;
  } catch (const std::bad_alloc&) {
    throw InputError(name + ": the log does not fit into memory; cut it into pieces or decimate it");
  }
}

}  // namespace slipstack::workbench
