#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""hdf5storage_v73.mat, written anew by hdf5storage (Debian's python3-hdf5storage): the motion of make_with_octave.m as MATLAB's
save -v7.3 stores it, in a struct."""

import hdf5storage
import numpy

t = numpy.arange(1200).reshape(-1, 1) * 0.002
x = 0.0125 + 0.003 * numpy.sin(2 * numpy.pi * 1.5 * t)
F = 4 * numpy.sign(numpy.cos(2 * numpy.pi * 1.5 * t)) + 20 * x
log = {"time_s": t, "position_m": x, "force_N": F, "operator_name": "Hans"}
hdf5storage.savemat("hdf5storage_v73.mat", {"log": log, "other": numpy.eye(3)}, format="7.3",
                    store_python_metadata=False, oned_as="column",
                    truncate_existing=True)
