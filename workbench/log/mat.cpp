// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/mat.h"

#include <fmt/format.h>
#include <matio.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "workbench/log/columns.h"
#include "workbench/log/input_error.h"
#include "workbench/log/text.h"

namespace slipstack::workbench {
namespace {

constexpr double kSinglePrecision = 0x1p-24;
constexpr std::string_view kHdf5Signature = "\x89HDF\r\n\x1A\n";

struct FileCloser {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct VariableFreer {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using File = std::unique_ptr<mat_t, FileCloser>;
using Variable = std::unique_ptr<matvar_t, VariableFreer>;

std::size_t element_count(const matvar_t& variable) {
  std::size_t count = 1;
  for (int i = 0; i < variable.rank; ++i) {
    if (__builtin_mul_overflow(count, variable.dims[i], &count)) return SIZE_MAX;
  }
  return count;
}

bool is_vector(const matvar_t& variable) {
  if (variable.rank != 2) return false;
  return variable.dims[0] == 1 || variable.dims[1] == 1;
}

template <typename Number>
std::vector<double> converted(const matvar_t& variable) {
  const auto* const first = static_cast<const Number*>(variable.data);
  std::vector<double> values(element_count(variable));
  std::transform(first, first + values.size(), values.begin(),
                 [](Number value) { return static_cast<double>(value); });
  return values;
}

// The numbers of a real vector; empty for everything else.
std::vector<double> numbers(const matvar_t& variable) {
  if (variable.data == nullptr || variable.isComplex != 0 || !is_vector(variable)) return {};
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      return converted<double>(variable);
    case MAT_C_SINGLE:
      return converted<float>(variable);
    case MAT_C_INT8:
      return converted<std::int8_t>(variable);
    case MAT_C_UINT8:
      return converted<std::uint8_t>(variable);
    case MAT_C_INT16:
      return converted<std::int16_t>(variable);
    case MAT_C_UINT16:
      return converted<std::uint16_t>(variable);
    case MAT_C_INT32:
      return converted<std::int32_t>(variable);
    case MAT_C_UINT32:
      return converted<std::uint32_t>(variable);
    case MAT_C_INT64:
      return converted<std::int64_t>(variable);
    case MAT_C_UINT64:
      return converted<std::uint64_t>(variable);
    default:
      return {};
  }
}

std::uint32_t read_u32(std::FILE* file, bool swapped, bool& ok) {
  std::uint32_t value = 0;
  ok = std::fread(&value, sizeof value, 1, file) == 1;
  return swapped ? __builtin_bswap32(value) : value;
}

struct StdioCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// The library reads what it finds and returns less than there was; the sizes that the elements of the file
// announce tell whether all of it is there.
void require_whole(const std::string& name, const std::filesystem::path& path, std::size_t file_size,
                   bool swapped) {
  const std::unique_ptr<std::FILE, StdioCloser> file(std::fopen(path.c_str(), "rb"));
  std::size_t offset = kMatHeaderSize;
  while (file != nullptr && offset < file_size) {
    bool whole = std::fseek(file.get(), static_cast<long>(offset), SEEK_SET) == 0;
    bool ok = false;
    const std::uint32_t type = read_u32(file.get(), swapped, ok);
    whole = whole && ok;
    const std::uint32_t length = read_u32(file.get(), swapped, ok);
    whole = whole && ok;
    if (whole && type != MAT_T_MATRIX && type != MAT_T_COMPRESSED) {
      throw InputError(fmt::format("{}: the MAT file is damaged at byte {}; save it again", name, offset));
    }
    offset += 8 + std::size_t{length};
    if (whole && offset <= file_size) continue;
    throw InputError(name + ": the MAT file is cut off; copy or save it again");
  }
}

// A compressed element cannot hold more than zlib's best ratio of its file: a damaged size is refused before
// memory is asked for it.
void require_plausible_size(const std::string& name, const matvar_t& variable, std::size_t file_size) {
  constexpr std::size_t kBestCompression = 1032;
  const std::size_t count = element_count(variable);
  if (count <= file_size * kBestCompression / 8 || count <= file_size) return;
  throw InputError(name + ": variable " + quoted(variable.name == nullptr ? "" : variable.name) +
                   " announces more numbers than the file can hold; save it again");
}

class MatReader {
 public:
  MatReader(std::string name, std::size_t file_size) : file_size_(file_size) {
    table_.source = std::move(name);
  }

  RawTable read(mat_t* file) {
    std::vector<Variable> variables = read_variables(file);
    const matvar_t* const record = find_record(variables);
    if (record != nullptr) {
      for (unsigned i = 0; i < Mat_VarGetNumberOfFields(const_cast<matvar_t*>(record)); ++i) {
        const matvar_t* field = Mat_VarGetStructFieldByIndex(const_cast<matvar_t*>(record), i, 0);
        const char* const field_name = Mat_VarGetStructFieldnames(record)[i];
        if (field != nullptr && field_name != nullptr) take(field_name, *field, false);
      }
    }
    for (const Variable& variable : variables) {
      if (variable.get() == record || variable->name == nullptr) continue;
      take(variable->name, *variable, record != nullptr);
    }
    if (!left_out_.empty())
      table_.notes.push_back("left out, neither vector, number nor text: " + joined(left_out_));
    require_equal_lengths();
    return std::move(table_);
  }

 private:
  std::vector<Variable> read_variables(mat_t* file) {
    std::vector<Variable> variables;
    while (Variable variable{Mat_VarReadNextInfo(file)}) {
      require_plausible_size(table_.source, *variable, file_size_);
      if (variable->class_type == MAT_C_STRUCT) require_plausible_fields(*variable);
      if (Mat_VarReadDataAll(file, variable.get()) != 0 && variable->class_type != MAT_C_EMPTY) {
        throw InputError(table_.source + ": variable " +
                         quoted(variable->name == nullptr ? "" : variable->name) +
                         " cannot be read; save the file again");
      }
      variables.push_back(std::move(variable));
    }
    return variables;
  }

