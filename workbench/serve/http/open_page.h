// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace slipstack::workbench {

/// Opens an address in the user's browser by xdg-open, as long as the object lives. The address holds a
/// secret and the arguments of a process can be read by every user, so the browser is given a page that only
/// this user can read, and that leads there.
class OpenPage {
 public:
  /// Writes the page into `folder` and starts the browser. Throws UsageError where either cannot be done.
  OpenPage(const std::filesystem::path& folder, const std::string& address);
  ~OpenPage();
  OpenPage(const OpenPage&) = delete;
  OpenPage& operator=(const OpenPage&) = delete;

 private:
  std::filesystem::path page_;
  int process_ = -1;
};

}  // namespace slipstack::workbench
