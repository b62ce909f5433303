// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/http/upload.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "workbench/base/atomic_write.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/log/byte_source.h"
#include "workbench/log/csv/csv.h"
#include "workbench/log/import/import_log.h"
#include "workbench/log/mat/mat.h"
#include "workbench/serve/session/plain_file.h"
#include "workbench/serve/session/workspace.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// Whether the names of the columns are those of a log. The rest is checked when it is opened.
bool has_log_columns(const std::string& name, const std::string& content) {
  if (looks_like_mat(std::string_view(content).substr(0, kMatHeaderSize))) return true;
  try {
    MemorySource source(content);
    const CsvReader reader(name, source);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

json preview_json(const ImportPreview& preview) {
  json columns = json::array();
  for (const ImportColumn& column : preview.profile.columns) {
    columns.push_back({{"source", printable(column.source)},
                       {"target", column.target},
                       {"factor", column.factor},
                       {"iso_time", column.iso_time},
                       {"same_time", column.same_time}});
  }
  return {{"opened", false},
          {"encoding", preview.profile.encoding},
          {"separator", std::string(1, preview.profile.separator)},
          {"decimal", std::string(1, preview.profile.decimal)},
          {"skip_lines", preview.profile.skip_lines},
          {"units_row", preview.profile.units_row},
          {"columns", columns},
          {"rows", preview.rows},
          {"fault", preview.fault},
          {"profile", to_toml(preview.profile)}};
}

std::string csv_name(const std::string& name) {
  return std::filesystem::path(plain_name(name, "log")).stem().string() + ".csv";
}

}  // namespace

json take_upload(Workspace& workspace, const std::string& name, const std::string& content,
                 const std::string& profile) {
  if (content.empty()) throw InputError(fmt::format("{}: the file is empty", printable(name)));
  const std::string shown = printable(plain_name(name, "log"));
  if (!profile.empty()) {
    const ImportProfile wanted = parse_profile("profile", profile);
    workspace.add_log(csv_name(name), import_log(shown, content, wanted).text);
    write_atomically(workspace.folder() / "import.toml", to_toml(wanted));
    return {{"opened", true}};
  }
  if (has_log_columns(shown, content)) {
    workspace.add_log(shown, content);
    return {{"opened", true}};
  }
  return preview_json(guess_import(shown, content));
}

}  // namespace slipstack::workbench
