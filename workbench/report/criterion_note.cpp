// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/criterion_note.h"

#include <fmt/format.h>

#include "workbench/diagnose/evidence/criterion.h"

namespace slipstack::workbench {

std::string criterion_note() {
  return fmt::format(
      "criterion: change of the information criterion by the effect; the log supports the effect below "
      "{:.0f} (Kass and Raftery 1995)",
      -kBareMention);
}

}  // namespace slipstack::workbench
