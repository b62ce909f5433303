// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace slipstack::workbench {

class Workspace;

struct ServerOptions {
  int port = 0;       ///< 0: any that is free
  bool open = false;  ///< also opens the address in the user's browser
};

/// Serves the workspace to the browsers of this machine until SIGINT or SIGTERM: binds 127.0.0.1 alone and
/// prints the address, which holds the token. Throws UsageError where the port is taken, or
/// where a browser is wanted and none can be started.
void serve_pages(Workspace& workspace, const ServerOptions& options);

}  // namespace slipstack::workbench
