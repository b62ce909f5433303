// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/mat/mat_elements.h"

#include <gtest/gtest.h>

#include <cstring>
#include <initializer_list>
#include <string>
#include <vector>

namespace slipstack::workbench::test {
namespace {

constexpr bool kSameOrder = false;
constexpr bool kOtherOrder = true;

std::vector<std::byte> bytes_of(std::initializer_list<unsigned> values) {
  std::vector<std::byte> bytes;
  for (const unsigned value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

// A heap block of exactly these bytes, so that a sanitizer notices a read beyond them.
TEST(MatCursor, TakesTheLastByteAndNoMore) {
  const auto whole = bytes_of({1, 0, 0, 0, 5, 0, 0, 0, 10, 20, 30, 40, 50});
  MatCursor cursor(whole, kSameOrder);
  const MatElement element = cursor.next(MatType::kInt8);
  EXPECT_EQ(mat_numbers(element, kSameOrder), (std::vector<double>{10, 20, 30, 40, 50}));
  EXPECT_TRUE(cursor.at_end());
  EXPECT_THROW(cursor.next(), MatDamage);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_THROW(MatCursor(cut, kSameOrder).next(), MatDamage) << length;
  }
}

TEST(MatCursor, ReadsTheShortFormInBothOrders) {
  const auto little = bytes_of({3, 0, 4, 0, 0xFE, 0xFF, 7, 0});  // two of int16
  const auto big = bytes_of({0, 4, 0, 3, 0xFF, 0xFE, 0, 7});
  const std::vector<double> expected{-2, 7};
  EXPECT_EQ(mat_numbers(MatCursor(little, kSameOrder).next(MatType::kInt16), kSameOrder), expected);
  EXPECT_EQ(mat_numbers(MatCursor(big, kOtherOrder).next(MatType::kInt16), kOtherOrder), expected);
}

TEST(MatCursor, RefusesAnImpossibleShortForm) {
  EXPECT_THROW(MatCursor(bytes_of({1, 0, 5, 0, 1, 2, 3, 4}), kSameOrder).next(), MatDamage);
}

TEST(MatCursor, MovesBehindThePadding) {
  const auto bytes = bytes_of({1, 0, 0, 0, 3, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0, 2, 0, 1, 0, 9, 0, 0, 0});
  MatCursor cursor(bytes, kSameOrder);
  EXPECT_EQ(mat_numbers(cursor.next(), kSameOrder), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(mat_numbers(cursor.next(MatType::kUint8), kSameOrder), (std::vector<double>{9}));
  EXPECT_TRUE(cursor.at_end());
}

TEST(MatCursor, RefusesAnotherType) {
  EXPECT_THROW(MatCursor(bytes_of({2, 0, 1, 0, 9, 0, 0, 0}), kSameOrder).next(MatType::kInt8), MatDamage);
}

TEST(MatNumbers, RefusesHalfANumberAndUnknownTypes) {
  const auto bytes = bytes_of({1, 2, 3});
  EXPECT_THROW(mat_numbers({MatType::kUint16, bytes}, kSameOrder), MatDamage);
  EXPECT_THROW(mat_numbers({static_cast<MatType>(8), bytes}, kSameOrder), MatDamage);
}

TEST(MatText, BecomesUtf8) {
  const auto utf16 = bytes_of({0x4C, 0, 0xE8, 0, 0xAC, 0x20, 0x00, 0xD8});  // L è € and half a pair
  EXPECT_EQ(mat_text({MatType::kUtf16, utf16}, kSameOrder), "Lè€?");
  const auto utf32 = bytes_of({0, 1, 0xF6, 0, 0, 0x11, 0, 0});
  EXPECT_EQ(mat_text({MatType::kUtf32, utf32}, kOtherOrder), "😀?");
  EXPECT_THROW(mat_text({MatType::kDouble, utf16}, kSameOrder), MatDamage);
}

}  // namespace
}  // namespace slipstack::workbench::test
