// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <matio.h>

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace slipstack::workbench::test {

// Writes MAT-files as MATLAB's save does, with the library's writing half.
class MatBuilder {
 public:
  explicit MatBuilder(const std::filesystem::path& path, mat_ft version = MAT_FT_MAT5,
                      bool compressed = false)
      : file_(Mat_CreateVer(path.c_str(), nullptr, version)),
        compression_(compressed ? MAT_COMPRESSION_ZLIB : MAT_COMPRESSION_NONE) {
    if (file_ == nullptr) throw std::runtime_error("cannot create a MAT file");
  }
  ~MatBuilder() { Mat_Close(file_); }
  MatBuilder(const MatBuilder&) = delete;
  MatBuilder& operator=(const MatBuilder&) = delete;

  template <typename Number>
  static matvar_t* make(const std::string& name, matio_classes class_type, matio_types data_type,
                        std::vector<Number> values, std::size_t columns = 1) {
    std::array<std::size_t, 2> dims{values.size() / columns, columns};
    return Mat_VarCreate(name.c_str(), class_type, data_type, 2, dims.data(), values.data(), 0);
  }
  static matvar_t* make(const std::string& name, std::vector<double> values, std::size_t columns = 1) {
    return make(name, MAT_C_DOUBLE, MAT_T_DOUBLE, std::move(values), columns);
  }
  static matvar_t* make(const std::string& name, std::string text) {
    std::array<std::size_t, 2> dims{1, text.size()};
    return Mat_VarCreate(name.c_str(), MAT_C_CHAR, MAT_T_UTF8, 2, dims.data(), text.data(), 0);
  }

  // Writes a variable, and frees it.
  MatBuilder& add(matvar_t* variable) {
    Mat_VarWrite(file_, variable, compression_);
    Mat_VarFree(variable);
    return *this;
  }

  // Writes a 1×1 struct of the given variables, which become its fields and belong to it.
  MatBuilder& add_struct(const std::string& name, const std::vector<matvar_t*>& fields) {
    std::vector<const char*> names;
    names.reserve(fields.size());
    for (const matvar_t* field : fields) names.push_back(field->name);
    std::array<std::size_t, 2> dims{1, 1};
    matvar_t* record =
        Mat_VarCreateStruct(name.c_str(), 2, dims.data(), names.data(), static_cast<unsigned>(names.size()));
    for (matvar_t* field : fields) Mat_VarSetStructFieldByName(record, field->name, 0, field);
    return add(record);
  }

 private:
  mat_t* file_;
  matio_compression compression_;
};

}  // namespace slipstack::workbench::test
