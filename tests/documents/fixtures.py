# SPDX-License-Identifier: Apache-2.0
"""What the pages take for granted when their commands are typed: the files that they name, a node on the bus, and the
commands that are not typed, each with its reason."""

import dataclasses
import os
import pathlib
import re
import shutil
import subprocess
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "tests/cli"))
import program  # noqa: E402
import hysteresis_experiments_test  # noqa: E402
import user_effect_test  # noqa: E402
import markdown  # noqa: E402

SHARED = pathlib.Path(os.environ.get("SLIPSTACK_SHARED", REPOSITORY / ".." / "shared")) / "data"
PYTHON = os.environ.get("SLIPSTACK_PYTHON", sys.executable)
FOREIGN = REPOSITORY / "tests/data/foreign"


class Absent(Exception):
    """A file of measurements, or a program, that this machine does not have: the reason why a command is skipped."""


# --- files, made when a command names one that is not there ---


def simulated(*options, seed=1):
    return lambda path: program.simulate(path, *options, seed=seed)


def viscous(path):
    program.small_log(path, "viscous")


def other_axis(path):
    program.small_log(path, "viscous,stribeck")


def of_commands(log, *commands):
    """A file that commands make of a log: `{log}` and `{path}` stand for both."""
    def make(path):
        source = path.with_name(f"made_of_{log.__name__}.csv")
        if not source.exists():
            log(source)
        for command in commands:
            words = [word.format(log=source, path=path) for word in command.split()]
            subprocess.run([program.SLIPSTACK, *words], check=True, capture_output=True, timeout=program.PATIENCE_S)
    return make


BASE = of_commands(viscous, f"fit {{log}} --effects {program.BASELINE} --model {{path}}")
ADDED = of_commands(viscous, f"fit {{log}} --effects {program.BASELINE} --model {{path}}.base",
                    "add {log} --model {path}.base --effect viscous --out {path}")


def shared(name):
    def make(path):
        source = SHARED / name
        if not source.is_file():
            raise Absent(f"{source} is not there; set SLIPSTACK_SHARED")
        shutil.copy(source, path)
    return make


def foreign(name, head=None):
    def make(path):
        lines = (FOREIGN / name).read_bytes()
        path.write_bytes(lines if head is None else head + lines.partition(b"\n")[2])
    return make


def snag(path):
    """A log with the user-defined effect of the page."""
    clean = path.with_name("clean.csv")
    program.simulate(clean, "--effects", "none", "--seconds", "20", "--rate", "1000", seed=3)
    user_effect_test.hide_snag(clean, path, 4.0, 0.21, 0.004)


def loops(path):
    """Slow sines of stepped amplitude, with what a log of a guideway says of its balls."""
    hysteresis_experiments_test.masing_log(path, (1e-6, 3e-6, 1e-5))


def bag(path):
    """A bag that ROS's own library writes."""
    log = path.with_name("bag.csv")
    viscous(log)
    done = subprocess.run([PYTHON, "-B", REPOSITORY / "tests/python/write_bag.py", log, path], capture_output=True, text=True)
    if "No module named" in done.stderr:
        raise Absent(done.stderr.splitlines()[-1])
    done.check_returncode()


def update(path):
    """New firmware for the board `host`."""
    slots = []
    for slot in ("1", "2"):
        image = path.with_name(f"slot{slot}.bin")
        image.write_bytes(b"new" + slot.encode() + bytes(range(256)) * 100)
        slots += ["--image", {"1": "0x08007000", "2": "0x08047000"}[slot], str(image)]
    subprocess.run([sys.executable, "-B", REPOSITORY / "toolchain/make-update", "--header",
                    REPOSITORY / "firmware/update/image_header.h", "--board", "HOST", *slots, "--out", path],
                   check=True, capture_output=True)


