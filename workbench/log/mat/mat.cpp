// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/mat/mat.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/log/mat/mat_content.h"
#include "workbench/log/mat/mat_elements.h"

namespace slipstack::workbench {
namespace {

// Version 0x0100 and "MI" in the byte order of the machine that wrote the file.
constexpr std::string_view kLittleEndian("\0\1IM", 4);
constexpr std::string_view kBigEndian("\1\0MI", 4);
constexpr std::string_view kHdf5Signature = "\x89HDF\r\n\x1A\n";

constexpr std::size_t kLargestVariable = std::size_t{512} << 20;

// Array classes (MAT-File Format, table 1-3).
enum class MatClass : std::uint32_t { kStruct = 2, kChar = 4, kDouble = 6, kSingle = 7, kUint64 = 15 };
constexpr std::uint32_t kComplexFlag = 0x0800;

bool is_level5(std::string_view head) {
  return head.ends_with(kLittleEndian) || head.ends_with(kBigEndian);
}

// The header of an array, and a cursor to its content.
struct Array {
  std::string name;
  std::uint32_t array_class = 0;
  bool complex = false;
  std::vector<double> dimensions;
  MatCursor content;

  bool is(MatClass wanted) const { return array_class == static_cast<std::uint32_t>(wanted); }
  bool is_numeric() const {
    return array_class >= static_cast<std::uint32_t>(MatClass::kDouble) &&
           array_class <= static_cast<std::uint32_t>(MatClass::kUint64);
  }
  double element_count() const {
    double count = 1.0;
    for (const double dimension : dimensions) count *= dimension;
    return count;
  }
  bool is_vector() const { return dimensions.size() == 2 && (dimensions[0] == 1.0 || dimensions[1] == 1.0); }
};

Array open_array(std::span<const std::byte> bytes, bool swapped) {
  MatCursor cursor(bytes, swapped);
  const std::uint32_t flags = mat_uint32(cursor.next(MatType::kUint32).data, swapped);
  std::vector<double> dimensions = mat_numbers(cursor.next(MatType::kInt32), swapped);
  std::string name = mat_text(cursor.next(MatType::kInt8), swapped);
  return {std::move(name), flags & 0xFF, (flags & kComplexFlag) != 0, std::move(dimensions), cursor};
}

class MatReader {
 public:
  MatReader(const std::string& name, ByteSource& source, std::size_t file_size)
      : name_(name), source_(source), remaining_(file_size), content_(name) {}

  RawTable read() {
    read_head();
    while (remaining_ > 0) read_variable();
    return content_.finish();
  }

 private:
  std::vector<std::byte> read_bytes(std::size_t count) {
    if (count > remaining_) throw MatDamage("the file is cut off");
    std::vector<std::byte> bytes(count);
    std::size_t filled = 0;
    while (filled < count) {
      const std::size_t got = source_.read(reinterpret_cast<char*>(bytes.data()) + filled, count - filled);
      if (got == 0) throw MatDamage("the file is cut off");
      filled += got;
    }
    remaining_ -= count;
    return bytes;
  }

  void read_head() {
    const std::vector<std::byte> bytes = read_bytes(std::min(remaining_, kMatHeaderSize));
    const std::string_view head(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (head.starts_with(kHdf5Signature)) {
      throw InputError(name_ + ": is an HDF5 file, not one of MATLAB; save it with save(..., '-v7')");
    }
    if (head.size() < kMatHeaderSize) throw MatDamage("the file is cut off");
    if (!is_level5(head)) {
      throw InputError(name_ + ": is not a MAT file of level 5; save it with save(..., '-v7')");
    }
    swapped_ = head.ends_with(kLittleEndian) != (std::endian::native == std::endian::little);
  }

  // Reads one variable: its tag, then its bytes, which may be compressed.
  void read_variable() {
    const std::vector<std::byte> tag = read_bytes(8);
    const auto type = static_cast<MatType>(mat_uint32(tag, swapped_));
    const std::size_t length = mat_uint32(std::span(tag).subspan(4), swapped_);
    if (type != MatType::kMatrix && type != MatType::kCompressed) throw MatDamage("a variable has no type");
    if (length > remaining_) throw MatDamage("the file is cut off");
    if (length > kLargestVariable) throw MatDamage("a variable is larger than this program reads");
    const std::vector<std::byte> bytes = read_bytes(length);
    if (type == MatType::kMatrix) {
      take_variable(bytes);
      return;
    }
    const std::vector<std::byte> inflated = mat_inflated(bytes, swapped_, kLargestVariable);
    take_variable(MatCursor(inflated, swapped_).next(MatType::kMatrix).data);
  }

  void take_variable(std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    Array array = open_array(bytes, swapped_);
    const std::string name = array.name;
    if (array.is(MatClass::kStruct) && array.element_count() == 1.0 && take_record(array)) return;
    take(name, array, false);
  }

  // A struct with a field time_s holds the log. False for any other struct.
  bool take_record(const Array& record) {
    MatCursor cursor = record.content;
    const std::size_t name_length = mat_uint32(cursor.next(MatType::kInt32).data, swapped_);
    const std::string names = mat_text(cursor.next(MatType::kInt8), swapped_);
    if (name_length == 0 || names.size() % name_length != 0)
      throw MatDamage("the fields of a struct have no names");
    std::vector<std::string> fields;
    for (std::size_t i = 0; i < names.size(); i += name_length) {
      const std::string field = names.substr(i, name_length);
      fields.push_back(field.substr(0, field.find('\0')));
    }
    if (std::find(fields.begin(), fields.end(), "time_s") == fields.end()) return false;
    content_.begin_record(record.name);
    for (const std::string& field : fields) {
      const MatElement element = cursor.next(MatType::kMatrix);
      if (element.data.empty()) continue;  // an empty array
      take(field, open_array(element.data, swapped_), true);
    }
    return true;
  }

  void take(const std::string& name, Array array, bool in_record) {
    if (array.is(MatClass::kChar) && array.is_vector()) {
      content_.add_text(in_record, name, mat_text(array.content.next(), swapped_));
      return;
    }
    if (!array.is_numeric() || array.complex || !array.is_vector() || array.element_count() == 0.0) {
      content_.leave_out(name);
      return;
    }
    std::vector<double> values = mat_numbers(array.content.next(), swapped_);
    if (static_cast<double>(values.size()) != array.element_count()) {
      throw MatDamage("the size of variable " + in_quotes(name) + " does not fit its numbers");
    }
    content_.add_numbers(in_record, name, std::move(values),
                         array.is(MatClass::kSingle) ? kSinglePrecision : 0.0);
  }

  const std::string& name_;
  ByteSource& source_;
  std::size_t remaining_;
  bool swapped_ = false;
  MatContent content_;
};

}  // namespace

bool looks_like_mat(std::string_view head) {
  if (head.starts_with("MATLAB ") || head.starts_with(kHdf5Signature)) return true;
  return head.size() == kMatHeaderSize && is_level5(head);
}

bool is_mat73(std::string_view head) {
  return head.starts_with("MATLAB 7.3");
}

RawTable read_mat(const std::string& name, ByteSource& source, std::size_t file_size) {
  try {
    return MatReader(name, source, file_size).read();
  } catch (const MatDamage& damage) {
    throw InputError(name + ": the MAT file is damaged: " + damage.what() + "; copy or save it again");
  }
}

}  // namespace slipstack::workbench
