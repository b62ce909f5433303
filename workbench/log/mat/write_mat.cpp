// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/mat/write_mat.h"

#include <cstdint>
#include <cstring>

namespace slipstack::workbench {
namespace {

// Data types and array class of the format.
constexpr std::uint32_t kInt8 = 1;
constexpr std::uint32_t kInt32 = 5;
constexpr std::uint32_t kUint32 = 6;
constexpr std::uint32_t kDouble = 9;
constexpr std::uint32_t kMatrix = 14;
constexpr std::uint32_t kDoubleArray = 6;

void put_word(std::string& out, std::uint32_t word) {
  char bytes[4];
  std::memcpy(bytes, &word, 4);  // the header says which byte order this is
  out.append(bytes, 4);
}

void put_element(std::string& out, std::uint32_t type, const void* data, std::size_t bytes) {
  put_word(out, type);
  put_word(out, static_cast<std::uint32_t>(bytes));
  if (bytes > 0) out.append(static_cast<const char*>(data), bytes);
  out.append((8 - bytes % 8) % 8, '\0');
}

std::string head() {
  std::string out = "MATLAB 5.0 MAT-file, written by slipstack";
  out.resize(124, ' ');
  const std::uint16_t version = 0x0100;
  const std::uint16_t order = 0x4D49;  // "MI" where the reader has the byte order of the writer
  char bytes[4];
  std::memcpy(bytes, &version, 2);
  std::memcpy(bytes + 2, &order, 2);
  return out.append(bytes, 4);
}

}  // namespace

std::string mat_file(const std::vector<std::pair<std::string, std::vector<double>>>& variables) {
  std::string out = head();
  for (const auto& [name, values] : variables) {
    std::string matrix;
    const std::uint32_t flags[2] = {kDoubleArray, 0};
    put_element(matrix, kUint32, flags, sizeof(flags));
    const std::int32_t size[2] = {static_cast<std::int32_t>(values.size()), 1};
    put_element(matrix, kInt32, size, sizeof(size));
    put_element(matrix, kInt8, name.data(), name.size());
    put_element(matrix, kDouble, values.data(), values.size() * sizeof(double));
    put_word(out, kMatrix);
    put_word(out, static_cast<std::uint32_t>(matrix.size()));
    out += matrix;
  }
  return out;
}

}  // namespace slipstack::workbench