def emps_mat(path):
    """The variables of the benchmark's own file, of the record that is here as a log."""
    record = path.with_name("record.csv")
    shared("emps/emps_estimation.csv")(record)
    if not shutil.which("octave-cli"):
        raise Absent("octave-cli is not there")
    subprocess.run(["octave-cli", "--no-init-file", "--eval", "x = dlmread('record.csv', ',', 2, 0); gtau = 35.15065188248547; t = x(:, 1); "
                    f"qm = x(:, 2); qg = x(:, 3); vir = x(:, 4) / gtau; save('-v7', '{path.name}', 't', 'qm', 'qg', 'vir', 'gtau')"],
                   cwd=path.parent, check=True, capture_output=True, timeout=program.PATIENCE_S)


FILES = {
    "log.csv": viscous,
    "other.csv": other_axis,
    "monday.csv": viscous, "tuesday.csv": other_axis, "tuesday_loaded.csv": other_axis, "rail_end.csv": other_axis,
    "logs/monday.csv": viscous,
    "axis.toml": BASE,
    "better.toml": ADDED, "model.toml": ADDED,
    "DATA_EMPS.mat": emps_mat,
    "emps.csv": shared("emps/emps_estimation.csv"), "emps_estimation.csv": shared("emps/emps_estimation.csv"),
    "result.json": of_commands(viscous, "diagnose {log} --json {path}"),
    "setpoints.csv": of_commands(viscous, "experiment plan --log {log} --for stribeck --out {path}"),
    "loops.csv": loops,
    "again.csv": of_commands(viscous, "experiment transducer --write-log {path}"),
    "new.update": update, "build/cortex-m4/bin/slipstack-stm32g474.update": update,
    "drive.eds": lambda path: shutil.copy(REPOSITORY / "docs/slipstack.eds", path),
    "can.log": foreign("candump.log"), "axis.mcap": foreign("mcap_ros2.mcap"), "axis.bag": bag,
    "slipstack-session/models/3.toml": BASE,
}
# Where a page means another file by the same name.
FILES_OF_PAGES = {
    "docs/user-effect.md": {"log.csv": snag},
    "docs/other-programs.md": {name: foreign("pandas_german.csv", b";Zeit [ms];Pos [mm];F\n") for name in ("scope.csv", "other.csv")},
}

# What stands for what cannot or need not be typed as it is printed.
STANDS_FOR = {
    r"\bcan0\b": "vcan0",  # never the bus of a real machine
    r"--port 8080\b": "--port 0",
    r"\bLOG(\.csv)?\b": "log.csv", r"\bEFFECT\b": "stribeck", r"\bCOMMAND\b": "diagnose", r"\bNAME\b": "free",
    r"\bIMAGE\b": "new.update", r"\bPREFIX\b": "/usr", "<board>": "stm32g474", r"--effects \.\.\.": "--effects viscous",
    r"(?<=^slipstack )(bode|tune)(?= --can)": r"\1 --captures 2",  # of 4
    r"(?<=--board mps2-an386)": " --seconds 8",  # of 60, in the emulator
    r"^toolchain/demo\b": "toolchain/demo --built build/host/bin",
    r"\bmpirun\b": "mpirun --allow-run-as-root --oversubscribe",
}
# Options that a page leaves out, and says so.
LEFT_OUT = {"docs/hardware.md": (r"^slipstack (object|status)\b", " --can vcan0 --node 5")}

# How far numbers of a page may be from those that are printed, where time with the clock decides over the last digits;
# all others are compared exactly.
TOLERANCES = {"docs/hardware.md": 1e-4}

# The node that a page's commands speak to before the page starts one.
NODE = "slipstack node --can vcan0 --node 5"
# What is done on a new node before each command of a page: a measurement may leave the axis elsewhere, in the end too near to
# the end of its travel for the next.
BEFORE = {"docs/bode.md": ["slipstack object --can vcan0 --node 5 6060=1 6040=6 6040=7 6040=15", "sleep 1"]}

