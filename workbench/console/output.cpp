// SPDX-License-Identifier: Apache-2.0
#include "workbench/console/output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>

#include "workbench/base/text.h"
#include "workbench/console/cleanup.h"
#include "workbench/console/wrap.h"

namespace slipstack::workbench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStandardOutput = "-";

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw UsageError(fmt::format("{}: {}", printable(name), what));
}

[[noreturn]] void refuse_errno(const std::string& name, int error) {
  refuse(name, fmt::format("cannot be written: {}; name a place that is there, is yours and has room",
                           std::generic_category().message(error)));
}

/// The place with symbolic links followed, also those whose target does not exist yet: the target of a link
/// is written, the link itself is not replaced.
fs::path followed(const std::string& name) {
  std::error_code error;
  fs::path place = fs::absolute(name, error);
  constexpr int kMostLinks = 40;
  for (int link = 0; link < kMostLinks && fs::is_symlink(place, error); ++link) {
    place = place.parent_path() / fs::read_symlink(place, error);
  }
  fs::path canonical = fs::weakly_canonical(place, error);
  return error ? place : canonical;
}

bool is_standard_output(const std::string& name) {
  if (name == kStandardOutput) return true;
  struct stat place {};
  struct stat output {};
  return ::stat(name.c_str(), &place) == 0 && ::fstat(STDOUT_FILENO, &output) == 0 &&
         place.st_dev == output.st_dev && place.st_ino == output.st_ino;
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  return followed(a) == followed(b) || fs::equivalent(a, b, error);
}

/// Writes all of `content`; 0 or errno.
int write_all(int descriptor, std::string_view content) {
  while (!content.empty()) {
    const ssize_t count = ::write(descriptor, content.data(), content.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    content.remove_prefix(static_cast<std::size_t>(count));
  }
  return 0;
}

/// A name that no other process chooses at the same moment. Process ids alone are not unique: containers that
/// share a folder may use the same ones.
fs::path temporary_beside(const fs::path& place) {
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  return place.parent_path() / fmt::format(".slipstack.{}.{:x}.part", ::getpid(), now);
}

int create(const fs::path& path) {
  return ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
}

/// Tests whether a file can be created at `place` by creating one beside it and removing it again.
void probe(const std::string& name, const fs::path& place, const fs::path& temporary) {
  if (::access(place.c_str(), W_OK) != 0 && errno != ENOENT) refuse_errno(name, errno);
  const Cleanup cleanup({temporary.string()});
  const int descriptor = create(temporary);
  if (descriptor < 0) refuse_errno(name, errno);
  ::close(descriptor);
}

}  // namespace

void Outputs::protect_input(const std::string& path) {
  inputs_.push_back(path);
}

void Outputs::claim(const std::string& path) {
  if (path.empty()) return;
  const bool standard = is_standard_output(path);
  for (const std::string& input : inputs_) {
    if (path != kStandardOutput && same_file(path, input)) {
      refuse(path, "is an input of this command; name another file to write");
    }
  }
  Output output{path, followed(path), {}, standard ? Kind::standard_output : Kind::file, {}};
  std::error_code error;
  const fs::file_status status = fs::status(output.place, error);
  if (fs::is_directory(status)) refuse(path, "is a directory; name a file to write");
  if (fs::is_block_file(status) || fs::is_socket(status)) {
    refuse(path, "is a disk or a socket; name a file to write");
  }
  if (!standard && (fs::is_character_file(status) || fs::is_fifo(status))) output.kind = Kind::stream;
  for (const Output& other : outputs_) {
    const bool twice = other.kind == output.kind && output.kind != Kind::stream &&
                       (standard || same_file(path, other.place.string()));
    if (twice) refuse(path, "is named for two outputs; name two files");
  }
  if (output.kind == Kind::file) {
    output.temporary = temporary_beside(output.place);
    probe(path, output.place, output.temporary);
  }
  outputs_.push_back(std::move(output));
}

void Outputs::set(const std::string& path, std::string content) {
  if (path.empty()) return;
  for (Output& output : outputs_) {
    if (output.name != path) continue;
    output.content = std::move(content);
    return;
  }
}

void Outputs::commit(const std::string& text) {
  std::vector<std::string> temporaries;
  for (const Output& output : outputs_) {
    if (output.kind == Kind::file) temporaries.push_back(output.temporary.string());
  }
  const Cleanup cleanup(std::move(temporaries));
  write_temporaries();
  write_streams(text);
  rename_all();
}

void Outputs::write_temporaries() const {
  for (const Output& output : outputs_) {
    if (output.kind != Kind::file) continue;
    const int descriptor = create(output.temporary);
    if (descriptor < 0) refuse_errno(output.name, errno);
    int failed = write_all(descriptor, output.content);
    // A file that is replaced keeps its permissions.
    struct stat old {};
    if (::stat(output.place.c_str(), &old) == 0) ::fchmod(descriptor, old.st_mode & 07777);
    if (::close(descriptor) != 0 && failed == 0) failed = errno;
    if (failed != 0) refuse_errno(output.name, failed);
  }
}

void Outputs::write_streams(const std::string& text) const {
  const Output* standard = nullptr;
  for (const Output& output : outputs_) {
    if (output.kind == Kind::standard_output) standard = &output;
    if (output.kind != Kind::stream) continue;
    const int descriptor = ::open(output.place.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (descriptor < 0) refuse_errno(output.name, errno);
    int failed = write_all(descriptor, output.content);
    if (::close(descriptor) != 0 && failed == 0) failed = errno;
    if (failed != 0) refuse_errno(output.name, failed);
  }
  const int failed =
      write_all(STDOUT_FILENO, standard != nullptr ? standard->content : wrapped(text, terminal_width()));
  if (failed != 0) refuse_errno("standard output", failed);
}

void Outputs::rename_all() const {
  const SignalsHeld held;
  for (const Output& output : outputs_) {
    if (output.kind != Kind::file) continue;
    if (::rename(output.temporary.c_str(), output.place.c_str()) != 0) refuse_errno(output.name, errno);
  }
}

}  // namespace slipstack::workbench
