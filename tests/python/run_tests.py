#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs tests of this folder by pytest; status 77 and SKIP with the reason where that cannot be.

run_tests.py [--long] FILE...: those that are not marked pytest.mark.long; with --long those that are.
"""

import importlib.util
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77
NEEDED = {"pytest": "python3-pytest is not installed", "numpy": "python3-numpy is not installed",
          "slipstack": "the package was not built: pybind11-dev, python3-dev or python3-numpy is not installed"}
NEEDED_BY = {"bag_test.py": {"rosbag": "python3-rosbag", "sensor_msgs": "python3-sensor-msgs", "geometry_msgs": "python3-geometry-msgs"}}


def main():
    for module, reason in NEEDED.items():
        if importlib.util.find_spec(module) is None:
            print(f"SKIP: {reason} (toolchain/install test)")
            return SKIPPED
    for module, package in [needed for name in sys.argv[1:] for needed in NEEDED_BY.get(name, {}).items()]:
        if importlib.util.find_spec(module) is None:
            print(f"SKIP: {package} is not installed (toolchain/install full)")
            return SKIPPED
    import pytest
    sys.path.insert(0, str(HERE.parent / "cli"))
    names = sys.argv[1:]
    long_ones = names[:1] == ["--long"]
    return pytest.main(["-q", "-rs", "-p", "no:cacheprovider", "--rootdir", str(HERE), "--strict-markers",
                        "-o", "markers=long: toolchain/test --full only", "-m", "long" if long_ones else "not long",
                        *(str(HERE / name) for name in names[long_ones:])])


if __name__ == "__main__":
    sys.exit(main())
