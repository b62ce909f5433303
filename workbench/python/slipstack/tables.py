# SPDX-License-Identifier: Apache-2.0
"""What the converters of this package have in common: the table for `slipstack import`, and their one line on a fault."""

import argparse
import contextlib
import csv
import sys


LONGEST_ARRAY = 64  # an image or a point cloud is no signal


class BadInput(Exception):
    """What is wrong with the input, in one line."""


def chosen_topics(path, wanted, there):
    """The topics of a recording that make the table: those wanted, or the only one that is there."""
    there = sorted(there)
    wanted = wanted or (there if len(there) == 1 else [])
    if not wanted:
        raise BadInput(f"{path}: say --topic; there are {', '.join(there) or 'none'}")
    for topic in wanted:
        if topic not in there:
            raise BadInput(f"{path}: has no topic {topic}; there are {', '.join(there) or 'none'}")
    return wanted


def table_of_topics(path, topics, messages):
    """Head and rows of the messages, each a topic, its time [ns] and its (name, value) pairs: a row for each message of the first
    topic, with the last values of the others. The time of the rows is in s from the first one."""
    columns, last, rows = {topic: [] for topic in topics}, {}, []
    for topic, time_ns, values in messages:
        names = [name for name, _ in values]
        columns[topic] = columns[topic] or names
        if names != columns[topic]:
            raise BadInput(f"{path}: the messages of {topic} change their fields after {len(rows)} rows; "
                           "write one topic of messages alike")
        last[topic] = [int(value) if isinstance(value, bool) else value for _, value in values]
        if topic == topics[0] and len(last) == len(topics):
            rows.append([time_ns, *(value for one in topics for value in last[one])])
    if not rows or not any(columns.values()):
        raise BadInput(f"{path}: no message of {', '.join(topics)} has numbers")
    head = [f"{topic} {name}" if topic != topics[0] else name for topic in topics for name in columns[topic]]
    begin_ns = rows[0][0]
    return ["time [s]", *head], [[(time_ns - begin_ns) * 1e-9, *values] for time_ns, *values in rows]


def converted(program, out, read, decimals):
    """Status of a converter: writes what read() returns, a head and rows that begin with a time [s], as CSV to a file or, as
    '-', to standard output. 2 and one line where read() raises BadInput or a file cannot be used."""
    try:
        head, rows = read()
        with contextlib.nullcontext(sys.stdout) if out == "-" else open(out, "w", newline="", encoding="utf-8") as target:
            writer = csv.writer(target, lineterminator="\n")
            writer.writerow(head)
            writer.writerows([f"{row[0]:.{decimals}f}", *row[1:]] for row in rows)
    except (BadInput, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 2
    return 0


def converted_topics(program, doc, recording, table, arguments):
    """Status of the command that writes topics of a recording: `recording` is the kind of its file, table(path, topics) its head
    and rows, with time stamps in ns."""
    parser = argparse.ArgumentParser(prog=program, description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", help=recording)
    parser.add_argument("--topic", action="append",
                        help="topic whose messages make the rows (default: the only one); may be repeated")
    parser.add_argument("--out", required=True, help="table to write, CSV; '-': standard output")
    options = parser.parse_args(arguments)
    return converted(program, options.out, lambda: table(options.file, options.topic), decimals=9)
