// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <new>
#include <string_view>

#include "workbench/base/text.h"
#include "workbench/log/assemble.h"
#include "workbench/log/csv/csv.h"
#include "workbench/log/foreign_format.h"
#include "workbench/log/input_file.h"
#include "workbench/log/log.h"
#include "workbench/log/mat/mat.h"
#include "workbench/log/mat/mat73.h"

namespace slipstack::workbench {
namespace {

Log read_file(const std::string& name, const std::filesystem::path& path) {
  const InputFile file(name, path);
  if (file.size() == 0) throw InputError(name + ": the file is empty; record a log into it");
  std::array<char, kMatHeaderSize> head{};
  const std::size_t count = file.read_at(0, head.data(), head.size());
  if (const std::string format = foreign_format({head.data(), count}); !format.empty())
    throw InputError(name + ": is " + format);
  if (is_mat73({head.data(), count})) return assemble_log(read_mat73(name, path, file.size()));
  FileSource source(file, 0);
  if (looks_like_mat({head.data(), count})) return assemble_log(read_mat(name, source, file.size()));
  return assemble_log(read_csv(name, source));
}

}  // namespace

Log read_log(const std::filesystem::path& path) {
  const std::string name = printable(path.string());
  try {
    Log log = read_file(name, path);
    log.path = path.string();
    return log;
  } catch (const std::bad_alloc&) {
    throw InputError(name + ": the log does not fit into memory; split it into shorter logs or decimate it");
  }
}

}  // namespace slipstack::workbench
