# SPDX-License-Identifier: Apache-2.0
"""Reads messages of ROS by the text of their definition, as a recording carries it: ROS 1 serialisation, and CDR of ROS 2.

Sources: "ROS msg" (wiki.ros.org/msg), "About interfaces" (docs.ros.org), and CDR of the DDSI-RTPS specification 2.3, chapter 10
(OMG formal/2019-04-03): numbers are aligned to their size, counted from behind the encapsulation header.
"""

import re
import struct

NUMBERS = {"bool": "?", "byte": "b", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i",
           "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d"}
ROS2_NUMBERS = {**NUMBERS, "byte": "B"}
STAMPS = {"time": ("I", "I"), "duration": ("i", "i")}  # of ROS 1: seconds and nanoseconds
# What the text of a definition may leave out.
KNOWN = {"builtin_interfaces/Time": "int32 sec\nuint32 nanosec", "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec"}
FIELD = re.compile(r"(?P<type>[\w/]+)(?:<=\d+)?(?P<array>\[(?:<=)?\d*\])?\s+(?P<name>\w+)\s*(?P<rest>.*)$")
DEEPEST = 16  # structures in structures


class Unreadable(Exception):
    """Why a definition or a message cannot be read."""


def without_msg(name):
    """pkg/msg/Name is pkg/Name."""
    return name.replace("/msg/", "/")


def definitions(name, text):
    """The lines of each message type of a definition, the types below it included."""
    found, current, lines = {}, without_msg(name), []
    for line in text.splitlines():
        if line.startswith("=" * 20):
            continue
        if line.startswith("MSG: "):
            found[current], current, lines = lines, without_msg(line[5:].strip()), []
            continue
        lines.append(line.split("#")[0].strip())
    found[current] = lines
    return found


class Cursor:
    """Takes values from the bytes of a message; `align`: CDR."""

    def __init__(self, data, begin, order, align):
        self.data, self.at, self.begin, self.order, self.align = data, begin, begin, order, align

    def numbers(self, code, count):
        size = struct.calcsize(code)
        if self.align and count > 0:
            self.at += (self.begin - self.at) % size
        if count * size > len(self.data) - self.at:
            raise Unreadable("ends within a field")
        values = struct.unpack_from(f"{self.order}{count}{code}", self.data, self.at)
        self.at += count * size
        return values

    def count(self):
        return self.numbers("I", 1)[0]

    def structures(self, read, count):
        if count > len(self.data) - self.at:  # each takes a byte at least
            raise Unreadable("ends within an array")
        return [read(self) for _ in range(count)]

    def text(self):
        length = self.count()
        if length > len(self.data) - self.at:
            raise Unreadable("ends within a text")
        text = self.data[self.at:self.at + length]
        self.at += length
        return text.rstrip(b"\0").decode("utf-8", "replace")


class Definition:
    """A message type: read() makes a dict of a message, nested as its fields are."""

    def __init__(self, name, text, ros2):
        self.ros2 = ros2
        self.types = {**{key: value.splitlines() for key, value in KNOWN.items()}, **definitions(name, text)}
        self.fields = self.compiled(without_msg(name), 0)

    def resolved(self, word, package):
        word = without_msg(word)
        for full in (word, f"{package}/{word}", f"std_msgs/{word}"):
            if full in self.types:
                return full
        raise Unreadable(f"its definition lacks the type {word}")

    def compiled(self, name, depth):
        """(field, reader of one value, code of a number or None, array: None, -1 for any length, or its length) of each field."""
        if depth > DEEPEST:
            raise Unreadable("its definition has no end")
        package, numbers, fields = name.rpartition("/")[0], ROS2_NUMBERS if self.ros2 else NUMBERS, []
        for line in self.types[name]:
            match = FIELD.match(line)
            if not match or match["rest"].startswith("="):  # a constant, a blank line
                continue
            word, array = match["type"], match["array"]
            length = None if array is None else -1 if array == "[]" or "<" in array else int(array[1:-1])
            code, read = numbers.get(word), None
            if code is not None:
                pass
            elif word == "string":
                read = Cursor.text
            elif not self.ros2 and word in STAMPS:
                read = self.stamp_reader(*STAMPS[word])
            elif word == "wstring":
                raise Unreadable("its definition has wide text, which is not read")
            else:
                read = self.structure_reader(self.compiled(self.resolved(word, package), depth + 1))
            fields.append((match["name"], read, code, length))
        if not fields and self.ros2:  # an empty structure is one byte in ROS 2
            fields.append(("", None, "B", None))
        return fields

    @staticmethod
    def stamp_reader(seconds, nanoseconds):
        return lambda cursor: {"sec": cursor.numbers(seconds, 1)[0], "nanosec": cursor.numbers(nanoseconds, 1)[0]}

    @staticmethod
    def structure_reader(fields):
        def read(cursor):
            values = {}
            for name, one, code, length in fields:
                if not name:
                    cursor.numbers(code, 1)
                elif length is None:
                    values[name] = cursor.numbers(code, 1)[0] if code else one(cursor)
                elif code:
                    values[name] = cursor.numbers(code, cursor.count() if length < 0 else length)
                else:
                    values[name] = cursor.structures(one, cursor.count() if length < 0 else length)
            return values
        return read

    def read(self, data):
        """The values of one message. Throws Unreadable."""
        if not self.ros2:
            return self.structure_reader(self.fields)(Cursor(data, 0, "<", False))
        if len(data) < 4 or data[0] != 0 or data[1] > 1:
            raise Unreadable("is no plain CDR")
        return self.structure_reader(self.fields)(Cursor(data, 4, "><"[data[1]], True))
