# SPDX-License-Identifier: Apache-2.0
"""slipstack.bag on bags that ROS's own library wrote: the log that comes of it is the one that went in."""

import subprocess
import sys

import conftest
import genpy
import geometry_msgs.msg
import numpy
import program
import pytest
import rosbag
import sensor_msgs.msg

BEGIN_NS = 1_700_000_000_123_456_789


def run(*arguments, cwd):
    return subprocess.run([sys.executable, "-B", "-m", "slipstack.bag", *map(str, arguments)], cwd=cwd, capture_output=True,
                          text=True, timeout=program.PATIENCE_S)


def refused(cwd, *arguments):
    """The line of an input that cannot be used."""
    done = run(*arguments, "--out", "table.csv", cwd=cwd)
    assert done.returncode == 2 and done.stdout == "", done
    assert not (cwd / "table.csv").exists()
    return done.stderr


def stamp(offset_ns):
    return genpy.Time(*divmod(BEGIN_NS + offset_ns, 10**9))


@pytest.fixture
def bag(here):
    """axis.bag: good.csv as joint states that were recorded 0.5 ms late, a wrench at every tenth, and a topic of two kinds."""
    _, log = conftest.read_log("good.csv")
    with rosbag.Bag("axis.bag", "w", compression="bz2") as file:
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
    return here, log


def test_the_log_that_went_in(bag):
    folder, log = bag
    done = run("axis.bag", "--topic", "/joint_states", "--out", "table.csv", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    done = program.run("import", "table.csv", "--out", "log.csv", "--columns",
                       "time [s]=time_s,position[slide]=position_m,effort[slide]=force_N", "--header", "mass_kg=35.45", cwd=folder)
    assert done.returncode == 0, done.stderr
    _, got = conftest.read_log(folder / "log.csv")
    for name in ("position_m", "force_N"):
        assert numpy.array_equal(got[name], log[name]), name
    assert numpy.max(numpy.abs(got["time_s"] - (log["time_s"] - log["time_s"][0]))) < 1e-9


def test_a_further_topic_keeps_its_last_value(bag):
    folder, log = bag
    done = run("axis.bag", "--topic", "/joint_states", "--topic", "/wrench", "--out", "-", cwd=folder)
    head, *rows = done.stdout.splitlines()
    column = head.split(",").index("/wrench wrench.force.x")
    got = [float(row.split(",")[column]) for row in rows]
    assert got == [10.0 * (i // 10) for i in range(len(got))]
    assert len(rows) == len(log["time_s"])


def test_what_cannot_be_used_is_said_in_one_line(bag):
    folder, _ = bag
    assert refused(folder, "axis.bag") == "slipstack.bag: axis.bag: say --topic; there are /changing, /joint_states, /wrench\n"
    assert "has no topic /joints; there are /changing" in refused(folder, "axis.bag", "--topic", "/joints")
    assert "change their fields" in refused(folder, "axis.bag", "--topic", "/changing")
    assert "is no ROS 1 bag" in refused(folder, "good.csv")
    assert "is no file" in refused(folder, "none.bag")
    whole = (folder / "axis.bag").read_bytes()
    (folder / "cut.bag").write_bytes(whole[:len(whole) // 2])
    assert refused(folder, "cut.bag").count("\n") == 1
    assert b"python3 -m slipstack.bag" in program.run("diagnose", "axis.bag", cwd=folder).stderr


def test_what_the_page_says_can_be_typed(bag):
    folder, good = bag
    conftest.type_block("other-programs.md", "slipstack.bag", folder)
    _, log = conftest.read_log(folder / "log.csv")
    assert len(log["force_N"]) == len(good["force_N"])
