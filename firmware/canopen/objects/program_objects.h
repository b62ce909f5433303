// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "firmware/canopen/objects/object.h"

// Objects of the firmware update: 1F50h and its kin (CiA 302-3), and what a master wants to know beside them.
namespace slipstack::canopen {

inline constexpr std::uint16_t kProgramDataIndex = 0x1F50;
inline constexpr std::uint16_t kProgramControlIndex = 0x1F51;
inline constexpr std::uint16_t kProgramIdentityIndex = 0x1F56;
inline constexpr std::uint16_t kFlashStatusIndex = 0x1F57;
inline constexpr std::uint16_t kUpdateIndex = 0x2410;

inline constexpr auto kProgramRows = std::to_array<Object>({
    head(kProgramDataIndex, ObjectCode::kArray, "Program data", 1),
    entry(kProgramDataIndex, 1, Type::kDomain, "Program 1").write_only(),
    head(kProgramControlIndex, ObjectCode::kArray, "Program control", 1),
    entry(kProgramControlIndex, 1, Type::kU8, "Program 1 (0 stop, 1 start, 2 reset, 3 clear)")
        .within(0, 3)
        .from_device(),
    head(kProgramIdentityIndex, ObjectCode::kArray, "Program software identification", 1),
    entry(kProgramIdentityIndex, 1, Type::kU32, "CRC-32 of program 1").read_only().from_device(),
    head(kFlashStatusIndex, ObjectCode::kArray, "Flash status identification", 1),
    entry(kFlashStatusIndex, 1, Type::kU32, "Status of program 1").read_only().from_device(),
});

inline constexpr auto kUpdateRows = std::to_array<Object>({
    head(kUpdateIndex, ObjectCode::kRecord, "Firmware update", 9),
    entry(kUpdateIndex, 1, Type::kU8, "Slot that runs (1, 2)").read_only().from_device(),
    entry(kUpdateIndex, 2, Type::kU8,
          "Running program (0 not installed, 1 on trial, 2 confirmed, 3 given up)")
        .read_only()
        .from_device(),
    entry(kUpdateIndex, 3, Type::kU8, "Program in the spare slot (as sub 2)").read_only().from_device(),
    entry(kUpdateIndex, 4, Type::kU32, "CRC-32 of the program in the spare slot").read_only().from_device(),
    entry(kUpdateIndex, 5, Type::kU32, "Address of the spare slot").read_only().from_device(),
    entry(kUpdateIndex, 6, Type::kU32, "Board").read_only().from_device(),
    entry(kUpdateIndex, 7, Type::kU32, "Bytes of the program taken").read_only().from_device(),
    entry(kUpdateIndex, 8, Type::kU32, "CRC-32 of the program that is being taken").read_only().from_device(),
    entry(kUpdateIndex, 9, Type::kU8, "Why the last update was refused").read_only().from_device(),
});

}  // namespace slipstack::canopen
