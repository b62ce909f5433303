// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/http/guard.h"

#include <gtest/gtest.h>

namespace slipstack::workbench {
namespace {

TEST(Guard, KnowsItsOwnPageAlone) {
  const Guard guard(4711);
  EXPECT_TRUE(guard.knows_host("127.0.0.1:4711"));
  EXPECT_TRUE(guard.knows_host("localhost:4711"));
  for (const char* host :
       {"", "127.0.0.1", "127.0.0.1:4712", "evil.example:4711", "127.0.0.1:4711.evil.example"}) {
    EXPECT_FALSE(guard.knows_host(host)) << host;
  }
  EXPECT_TRUE(guard.knows_origin(""));
  EXPECT_TRUE(guard.knows_origin("http://127.0.0.1:4711"));
  for (const char* origin :
       {"null", "http://127.0.0.1:4712", "https://127.0.0.1:4711", "http://evil.example"}) {
    EXPECT_FALSE(guard.knows_origin(origin)) << origin;
  }
}

TEST(Guard, TokenIsFreshAndWhole) {
  const Guard guard(1);
  const Guard other(1);
  EXPECT_NE(guard.token(), other.token());
  EXPECT_EQ(guard.token().size(), 48U);
  EXPECT_TRUE(guard.knows_token("Bearer " + guard.token()));
  EXPECT_FALSE(guard.knows_token(guard.token()));
  EXPECT_FALSE(guard.knows_token(""));
  EXPECT_FALSE(guard.knows_token("Bearer " + other.token()));
  EXPECT_FALSE(guard.knows_token("Bearer " + guard.token() + "0"));
  EXPECT_FALSE(guard.knows_token("Bearer " + guard.token().substr(1)));
}

}  // namespace
}  // namespace slipstack::workbench
