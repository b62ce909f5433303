// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/http/guard.h"

#include <sys/random.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <system_error>

namespace slipstack::workbench {
namespace {

constexpr std::size_t kTokenBytes = 24;

std::string random_token() {
  std::array<std::uint8_t, kTokenBytes> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::system_error(errno, std::generic_category(), "getrandom");
  }
  std::string token;
  for (const std::uint8_t byte : bytes) {
    token += "0123456789abcdef"[byte >> 4U];
    token += "0123456789abcdef"[byte & 15U];
  }
  return token;
}

}  // namespace

Guard::Guard(int port) : port_(std::to_string(port)), token_(random_token()) {}

bool Guard::knows_host(const std::string& host) const {
  return host == "127.0.0.1:" + port_ || host == "localhost:" + port_;
}

bool Guard::knows_origin(const std::string& origin) const {
  return origin.empty() || origin == "http://127.0.0.1:" + port_ || origin == "http://localhost:" + port_;
}

bool Guard::knows_token(const std::string& authorization) const {
  const std::string wanted = "Bearer " + token_;
  unsigned different = authorization.size() == wanted.size() ? 0U : 1U;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const char given = i < authorization.size() ? authorization[i] : '\0';
    different |=
        static_cast<unsigned>(static_cast<unsigned char>(given) ^ static_cast<unsigned char>(wanted[i]));
  }
  return different == 0U;
}

}  // namespace slipstack::workbench
