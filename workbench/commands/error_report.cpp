// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <new>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/commands/command.h"
#include "workbench/model/expression/definition.h"

namespace slipstack::workbench {

std::string as_one_line(std::string_view message) {
  return printable(message.substr(0, message.find_last_not_of('\n') + 1));
}

ErrorReport error_report_of(const std::exception_ptr& fault) {
  try {
    std::rethrow_exception(fault);
  } catch (const DefinitionError& error) {
    return {as_one_line(fmt::format("--effect: {}", error.what())), error.picture(), kUnusableInput};
  } catch (const UsageError& error) {
    return {as_one_line(error.what()), "", kUnusableInput};
  } catch (const InputError& error) {
    return {as_one_line(error.what()), "", kUnusableInput};
  } catch (const RunError& error) {
    return {as_one_line(error.what()), "", kInternalFault};
  } catch (const std::bad_alloc&) {
    return {"out of memory; give a shorter log or a larger machine", "", kInternalFault};
  } catch (const std::exception& error) {
    return {as_one_line(fmt::format("internal fault: {}", error.what())), "", kInternalFault};
  }
}

}  // namespace slipstack::workbench
