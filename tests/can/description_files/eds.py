# SPDX-License-Identifier: Apache-2.0
"""Reads an electronic data sheet after the rules of CiA 306-1 and says what breaks them."""

import re

BITS = {1: 1, 2: 8, 3: 16, 4: 32, 5: 8, 6: 16, 7: 32, 8: 32, 9: None, 15: None}
SIGNED = {2, 3, 4}
ACCESS = {"ro", "wo", "rw", "rwr", "rww", "const"}
OBJECT_TYPES = {2, 7, 8, 9}  # DOMAIN, VAR, ARRAY, RECORD
FILE_INFO = ["FileName", "FileVersion", "FileRevision", "EDSVersion", "Description", "CreationTime", "CreationDate",
             "CreatedBy", "ModificationTime", "ModificationDate", "ModifiedBy"]
DEVICE_INFO = ["VendorName", "VendorNumber", "ProductName", "ProductNumber", "RevisionNumber", "OrderCode",
               "BaudRate_10", "BaudRate_20", "BaudRate_50", "BaudRate_125", "BaudRate_250", "BaudRate_500",
               "BaudRate_800", "BaudRate_1000", "SimpleBootUpMaster", "SimpleBootUpSlave", "Granularity",
               "DynamicChannelsSupported", "GroupMessaging", "NrOfRXPDO", "NrOfTXPDO", "LSS_Supported"]


