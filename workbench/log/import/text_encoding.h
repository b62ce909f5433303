// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace slipstack::workbench {

/// The encoding of the beginning of a file, by its byte-order mark, the zeros of UTF-16 and what UTF-8
/// forbids: utf-8, utf-16le, utf-16be or latin-1.
std::string encoding_of(std::string_view bytes);

/// The text as UTF-8, without a byte-order mark. `encoding`: one of the above.
std::string decoded(std::string_view bytes, const std::string& encoding);

}  // namespace slipstack::workbench
