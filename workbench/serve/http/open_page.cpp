// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/http/open_page.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

constexpr const char* kOpener = "xdg-open";

void write_for_this_user(const std::filesystem::path& path, const std::string& text) {
  std::error_code ignored;
  std::filesystem::remove(path, ignored);  // of a session that was killed, maybe with other permissions
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  const bool written =
      file >= 0 && ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  if (file >= 0) ::close(file);
  if (!written) {
    throw UsageError(fmt::format("{}: cannot be written: {}; leave out --open", printable(path.string()),
                                 std::strerror(error)));
  }
}

}  // namespace

OpenPage::OpenPage(const std::filesystem::path& folder, const std::string& address)
    : page_(std::filesystem::absolute(folder / "open.html")) {
  write_for_this_user(page_, fmt::format("<!doctype html><meta charset=\"utf-8\"><title>slipstack</title>\n"
                                         "<meta http-equiv=\"refresh\" content=\"0; url={0}\">\n"
                                         "<a href=\"{0}\">slipstack</a>\n",
                                         address));
  std::string name = kOpener;
  std::string page = page_.string();
  char* arguments[] = {name.data(), page.data(), nullptr};
  const int error = ::posix_spawnp(&process_, kOpener, nullptr, nullptr, arguments, environ);
  if (error == 0) return;
  std::error_code ignored;
  std::filesystem::remove(page_, ignored);
  throw UsageError(
      fmt::format("--open: {} cannot be started: {}; install xdg-utils, or leave out --open and open "
                  "the address that is printed",
                  kOpener, std::strerror(error)));
}

OpenPage::~OpenPage() {
  std::error_code ignored;
  std::filesystem::remove(page_, ignored);
  ::waitpid(process_, nullptr, WNOHANG);
}

}  // namespace slipstack::workbench
