// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/define_serve.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/console/output.h"
#include "workbench/log/import/import_log.h"
#include "workbench/serve/http/server.h"
#include "workbench/serve/session/plain_file.h"
#include "workbench/serve/session/workspace.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kLargestImport = std::size_t{2} << 30;

struct ServeRequest {
  std::vector<std::string> logs;
  std::string session = "slipstack-session";
  int port = 0;
  bool open = false;
};

void serve(const ServeRequest& request, ProcessGroup& group) {
  for (const std::string& log : request.logs) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(log, error)) {
      throw InputError(fmt::format("{}: no such file", printable(log)));
    }
  }
  Workspace workspace(group, request.session);
  if (request.logs.empty()) {
    workspace.open_logs();
  } else {
    workspace.set_logs(request.logs);
  }
  serve_pages(workspace, {request.port, request.open});
}

struct ImportRequest {
  std::string file;
  std::string columns;
  std::string profile;
  std::string save_profile;
  std::vector<std::string> header;
  std::string out;
};

void take_header(ImportProfile& profile, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) {
      throw UsageError(fmt::format("--header: {} is not KEY=VALUE, as mass_kg=35.45", in_quotes(line)));
    }
    const std::string key = printable(line.substr(0, equals));
    const std::string value = printable(line.substr(equals + 1));
    const auto is_time = [](const ImportColumn& column) { return column.target == "time_s"; };
    if (key == "sample_rate_Hz" && std::none_of(profile.columns.begin(), profile.columns.end(), is_time)) {
      const char* const end = value.data() + value.size();
      if (parse_double(value.data(), end, profile.sample_rate_Hz) != end || !(profile.sample_rate_Hz > 0.0)) {
        throw UsageError(
            fmt::format("--header: sample_rate_Hz {} is not a number above 0", in_quotes(value)));
      }
      continue;  // there is no time to compare it with: it makes the time
    }
    profile.header[key] = value;
  }
}

std::string shown(const ImportProfile& profile) {
  std::string text =
      fmt::format("encoding   {}\nseparator  '{}', decimal '{}'\n", profile.encoding,
                  profile.separator == '\t' ? "tab" : std::string(1, profile.separator), profile.decimal);
  for (const ImportColumn& column : profile.columns) {
    text += fmt::format("column     {} -> {}", printable(column.source),
                        column.same_time        ? "time of the channels behind it"
                        : column.target.empty() ? "left out"
                                                : column.target);
    if (column.factor != 1.0) text += fmt::format(", times {:g}", column.factor);
    text += column.iso_time ? ", date and time\n" : "\n";
  }
  return text;
}

void import(const ImportRequest& request) {
  Outputs outputs;
  outputs.protect_input(request.file);
  outputs.claim(request.out);
  outputs.claim(request.save_profile);
  const std::string bytes = read_whole(request.file, kLargestImport);
  const std::string name = printable(request.file);
  ImportProfile profile =
      request.profile.empty()
          ? guess_import(name, bytes).profile
          : parse_profile(printable(request.profile), read_whole(request.profile, std::size_t{1} << 20));
  if (!request.columns.empty()) assign_columns(profile, request.columns);
  take_header(profile, request.header);
  ImportedLog log = import_log(name, bytes, profile);
  outputs.set(request.out, std::move(log.text));
  outputs.set(request.save_profile, to_toml(profile));
  std::string text = shown(profile);
  for (const std::string& note : log.notes) text += "note       " + note + "\n";
  outputs.commit(text);
}

void define_import(CLI::App& app) {
  const auto request = std::make_shared<ImportRequest>();
  CLI::App* command = app.add_subcommand("import", "Convert a table of another program into a log");
  command->add_option("FILE", request->file, "table of text: CSV, TSV, export of a scope")->required();
  command
      ->add_option(
          "--columns", request->columns,
          "what the columns are, as 'Pos [mm]=position_mm,F=force_N*0.001'; where none is the time, it is "
          "guessed (default: all are)")
      ->type_name("NAME=TARGET,..");
  command->add_option("--import", request->profile, "profile that tells how to read the file")
      ->type_name("FILE");
  command->add_option("--save-profile", request->save_profile, "write the profile that was used")
      ->type_name("FILE");
  command
      ->add_option("--header", request->header,
                   "a header line of the log, as mass_kg=35.45; sample_rate_Hz=RATE makes the time of a "
                   "table without one; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->take_all();
  command->add_option("--out", request->out, "log to write; '-': standard output")
      ->type_name("FILE")
      ->required();
  command->callback([request] { import(*request); });
}

}  // namespace

void define_serve(CLI::App& app, ProcessGroup* const& group) {
  const auto request = std::make_shared<ServeRequest>();
  CLI::App* command = app.add_subcommand("serve", "Open the workbench in the browser of this machine");
  command->add_option("LOG", request->logs, "logs to open (default: those of the session)")
      ->type_name("LOG...");
  command->add_option("--session", request->session, "folder of plain files that keeps the work")
      ->type_name("FOLDER")
      ->capture_default_str();
  command->add_option("--port", request->port, "on 127.0.0.1 (default: any that is free)")
      ->type_name("N")
      ->check(CLI::Range(0, 65535));
  command->add_flag("--open", request->open, "open the address in your browser");
  command->callback([request, &group] { serve(*request, *group); });
  define_import(app);
}

}  // namespace slipstack::workbench