  void require_plausible_fields(const matvar_t& record) const {
    const std::size_t count = element_count(record);
    if (count != 1) return;
    for (unsigned i = 0; i < Mat_VarGetNumberOfFields(const_cast<matvar_t*>(&record)); ++i) {
      const matvar_t* field = Mat_VarGetStructFieldByIndex(const_cast<matvar_t*>(&record), i, 0);
      if (field != nullptr) require_plausible_size(table_.source, *field, file_size_);
    }
  }

  // The struct that holds the log, when time_s is no variable of its own.
  const matvar_t* find_record(const std::vector<Variable>& variables) const {
    const matvar_t* found = nullptr;
    for (const Variable& variable : variables) {
      if (variable->name != nullptr && std::string_view(variable->name) == "time_s") return nullptr;
      if (variable->class_type != MAT_C_STRUCT || element_count(*variable) != 1) continue;
      if (Mat_VarGetStructFieldByName(variable.get(), "time_s", 0) == nullptr) continue;
      if (found != nullptr) {
        throw InputError(table_.source + ": structs " + quoted(found->name) + " and " +
                         quoted(variable->name) + " both hold a log; save one of them alone");
      }
      found = variable.get();
    }
    return found;
  }

  // Vectors become columns, scalars and text header entries. Beside a struct that holds the log, vectors are
  // somebody else's.
  void take(const std::string& name, const matvar_t& variable, bool beside_record) {
    const bool is_text = variable.class_type == MAT_C_CHAR;
    std::vector<double> values = is_text ? std::vector<double>{} : numbers(variable);
    if (is_text) {
      take_header(name, text_of(variable));
    } else if (values.size() == 1) {
      take_header(name, fmt::format("{}", values.front()));
    } else if (values.empty() || beside_record) {
      left_out_.push_back(printable(name));
    } else {
      require_finite(name, values);
      const double precision = variable.class_type == MAT_C_SINGLE ? kSinglePrecision : 0.0;
      table_.columns.push_back({name, std::move(values), precision});
    }
  }

  void take_header(const std::string& name, const std::string& value) {
    table_.header.try_emplace(printable(name), RawTable::HeaderEntry{value, 0});
  }

  // A row of characters, one or two bytes each; what is not ASCII becomes '?' unless it came as UTF-8.
  static std::string text_of(const matvar_t& variable) {
    if (variable.data == nullptr || !is_vector(variable)) return {};
    const std::size_t count = element_count(variable);
    std::string text;
    const auto width = static_cast<std::size_t>(std::max(variable.data_size, 1));
    if (width == 1) {
      text.assign(static_cast<const char*>(variable.data), std::min(count, variable.nbytes));
    } else {
      const auto* const bytes = static_cast<const unsigned char*>(variable.data);
      for (std::size_t i = 0; i < std::min(count, variable.nbytes / width); ++i) {
        std::uint16_t unit = 0;
        std::memcpy(&unit, bytes + i * width, sizeof unit);
        text += unit < 0x80 ? static_cast<char>(unit) : '?';
      }
    }
    return printable(trimmed(text));
  }

  void require_finite(const std::string& name, const std::vector<double>& values) const {
    const auto bad = std::find_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); });
    if (bad == values.end()) return;
    throw InputError(fmt::format("{}: {}({}) is {}; remove or correct the sample", table_.source,
                                 printable(name), bad - values.begin() + 1, *bad));
  }

  void require_equal_lengths() const {
    plan_columns(table_, read_header_values(table_));
    const auto& first = table_.columns.front();
    for (const auto& column : table_.columns) {
      if (column.values.size() == first.values.size()) continue;
      throw InputError(fmt::format("{}: {} has {} samples, {} has {}; save vectors of one length",
                                   table_.source, column.name, column.values.size(), first.name,
                                   first.values.size()));
    }
  }

  RawTable table_;
  std::size_t file_size_;
  std::vector<std::string> left_out_;
};

}  // namespace

bool looks_like_mat(std::string_view head) {
  if (head.starts_with("MATLAB ") || head.starts_with(kHdf5Signature)) return true;
  if (head.size() < kMatHeaderSize) return false;
  const std::string_view version = head.substr(kMatHeaderSize - 4);
  return version == std::string_view("\0\1IM", 4) || version == std::string_view("\1\0MI", 4);
}

RawTable read_mat(const std::string& name, const std::filesystem::path& path, std::string_view head,
                  std::size_t file_size) {
  if (head.starts_with("MATLAB 7.3") || head.starts_with(kHdf5Signature)) {
    throw InputError(name + ": is a MAT file of version 7.3 (HDF5); save it with save(..., '-v7')");
  }
  if (head.size() < kMatHeaderSize)
    throw InputError(name + ": the MAT file is cut off; copy or save it again");
  const std::string_view order = head.substr(kMatHeaderSize - 2);
  if (order != "IM" && order != "MI") {
    throw InputError(name + ": the head of the MAT file is damaged; save it again with save(..., '-v7')");
  }
  const bool file_is_little = order == "IM";
  require_whole(name, path, file_size, file_is_little != (std::endian::native == std::endian::little));
  const File file(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (file == nullptr || Mat_GetVersion(file.get()) != MAT_FT_MAT5) {
    throw InputError(name + ": is not a MAT file of level 5; save it with save(..., '-v7')");
  }
  return MatReader(name, file_size).read(file.get());
}

}  // namespace slipstack::workbench
