// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

namespace slipstack::workbench {

/// A file of the page: workbench/web, embedded at build time.
struct Page {
  const char* path;
  const char* type;
  std::string_view content;
};
const std::vector<Page>& pages();

}  // namespace slipstack::workbench
