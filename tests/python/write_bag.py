# SPDX-License-Identifier: Apache-2.0
"""A log as a bag, by ROS's own library:  write_bag.py LOG.csv BAG"""

import pathlib
import sys

import genpy
import geometry_msgs.msg
import rosbag
import sensor_msgs.msg

BEGIN_NS = 1_700_000_000_123_456_789


def stamp(offset_ns):
    return genpy.Time(*divmod(BEGIN_NS + offset_ns, 10**9))


def write(path, log):
    """The log as joint states that were recorded 0.5 ms late, a wrench at every tenth, and a topic of two kinds."""
    with rosbag.Bag(path, "w", compression="bz2") as file:
        for i, time_s in enumerate(log["time_s"]):
            at_ns = round(1e9 * time_s)
            joint = sensor_msgs.msg.JointState(name=["turn", "slide"], position=[0.5, log["position_m"][i]], effort=[0.0, log["force_N"][i]])
            joint.header.stamp = stamp(at_ns)
            file.write("/joint_states", joint, stamp(at_ns + 500_000))
            if i % 10 == 0:
                wrench = geometry_msgs.msg.WrenchStamped()
                wrench.header.stamp = joint.header.stamp
                wrench.wrench.force.x = float(i)
                file.write("/wrench", wrench, stamp(at_ns))
        file.write("/changing", sensor_msgs.msg.JointState(position=[1.0]), stamp(0))
        file.write("/changing", sensor_msgs.msg.JointState(position=[1.0, 2.0]), stamp(1))


if __name__ == "__main__":
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
    import conftest
    write(sys.argv[2], conftest.read_log(sys.argv[1])[1])
