// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// The files of workbench/web/serve; the definitions are generated at build time (report/html/embed.cmake).
namespace slipstack::workbench::web {

extern const std::string_view kServePage;
extern const std::string_view kServeStyle;
extern const std::string_view kServeGlobals;
extern const std::string_view kServeApp;
extern const std::string_view kServeApi;
extern const std::string_view kServeChart;
extern const std::string_view kServeChartExport;
extern const std::string_view kServeCharts;
extern const std::string_view kServeLinked;
extern const std::string_view kServeCursors;
extern const std::string_view kServeTimeCharts;
extern const std::string_view kServeAgainstCharts;
extern const std::string_view kServeFrequencyCharts;
extern const std::string_view kServeLoopCharts;
extern const std::string_view kServeDom;
extern const std::string_view kServeLive;
extern const std::string_view kServeMissing;
extern const std::string_view kServeModel;
extern const std::string_view kServeExperiment;
extern const std::string_view kServeHistory;
extern const std::string_view kServeOpen;
extern const std::string_view kServeStore;
extern const std::string_view kServeFigures;

}  // namespace slipstack::workbench::web
