// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "workbench/base/errors.h"

namespace slipstack::workbench {
namespace {

std::string reason(int error) {
  return std::generic_category().message(error);
}

}  // namespace

InputFile::InputFile(std::string name, const std::filesystem::path& path) : name_(std::move(name)) {
  struct stat status {};
  // Examined before opening, because opening some devices already has effects.
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

InputFile::~InputFile() {
  ::close(descriptor_);
}

std::size_t InputFile::read_at(std::size_t offset, char* buffer, std::size_t capacity) const {
  for (;;) {
    const ssize_t count = ::pread(descriptor_, buffer, capacity, static_cast<off_t>(offset));
    if (count >= 0) return static_cast<std::size_t>(count);
    if (errno != EINTR) throw InputError(name_ + ": cannot be read: " + reason(errno) + "; copy it again");
  }
}

}  // namespace slipstack::workbench
