// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/commission_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

constexpr const char* kStages = "stages.json";
constexpr int kFormat = 1;

[[noreturn]] void cannot(const std::filesystem::path& path, const std::string& what) {
  throw UsageError(fmt::format("{}: {} ({})", printable(path.string()), what, std::strerror(errno)));
}

/// An open file, closed when this ends.
class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags) : fd_(::open(path.c_str(), flags, 0666)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  bool good() const { return fd_ >= 0; }
  bool write(const std::string& content) const {
    for (std::size_t at = 0; at < content.size();) {
      const ssize_t written = ::write(fd_, content.data() + at, content.size() - at);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      at += static_cast<std::size_t>(written);
    }
    return true;
  }
  bool sync() const { return ::fsync(fd_) == 0; }

 private:
  int fd_;
};

}  // namespace

CommissionFolder::CommissionFolder(const std::filesystem::path& folder, const std::string& axis)
    : folder_(folder) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) {
    throw UsageError(fmt::format("{}: no folder can be made there ({}); name another with --out",
                                 printable(folder_.string()), error.message()));
  }
  stages_ = {{"format", kFormat}, {"axis", axis}, {"stages", nlohmann::json::object()}};
  std::ifstream file(path(kStages));
  if (!file) {
    if (!std::filesystem::is_empty(folder_, error) || error) {
      throw UsageError(
          fmt::format("{}: holds other files and no commissioning; name an empty or a new folder with --out",
                      printable(folder_.string())));
    }
    write(kStages, stages_.dump(2) + "\n");
    return;
  }
  const nlohmann::json before = nlohmann::json::parse(file, nullptr, false);
  const bool whole = before.is_object() && before.contains("format") && before["format"] == kFormat &&
                     before.contains("axis") && before["axis"].is_string() && before.contains("stages") &&
                     before["stages"].is_object();
  if (!whole) {
    throw UsageError(fmt::format("{}: is not the record of a commissioning; name another folder with --out",
                                 printable(path(kStages).string())));
  }
  if (before["axis"] != axis) {
    throw UsageError(fmt::format("{}: is of another axis ({}); name another folder with --out",
                                 printable(folder_.string()), printable(before["axis"].get<std::string>())));
  }
  stages_ = before;
  resumed_ = true;
}

void CommissionFolder::finish(const std::string& stage, nlohmann::json found) {
  stages_["stages"][stage] = std::move(found);
  write(kStages, stages_.dump(2) + "\n");
}

void CommissionFolder::write(const std::string& name, const std::string& content) const {
  const std::filesystem::path place = path(name);
  const std::filesystem::path beside = path(name + ".part");
  {
    const Descriptor file(beside, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC);
    if (!file.good() || !file.write(content) || !file.sync()) cannot(beside, "cannot be written");
  }
  if (std::rename(beside.c_str(), place.c_str()) != 0) cannot(place, "cannot be written");
  const Descriptor folder(folder_, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (!folder.good() || !folder.sync()) cannot(folder_, "cannot be written");
}

std::string CommissionFolder::read(const std::string& name) const {
  std::ifstream file(path(name), std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(file), {}};
  if (!file) {
    throw UsageError(fmt::format("{}: is missing; begin anew in another folder with --out",
                                 printable(path(name).string())));
  }
  return content;
}

}  // namespace slipstack::workbench
