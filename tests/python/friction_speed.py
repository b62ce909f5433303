# SPDX-License-Identifier: Apache-2.0
"""The friction core of the package along positions, as friction_speed.cpp has it in C++.

friction_speed.py MODEL POSITIONS REPETITIONS: prints the user seconds of each repetition and the sum of the forces
"""

import resource
import sys

import numpy
import slipstack


def user_s():
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def main():
    name, positions, repetitions = sys.argv[1:]
    x = numpy.fromfile(positions)
    places = numpy.arange(1.0, 11.0)
    model = slipstack.MaxwellSlip(0.5 * places, 1.0 / places) if name == "MaxwellSlip" else slipstack.MemoryStack.rational(8.0, 2.0)
    for _ in range(int(repetitions)):
        model.reset(0.0)
        before_s = user_s()
        force_N = model.step(x)
        taken_s = user_s() - before_s
        # One after the other, as C++ adds; numpy.sum() adds in pairs.
        print(f"{taken_s:.6f} {numpy.add.accumulate(force_N)[-1]:.17g}")


if __name__ == "__main__":
    main()
