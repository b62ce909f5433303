# SPDX-License-Identifier: Apache-2.0
"""Writes the numbers of topics of an MCAP file, as ROS 2 and others record them, as a CSV table for `slipstack import`.

    python3 -m slipstack.mcap axis.mcap --topic /joint_states --out table.csv
    slipstack import table.csv --out log.csv --columns "time [s]=time_s,position[slide]=position_m,effort[slide]=force_N"

The table has a row for each message of the first topic; further topics add their fields, with their last values. Columns are named
as the fields: `wrench.force.x`, `data[0]`, and by joint where the message says names (`position[slide]`); those of further topics
begin with their topic. The time is that of the header, or of the recording where the messages have none. Messages of ROS 1 and
ROS 2 (with their definition, as rosbag2 writes it) and of JSON are read. Chunks compressed by lz4 or zstd need the packages python3-lz4 or
python3-zstandard. Status 2 and one line where the file cannot be used.

Source: "MCAP Format Specification" (mcap.dev/spec).
"""

import json
import struct
import sys
import zlib

from slipstack.ros_messages import Definition, Unreadable
from slipstack.tables import LONGEST_ARRAY, BadInput, chosen_topics, converted_topics, table_of_topics

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 0x02, 0x03, 0x04, 0x05, 0x06, 0x0F
LARGEST_RECORD = 1 << 30


