// SPDX-License-Identifier: Apache-2.0
#include "workbench/base/atomic_write.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw UsageError(fmt::format("{}: {}", printable(path.string()), std::strerror(error)));
}

/// An open file, closed when this ends.
class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags)
      : fd_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  bool good() const { return fd_ >= 0; }
  bool write(const std::string& content) const {
    for (std::size_t done = 0; done < content.size();) {
      const ssize_t count = ::write(fd_, content.data() + done, content.size() - done);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return false;
      done += static_cast<std::size_t>(count);
    }
    return true;
  }
  bool sync() const { return ::fsync(fd_) == 0; }

 private:
  int fd_;
};

/// False with errno.
bool write_beside(const std::filesystem::path& beside, const std::string& content) {
  const Descriptor file(beside, O_WRONLY | O_CREAT | O_EXCL);
  return file.good() && file.write(content) && file.sync();
}

}  // namespace

void write_atomically(const std::filesystem::path& path, const std::string& content) {
  static std::atomic<unsigned> number{0};
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const std::filesystem::path beside =
      folder / fmt::format(".{}.{}.{}", path.filename().string(), ::getpid(), number++);
  if (!write_beside(beside, content) || std::rename(beside.c_str(), path.c_str()) != 0) {
    const int error = errno;
    ::unlink(beside.c_str());
    fail(path, error);
  }
  const Descriptor directory(folder, O_RDONLY | O_DIRECTORY);
  // EINVAL: a file system that forces no folder.
  if (!directory.good() || (!directory.sync() && errno != EINVAL)) fail(path, errno);
}

}  // namespace slipstack::workbench
