// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>

// How an object of the dictionary is described: the vocabulary of object_table.h.
namespace slipstack::canopen {

/// Data types (CiA 301 table 44); the number is the index of the type's own dictionary entry.
enum class Type : std::uint8_t {
  kBoolean = 0x01,
  kI8 = 0x02,
  kI16 = 0x03,
  kI32 = 0x04,
  kU8 = 0x05,
  kU16 = 0x06,
  kU32 = 0x07,
  kReal32 = 0x08,
  kString = 0x09,
  kDomain = 0x0F,
};

/// Bytes of a value; 0 for strings and domains.
constexpr std::size_t size_of(Type type) {
  switch (type) {
    case Type::kBoolean:
    case Type::kI8:
    case Type::kU8:
      return 1;
    case Type::kI16:
    case Type::kU16:
      return 2;
    case Type::kI32:
    case Type::kU32:
    case Type::kReal32:
      return 4;
    default:
      return 0;
  }
}

/// CiA 301 table 43.
enum class ObjectCode : std::uint8_t { kDomain = 2, kVariable = 7, kArray = 8, kRecord = 9 };

enum class Access : std::uint8_t { kConstant, kRead, kWrite, kReadWrite };

/// In which PDOs an object may be mapped.
enum class Mapping : std::uint8_t { kNone, kTransmit, kReceive, kBoth };

/// What happens to a value when it is stored (1010h), and who may change it when.
enum class Storage : std::uint8_t {
  kVolatile,   ///< begins with its default
  kParameter,  ///< stored; locked while the drive is enabled and by the access lock
  kSetting,    ///< stored; locked by the access lock only
};

/// One sub-index. Values travel as 32 raw bits: floats as their IEEE bits, shorter integers extended by sign.
struct Object {
 private:
  // Declared first: clang requires that where it is used in a constant expression.
  template <class Change>
  constexpr Object with(Change&& change) const {
    Object copy = *this;
    change(copy);
    return copy;
  }

 public:
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  Type type = Type::kU32;
  ObjectCode code = ObjectCode::kVariable;  ///< of the whole object
  Access access = Access::kReadWrite;
  Mapping mapping = Mapping::kNone;
  Storage storage = Storage::kVolatile;
  bool live = false;       ///< read from, or written to, the device instead of a place in memory
  bool plus_node = false;  ///< the node id is added to the default
  std::uint32_t initial = 0;
  std::uint32_t low = 0;
  std::uint32_t high = 0xFFFFFFFF;
  float scale = 1.0F;          ///< of one step, in `unit`
  const char* unit = "";       ///< SI where there is one
  const char* object = "";     ///< name of the object, at its first sub-index
  const char* name = "";       ///< name of this sub-index
  int number = 0;              ///< after the name, where several have the same
  const char* text = nullptr;  ///< a string's value

  constexpr Object read_only() const {
    return with([](Object& o) { o.access = Access::kRead; });
  }
  constexpr Object write_only() const {
    return with([](Object& o) { o.access = Access::kWrite; });
  }
  constexpr Object constant(std::uint32_t value) const {
    return with([&](Object& o) {
      o.access = Access::kConstant;
      o.initial = value;
    });
  }
  constexpr Object from_device() const {
    return with([](Object& o) { o.live = true; });
  }
  constexpr Object at_first(std::integral auto value) const {
    return with([&](Object& o) { o.initial = static_cast<std::uint32_t>(value); });
  }
  constexpr Object at_first(float value) const { return at_first(std::bit_cast<std::uint32_t>(value)); }
  constexpr Object node_id_added() const {
    return with([](Object& o) { o.plus_node = true; });
  }
  constexpr Object within(std::integral auto lowest, std::integral auto highest) const {
    return with([&](Object& o) {
      o.low = static_cast<std::uint32_t>(lowest);
      o.high = static_cast<std::uint32_t>(highest);
    });
  }
  constexpr Object within(float lowest, float highest) const {
    return with([&](Object& o) {
      o.low = std::bit_cast<std::uint32_t>(lowest);
      o.high = std::bit_cast<std::uint32_t>(highest);
    });
  }
  constexpr Object mapped(Mapping where) const {
    return with([&](Object& o) { o.mapping = where; });
  }
  constexpr Object stored(Storage how) const {
    return with([&](Object& o) { o.storage = how; });
  }
  constexpr Object in(const char* of_unit, float of_scale = 1.0F) const {
    return with([&](Object& o) {
      o.unit = of_unit;
      o.scale = of_scale;
    });
  }

  constexpr Object reads(const char* value) const {
    return with([&](Object& o) {
      o.access = Access::kConstant;
      o.text = value;
    });
  }

  constexpr bool readable() const { return access != Access::kWrite; }
  constexpr bool writable() const { return access == Access::kWrite || access == Access::kReadWrite; }
};

/// A value of `type` with the widest bounds the type has.
constexpr Object entry(std::uint16_t index, std::uint8_t sub, Type type, const char* name) {
  Object object;
  object.index = index;
  object.sub = sub;
  object.type = type;
  object.name = name;
  object.code = ObjectCode::kVariable;
  switch (type) {
    case Type::kBoolean:
      return object.within(0, 1);
    case Type::kI8:
      return object.within(-128, 127);
    case Type::kU8:
      return object.within(0, 255);
    case Type::kI16:
      return object.within(-32768, 32767);
    case Type::kU16:
      return object.within(0, 65535);
    case Type::kI32:
      return object.within(-2147483647 - 1, 2147483647);
    case Type::kReal32:
      return object.within(-3.402823466e+38F, 3.402823466e+38F);
    case Type::kDomain:
      object.code = ObjectCode::kDomain;
      object.live = true;
      return object;
    default:
      return object;
  }
}

/// An object without sub-indices.
constexpr Object variable(std::uint16_t index, Type type, const char* name) {
  Object object = entry(index, 0, type, name);
  object.object = name;
  return object;
}

/// A value that the device measures or counts; it may be mapped into a TPDO.
constexpr Object reading(std::uint16_t index, std::uint8_t sub, Type type, const char* name) {
  return entry(index, sub, type, name).read_only().from_device().mapped(Mapping::kTransmit);
}

/// Sub-index 0 of an array or record of `count` more.
constexpr Object head(std::uint16_t index, ObjectCode code, const char* name, std::uint8_t count) {
  Object object = entry(index, 0, Type::kU8, "Highest sub-index supported").constant(count);
  object.code = code;
  object.object = name;
  return object;
}

}  // namespace slipstack::canopen
