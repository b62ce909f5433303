// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/mat/mat73.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "workbench/base/errors.h"
#include "workbench/log/mat/hdf5_variables.h"
#include "workbench/log/mat/mat.h"
#include "workbench/log/mat/mat_content.h"
#include "workbench/log/mat/mat_elements.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kBytesPerSecond = 10'000'000;  // far below what libhdf5 reads in a second
constexpr rlim_t kLeastSeconds = 20;

void limit(int resource, rlim_t value) {
  const rlimit both{value, value};
  static_cast<void>(setrlimit(static_cast<__rlimit_resource_t>(resource), &both));
}

/// One end of a pipe, closed with it.
class PipeEnd {
 public:
  explicit PipeEnd(int descriptor) : descriptor_(descriptor) {}
  ~PipeEnd() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  PipeEnd(const PipeEnd&) = delete;
  PipeEnd& operator=(const PipeEnd&) = delete;

  /// False where the other end is closed.
  bool write_all(const void* bytes, std::size_t count) const {
    const auto* at = static_cast<const char*>(bytes);
    while (count > 0) {
      const ssize_t done = write(descriptor_, at, count);
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) return false;
      at += done;
      count -= static_cast<std::size_t>(done);
    }
    return true;
  }
  void read_all(void* bytes, std::size_t count) const {
    auto* at = static_cast<char*>(bytes);
    while (count > 0) {
      const ssize_t done = read(descriptor_, at, count);
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) throw MatDamage("libhdf5 has failed on it");
      at += done;
      count -= static_cast<std::size_t>(done);
    }
  }

 private:
  int descriptor_;
};

/// What goes before the name, the text and the numbers of an item.
struct ItemHead {
  Hdf5Item::Kind kind;
  bool in_record;
  bool single;
  std::uint64_t name_size, text_size, count;
};

void send(const PipeEnd& out, const Hdf5Item& item) {
  const ItemHead head{item.kind,        item.in_record,   item.single,
                      item.name.size(), item.text.size(), item.numbers.size()};
  const bool sent = out.write_all(&head, sizeof head) && out.write_all(item.name.data(), item.name.size()) &&
                    out.write_all(item.text.data(), item.text.size()) &&
                    out.write_all(item.numbers.data(), item.numbers.size() * sizeof(double));
  if (!sent) _exit(1);
}

Hdf5Item receive(const PipeEnd& in) {
  ItemHead head{};
  in.read_all(&head, sizeof head);
  Hdf5Item item{head.kind,
                head.in_record,
                head.single,
                std::string(head.name_size, '\0'),
                std::string(head.text_size, '\0'),
                std::vector<double>(head.count)};
  in.read_all(item.name.data(), item.name.size());
  in.read_all(item.text.data(), item.text.size());
  in.read_all(item.numbers.data(), item.numbers.size() * sizeof(double));
  return item;
}

/// The process that reads a file, which ends with this.
class ReadingProcess {
 public:
  ReadingProcess(const std::string& path, std::size_t file_size) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
    process_ = fork();
    if (process_ == 0) {
      close(ends[0]);
      limit(RLIMIT_CORE, 0);
      limit(RLIMIT_CPU, kLeastSeconds + file_size / kBytesPerSecond);
      const PipeEnd out(ends[1]);
      read_hdf5_variables(path, [&](const Hdf5Item& item) { send(out, item); });
      _exit(0);
    }
    close(ends[1]);
    in_.emplace(ends[0]);
    if (process_ < 0) {
      throw std::system_error(errno, std::generic_category(), "fork");
    }
  }
  ~ReadingProcess() {
    in_.reset();  // ends a process that still writes
    while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  ReadingProcess(const ReadingProcess&) = delete;
  ReadingProcess& operator=(const ReadingProcess&) = delete;

  const PipeEnd& in() const { return *in_; }

 private:
  std::optional<PipeEnd> in_;
  pid_t process_ = -1;
};

RawTable received(const std::string& name, const PipeEnd& in) {
  MatContent content(name);
  for (;;) {
    Hdf5Item item = receive(in);
    switch (item.kind) {
      case Hdf5Item::Kind::kNumbers:
        content.add_numbers(item.in_record, item.name, std::move(item.numbers),
                            item.single ? kSinglePrecision : 0.0);
        break;
      case Hdf5Item::Kind::kText:
        content.add_text(item.in_record, item.name, item.text);
        break;
      case Hdf5Item::Kind::kOther:
        content.leave_out(item.name);
        break;
      case Hdf5Item::Kind::kRecord:
        content.begin_record(item.name);
        break;
      case Hdf5Item::Kind::kFault:
        if (!item.text.empty()) throw MatDamage(item.text);
        throw InputError(
            name +
            ": is a MAT file of version 7.3 (HDF5); install the package libhdf5-103-1, or save it "
            "with save(..., '-v7')");
      case Hdf5Item::Kind::kEnd:
        return content.finish();
    }
  }
}

}  // namespace

RawTable read_mat73(const std::string& name, const std::filesystem::path& path, std::size_t file_size) {
  try {
    const ReadingProcess process(path.string(), file_size);
    return received(name, process.in());
  } catch (const MatDamage& damage) {
    throw InputError(name + ": the MAT file is damaged: " + damage.what() + "; copy or save it again");
  }
}

}  // namespace slipstack::workbench
