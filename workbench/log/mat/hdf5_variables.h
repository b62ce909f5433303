// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace slipstack::workbench {

/// One thing that a MAT-file of version 7.3 holds.
struct Hdf5Item {
  enum class Kind : std::uint8_t { kNumbers, kText, kOther, kRecord, kEnd, kFault };

  Kind kind = Kind::kEnd;
  bool in_record = false;  ///< a field of the struct of the last kRecord
  bool single = false;     ///< numbers of single precision
  std::string name;
  std::string text;             ///< of kText; of kFault what is wrong
  std::vector<double> numbers;  ///< of kNumbers
};

/// Passes each variable of the file at `path`, and each field of a struct that has a field time_s, to `take`;
/// then kEnd, or kFault with what is wrong, or kFault without text where libhdf5 is not there.
void read_hdf5_variables(const std::string& path, const std::function<void(const Hdf5Item&)>& take);

}  // namespace slipstack::workbench