# Commands that take minutes by the clock: begun, and ended by Ctrl-C when the file is there.
BEGUN = {r"slipstack commission .*--can vcan0 .*": ("stages.json", "5 minutes by the clock; can.commission_session, on demand, runs all")}


@dataclasses.dataclass(frozen=True)
class NotTyped:
    command: str            # regular expression of the whole command
    reason: str
    test: str | None = None  # of CTest, that does it instead

    def covers(self, command):
        return re.fullmatch(self.command, command) is not None


NOT_TYPED = [
    NotTyped(r"toolchain/(install|fresh)( .*)?|\.ci/run", "root, apt and the network: .ci/run, which decides over a change, is the latter"),
    NotTyped(r"toolchain/test( --full)?", "runs this test"),
    NotTyped(r"toolchain/demo (LOG\.csv|--loop)", "half a minute in a kernel of its own; toolchain/demo is typed", "cli.demo_long"),
    NotTyped(r"cmake --(preset|build) .*|touch .*", "builds what this test runs"),
    NotTyped(r"python3 tests/bench/mutation/mutate.py all", "a quarter of an hour; that the rewriting works is tested", "bench.mutation_rewriting"),
    NotTyped(r"toolchain/(check-\w+|update-uplot)( .*)?", "stages of toolchain/test"),
    NotTyped(r"toolchain/site", "writes into the build; run into another folder", "cli.documented"),
    NotTyped(r"toolchain/package( .*)?|apt install .*", "root: toolchain/fresh packages installs and uses all of them", "packages.made"),
    NotTyped(r"podman .*|buildah .*|debootstrap .*|tar -C root .*", "root and a registry: toolchain/fresh container"),
    NotTyped(r"toolchain/flash .*-new\.hex", "a board at a debug probe"),
    NotTyped(r"slcand .*|toolchain/with-can --serial .*|slipstack node --board .*",
             "a terminal whose name is another each time, in a kernel with CAN", "can.emulated_controller"),
    NotTyped(r"candump .*", "goes on until Ctrl-C; tests/data/foreign/candump.log is such a capture", "python.candump"),
    NotTyped(r"libreoffice .*", "LibreOffice is no package of the project; what it wrote is in tests/data/foreign"),
    NotTyped(r"mpirun --(host|quiet).*", "two machines; an option of mpirun itself"),
    NotTyped(r"slipstack loop --compare( --seed \d+)?( --seeds 20.*)?", "a quarter of a minute to six minutes; --brief is typed"),
]
# Pages of which another test types everything.
PAGES_OF_OTHER_TESTS = {"docs/can-sessions.md": "can.documented_sessions"}


@dataclasses.dataclass(frozen=True)
class Shown:
    """A block that is no command, by how it begins: what it is compared with."""
    begins: str
    of: str = ""        # a command of the page, as printed, whose output it is
    command: str = ""   # or a command that prints it; `{second}` is the second line of the block, `{rest}` all but the first
    names: str = ""     # files that the command needs beside those that it names
    log: bool = False   # or the beginning of a log that is read
    file: str = ""      # or an excerpt of such a file, without its values
    source: str = ""    # or files and folders, a line each, that sources below a folder name
    test: str = ""      # or the test of CTest that compares it
    reason: str = ""    # or why there is nothing to compare


def damaged(path):
    """A log whose row of line 700 has a unit in its force."""
    viscous(path)
    lines = path.read_text().splitlines()
    lines[699] = lines[699].rpartition(",")[0] + ",12.5N"
    path.write_text("\n".join(lines) + "\n")


def bench_program(path):
    """The C++ of sim_host/README.md in a program."""
    block, = [one for one in markdown.code("sim_host/README.md") if one.language == "cpp"]
    path.write_text('#include "sim_host/log/draw.h"\n#include "sim_host/plant/plant.h"\n#include "sim_host/sensors/encoder.h"\n'
                    "using namespace slipstack::sim;\ndouble current_A;\nint seed;\nint main() {\n" + block.text + "return counts != 0;\n}\n")


