# SPDX-License-Identifier: Apache-2.0
"""What the tests of the command line share: running the real programs, and a folder with a good log and model.

The programs are named by the environment, SLIPSTACK and SLIPSTACK_SIM (set by CTest); else those of build/host.
"""

import copy
import functools
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
SLIPSTACK = os.environ.get("SLIPSTACK", str(REPOSITORY / "build/host/bin/slipstack"))
SLIPSTACK_SIM = os.environ.get("SLIPSTACK_SIM", str(REPOSITORY / "build/host/bin/slipstack-sim"))
PATIENCE_S = 240

BASELINE = "inertia,presliding_hysteresis"


def simulate(log, *options, seed=1, truth=None):
    """Writes a simulated log of the pick-and-place axis; what it hides goes to `truth`."""
    hidden = truth or f"{log}.truth"
    command = [SLIPSTACK_SIM, "log", "--setup", "pick_and_place", "--seed", str(seed), "--out", str(log),
               "--truth", str(hidden), *options]
    subprocess.run(command, check=True, capture_output=True, timeout=PATIENCE_S)
    if truth is None:
        os.remove(hidden)


def small_log(log, effect):
    """Eight seconds at 500 Hz: enough to fit, quick to diagnose."""
    simulate(log, "--effects", effect, "--seconds", "8", "--rate", "500", "--strength", "10")


def run(*arguments, cwd, **options):
    return subprocess.run([SLIPSTACK, *map(os.fspath, arguments)], cwd=cwd, capture_output=True,
                          timeout=PATIENCE_S, **options)


def schema_library():
    """The module jsonschema of this interpreter, or that of the distribution's; None where there is none."""
    try:
        import jsonschema
        return jsonschema
    except ImportError:
        sys.path.append("/usr/lib/python3/dist-packages")
    try:
        import jsonschema
        return jsonschema
    except ImportError:
        return None


def closed(schema):
    """The same, but of objects no keys that the schema does not name: a new one is to be written down."""
    if isinstance(schema, list):
        return [closed(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    out = {key: closed(value) for key, value in schema.items()}
    if schema.get("type") == "object" and ("properties" in schema or "patternProperties" in schema):
        out.setdefault("additionalProperties", False)
    return out


@functools.cache
def validator(urn):
    name = urn.removeprefix("urn:slipstack:")
    schema = json.loads((REPOSITORY / "docs/schema" / f"{name}.json").read_text())
    if schema["$id"] != urn:
        raise AssertionError(f"docs/schema/{name}.json: $id is {schema['$id']}, not {urn}")
    kind = schema_library().Draft202012Validator
    kind.check_schema(schema)
    return kind(closed(copy.deepcopy(schema)))


def published(text, **options):
    """What --json wrote, checked against the schema that it names (where jsonschema is installed)."""
    result = json.loads(text, **options)
    if schema_library() is not None:
        faults = [f"{'/'.join(map(str, fault.absolute_path))}: {fault.message[:300]}"
                  for fault in validator(result["schema"]).iter_errors(result)]
        if faults:
            raise AssertionError(f"{result['schema']}: " + "; ".join(faults[:5]))
    return result


class Workshop(unittest.TestCase):
    """Each test starts in a new folder `self.here` with good.csv (viscous friction hidden) and good.toml."""

    maxDiff = None

    @classmethod
    def setUpClass(cls):
        cls.stock = pathlib.Path(tempfile.mkdtemp(prefix="slipstack-stock-"))
        cls.addClassCleanup(shutil.rmtree, cls.stock)
        small_log(cls.stock / "good.csv", "viscous")
        done = run("fit", "good.csv", "--effects", BASELINE, "--model", "good.toml", cwd=cls.stock)
        if done.returncode != 0:
            raise RuntimeError(done.stderr.decode())

    def setUp(self):
        self.here = pathlib.Path(tempfile.mkdtemp(prefix="slipstack-test-"))
        self.addCleanup(shutil.rmtree, self.here)
        for name in ("good.csv", "good.toml"):
            shutil.copy(self.stock / name, self.here / name)

    def run_here(self, *arguments, **options):
        return run(*arguments, cwd=self.here, **options)

    def content(self):
        """Every entry of the folder with a digest of what it holds."""
        found = {}
        for path in sorted(self.here.rglob("*")):
            name = str(path.relative_to(self.here))
            if path.is_symlink() or not path.is_file():
                found[name] = str(path.readlink()) if path.is_symlink() else "not a file"
            elif path.stat().st_size > 1 << 28:
                found[name] = f"{path.stat().st_size} bytes"
            else:
                found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        return found

    def assert_one_line(self, stderr, *expected):
        line = stderr.decode("utf-8")
        self.assertTrue(line.endswith("\n") and line.count("\n") == 1, f"not one line: {line!r}")
        self.assertTrue(line.startswith("slipstack: "), line)
        self.assertTrue(line[:-1].isprintable(), f"control characters: {line!r}")
        self.assertNotIn("internal fault", line)
        for part in expected:
            self.assertIn(part, line)

    def assert_refused(self, arguments, *expected, **options):
        """Status 2, one line on standard error that holds all of `expected`, and no trace of a run."""
        before = self.content()
        done = self.run_here(*arguments, **options)
        self.assertEqual(done.returncode, 2, f"{arguments}: {done.stderr.decode()}")
        self.assertEqual(done.stdout, b"")
        self.assert_one_line(done.stderr, *expected)
        self.assertEqual(self.content(), before, f"{arguments} left something behind")

    def assert_done(self, *arguments, **options):
        done = self.run_here(*arguments, **options)
        self.assertEqual(done.returncode, 0, f"{arguments}: {done.stderr.decode()}")
        self.assertEqual(done.stderr, b"")
        return done


def long(test):
    """Marks a test, or a class of tests, that only toolchain/test --full runs."""
    test.long = True
    return test


class Selection(unittest.TestLoader):
    """The tests of a script that are marked @long, or the others."""

    def __init__(self, long_ones):
        super().__init__()
        self.long_ones = long_ones

    def getTestCaseNames(self, case):
        return [name for name in super().getTestCaseNames(case)
                if getattr(getattr(case, name), "long", getattr(case, "long", False)) == self.long_ones]


def main():
    """Runs the tests of the calling script that are not marked @long; with --long as first word, those that are."""
    words = sys.argv[1:]
    long_ones = words[:1] == ["--long"]
    done = unittest.main(argv=sys.argv[:1] + words[long_ones:], testLoader=Selection(long_ones), exit=False)
    if done.result.testsRun == 0:
        sys.exit("no test was run")
    sys.exit(not done.result.wasSuccessful())


def every_command(log="good.csv", model="good.toml"):
    """A right command line of each kind, with every output that it can write."""
    files = ["--report", "new.html", "--json", "new.json"]
    return {
        "compare": ["compare", log, "--model", model, *files],
        "fit": ["fit", log, "--effects", BASELINE, "--model", "new.toml", *files],
        "diagnose": ["diagnose", log, "--model", model, "--stepwise", *files],
        "add": ["add", log, "--model", model, "--effect", "viscous", "--out", "new.toml", *files],
    }
