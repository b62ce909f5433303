// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// The files of workbench/web and of its pinned uplot package; the definitions are generated at build time
// (embed.cmake).
namespace slipstack::workbench::web {

extern const std::string_view kTemplate;
extern const std::string_view kColours;
extern const std::string_view kReportStyle;
extern const std::string_view kUnitsScript;
extern const std::string_view kChartsScript;
extern const std::string_view kPlotsScript;
extern const std::string_view kReportScript;
extern const std::string_view kUplotStyle;
extern const std::string_view kUplotScript;
extern const std::string_view kUplotLicence;

}  // namespace slipstack::workbench::web
