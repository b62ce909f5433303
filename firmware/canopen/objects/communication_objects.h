// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "firmware/canopen/objects/object.h"
#include "firmware/update/image_header.h"

// Objects of the communication profile (CiA 301, 7.5): 1000h to 1FFFh.
namespace slipstack::canopen {

inline constexpr std::uint8_t kPdoCount = 4;          ///< each way
inline constexpr std::uint8_t kMappedLargest = 8;     ///< objects in a PDO
inline constexpr std::uint8_t kHeartbeatSources = 4;  ///< that 1016h can watch
inline constexpr std::uint8_t kErrorHistory = 8;

// Who the device is, for the bus and for an update: one place.
using update::kProductCode;
using update::kRevision;
using update::kVendorId;

inline constexpr std::uint32_t kInvalidPdo = 0x80000000;
/// No remote requests on this TPDO: CiA 301 lets a device leave them out, and so do we.
inline constexpr std::uint32_t kNoRemote = 0x40000000;

inline constexpr auto kCommunicationObjects = [] {
  constexpr Storage kSetting = Storage::kSetting;
  return std::to_array<Object>({
      // Drive profile 402, servo drive (IEC 61800-7-201, 6.2).
      variable(0x1000, Type::kU32, "Device type").constant(0x00020192),
      variable(0x1001, Type::kU8, "Error register").read_only().from_device().mapped(Mapping::kTransmit),
      [] {
        Object object = head(0x1003, ObjectCode::kArray, "Pre-defined error field", 0);
        object.access = Access::kReadWrite;  // 0 empties the history
        object.live = true;
        return object.within(0, 0);
      }(),
      entry(0x1003, 1, Type::kU32, "Standard error field").read_only().from_device(),
      entry(0x1003, 2, Type::kU32, "Standard error field").read_only().from_device(),
      entry(0x1003, 3, Type::kU32, "Standard error field").read_only().from_device(),
      entry(0x1003, 4, Type::kU32, "Standard error field").read_only().from_device(),
      entry(0x1003, 5, Type::kU32, "Standard error field").read_only().from_device(),
      entry(0x1003, 6, Type::kU32, "Standard error field").read_only().from_device(),
      entry(0x1003, 7, Type::kU32, "Standard error field").read_only().from_device(),
      entry(0x1003, 8, Type::kU32, "Standard error field").read_only().from_device(),
      variable(0x1005, Type::kU32, "COB-ID SYNC").at_first(0x80U).stored(kSetting),
      variable(0x1006, Type::kU32, "Communication cycle period").in("s", 1e-6F).stored(kSetting),
      variable(0x1008, Type::kString, "Manufacturer device name").reads("slipstack drive"),
      variable(0x1009, Type::kString, "Manufacturer hardware version").reads("any board"),
      variable(0x100A, Type::kString, "Manufacturer software version").reads("0.1.0"),
      head(0x1010, ObjectCode::kArray, "Store parameters", 4),
      entry(0x1010, 1, Type::kU32, "Save all parameters").from_device(),
      entry(0x1010, 2, Type::kU32, "Save communication parameters").from_device(),
      entry(0x1010, 3, Type::kU32, "Save application parameters").from_device(),
      entry(0x1010, 4, Type::kU32, "Save manufacturer parameters").from_device(),
      head(0x1011, ObjectCode::kArray, "Restore default parameters", 4),
      entry(0x1011, 1, Type::kU32, "Restore all default parameters").from_device(),
      entry(0x1011, 2, Type::kU32, "Restore communication default parameters").from_device(),
      entry(0x1011, 3, Type::kU32, "Restore application default parameters").from_device(),
      entry(0x1011, 4, Type::kU32, "Restore manufacturer default parameters").from_device(),
      variable(0x1014, Type::kU32, "COB-ID EMCY").at_first(0x80U).node_id_added().stored(kSetting),
      variable(0x1015, Type::kU16, "Inhibit time EMCY").in("s", 1e-4F).stored(kSetting),
      head(0x1016, ObjectCode::kArray, "Consumer heartbeat time", kHeartbeatSources),
      entry(0x1016, 1, Type::kU32, "Consumer heartbeat time").stored(kSetting),
      entry(0x1016, 2, Type::kU32, "Consumer heartbeat time").stored(kSetting),
      entry(0x1016, 3, Type::kU32, "Consumer heartbeat time").stored(kSetting),
      entry(0x1016, 4, Type::kU32, "Consumer heartbeat time").stored(kSetting),
      variable(0x1017, Type::kU16, "Producer heartbeat time").at_first(1000U).in("s", 1e-3F).stored(kSetting),
      head(0x1018, ObjectCode::kRecord, "Identity object", 4),
      entry(0x1018, 1, Type::kU32, "Vendor-ID").constant(kVendorId),
      entry(0x1018, 2, Type::kU32, "Product code").constant(kProductCode),
      entry(0x1018, 3, Type::kU32, "Revision number").constant(kRevision),
      entry(0x1018, 4, Type::kU32, "Serial number").read_only().from_device(),
      variable(0x1019, Type::kU8, "Synchronous counter overflow value").within(0, 240).stored(kSetting),
      head(0x1029, ObjectCode::kArray, "Error behaviour", 1),
      entry(0x1029, 1, Type::kU8, "Communication error").within(0, 2).stored(kSetting),
      head(0x1200, ObjectCode::kRecord, "SDO server parameter", 2),
      [] {
        Object object = entry(0x1200, 1, Type::kU32, "COB-ID client to server").constant(0x600);
        return object.node_id_added();
      }(),
      [] {
        Object object = entry(0x1200, 2, Type::kU32, "COB-ID server to client").constant(0x580);
        return object.node_id_added();
      }(),
  });
}();

/// What an SDO or a master finds in a PDO at first: mapping entries (index << 16 | sub << 8 | bits).
struct DefaultPdo {
  std::uint32_t cob;  ///< without the node id
  std::uint8_t transmission;
  std::uint16_t inhibit_100us;
  std::uint16_t event_ms;
  std::uint8_t count;
  std::array<std::uint32_t, kMappedLargest> mapped;
};

constexpr std::uint32_t mapping_entry(std::uint16_t index, std::uint8_t sub, std::uint8_t bits) {
  return (static_cast<std::uint32_t>(index) << 16) | (static_cast<std::uint32_t>(sub) << 8) | bits;
}

/// RPDO 1 controlword and mode, 2 the set-point of cyclic position, taken at SYNC; 3 and 4 unused.
inline constexpr std::array<DefaultPdo, kPdoCount> kReceivePdos{{
    {0x200, 255, 0, 0, 2, {mapping_entry(0x6040, 0, 16), mapping_entry(0x6060, 0, 8)}},
    {0x300, 1, 0, 0, 2, {mapping_entry(0x6040, 0, 16), mapping_entry(0x607A, 0, 32)}},
    {0x400 | kInvalidPdo, 255, 0, 0, 0, {}},
    {0x500 | kInvalidPdo, 255, 0, 0, 0, {}},
}};

/// TPDO 1 statusword and mode on change, and every 100 ms for masters that expect it in time, 2 position and
/// torque, 3 the measurement stream of `slipstack record` (tick, position, current), 4 following error and
/// residual.
inline constexpr std::array<DefaultPdo, kPdoCount> kTransmitPdos{{
    {0x180 | kNoRemote,
     255,
     100,
     100,
     3,
     {mapping_entry(0x6041, 0, 16), mapping_entry(0x6061, 0, 8), mapping_entry(0x603F, 0, 16)}},
    {0x280 | kNoRemote,
     1,
     0,
     0,
     3,
     {mapping_entry(0x6041, 0, 16), mapping_entry(0x6064, 0, 32), mapping_entry(0x6077, 0, 16)}},
    {0x380 | kNoRemote | kInvalidPdo,
     1,
     0,
     0,
     3,
     {mapping_entry(0x2210, 5, 16), mapping_entry(0x6063, 0, 32), mapping_entry(0x2200, 11, 16)}},
    {0x480 | kNoRemote, 1, 0, 0, 2, {mapping_entry(0x60F4, 0, 32), mapping_entry(0x2200, 3, 32)}},
}};

namespace detail {

/// The rows that RPDOs and TPDOs share, appended at `at`: communication record, sub-indices 0 to 2.
template <std::size_t N>
constexpr void append_communication(std::array<Object, N>& rows, std::size_t& at, std::uint16_t index,
                                    const DefaultPdo& pdo, std::uint8_t highest, const char* object,
                                    const char* cob) {
  rows[at] = head(index, ObjectCode::kRecord, object, highest);
  rows[at++].number = (index & 0xFF) + 1;
  rows[at++] = entry(index, 1, Type::kU32, cob).at_first(pdo.cob).node_id_added().stored(Storage::kSetting);
  rows[at++] = entry(index, 2, Type::kU8, "Transmission type")
                   .at_first(std::uint32_t{pdo.transmission})
                   .stored(Storage::kSetting);
}

/// A mapping record, appended at `at`.
template <std::size_t N>
constexpr void append_mapping(std::array<Object, N>& rows, std::size_t& at, std::uint16_t index,
                              const DefaultPdo& pdo, const char* object) {
  rows[at] = head(index, ObjectCode::kRecord, object, pdo.count).within(0, kMappedLargest);
  rows[at].number = (index & 0xFF) + 1;
  rows[at].access = Access::kReadWrite;
  rows[at++].storage = Storage::kSetting;
  for (std::uint8_t sub = 1; sub <= kMappedLargest; ++sub) {
    rows[at] = entry(index, sub, Type::kU32, "Mapped object")
                   .at_first(pdo.mapped[sub - 1U])
                   .stored(Storage::kSetting);
    rows[at++].number = sub;
  }
}

}  // namespace detail

inline constexpr auto kReceivePdoObjects = [] {
  std::array<Object, std::size_t{kPdoCount} * (4U + kMappedLargest + 1U)> rows{};
  std::size_t at = 0;
  for (std::uint8_t n = 0; n < kPdoCount; ++n) {
    const auto index = static_cast<std::uint16_t>(0x1400 + n);
    detail::append_communication(rows, at, index, kReceivePdos[n], 5, "RPDO communication parameter",
                                 "COB-ID used by RPDO");
    rows[at++] = entry(index, 5, Type::kU16, "Event timer").in("s", 1e-3F).stored(Storage::kSetting);
  }
  for (std::uint8_t n = 0; n < kPdoCount; ++n) {
    detail::append_mapping(rows, at, static_cast<std::uint16_t>(0x1600 + n), kReceivePdos[n],
                           "RPDO mapping parameter");
  }
  return rows;
}();

inline constexpr auto kTransmitPdoObjects = [] {
  std::array<Object, std::size_t{kPdoCount} * (6U + kMappedLargest + 1U)> rows{};
  std::size_t at = 0;
  for (std::uint8_t n = 0; n < kPdoCount; ++n) {
    const DefaultPdo& pdo = kTransmitPdos[n];
    const auto index = static_cast<std::uint16_t>(0x1800 + n);
    detail::append_communication(rows, at, index, pdo, 6, "TPDO communication parameter",
                                 "COB-ID used by TPDO");
    rows[at++] = entry(index, 3, Type::kU16, "Inhibit time")
                     .at_first(std::uint32_t{pdo.inhibit_100us})
                     .in("s", 1e-4F)
                     .stored(Storage::kSetting);
    rows[at++] = entry(index, 5, Type::kU16, "Event timer")
                     .at_first(std::uint32_t{pdo.event_ms})
                     .in("s", 1e-3F)
                     .stored(Storage::kSetting);
    rows[at++] = entry(index, 6, Type::kU8, "SYNC start value").within(0, 240).stored(Storage::kSetting);
  }
  for (std::uint8_t n = 0; n < kPdoCount; ++n) {
    detail::append_mapping(rows, at, static_cast<std::uint16_t>(0x1A00 + n), kTransmitPdos[n],
                           "TPDO mapping parameter");
  }
  return rows;
}();

}  // namespace slipstack::canopen
