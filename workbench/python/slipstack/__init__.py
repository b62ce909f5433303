# SPDX-License-Identifier: Apache-2.0
"""Friction models of rolling guideways, compared with measurements: the commands of `slipstack` on arrays.

    import slipstack
    found = slipstack.diagnose(frame, mass=35.45)
    print(found.verdict, found.candidates[0].effect)

A log is given as

  - a path of a CSV or MAT file,
  - a pandas frame, a mapping of names to arrays, or a structured array, with the columns of a log file
    (docs/log-format.md): time_s, position_m, force_N, ...,
  - a Log, which has header and name besides,
  - or a list of these: several logs of one axis, fitted together.

A model is given as the path of a model file, or as the result of fit() or add().

All functions take `progress`, a function of (stage, fraction) that is called in the caller's thread; the fraction is None
where it is not known. While they work the interpreter is free for other threads; Ctrl-C ends the work, and nothing is
written then. One command works at a time, others wait for it. What the command line would refuse with status 2 raises
InputError with the same line.
"""

import collections.abc
import json as _json
import os as _os

import numpy as _np

from . import _core
from ._core import InputError, MaxwellSlip, MemoryStack

__all__ = ["InputError", "Log", "MaxwellSlip", "MemoryStack", "Record", "Result", "add", "compare", "diagnose", "fit",
           "plan", "simulate"]
__version__ = _core.VERSION


class Record(dict):
    """An object of JSON whose keys are attributes too: record.verdict is record["verdict"]."""

    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no {name!r} here; there are: {', '.join(self)}") from None

    def __dir__(self):
        return [*super().__dir__(), *self]


class Result(Record):
    """What a command found: the keys of its JSON (docs/json.md), and what the command line prints and writes."""

    def __init__(self, text, json, file, has_model=False):
        super().__init__(_json.loads(json, object_hook=Record))
        self.__dict__.update(_given=(text, json, file), _has_model=has_model)

    def to_text(self):
        """The tables that the command line prints."""
        return self._given[0]

    def to_json(self):
        """The text that `--json` writes, byte for byte (docs/json.md)."""
        return self._given[1]

    def to_file(self):
        """The text of the file that the command writes: of fit and add the model (`--model`, `--out`), of plan and simulate
        the CSV file of `--out`; else empty."""
        return self._given[2]

    def columns(self):
        """The columns of the CSV file of plan and simulate as arrays, by name; units are in the names. Raises InputError for
        other results."""
        if self._has_model or not self.to_file():
            raise InputError("this result has no columns; those of plan and simulate have")
        lines = [line for line in self.to_file().splitlines() if not line.startswith("#")]
        table = _np.loadtxt(lines[1:], delimiter=",", ndmin=2)
        return dict(zip(lines[0].split(","), table.T))


class Log:
    """A log in memory.

    data    a frame, a mapping or a structured array with the columns of a log file
    header  what the `# key: value` lines of a file say, as {"encoder_resolution_m": 1e-6}; of a frame its attrs
            where none is given
    mass    the moving mass in kg (of a rotary axis the inertia in kg m2); the same as "mass_kg" in the header
    name    stands for the path in results and messages
    """

    def __init__(self, data, *, header=None, mass=None, name="log"):
        if header is None:
            header = getattr(data, "attrs", {})
        columns = _columns(data, name)
        header = {str(key): _header_text(value) for key, value in dict(header).items()}
        if mass is not None:
            header["inertia_kg_m2" if _is_rotary(columns) else "mass_kg"] = _header_text(mass)
        self.name = _os.fsdecode(name)
        self.header = header
        self.columns = columns

    def _table(self):
        return _table(self.name, self.columns, self.header)


