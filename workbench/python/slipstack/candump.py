# SPDX-License-Identifier: Apache-2.0
"""Decodes the PDOs of a CANopen node in a capture of candump by its EDS, into a CSV table for `slipstack import`.

    python3 -m slipstack.candump can.log --eds drive.eds --node 5 --out table.csv
    slipstack import table.csv --out log.csv --columns "time [s]=time_s,...=position_counts,...=current_A*0.01"

What candump -L, -l or -t a|z prints is read. Which objects a PDO carries is taken from the EDS, and from the SDOs of the capture,
which read or change it. The table has a row for each frame of one PDO (--pdo; default: that with the object of --clock, or the
most frames); further --pdo add the objects of others, with their last values. Status 2 and one line where the capture or the EDS cannot be used.
"""

import argparse
import collections
import configparser
import pathlib
import re
import struct
import sys

from slipstack.tables import BadInput, converted

# CiA 301: the data types of numbers, by code: letter of struct and bytes.
TYPES = {0x01: ("?", 1), 0x02: ("b", 1), 0x03: ("h", 2), 0x04: ("i", 4), 0x05: ("B", 1), 0x06: ("H", 2), 0x07: ("I", 4),
         0x08: ("f", 4), 0x11: ("d", 8), 0x15: ("q", 8), 0x1B: ("Q", 8)}
TPDOS = range(0x1800, 0x1804)  # those with an identifier of their own by default
MAPPING_OFFSET = 0x200         # 1A00h is the mapping of 1800h
INVALID_PDO = 1 << 31
COB_MASK = 0x7FF
SDO_TO_NODE, SDO_FROM_NODE = 0x600, 0x580
# Expedited transfers: command byte to number of bytes.
SIZES = {0x2F: 1, 0x2B: 2, 0x27: 3, 0x23: 4, 0x4F: 1, 0x4B: 2, 0x47: 3, 0x43: 4}


def frames(path):
    """(time_s, identifier, data) of each data frame with an 11-bit identifier."""
    compact = re.compile(r"\((\d+\.\d+)\)\s+\S+\s+([0-9A-Fa-f]{3})#([0-9A-Fa-f]*)\s*(?:[RT])?\s*$")
    spaced = re.compile(r"\s*\((\d+\.\d+)\)\s+\S+\s+(?:[RT]X\s+\S+\s+)?([0-9A-Fa-f]{3})\s+\[\d\]\s*((?:[0-9A-Fa-f]{2}\s*)*)$")
    any_line = False
    try:
        text = pathlib.Path(path).read_text(encoding="ascii", errors="replace")
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}") from error
    for line in text.splitlines():
        match = compact.match(line) or spaced.match(line)
        if match:
            any_line = True
            yield float(match.group(1)), int(match.group(2), 16), bytes.fromhex(match.group(3))
    if not any_line:
        raise BadInput(f"{path}: no line is one of candump with a time stamp; capture with candump -L")