FILES["damaged/log.csv"] = damaged
FILES["bench.cpp"] = bench_program
SHOWN = {
    "README.md": [Shown("  without viscous", of="toolchain/demo"), Shown("# mass_kg", log=True)],
    "CONTRIBUTING.md": [Shown("app →", reason="toolchain/check-rules checks it")],
    "docs/adaptation.md": [Shown("error of a move", test="bench.AdaptationPage"), Shown("    ", test="bench.AdaptationFresh")],
    "docs/adding-an-effect.md": [Shown("", test="cli.adding_an_effect")],
    "docs/can-sessions.md": [Shown("", test="can.documented_sessions")],
    "docs/comparison.md": [Shown("Tracking error", reason="20 axes: six minutes")],
    "docs/control.md": [Shown("counts", reason="a drawing")],
    "docs/energy.md": [Shown("", test="bench.Energy.ThePage")],
    "docs/experiments.md": [Shown("k_e", reason="a formula"), Shown("F·sin", reason="a formula"),
                            Shown("       ", command="slipstack experiment plan --log emps.csv --for stribeck,viscous --out plan.csv")],
    "docs/friction-observer.md": [Shown("error", test="bench.FrictionObserver.ThePage")],
    "docs/library.md": [Shown("#include", reason="compiled with the block before it")],
    "docs/log-format.md": [Shown("# mass_kg", log=True),
                           Shown("slipstack: log.csv:700", command="cd damaged && slipstack diagnose log.csv", names="damaged/log.csv")],
    "docs/model-file.md": [Shown("format", file="better.toml")],
    "docs/serve.md": [Shown("session.json", source="workbench/serve")],
    "docs/tutorial/real-axis.md": [Shown("time_s", command="grep -v ^# emps.csv | head -3")],
    "sim_host/README.md": [Shown("slipstack::sim::Bench", command="c++ -std=c++20 -fsyntax-only -I. bench.cpp && cat bench.cpp", names="bench.cpp")],
    "docs/user-effect.md": [
        Shown("slipstack: --effect", command="slipstack diagnose log.csv --effect '{second}'"),
        Shown("controller snag", command="slipstack fit log.csv --effects inertia,presliding_hysteresis --model snag.toml --effect "
                                         f"'{user_effect_test.SNAG}'")],
}
# Files of which the text of a page says that they are there afterwards, in the folder where its commands were typed.
AFTERWARDS = {
    "docs/install.md": ["man/slipstack.1", "man/slipstack-diagnose.1", "installed/usr/bin/slipstack", "installed/usr/bin/slipstack-sim",
                        "installed/usr/share/slipstack/schema/*.json", "installed/usr/share/man/man1/slipstack-diagnose.1*"],
    "docs/python.md": ["installed/usr/lib/python3/dist-packages/slipstack/__init__.py", "installed/usr/lib/python3/dist-packages/slipstack/_core.*",
                       "better.toml", "compare.html"],
    "docs/serve.md": ["slipstack-session/session.json", "tuesday/session.json"],
    "docs/tutorial/real-axis.md": ["emps.html", "better.html", "setpoints.csv"],
}
# What the output of a command holds, where the page does not show it: (page, command, expression).
PRINTED = [
    ("docs/install.md", r"slipstack manual man", r"pages in man"),
    ("docs/python.md", r"import pandas(.|\n)*", r"missing_effect viscous"),
    ("docs/python.md", r"python3 -c .*__version__.*", r"^\d+\.\d+\.\d+$"),
    ("docs/json.md", r"slipstack diagnose log.csv --json - .*", r"^viscous$"),
    ("docs/user-effect.md", r"slipstack diagnose .*", r"Missing: snag"),
    ("docs/matlab.md", r"addpath(.|\n)*", r"found again: viscous"),
]
# What a session in a language is asked after the page.
ASKED = {"docs/matlab.md": "assert(abs(found.parameters(3).parameters(1).value / 12 - 1) < 0.1); disp('found again: viscous')\n"}
