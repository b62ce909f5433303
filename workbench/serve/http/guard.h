// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace slipstack::workbench {

/// Who may talk to the server: pages that it served itself, to the person who has its address. Another page
/// in the same browser can send requests to any local port; it has neither the token nor this origin, and a
/// name that was made to point here (DNS rebinding) is not one of the hosts.
class Guard {
 public:
  explicit Guard(int port);

  const std::string& token() const { return token_; }
  /// `host`: that of the request's header.
  bool knows_host(const std::string& host) const;
  /// `origin`: that of the request's header, empty where there is none.
  bool knows_origin(const std::string& origin) const;
  /// `authorization`: "Bearer TOKEN". Compared in constant time.
  bool knows_token(const std::string& authorization) const;

 private:
  std::string port_;
  std::string token_;
};

/// What every answer says to the browser: nothing from elsewhere, no frames, no guessing of types.
inline constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; style-src-attr 'unsafe-inline'; connect-src "
    "'self'; "
    "img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace slipstack::workbench