def diagnose(log, *, effects=None, model=None, effect=(), stepwise=False, per_log=None, noise_N=None, mass=None,
             header=None, report=None, json=None, progress=None):
    """Names the physical effect that a model lacks: `slipstack diagnose`.

    effects   the baseline, as "a,b" or a list of ids; "auto": chosen by the log; None: the default
    model     or the effects of a model, fitted again
    effect    definitions of user-defined effects to try (docs/user-effect.md)
    stepwise  go on until nothing is missing or nothing helps
    per_log   of several logs: effects with gains of each log's own; "none": all are shared
    noise_N   standard deviation of the force's noise in one sample; None: estimated
    mass, header  of a log that is no file and no Log (see there)
    report, json  files to write, all or none
    """
    options, tables = _options(log, mass, header, per_log, noise_N, report, json)
    if model is not None and effects is not None:
        raise InputError("effects and model exclude each other; give one of them as the baseline")
    _set_model(options, model)
    options.effects = _joined(effects, "effects")
    options.user_effects = _listed(effect)
    options.stepwise = bool(stepwise)
    options.command_line = _call("diagnose", log, effects=effects, model=model, effect=effect, stepwise=stepwise,
                                 per_log=per_log, noise_N=noise_N, mass=mass, header=header)
    return Result(*_core.diagnose(options, tables, progress))


def fit(log, effects, *, effect=(), model=None, criterion="force", horizon_s=None, per_log=None, noise_N=None,
        mass=None, header=None, report=None, json=None, progress=None):
    """Fits a model of chosen effects to a log: `slipstack fit`.

    effects    as "a,b" or a list of ids
    effect     definitions of user-defined effects to fit too
    model      file to write the model to; the result can be given as a model without it
    criterion  "force": along the measured motion; "simulation": the position that the force alone gives
    horizon_s  duration of the runs of the latter
    The others as in diagnose().
    """
    options, tables = _options(log, mass, header, per_log, noise_N, report, json)
    options.effects = _joined(effects, "effects") or _refuse("effects: name at least one")
    options.user_effects = _listed(effect)
    options.model = _path(model, "model")
    if criterion not in ("force", "simulation"):
        raise InputError(f"criterion: {criterion!r} is none; give 'force' or 'simulation'")
    options.criterion = criterion
    options.horizon_s = _core.RUN_HORIZON_S if horizon_s is None else _number(horizon_s, "horizon_s", 0.2, 3600.0)
    options.command_line = _call("fit", log, effects, effect=effect, model=model, criterion=criterion,
                                 horizon_s=horizon_s, per_log=per_log, noise_N=noise_N, mass=mass, header=header)
    return Result(*_core.fit(options, tables, progress), has_model=True)


def add(log, model, effect, *, out=None, per_log=None, noise_N=None, mass=None, header=None, report=None, json=None,
        progress=None):
    """Adds an effect to a model and fits it again: `slipstack add`.

    effect  the id of an effect, or the definition of a user-defined one
    out     file to write the model to; the result can be given as a model without it
    The others as in diagnose().
    """
    options, tables = _options(log, mass, header, per_log, noise_N, report, json)
    _set_model(options, model, required=True)
    options.effect = str(effect)
    options.out = _path(out, "out")
    options.command_line = _call("add", log, model, effect, out=out, per_log=per_log, noise_N=noise_N, mass=mass,
                                 header=header)
    return Result(*_core.add(options, tables, progress), has_model=True)


def compare(log, model, *, per_log=None, noise_N=None, mass=None, header=None, report=None, json=None, progress=None):
    """Compares a model with a log, without any fit: `slipstack compare`. Arguments as in diagnose()."""
    options, tables = _options(log, mass, header, per_log, noise_N, report, json)
    _set_model(options, model, required=True)
    options.command_line = _call("compare", log, model, per_log=per_log, noise_N=noise_N, mass=mass, header=header)
    return Result(*_core.compare(options, tables, progress))


