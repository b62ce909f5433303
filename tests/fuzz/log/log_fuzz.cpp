// SPDX-License-Identifier: Apache-2.0
// libFuzzer target: for any bytes the log reader returns a valid log or an error message of one line.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "tests/unit/log/log_support.h"
#include "workbench/base/axis_units.h"

namespace {

void require(const std::string& fault) {
  if (fault.empty()) return;
  std::fprintf(stderr, "%s\n", fault.c_str());
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slipstack::workbench;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  forget_axis();  // the input before may have been of the other kind
  const bool is_mat = looks_like_mat(bytes.substr(0, kMatHeaderSize));
  try {
    require(test::violated_guarantee(is_mat ? test::parse_mat(bytes) : test::parse_text(bytes)));
  } catch (const InputError& error) {
    require(test::broken_message(error.what(), is_mat ? "log.mat" : "log.csv"));
  }
  return 0;
}
