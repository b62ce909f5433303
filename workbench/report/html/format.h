// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "workbench/base/quantity.h"

// How text becomes readable HTML; numbers and units are those of quantity.h. Everything here returns UTF-8.
namespace slipstack::workbench {

/// Escapes text for HTML content and double-quoted attributes. Control characters other than tab and newline
/// are dropped, so that the name of a log cannot hide anything.
std::string escape_html(std::string_view text);

/// Text as it is printed on a terminal, made inert in HTML: with a no-break space between a number and its
/// unit, and µ for the u of "um".
std::string prose_html(std::string_view text);

}  // namespace slipstack::workbench
