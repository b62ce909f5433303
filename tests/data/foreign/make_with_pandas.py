#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The files of pandas in this folder, written anew: python3 make_with_pandas.py (with python3-pandas, python3-openpyxl)."""
import numpy
import pandas

N = 1200
t = numpy.arange(N) * 0.002
x = 12.5 + 3.0 * numpy.sin(2.0 * numpy.pi * 1.5 * t)
force = 4.0 * numpy.sign(numpy.cos(2.0 * numpy.pi * 1.5 * t)) + 0.02 * x
frame = pandas.DataFrame({"Zeit [ms]": 1e3 * t, "Istposition [mm]": x.round(4), "Kraft [N]": force.round(3)})
frame.to_csv("pandas_german.csv", sep=";", decimal=",")  # with the index as an unnamed first column
stamps = pandas.Timestamp("2026-03-04T10:15:00") + pandas.to_timedelta((t * 1e9).round(), unit="ns")
frame = frame.rename(columns={"Zeit [ms]": "timestamp"})
frame["timestamp"] = stamps
frame.to_csv("pandas_dates.tsv", sep="\t", index=False)
frame["timestamp"] = stamps.astype("int64")
frame.to_csv("pandas_ns.csv", index=False)
jitter = numpy.random.default_rng(1).uniform(-4e-4, 4e-4, N)
frame["timestamp"] = (stamps.astype("int64") + (1e9 * jitter).astype("int64"))
frame.to_csv("pandas_jitter.csv", index=False)
pandas.DataFrame({"t [s]": t, "x [mm]": x.round(4), "F [N]": force.round(3)}).to_excel("pandas.xlsx", index=False)