def simulate(model, *, log=None, setpoints=None, start_s=0.0, end_s=0.0, mass=None, header=None, out=None, report=None,
             json=None, progress=None):
    """Runs a model forward: `slipstack simulate`. The result has columns().

    log        from the force of this log to the position, from start_s to end_s (0: its end)
    setpoints  a motion (a file, or data with time_s, position_m and perhaps velocity_mps, acceleration_mps2): the
               force that it asks for
    out        CSV file to write
    """
    request = _core.SimulateRequest()
    _set_model(request, model, required=True)
    tables = []
    if log is not None:
        paths, tables = _logs(log, mass, header)
        if len(paths) != 1:
            raise InputError(f"log: {len(paths)} logs; a simulation takes one")
        request.log = paths[0]
    if setpoints is not None:
        if _is_path(setpoints):
            request.set_points = _path(setpoints, "setpoints")
        else:
            request.set_points = "setpoints"
            request.points = _table("setpoints", _columns(setpoints, "setpoints"), {})
    request.start_s, request.end_s = float(start_s), float(end_s)
    line = _call("simulate", model, log=log, setpoints=setpoints, start_s=start_s or None, end_s=end_s or None, out=out)
    return Result(*_core.simulate(request, _outputs(report, json, out), line, tables, progress))


def plan(effects, *, log=(), model=None, baseline=None, effect=(), limits="", seconds=None, rate_Hz=None, mass=None,
         header=None, out=None, report=None, json=None, progress=None):
    """Plans the motion that separates effects, within the limits of the axis: `slipstack experiment plan`. The result
    has columns(): the set points.

    effects   ids of the effects to show and to separate
    log       logs of the axis; model: of the axis; baseline: effects, without a model
    effect    definitions of user-defined effects among `effects`
    limits    "stroke=low:high,velocity=,acceleration=,jerk=,force=,current=" in SI units, or a mapping of these
    seconds, rate_Hz  the motion may last so long, with so many set points a second
    out       CSV file to write
    """
    request = _core.PlanRequest()
    request.effects = _joined(effects, "effects")
    tables = []
    if isinstance(log, Log) or _is_path(log) or len(log) > 0:
        request.logs, tables = _logs(log, mass, header)
    if model is not None and baseline is not None:
        raise InputError("model and baseline exclude each other; give one of them")
    _set_model(request, model)
    request.baseline = _joined(baseline, "baseline")
    request.user_effects = _listed(effect)
    if isinstance(limits, collections.abc.Mapping):
        limits = ",".join(f"{key}={value}" for key, value in limits.items())
    request.limits = limits
    if seconds is not None:
        request.seconds = float(seconds)
    if rate_Hz is not None:
        request.rate_Hz = float(rate_Hz)
    line = _call("plan", effects, log=log, model=model, baseline=baseline, effect=effect, limits=limits,
                 seconds=seconds, rate_Hz=rate_Hz, out=out)
    return Result(*_core.plan(request, _outputs(report, json, out), line, tables, progress))


def _refuse(line):
    raise InputError(line)


def _is_path(value):
    return isinstance(value, (str, bytes, _os.PathLike))


def _path(value, what):
    """A path as the bytes that the system takes; None: none."""
    if value is None:
        return b""
    if not _is_path(value):
        raise InputError(f"{what}: {type(value).__name__} is no path")
    return _os.fsencode(value) or _refuse(f"{what}: must not be empty")


def _listed(value):
    return [value] if isinstance(value, str) else [str(one) for one in value]


def _joined(value, what):
    """Ids separated by commas; None: none."""
    if value is None:
        return ""
    return ",".join(_listed(value)) or _refuse(f"{what}: must not be empty")


def _number(value, what, lowest, highest):
    if not lowest <= value <= highest:
        raise InputError(f"{what}: must be between {lowest:g} and {highest:g}")
    return float(value)


def _header_text(value):
    return value if isinstance(value, str) else repr(value.item() if isinstance(value, _np.generic) else value)


def _is_rotary(columns):
    return any(name.startswith("torque_") or name.endswith(("_rad", "_deg", "_rev")) for name in columns)


