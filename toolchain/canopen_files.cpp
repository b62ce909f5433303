// SPDX-License-Identifier: Apache-2.0
// Writes what describes the controller on CAN, from the table that it serves: EDS (CiA 306), DBC of the
// default PDOs, the reference page, and which object belongs to which effect.
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "firmware/canopen/objects/object_table.h"

namespace {

using namespace slipstack::canopen;

/// The sub-indices of one index.
struct Whole {
  const Object* first;
  std::vector<const Object*> rows;
};

std::vector<Whole> objects() {
  std::vector<Whole> all;
  for (const Object& row : kObjects) {
    if (all.empty() || all.back().first->index != row.index) all.push_back({&row, {}});
    all.back().rows.push_back(&row);
  }
  return all;
}

bool simple(const Whole& object) {
  return object.rows.size() == 1 &&
         (object.first->code == ObjectCode::kVariable || object.first->code == ObjectCode::kDomain);
}

std::string object_name(const Object& row) {
  return row.number > 0 && row.sub == 0 ? fmt::format("{} {}", row.object, row.number)
                                        : std::string(row.object);
}

/// Unique within the object: rows of the same name are numbered.
std::string name_of(const Whole& object, const Object& row) {
  if (row.sub == 0) return simple(object) ? std::string(row.object) : std::string(row.name);
  bool repeated = false;
  for (const Object* other : object.rows) repeated |= other != &row && std::string(other->name) == row.name;
  if (row.number > 0) return fmt::format("{} {}", row.name, row.number);
  return repeated ? fmt::format("{} {}", row.name, row.sub) : std::string(row.name);
}

std::string number_text(const Object& row, std::uint32_t value) {
  switch (row.type) {
    case Type::kReal32:
      return fmt::format("{}", std::bit_cast<float>(value));
    case Type::kI8:
    case Type::kI16:
    case Type::kI32:
      return fmt::format("{}", static_cast<std::int32_t>(value));
    case Type::kU32:
      return fmt::format("0x{:08X}", value);
    default:
      return fmt::format("{}", value);
  }
}

std::string default_text(const Object& row) {
  if (row.type == Type::kString) return row.text;
  if (row.type == Type::kDomain) return "";
  if (row.plus_node) return fmt::format("$NODEID+0x{:X}", row.initial);
  return number_text(row, row.initial);
}

const char* access_text(const Object& row) {
  switch (row.access) {
    case Access::kConstant:
      return "const";
    case Access::kRead:
      return "ro";
    case Access::kWrite:
      return "wo";
    default:
      return row.mapping == Mapping::kReceive ? "rww" : "rw";
  }
}

bool bounded(const Object& row) {
  const Object widest = entry(row.index, row.sub, row.type, "");
  return row.type != Type::kString && row.type != Type::kDomain && row.type != Type::kBoolean &&
         (row.low != widest.low || row.high != widest.high) && row.writable();
}

std::string eds_fields(const Object& row, const std::string& name) {
  const int code = row.type == Type::kDomain ? 2 : 7;
  std::string text = fmt::format("ParameterName={}\nObjectType=0x{:X}\nDataType=0x{:04X}\nAccessType={}\n",
                                 name, code, static_cast<int>(row.type), access_text(row));
  text += fmt::format("DefaultValue={}\n", default_text(row));
  if (bounded(row)) {
    text += fmt::format("LowLimit={}\nHighLimit={}\n", number_text(row, row.low), number_text(row, row.high));
  }
  // Missing means 0 (CiA 306); a master that takes none at a domain refuses the whole file for it (npm:
  // canopen).
  if (row.type != Type::kDomain)
    text += fmt::format("PDOMapping={}\n", row.mapping == Mapping::kNone ? 0 : 1);
  return text;
}

std::string eds_lists(const std::vector<Whole>& all) {
  std::vector<std::uint16_t> mandatory, optional, manufacturer;
  for (const Whole& object : all) {
    const std::uint16_t index = object.first->index;
    const bool needed = index == 0x1000 || index == 0x1001 || index == 0x1018;
    (needed ? mandatory : index >= 0x2000 && index < 0x6000 ? manufacturer : optional).push_back(index);
  }
  std::string text;
  for (const auto& [title, list] :
       {std::pair{"MandatoryObjects", &mandatory}, std::pair{"OptionalObjects", &optional},
        std::pair{"ManufacturerObjects", &manufacturer}}) {
    text += fmt::format("[{}]\nSupportedObjects={}\n", title, list->size());
    int number = 0;
    for (const std::uint16_t index : *list) text += fmt::format("{}=0x{:04X}\n", ++number, index);
    text += "\n";
  }
  return text;
}

std::string eds() {
  const std::vector<Whole> all = objects();
  std::string text = fmt::format(
      "[FileInfo]\nFileName=slipstack.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\nDescription="
      "slipstack "
      "drive with friction "
      "compensation\nCreationTime=12:00AM\nCreationDate=01-01-2026\nCreatedBy=canopen-files\n"
      "ModificationTime=12:00AM\nModificationDate=01-01-2026\nModifiedBy=canopen-files\n\n"
      "[DeviceInfo]\nVendorName=slipstack\nVendorNumber=0x{:08X}\nProductName=slipstack "
      "drive\nProductNumber=0x{:08X}\n"
      "RevisionNumber=0x{:08X}\nOrderCode=slipstack\nBaudRate_10=1\nBaudRate_20=1\nBaudRate_50=1\nBaudRate_"
      "125=1\n"
      "BaudRate_250=1\nBaudRate_500=1\nBaudRate_800=1\nBaudRate_1000=1\nSimpleBootUpMaster="
      "0\nSimpleBootUpSlave=1\n"
      "Granularity=8\nDynamicChannelsSupported=0\nGroupMessaging=0\nNrOfRXPDO={}\nNrOfTXPDO={}\nLSS_"
      "Supported=1\n\n",
      kVendorId, kProductCode, kRevision, kPdoCount, kPdoCount);
  text += "[DummyUsage]\n";
  for (int type = 1; type <= 7; ++type) text += fmt::format("Dummy{:04X}=1\n", type);
  text +=
      "\n[Comments]\nLines=2\nLine1=Written from the object table of the firmware; do not edit.\n"
      "Line2=Position in encoder counts, velocity in counts per second, force in thousandths of 6076h.\n\n";
  text += eds_lists(all);
  for (const Whole& object : all) {
    const Object& first = *object.first;
    if (simple(object)) {
      text += fmt::format("[{:04X}]\n{}\n", first.index, eds_fields(first, object_name(first)));
      continue;
    }
    text += fmt::format("[{:04X}]\nParameterName={}\nObjectType=0x{:X}\nSubNumber={}\n\n", first.index,
                        object_name(first), static_cast<int>(first.code), object.rows.size());
    for (const Object* row : object.rows) {
      text +=
          fmt::format("[{:04X}sub{:X}]\n{}\n", row->index, row->sub, eds_fields(*row, name_of(object, *row)));
    }
  }
  return text;
}

std::string signal_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      name += c;
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

/// DBC of the default PDOs for node 1; other nodes: the identifier is larger by node - 1.
std::string dbc() {
  const std::vector<Whole> all = objects();
  std::string text = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: Master Drive\n\n";
  std::string types;
  for (const bool receive : {true, false}) {
    for (int n = 0; n < kPdoCount; ++n) {
      const auto at = static_cast<std::size_t>(n);
      const DefaultPdo& pdo = receive ? kReceivePdos[at] : kTransmitPdos[at];
      if (pdo.count == 0) continue;
      int bytes = 0;
      for (int i = 0; i < pdo.count; ++i)
        bytes += static_cast<int>(pdo.mapped[static_cast<std::size_t>(i)] & 0xFF) / 8;
      const std::uint32_t id = (pdo.cob & 0x7FF) + 1;
      text += fmt::format("BO_ {} {}PDO{}: {} {}\n", id, receive ? 'R' : 'T', n + 1, bytes,
                          receive ? "Master" : "Drive");
      int bit = 0;
      for (int i = 0; i < pdo.count; ++i) {
        const std::uint32_t mapped = pdo.mapped[static_cast<std::size_t>(i)];
        const Object& row = kObjects[find_row(static_cast<std::uint16_t>(mapped >> 16),
                                              static_cast<std::uint8_t>(mapped >> 8))];
        const Whole* whole = nullptr;
        for (const Whole& object : all) whole = object.first->index == row.index ? &object : whole;
        const std::string name = signal_name(name_of(*whole, row));
        const int bits = static_cast<int>(mapped & 0xFF);
        const bool is_signed = row.type == Type::kI8 || row.type == Type::kI16 || row.type == Type::kI32 ||
                               row.type == Type::kReal32;
        text += fmt::format(" SG_ {} : {}|{}@1{} ({},0) [0|0] \"{}\" {}\n", name, bit, bits,
                            is_signed ? '-' : '+', row.scale, row.unit, receive ? "Drive" : "Master");
        if (row.type == Type::kReal32) types += fmt::format("SIG_VALTYPE_ {} {} : 1;\n", id, name);
        bit += bits;
      }
      text += "\n";
    }
  }
  return text + types;
}

const char* type_name(Type type) {
  switch (type) {
    case Type::kBoolean:
      return "BOOLEAN";
    case Type::kI8:
      return "INTEGER8";
    case Type::kI16:
      return "INTEGER16";
    case Type::kI32:
      return "INTEGER32";
    case Type::kU8:
      return "UNSIGNED8";
    case Type::kU16:
      return "UNSIGNED16";
    case Type::kU32:
      return "UNSIGNED32";
    case Type::kReal32:
      return "REAL32";
    case Type::kString:
      return "VISIBLE_STRING";
    default:
      return "DOMAIN";
  }
}

std::string page() {
  std::string text =
      "# Object dictionary\n\nWritten by `canopen-files` from `firmware/canopen/objects/object_table.h`; do "
      "not edit. What the objects do: [can.md](can.md).\n\nPDO: T may be sent, R and T both ways. Stored: P "
      "parameter (locked "
      "while the "
      "drive is enabled), S setting.\n";
  const std::array<std::pair<std::uint32_t, const char*>, 3> parts = {
      {{0x1000, "Communication (CiA 301)"},
       {0x2000, "Axis, friction, trace, lock"},
       {0x6000, "Drive profile (CiA 402)"}}};
  std::size_t part = 0;
  for (const Whole& object : objects()) {
    if (part < parts.size() && object.first->index >= parts[part].first) {
      text += fmt::format(
          "\n## {}\n\n| object | name | type | access | PDO | stored | default | bounds | unit "
          "|\n|---|---|---|---|---|---|---|---|---|\n",
          parts[part++].second);
    }
    for (const Object* row : object.rows) {
      const std::string place = simple(object) ? fmt::format("{:04X}h", row->index)
                                               : fmt::format("{:04X}h:{:02X}", row->index, row->sub);
      std::string name = simple(object) ? object_name(*row) : name_of(object, *row);
      if (row->sub == 0 && !simple(object)) name = fmt::format("**{}**", object_name(*row));
      const bool has_number = row->type != Type::kDomain && row->type != Type::kString;
      const std::string unit =
          row->scale == 1.0F ? std::string(row->unit) : fmt::format("{} {}", row->scale, row->unit);
      text += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", place, name,
                          type_name(row->type), access_text(*row),
                          row->mapping == Mapping::kNone       ? ""
                          : row->mapping == Mapping::kTransmit ? "T"
                                                               : "R, T",
                          row->storage == Storage::kVolatile    ? ""
                          : row->storage == Storage::kParameter ? "P"
                                                                : "S",
                          row->live && row->access == Access::kRead ? "" : default_text(*row),
                          has_number && bounded(*row) ? fmt::format("{} … {}", number_text(*row, row->low),
                                                                    number_text(*row, row->high))
                                                      : "",
                          unit);
    }
  }
  return text;
}

