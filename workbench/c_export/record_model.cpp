// SPDX-License-Identifier: Apache-2.0
#include "workbench/c_export/record_model.h"

#include "workbench/c_export/recorder.h"

namespace slipstack::workbench {
namespace {

template <class T>
RecordedModel record(const Terms& terms, const ExportScales& scales) {
  try {
    return Recorder<T>(terms, scales).record();
  } catch (const NotRecordable&) {
    // Which effect it is shows when each is recorded by itself.
    for (const Term& term : terms) {
      try {
        Recorder<T>({term}, scales).record();
      } catch (const NotRecordable& error) {
        throw NotRecordable(term.id() + ": " + error.what());
      }
    }
    throw;
  }
}

}  // namespace

RecordedModel record_float(const Terms& target_terms, const ExportScales& scales) {
  return record<float>(target_terms, scales);
}

RecordedModel record_double(const Terms& target_terms, const ExportScales& scales) {
  return record<double>(target_terms, scales);
}

}  // namespace slipstack::workbench
