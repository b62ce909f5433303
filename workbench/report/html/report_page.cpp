// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/html/report_page.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "workbench/report/html/chart_data.h"
#include "workbench/report/html/format.h"
#include "workbench/report/html/json_access.h"
#include "workbench/report/html/sections.h"
#include "workbench/report/html/web_assets.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// Replaces every {{name}} of the template in one pass, so that inserted text is never taken for a
/// placeholder.
template <std::size_t N>
std::string fill(std::string_view page,
                 const std::array<std::pair<std::string_view, std::string>, N>& parts) {
  std::string out;
  std::size_t at = 0;
  while (at < page.size()) {
    const std::size_t open = page.find("{{", at);
    const std::size_t close = open == std::string_view::npos ? open : page.find("}}", open);
    if (close == std::string_view::npos) break;
    out += page.substr(at, open - at);
    const std::string_view name = page.substr(open + 2, close - open - 2);
    for (const auto& [key, value] : parts) {
      if (key == name) out += value;
    }
    at = close + 2;
  }
  out += page.substr(at);
  return out;
}

/// uPlot reads devicePixelRatio once, when it is loaded. It is wrapped in a function with an argument of that
/// name, so that it can be loaded a second time at the resolution of paper.
std::string script() {
  std::string out = "/*\nuPlot, from https://github.com/leeoniya/uPlot\n\n";
  out += web::kUplotLicence;
  out += "\n*/\nfunction loadUplot(devicePixelRatio) {\n";
  out += web::kUplotScript;
  out += "\nreturn uPlot;\n}\n";
  out += web::kUnitsScript;
  out += web::kChartsScript;
  out += web::kPlotsScript;
  out += web::kReportScript;
  return out;
}

std::runtime_error cannot_write(const fs::path& path, std::string_view why) {
  return std::runtime_error("cannot write the report " + path.string() + ": " + std::string(why));
}

void write_all(int file, std::string_view text, const fs::path& path) {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw cannot_write(path, std::strerror(errno));
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void write_and_close(int file, std::string_view text, const fs::path& path) {
  try {
    write_all(file, text, path);
  } catch (...) {
    ::close(file);
    throw;
  }
  // Network file systems report a full disk only here.
  if (::close(file) != 0) throw cannot_write(path, std::strerror(errno));
}

}  // namespace

std::string render_report(const json& data) {
  FigureNumbers figures;
  std::string body = masthead_html(data);
  body += verdict_html(data, figures);
  body += reasons_html(data);
  body += ranking_html(data);
  body += charts_html(data, figures);
  body += experiment_charts_html(data, figures);
  body += experiment_tables_html(data);
  body += parameters_html(data);
  body += method_html(data);
  const std::string title = text_at(data, "title");
  const std::string log = text_at(data, "log");
  return fill(
      web::kTemplate,
      std::array<std::pair<std::string_view, std::string>, 5>{{
          {"title", escape_html((title.empty() ? "Report" : title) + (log.empty() ? "" : " – " + log))},
          {"style", std::string(web::kUplotStyle) + "\n" + std::string(web::kColours) +
                        std::string(web::kReportStyle)},
          {"body", body},
          {"data", chart_data_json(data)},
          {"script", script()},
      }});
}

void write_report(const fs::path& path, const json& data) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) throw cannot_write(path, "it is a directory; name a file in it");
  const std::string page = render_report(data);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    // A pipe or /dev/stdout must not be replaced by a file.
    const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (file < 0) throw cannot_write(path, std::strerror(errno));
    write_and_close(file, page, path);
    return;
  }
  const fs::path target = fs::exists(status) ? fs::canonical(path, error) : path;
  fs::path temporary = error ? path : target;
  temporary += ".part-" + std::to_string(::getpid());
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) throw cannot_write(path, std::strerror(errno));
  try {
    write_and_close(file, page, path);
    if (::rename(temporary.c_str(), target.c_str()) != 0) throw cannot_write(path, std::strerror(errno));
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
}

}  // namespace slipstack::workbench