def _columns(data, name):
    """The columns of a log by name: arrays of one dimension. A frame may have one of them, with a name, as its index."""
    if hasattr(data, "reset_index") and getattr(data.index, "name", None):
        data = data.reset_index()
    if isinstance(data, _np.ndarray) and data.dtype.names:
        names = data.dtype.names
    elif hasattr(data, "keys"):
        names = list(data.keys())
    else:
        raise InputError(f"{_os.fsdecode(name)}: {type(data).__name__} has no named columns; give a path, a frame, or a "
                         "mapping of names to arrays")
    columns = {}
    for key in names:
        values = _np.asarray(data[key])
        if values.ndim != 1 or values.dtype.kind not in "fiu":
            raise InputError(f"{_os.fsdecode(name)}: column {key}: {values.dtype} of shape {values.shape} is no array of "
                             "numbers of one dimension")
        columns[str(key)] = values
    if not columns:
        raise InputError(f"{_os.fsdecode(name)}: no columns; give time_s, a position and a force")
    return columns


def _table(name, columns, header):
    table = _core.Table(_os.fsencode(name))
    for key, values in columns.items():
        # Half a unit of the last place, of numbers that are stored in fewer digits than a double's.
        precision = float(_np.finfo(values.dtype).eps) / 2.0 if values.dtype.kind == "f" and values.itemsize < 8 else 0.0
        table.add_column(key, values, precision)
    for key, value in header.items():
        table.add_header(key, value)
    return table


def _logs(log, mass, header):
    """The paths of logs, names for those in memory, and the tables of these."""
    paths, tables = [], []
    for one in log if isinstance(log, (list, tuple)) else [log]:
        if _is_path(one):
            if mass is not None or header is not None:
                raise InputError(f"{_os.fsdecode(one)}: mass and header of a file stand in the file; write them there")
            paths.append(_path(one, "log"))
            continue
        if isinstance(one, Log) and (mass is not None or header is not None):
            raise InputError(f"{one.name}: give mass and header to this Log")
        if not isinstance(one, Log):
            in_memory = sum(not _is_path(other) for other in log) if isinstance(log, (list, tuple)) else 1
            one = Log(one, header=header, mass=mass, name="log" if in_memory == 1 else f"log {len(paths) + 1}")
        paths.append(_os.fsencode(one.name))
        tables.append(one._table())
    if not paths:
        raise InputError("no log; give at least one")
    return paths, tables


def _options(log, mass, header, per_log, noise_N, report, json):
    options = _core.Options()
    options.logs, tables = _logs(log, mass, header)
    options.per_log = _joined(per_log, "per_log")
    if noise_N is not None:
        options.noise_N = noise_N if noise_N > 0.0 else _refuse("noise_N: must be positive")
    options.report = _path(report, "report")
    options.json = _path(json, "json")
    return options, tables


def _outputs(report, json, out):
    outputs = _core.ExperimentOutputs()
    outputs.report, outputs.json, outputs.out = _path(report, "report"), _path(json, "json"), _path(out, "out")
    return outputs


def _set_model(request, model, required=False):
    if model is None:
        if required:
            raise InputError("model: give the path of a model file, or the result of fit() or add()")
        return
    if isinstance(model, Result):
        if not model._has_model:
            raise InputError("model: this result has no model; give that of fit() or add()")
        request.model = _os.fsencode(model.get("model") or "model")
        request.model_content = model.to_file().encode("utf-8", "surrogateescape")
    else:
        request.model = _path(model, "model")


def _call(function, *arguments, **options):
    """The call as it stands in a report; data and results only by what they are."""
    def shown(value):
        if isinstance(value, (list, tuple)):
            return f"[{', '.join(map(shown, value))}]"
        if _is_path(value):
            return repr(_os.fsdecode(value))
        if isinstance(value, Log):
            return value.name
        return repr(value) if isinstance(value, (int, float, bool, dict)) and not isinstance(value, Record) \
            else type(value).__name__.lower()
    parts = [shown(one) for one in arguments]
    parts += [f"{key}={shown(value)}" for key, value in options.items()
              if value is not None and value is not False and not (isinstance(value, (tuple, str)) and not value)]
    return f"slipstack.{function}({', '.join(parts)})"