class Eds:
    def __init__(self, text):
        self.problems = []
        self.sections = {}
        self.node = 1
        self._read(text)
        self._check_head()
        self.objects = {}
        self._check_lists()
        self._check_objects()

    def _bad(self, what):
        self.problems.append(what)

    def _read(self, text):
        section = None
        for number, line in enumerate(text.split("\n"), 1):
            if not line.isascii() or len(line) > 255:
                self._bad(f"line {number}: not ASCII, or longer than 255 characters")
            line = line.strip()
            if not line or line.startswith(";"):
                continue
            if line.startswith("["):
                name = line[1:-1]
                if not line.endswith("]") or not re.fullmatch(r"[0-9A-Za-z_]+", name) or name.upper() in self.sections:
                    self._bad(f"line {number}: section {line} malformed or twice")
                section = self.sections.setdefault(name.upper(), {})
                continue
            key, sign, value = line.partition("=")
            if not sign or section is None or key.upper() in section:
                self._bad(f"line {number}: {line}: no key=value of a section, or twice")
                continue
            section[key.upper()] = value

    def get(self, section, key):
        value = self.sections.get(section.upper(), {}).get(key.upper())
        if value is None:
            self._bad(f"[{section}] lacks {key}")
            return ""
        return value

    def number(self, text, what):
        offset = 0
        match = re.fullmatch(r"\$NODEID\s*\+\s*(.+)", text, re.I)
        if match:
            text, offset = match[1], self.node
        if not re.fullmatch(r"-?(0[xX][0-9A-Fa-f]+|0[0-7]*|[1-9]\d*)", text, re.A):
            self._bad(f"{what}: {text!r} is no number")
            return 0
        return int(text, 8 if re.fullmatch(r"-?0[0-7]+", text) else 0) + offset

    def _real(self, text, what):
        if re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", text, re.A):
            return float(text)
        self._bad(f"{what}: {text!r} is no number")
        return 0.0

    def _check_head(self):
        for key in FILE_INFO:
            self.get("FileInfo", key)
        for key in DEVICE_INFO:
            self.get("DeviceInfo", key)
        for key in ("CreationTime", "ModificationTime"):
            if not re.fullmatch(r"(0[1-9]|1[0-2]):[0-5]\d(AM|PM)", self.get("FileInfo", key)):
                self._bad(f"{key} is not hh:mm(AM|PM)")
        for key in ("CreationDate", "ModificationDate"):
            if not re.fullmatch(r"(0[1-9]|1[0-2])-([0-2]\d|3[01])-\d{4}", self.get("FileInfo", key)):
                self._bad(f"{key} is not mm-dd-yyyy")
        if self.get("FileInfo", "EDSVersion") != "4.0":
            self._bad("EDSVersion is not 4.0")

    def _check_lists(self):
        self.listed = []
        for title, allowed in (("MandatoryObjects", lambda i: i in (0x1000, 0x1001, 0x1018)),
                               ("OptionalObjects", lambda i: 0x1000 <= i < 0x2000 or 0x6000 <= i <= 0xFFFF),
                               ("ManufacturerObjects", lambda i: 0x2000 <= i < 0x6000)):
            count = self.number(self.get(title, "SupportedObjects"), title)
            if len(self.sections.get(title.upper(), {})) != count + 1:
                self._bad(f"[{title}]: SupportedObjects is not the number of its entries")
            for i in range(1, min(count, 0xFFFF) + 1):
                if str(i) not in self.sections.get(title.upper(), {}):
                    self._bad(f"[{title}] lacks {i}")
                    break
                index = self.number(self.get(title, str(i)), f"[{title}] {i}")
                if not allowed(index):
                    self._bad(f"[{title}]: {index:04X} does not belong there")
                self.listed.append(index)
        if len(set(self.listed)) != len(self.listed):
            self._bad("an object is listed twice")

    def _check_objects(self):
        described = {int(name, 16) for name in self.sections if re.fullmatch(r"[0-9A-F]{4}", name)}
        if described != set(self.listed):
            self._bad(f"listed and described objects differ: {described ^ set(self.listed)}")
        for index in sorted(described):
            name = f"{index:04X}"
            self._check_name(name)
            kind = self.number(self.get(name, "ObjectType"), name)
            if kind not in OBJECT_TYPES:
                self._bad(f"[{name}]: ObjectType {kind}")
                continue
            if kind in (8, 9):
                self._check_whole(index, name)
            else:
                self.objects[index, 0] = self._entry(name, kind)
        subs = {name for name in self.sections if re.fullmatch(r"[0-9A-F]{4}SUB[0-9A-F]{1,2}", name)}
        known = {f"{i:04X}SUB{s:X}" for i, s in self.objects}
        if subs - known:
            self._bad(f"sub-indices of no object: {sorted(subs - known)}")

    def _check_whole(self, index, name):
        found = sorted(int(s[7:], 16) for s in self.sections if re.fullmatch(name + "SUB[0-9A-F]{1,2}", s))
        if self.number(self.get(name, "SubNumber"), name) != len(found):
            self._bad(f"[{name}]: SubNumber is not the number of its sub-indices")
        if not found or found[0] != 0:
            self._bad(f"[{name}]: no sub-index 0")
            return
        names = set()
        for sub in found:
            section = f"{name}sub{sub:X}"
            self.objects[index, sub] = self._entry(section, self.number(self.get(section, "ObjectType"), section))
            names.add(self.sections[section.upper()].get("PARAMETERNAME"))
        if len(names) != len(found):
            self._bad(f"[{name}]: two sub-indices have the same name")
        highest = self.objects[index, 0]
        if highest["type"] != 5:
            self._bad(f"[{name}sub0] is no UNSIGNED8")
        if highest["access"] == "const" and highest["default"] != found[-1]:
            self._bad(f"[{name}sub0]: {highest['default']} is not the highest sub-index {found[-1]}")

    def _check_name(self, section):
        name = self.get(section, "ParameterName")
        if not 1 <= len(name) <= 241:
            self._bad(f"[{section}]: ParameterName of {len(name)} characters")

    def _entry(self, section, kind):
        self._check_name(section)
        data_type = self.number(self.get(section, "DataType"), section)
        access = self.get(section, "AccessType")
        # Missing means 0; a domain goes without, for a master that takes none there.
        domain = kind == 2 and "PDOMAPPING" not in self.sections[section.upper()]
        mapping = "0" if domain else self.get(section, "PDOMapping")
        if data_type not in BITS:
            self._bad(f"[{section}]: DataType {data_type}")
        if access not in ACCESS:
            self._bad(f"[{section}]: AccessType {access}")
        if kind == 2 and not domain:
            self._bad(f"[{section}]: PDOMapping of a domain")
        if mapping not in ("0", "1"):
            self._bad(f"[{section}]: PDOMapping {mapping}")
        if kind not in (2, 7):
            self._bad(f"[{section}]: ObjectType {kind} of one value")
        if (kind == 2) != (data_type == 15):
            self._bad(f"[{section}]: DOMAIN goes with DataType 0x000F")
        entry = {"type": data_type, "access": access, "mapped": mapping == "1", "default": None,
                 "name": self.get(section, "ParameterName")}
        own = self.sections[section.upper()]
        values = {}
        for key in ("DefaultValue", "LowLimit", "HighLimit"):
            text = own.get(key.upper(), "")
            if text and data_type not in (9, 15):
                values[key] = (self._real if data_type == 8 else self.number)(text, f"[{section}] {key}")
                if data_type != 8:
                    self._check_range(section, key, values[key], data_type)
        entry["default"] = values.get("DefaultValue")
        if ("LowLimit" in values) != ("HighLimit" in values):
            self._bad(f"[{section}]: one limit without the other")
        elif "LowLimit" in values and access not in ("ro", "const"):
            low, high = values["LowLimit"], values["HighLimit"]
            if not low <= high or (entry["default"] is not None and not low <= entry["default"] <= high):
                self._bad(f"[{section}]: default {entry['default']} is not within {low} to {high}")
        return entry

    def _check_range(self, section, key, value, data_type):
        bits = BITS.get(data_type)
        if bits is None:
            return
        low, high = (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if data_type in SIGNED else (0, (1 << bits) - 1)
        if not low <= value <= high:
            self._bad(f"[{section}]: {key} {value} does not fit its type")