class Record:
    """Takes the fields of a record, one after another."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        if count > len(self.data) - self.at:
            raise Unreadable("a record ends within a field")
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self, code):
        return struct.unpack("<" + code, self.take(struct.calcsize("<" + code)))[0]

    def text(self):
        return bytes(self.take(self.number("I"))).decode("utf-8", "replace")

    def rest(self):
        return self.data[self.at:]


def unpacked(compression, data, size):
    """The records of a chunk."""
    if size > LARGEST_RECORD:
        raise Unreadable("a chunk is larger than this program reads")
    if compression == "":
        return data
    try:
        if compression == "lz4":
            import lz4.frame
            return lz4.frame.decompress(data)
        if compression == "zstd":
            import zstandard
            return zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
    except ImportError as error:
        raise BadInput(f"chunks compressed by {compression} need the package "
                       f"{'python3-lz4' if compression == 'lz4' else 'python3-zstandard'} ({error})") from error
    except Exception as error:  # the libraries have errors of their own
        raise Unreadable(f"a chunk cannot be decompressed ({error})") from error
    raise Unreadable(f"a chunk is compressed by {compression}, which is not read")


def records_of_chunk(data):
    """(opcode, content) of each record of a chunk."""
    chunk = Record(data)
    chunk.take(16)  # times of its first and last message
    size, crc, compression = chunk.number("Q"), chunk.number("I"), chunk.text()
    records = Record(unpacked(compression, chunk.take(chunk.number("Q")), size))
    if len(records.data) != size or (crc != 0 and zlib.crc32(records.data) != crc):
        raise Unreadable("a chunk does not fit its checksum")
    while records.at < len(records.data):
        opcode = records.number("B")
        yield opcode, records.take(records.number("Q"))


def records(file):
    """(opcode, content) of each record of the data section, those in chunks included."""
    if file.read(len(MAGIC)) != MAGIC:
        raise BadInput("is no MCAP file")
    crc = zlib.crc32(MAGIC)
    while True:
        head = file.read(9)
        opcode, length = struct.unpack("<BQ", head) if len(head) == 9 else (FOOTER, None)
        if length is None or length > LARGEST_RECORD:
            raise Unreadable("it ends within its data" if length is None else "a record is larger than this program reads")
        data = file.read(length)
        if len(data) < length:
            raise Unreadable("it ends within its data")
        if opcode == DATA_END:
            expected = Record(data).number("I")
            if expected not in (0, crc):
                raise Unreadable("its data does not fit its checksum")
            return
        if opcode == FOOTER:
            return
        crc = zlib.crc32(data, zlib.crc32(head, crc))
        if opcode == CHUNK:
            yield from records_of_chunk(data)
        else:
            yield opcode, data


def numbers(message, path=""):
    """(name, value) of each number of a message, however deep; those of long arrays are left out."""
    names = message.get("name")
    for field, value in message.items():
        name = f"{path}{field}"
        if isinstance(value, (bool, int, float)):
            yield name, value
        elif isinstance(value, dict):
            if field != "header":
                yield from numbers(value, f"{name}.")
        elif isinstance(value, (list, tuple)) and len(value) <= LONGEST_ARRAY:
            by_name = isinstance(names, list) and len(names) == len(value)
            for i, one in enumerate(value):
                if isinstance(one, (bool, int, float)):
                    yield f"{name}[{names[i] if by_name else i}]", one
                elif isinstance(one, dict):
                    yield from numbers(one, f"{name}[{i}].")


def time_of(message, recorded_ns):
    """The instant of a message [ns]: of its header, or that at which it was recorded."""
    header = message.get("header")
    stamp = header.get("stamp") if isinstance(header, dict) else None
    if not isinstance(stamp, dict):
        return recorded_ns
    time_ns = stamp.get("sec", 0) * 10**9 + stamp.get("nanosec", stamp.get("nsec", 0))
    return time_ns or recorded_ns


def read_json(data):
    try:
        message = json.loads(bytes(data))
    except ValueError as error:
        raise Unreadable("is no JSON") from error
    return message if isinstance(message, dict) else {"value": message}


def reader_of(topic, encoding, schema):
    """What makes a dict of a message of this topic."""
    name, kind, text = schema
    if encoding == "json":
        return read_json
    if (encoding, kind) in (("cdr", "ros2msg"), ("ros1", "ros1msg")):
        try:
            return Definition(name, text, ros2=encoding == "cdr").read
        except Unreadable as error:
            raise BadInput(f"{topic}: {name}: {error}") from error
    raise BadInput(f"{topic}: its messages are {encoding or 'of no named encoding'}, defined by {kind or 'nothing'}; read are cdr by "
                   "ros2msg, ros1 by ros1msg, and json")


def topics_and_messages(file):
    """The readers of each topic, or why it cannot be read, and its messages in the order of their recording."""
    schemas, channels, topics, messages = {0: ("", "", "")}, {}, {}, []
    for opcode, data in records(file):
        record = Record(data)
        if opcode == SCHEMA:
            number, name, kind = record.number("H"), record.text(), record.text()
            schemas[number] = (name, kind, record.text())
        elif opcode == CHANNEL:
            number, schema, topic, encoding = record.number("H"), record.number("H"), record.text(), record.text()
            channels[number] = topic
            if schema not in schemas:
                raise Unreadable(f"the schema of {topic} is missing")
            topics[topic] = (encoding, schemas[schema])
        elif opcode == MESSAGE:
            number, _, logged_ns, _ = record.number("H"), record.number("I"), record.number("Q"), record.number("Q")
            if number not in channels:
                raise Unreadable("the channel of a message is missing")
            messages.append((logged_ns, channels[number], record.rest()))
    messages.sort(key=lambda one: one[0])  # chunks may overlap in time
    return topics, messages


def table(path, topics):
    """Head and rows: time, then the fields of the first topic, then those of the others."""
    try:
        with open(path, "rb") as file:
            there, recorded = topics_and_messages(file)
        topics = chosen_topics(path, topics, there)
        readers = {topic: reader_of(topic, *there[topic]) for topic in topics}

        def messages():
            for logged_ns, topic, data in recorded:
                if topic in readers:
                    try:
                        message = readers[topic](data)
                    except Unreadable as error:
                        raise Unreadable(f"a message of {topic} {error}") from error
                    yield topic, time_of(message, logged_ns), list(numbers(message))
        return table_of_topics(path, topics, messages())
    except Unreadable as error:
        raise BadInput(f"{path}: the MCAP file is damaged: {error}; copy it again, or repair it by `mcap recover`") from error
    except BadInput as error:
        raise error if str(error).startswith(str(path)) else BadInput(f"{path}: {error}") from error


def main(arguments=None):
    return converted_topics("slipstack.mcap", __doc__, "MCAP file", table, arguments)


if __name__ == "__main__":
    sys.exit(main())