template <class... Effects>
std::string effect_places(const std::tuple<Effects...>*) {
  std::string text =
      "# The place of an effect is its object, and goes into the hash of a model: it is kept, and a new "
      "effect\n"
      "# comes last. Written by canopen-files from firmware/effects/catalogue.h; do not "
      "edit.\nobject,effect\n";
  std::uint16_t index = kEffectIndex;
  ((text += fmt::format("{:04X}h,{}\n", index++, Effects::text.id)), ...);
  return text;
}

std::string text_in(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "canopen-files: give the folder to write to, as `canopen-files docs`\n");
    return 2;
  }
  const std::string places = effect_places(slipstack::canopen::detail::kCatalogue);
  const std::string places_path = fmt::format("{}/effect-objects.csv", argv[1]);
  if (!places.starts_with(text_in(places_path))) {
    fmt::print(
        stderr,
        "canopen-files: {}: an effect has left its place; controllers and model files in the field know "
        "it by that, so add new effects at the end of the catalogue\n",
        places_path);
    return 2;
  }
  for (const auto& [name, text] :
       {std::pair{"slipstack.eds", eds()}, std::pair{"slipstack.dbc", dbc()},
        std::pair{"object-dictionary.md", page()}, std::pair{"effect-objects.csv", places}}) {
    const std::string path = fmt::format("{}/{}", argv[1], name);
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file) {
      fmt::print(stderr, "canopen-files: {}: cannot be written\n", path);
      return 2;
    }
  }
  return 0;
}
