// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace slipstack::workbench {

class Workspace;

/// Takes a log that a page sent. Where it is a log of the documented format it is opened at once:
/// {"opened": true}. Otherwise the answer says how it would be read, for a person to confirm: {"opened":
/// false, "profile", "columns", "rows", "fault"}; sent again with a `profile` (TOML) it is converted and
/// opened.
nlohmann::json take_upload(Workspace& workspace, const std::string& name, const std::string& content,
                           const std::string& profile);

}  // namespace slipstack::workbench