class Node:
    """What the EDS says of a node, and what the SDOs of the capture have said since."""

    def __init__(self, eds, node):
        self.node = node
        self.eds = configparser.ConfigParser(interpolation=None, strict=False)
        try:
            if not self.eds.read(eds, encoding="latin-1"):
                raise BadInput(f"{eds}: cannot be read; name the EDS of the drive")
        except configparser.Error as error:
            raise BadInput(f"{eds}: is no EDS: {str(error).splitlines()[0]}") from error
        self.sections = {name.lower(): name for name in self.eds.sections()}
        self.values = {}

    def section(self, index, sub):
        for name in ([f"{index:x}sub{sub:x}", f"{index:x}"] if sub == 0 else [f"{index:x}sub{sub:x}"]):
            if name in self.sections:
                return self.eds[self.sections[name]]
        return None

    def value(self, index, sub):
        if (index, sub) in self.values:
            return self.values[index, sub]
        section = self.section(index, sub)
        text = section.get("DefaultValue", "0") if section is not None else "0"
        terms = text.replace(" ", "").upper().split("+")
        return sum(self.node if term == "$NODEID" else int(term or "0", 0) for term in terms)

    def take_sdo(self, identifier, data):
        """Remembers what a transfer says of the PDOs."""
        if identifier not in (SDO_TO_NODE + self.node, SDO_FROM_NODE + self.node) or len(data) < 8 or data[0] not in SIZES:
            return
        index, sub = struct.unpack_from("<HB", data, 1)
        if TPDOS.start <= index < TPDOS.stop + MAPPING_OFFSET:
            self.values[index, sub] = int.from_bytes(data[4:4 + SIZES[data[0]]], "little")

    def pdo_of(self, identifier):
        """The number of the transmit PDO with this identifier, from 1 on; None: it is of none."""
        for index in TPDOS:
            cob = self.value(index, 1)
            if not cob & INVALID_PDO and cob & COB_MASK == identifier:
                return index - TPDOS.start + 1
        return None

    def decode(self, pdo, data):
        """{(index, sub): value} of a frame."""
        mapping = TPDOS.start + MAPPING_OFFSET + pdo - 1
        found, at = {}, 0
        for place in range(1, self.value(mapping, 0) + 1):
            entry = self.value(mapping, place)
            index, sub, bits = entry >> 16, entry >> 8 & 0xFF, entry & 0xFF
            section = self.section(index, sub)
            code = int(section.get("DataType", "0"), 0) if section is not None else 0
            if bits % 8 or at + bits // 8 > len(data):
                return {}
            part = data[at:at + bits // 8]
            at += bits // 8
            letter, size = TYPES.get(code, ("", 0))
            if size == len(part):
                found[index, sub] = struct.unpack("<" + letter, part)[0]
        return found

    def name(self, index, sub):
        section = self.section(index, sub)
        title = section.get("ParameterName", "object") if section is not None else "object"
        return f"{title} {index:04X}:{sub:02X}".replace(",", " ")


def decoded(path, node):
    """[(time_s, pdo, {object: value})] in the order of the capture."""
    rows = []
    for time_s, identifier, data in frames(path):
        node.take_sdo(identifier, data)
        pdo = node.pdo_of(identifier)
        values = node.decode(pdo, data) if pdo else {}
        if values:
            rows.append((time_s, pdo, values))
    if not rows:
        raise BadInput(f"{path}: no frame is a transmit PDO of node {node.node} by this EDS; check --node")
    return rows


def unwrapped(ticks, bits):
    """A counter of so many bits that wraps, from 0 on."""
    total, out = 0, []
    for before, now in zip([ticks[0], *ticks], ticks):
        total += (now - before) % (1 << bits)
        out.append(total)
    return out


def table(rows, node, pdos=None, clock=None):
    """Head and rows of the table. `pdos`: the first makes the rows. `clock`: an object that counts, and the seconds of one
    count."""
    frames_of = collections.Counter(number for _, number, _ in rows)
    with_clock = [number for _, number, values in rows if clock is not None and clock[0] in values]
    pdos = pdos or with_clock[:1] or [frames_of.most_common(1)[0][0]]
    for pdo in pdos:
        if not frames_of[pdo]:
            raise BadInput(f"--pdo {pdo}: has no frame in the capture; there are "
                           + ", ".join(f"{number} ({count} frames)" for number, count in sorted(frames_of.items())))
    objects = sorted({key for _, number, values in rows if number in pdos for key in values})
    last, out = {}, []
    start_s = None
    for time_s, number, values in rows:
        if number in pdos:
            last.update(values)
        if number != pdos[0] or len(last) < len(objects):
            continue
        start_s = time_s if start_s is None else start_s
        out.append([time_s - start_s, *(last[key] for key in objects)])
    if not out:
        raise BadInput(f"no frame of PDO {pdos[0]} comes after a frame of each of the others; leave one out of --pdo")
    if clock is not None:
        key, step_s = clock
        if key not in objects:
            raise BadInput(f"--clock: {key[0]:04X}:{key[1]:02X} is not in the table; there are "
                           + ", ".join(f"{index:04X}:{sub:02X}" for index, sub in objects))
        column = 1 + objects.index(key)
        bits = 8 * TYPES[int(node.section(*key)["DataType"], 0)][1]
        for row, tick in zip(out, unwrapped([row[column] for row in out], bits)):
            row[0] = tick * step_s
    return ["time [s]", *(node.name(*key) for key in objects)], out


def clock_of(text):
    match = re.fullmatch(r"([0-9A-Fa-f]{4}):([0-9A-Fa-f]{1,2})=([0-9.eE+-]+)", text)
    if not match:
        raise argparse.ArgumentTypeError("INDEX:SUB=SECONDS, as 2210:05=1e-4")
    try:
        return (int(match.group(1), 16), int(match.group(2), 16)), float(match.group(3))
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="slipstack.candump", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("capture", help="what candump -L or candump -l wrote")
    parser.add_argument("--eds", required=True, help="electronic data sheet of the node")
    parser.add_argument("--node", type=int, default=5, help="node id (default: 5)")
    parser.add_argument("--pdo", type=int, action="append",
                        help="transmit PDO that makes the rows (default: that of --clock, or with the most frames); may be repeated")
    parser.add_argument("--clock", type=clock_of, metavar="INDEX:SUB=SECONDS",
                        help="an object that counts, and the time of one count: the time of the samples, free of the bus's delays")
    parser.add_argument("--out", required=True, help="table to write, CSV; '-': standard output")
    options = parser.parse_args(arguments)

    def read():
        node = Node(options.eds, options.node)
        return table(decoded(options.capture, node), node, options.pdo, options.clock)

    return converted(parser.prog, options.out, read, decimals=6)


if __name__ == "__main__":
    sys.exit(main())
