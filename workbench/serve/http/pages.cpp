// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/http/pages.h"

#include "workbench/report/html/web_assets.h"
#include "workbench/serve/http/page_assets.h"

namespace slipstack::workbench {

const std::vector<Page>& pages() {
  constexpr const char* kScript = "text/javascript; charset=utf-8";
  constexpr const char* kStyle = "text/css; charset=utf-8";
  static const std::vector<Page> kPages{
      {"/", "text/html; charset=utf-8", web::kServePage},
      {"/workbench.css", kStyle, web::kServeStyle},
      {"/colours.css", kStyle, web::kColours},
      {"/uplot.css", kStyle, web::kUplotStyle},
      {"/uplot.js", kScript, web::kUplotScript},
      {"/globals.js", kScript, web::kServeGlobals},
      {"/units.js", kScript, web::kUnitsScript},
      {"/app.js", kScript, web::kServeApp},
      {"/api.js", kScript, web::kServeApi},
      {"/chart.js", kScript, web::kServeChart},
      {"/chart_export.js", kScript, web::kServeChartExport},
      {"/charts.js", kScript, web::kServeCharts},
      {"/linked.js", kScript, web::kServeLinked},
      {"/cursors.js", kScript, web::kServeCursors},
      {"/time_charts.js", kScript, web::kServeTimeCharts},
      {"/against_charts.js", kScript, web::kServeAgainstCharts},
      {"/frequency_charts.js", kScript, web::kServeFrequencyCharts},
      {"/loop_charts.js", kScript, web::kServeLoopCharts},
      {"/dom.js", kScript, web::kServeDom},
      {"/figures.js", kScript, web::kServeFigures},
      {"/live.js", kScript, web::kServeLive},
      {"/missing.js", kScript, web::kServeMissing},
      {"/model.js", kScript, web::kServeModel},
      {"/experiment.js", kScript, web::kServeExperiment},
      {"/history.js", kScript, web::kServeHistory},
      {"/open.js", kScript, web::kServeOpen},
      {"/store.js", kScript, web::kServeStore},
  };
  return kPages;
}

}  // namespace slipstack::workbench
