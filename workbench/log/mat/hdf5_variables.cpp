// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/mat/hdf5_variables.h"

#ifdef SLIPSTACK_HDF5
#include <dlfcn.h>
#include <hdf5.h>

#include <array>
#include <exception>
#include <stdexcept>
#include <utility>

#include "workbench/log/utf8.h"
#endif

namespace slipstack::workbench {

#ifdef SLIPSTACK_HDF5
namespace {

constexpr hsize_t kMostNumbers = (hsize_t{512} << 20) / sizeof(double);  // as of a file of level 5
constexpr unsigned kReadOnly = 0;  // H5F_ACC_RDONLY, whose macro calls the library
constexpr std::size_t kLongestName = 1024;
// Attributes and groups that MATLAB's save -v7.3 writes beside the variables.
constexpr const char* kClass = "MATLAB_class";
constexpr const char* kEmpty = "MATLAB_empty";
constexpr char kReserved = '#';  // #refs#, #subsystem#

/// The functions of libhdf5, found when they are needed.
class Library {
 public:
  Library() : handle_(dlopen(SLIPSTACK_HDF5, RTLD_NOW | RTLD_LOCAL)) {}
  explicit operator bool() const { return handle_ != nullptr; }

  template <typename Function>
  Function* function(const char* name) const {
    void* symbol = dlsym(handle_, name);
    if (symbol == nullptr) throw std::runtime_error(std::string("libhdf5 lacks ") + name);
    return reinterpret_cast<Function*>(symbol);
  }
  /// A type of the library, known after H5open().
  hid_t type(const char* name) const { return *function<hid_t>(name); }

 private:
  void* handle_;
};

// H5(open) is H5open of the library.
#define H5(name) library_.function<decltype(::H5##name)>("H5" #name)

/// Reads one file. Nothing is closed: the process that reads ends with it.
class Reader {
 public:
  Reader(const Library& library, const std::function<void(const Hdf5Item&)>& take)
      : library_(library), take_(take) {}

  void read(const std::string& path) {
    H5(open)();
    H5(Eset_auto2)(H5E_DEFAULT, nullptr, nullptr);
    const hid_t file = H5(Fopen)(path.c_str(), kReadOnly, H5P_DEFAULT);
    if (file < 0) throw std::runtime_error("libhdf5 cannot open it");
    read_group(checked(H5(Gopen2)(file, "/", H5P_DEFAULT)), false);
  }

 private:
  static hid_t checked(hid_t id) {
    if (id < 0) throw std::runtime_error("libhdf5 cannot read a part of it");
    return id;
  }

  void read_group(hid_t group, bool in_record) {
    H5G_info_t info{};
    checked(H5(Gget_info)(group, &info));
    for (hsize_t i = 0; i < info.nlinks; ++i) {
      std::array<char, kLongestName> name{};
      checked(static_cast<hid_t>(H5(Lget_name_by_idx)(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(),
                                                      name.size() - 1, H5P_DEFAULT)));
      if (name[0] == kReserved) continue;
      const hid_t object = checked(H5(Oopen)(group, name.data(), H5P_DEFAULT));
      const H5I_type_t kind = H5(Iget_type)(object);
      if (kind == H5I_DATASET) {
        read_dataset(name.data(), object, in_record);
      } else if (kind == H5I_GROUP && !in_record && H5(Lexists)(object, "time_s", H5P_DEFAULT) > 0) {
        take_({Hdf5Item::Kind::kRecord, false, false, name.data(), "", {}});
        read_group(object, true);
      } else {
        take_({Hdf5Item::Kind::kOther, in_record, false, name.data(), "", {}});
      }
    }
  }

  /// The class that MATLAB gave a variable; empty where it gave none.
  std::string class_of(hid_t object) {
    if (H5(Aexists)(object, kClass) <= 0) return "";
    const hid_t attribute = checked(H5(Aopen)(object, kClass, H5P_DEFAULT));
    const hid_t type = checked(H5(Aget_type)(attribute));
    std::array<char, 32> text{};
    if (H5(Tget_class)(type) != H5T_STRING || H5(Tis_variable_str)(type) != 0 ||
        H5(Tget_size)(type) >= text.size())
      return "";
    checked(H5(Aread)(attribute, type, text.data()));
    return text.data();
  }

  /// How many numbers a row or a column has; 0 for any other shape.
  hsize_t length_of(hid_t dataset) {
    const hid_t space = checked(H5(Dget_space)(dataset));
    const int rank = H5(Sget_simple_extent_ndims)(space);
    std::array<hsize_t, 2> extent{1, 1};
    if (rank < 0 || rank > 2) return 0;
    checked(H5(Sget_simple_extent_dims)(space, extent.data(), nullptr));
    return extent[0] == 1 ? extent[1] : extent[1] == 1 ? extent[0] : 0;
  }

  void read_dataset(const std::string& name, hid_t dataset, bool in_record) {
    const H5T_class_t stored = H5(Tget_class)(checked(H5(Dget_type)(dataset)));
    const std::string matlab_class = class_of(dataset);
    const hsize_t length = length_of(dataset);
    const bool numeric = stored == H5T_FLOAT || stored == H5T_INTEGER;
    if (!numeric || length == 0 || matlab_class == "cell" || H5(Aexists)(dataset, kEmpty) > 0) {
      take_({Hdf5Item::Kind::kOther, in_record, false, name, "", {}});
      return;
    }
    if (length > kMostNumbers) throw std::runtime_error("a variable is larger than this program reads");
    Hdf5Item item{Hdf5Item::Kind::kNumbers, in_record, matlab_class == "single", name, "", {}};
    item.numbers.resize(length);
    checked(H5(Dread)(dataset, library_.type("H5T_NATIVE_DOUBLE_g"), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                      item.numbers.data()));
    if (matlab_class == "char") {
      item.kind = Hdf5Item::Kind::kText;
      for (const double unit : std::exchange(item.numbers, {}))
        append_utf8(item.text, unit >= 0.0 && unit < 0x110000 ? static_cast<std::uint32_t>(unit) : 0xD800);
    }
    take_(item);
  }

  const Library& library_;
  const std::function<void(const Hdf5Item&)>& take_;
};

#undef H5

}  // namespace

void read_hdf5_variables(const std::string& path, const std::function<void(const Hdf5Item&)>& take) {
  const Library library;
  if (!library) return take({Hdf5Item::Kind::kFault, false, false, "", "", {}});
  try {
    Reader(library, take).read(path);
    take({});
  } catch (const std::exception& fault) {
    take({Hdf5Item::Kind::kFault, false, false, "", fault.what(), {}});
  }
}

#else

void read_hdf5_variables(const std::string&, const std::function<void(const Hdf5Item&)>& take) {
  take({Hdf5Item::Kind::kFault, false, false, "", "", {}});
}

#endif

}  // namespace slipstack::workbench
