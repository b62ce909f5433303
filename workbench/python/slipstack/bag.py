# SPDX-License-Identifier: Apache-2.0
"""Writes the numbers of topics of a ROS 1 bag as a CSV table for `slipstack import`.

    python3 -m slipstack.bag axis.bag --topic /joint_states --out table.csv
    slipstack import table.csv --out log.csv --columns "time [s]=time_s,position[slide]=position_m,effort[slide]=force_N"

The table has a row for each message of the first topic; further topics add their fields, with their last values. Columns are named
as the fields: `wrench.force.x`, `data[0]`, and by joint where the message says names (`position[slide]`); those of further topics
begin with their topic. The time is that of the header, or of the recording where the messages have none. Needs the package
python3-rosbag. Status 2 and one line where the bag cannot be used.
"""

import pathlib
import sys

from slipstack.tables import LONGEST_ARRAY, BadInput, chosen_topics, converted_topics, table_of_topics

NUMBERS = (bool, int, float)


def numbers(message, path=""):
    """(name, value) of each number of a message, however deep; those of long arrays are left out."""
    names = getattr(message, "name", None)
    for field in message.__slots__:
        value, name = getattr(message, field), f"{path}{field}"
        if isinstance(value, NUMBERS):
            yield name, value
        elif hasattr(value, "to_sec"):
            yield name, value.to_sec()
        elif isinstance(value, (list, tuple)):
            by_name = isinstance(names, list) and len(names) == len(value)
            for i, one in enumerate(value[:LONGEST_ARRAY] if len(value) <= LONGEST_ARRAY else ()):
                if isinstance(one, NUMBERS):
                    yield f"{name}[{names[i] if by_name else i}]", one
        elif hasattr(value, "__slots__") and field != "header":
            yield from numbers(value, f"{name}.")


def time_of(message, recorded):
    """The instant of a message [ns]: of its header, or that at which it was recorded."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return (stamp if stamp is not None and stamp.to_nsec() != 0 else recorded).to_nsec()


def opened(path):
    try:
        import rosbag
    except ImportError as error:
        raise BadInput(f"needs the package python3-rosbag ({error})") from error
    if not pathlib.Path(path).is_file():
        raise BadInput(f"{path}: is no file; name a bag")
    try:
        return rosbag.Bag(path)
    except rosbag.bag.ROSBagUnindexedException as error:
        raise BadInput(f"{path}: has no index, its recording was cut off; repair it by `rosbag reindex`") from error
    except (rosbag.bag.ROSBagException, OSError) as error:
        raise BadInput(f"{path}: is no ROS 1 bag: {str(error).splitlines()[0]}") from error


def table(path, topics):
    """Head and rows: time (in the rows in ns), then the fields of the first topic, then those of the others."""
    with opened(path) as bag:
        topics = chosen_topics(path, topics, bag.get_type_and_topic_info().topics)
        messages = ((topic, time_of(message, recorded), list(numbers(message)))
                    for topic, message, recorded in bag.read_messages(topics=topics))
        return table_of_topics(path, topics, messages)


def main(arguments=None):
    return converted_topics("slipstack.bag", __doc__, "ROS 1 bag", table, arguments)


if __name__ == "__main__":
    sys.exit(main())
