// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace slipstack::workbench {

/// Arrays of numbers for a page, without the cost of text: the length of a JSON header (4 bytes, little
/// endian), the header, padded to a multiple of eight, then the arrays. The header lists them under `arrays`,
/// each with name, type (f4, f8) and length; each begins at a multiple of eight.
class Bytes {
 public:
  nlohmann::json header = nlohmann::json::object();

  void add_f8(const char* name, const std::vector<double>& values) {
    append(name, "f8", values.size(), values.data(), values.size() * sizeof(double));
  }
  template <class Values>
  void add_f4(const char* name, const Values& values) {
    const auto size = static_cast<std::size_t>(values.size());
    std::vector<float> narrow(size);
    for (std::size_t i = 0; i < size; ++i) {
      narrow[i] = static_cast<float>(values[static_cast<decltype(values.size())>(i)]);
    }
    append(name, "f4", size, narrow.data(), size * sizeof(float));
  }

  std::string text() const {
    nlohmann::json whole = header;
    whole["arrays"] = arrays_;
    std::string head = whole.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    while ((head.size() + 4) % 8 != 0) head += ' ';
    const auto length = static_cast<std::uint32_t>(head.size());
    std::string out(4, '\0');
    for (std::size_t i = 0; i < 4; ++i) out[i] = static_cast<char>(length >> (8 * i));
    return out + head + data_;
  }

 private:
  void append(const char* name, const char* type, std::size_t count, const void* values, std::size_t bytes) {
    arrays_.push_back({{"name", name}, {"type", type}, {"length", count}});
    const std::size_t begin = data_.size();
    data_.resize(begin + (bytes + 7) / 8 * 8, '\0');
    if (bytes > 0) std::memcpy(data_.data() + begin, values, bytes);
  }
  nlohmann::json arrays_ = nlohmann::json::array();
  std::string data_;
};

}  // namespace slipstack::workbench
