# SPDX-License-Identifier: Apache-2.0
"""A folder that looks like a clone of the project, and what is typed there."""

import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import tempfile
import time
import urllib.request

import fixtures
from commands import commands, files_written, not_typed
from fixtures import program

PATIENCE_S = 200
BUILD = pathlib.Path(os.environ.get("SLIPSTACK_BUILD", pathlib.Path(program.SLIPSTACK).parents[1]))
TARGET_BUILD = pathlib.Path(os.environ.get("SLIPSTACK_TARGET_BUILD") or program.REPOSITORY / "build/cortex-m4")
NAMES = re.compile(r"[\w./-]+\.(?:csv|toml|json|log|eds|bag|mcap|update|cpp|mat)\b")


class Session:
    """The commands of a page are typed in one folder, whose environment, files and running services last from one to the next."""

    def __init__(self, page, bus):
        self.page, self.bus = page, bus
        self.here = pathlib.Path(tempfile.mkdtemp(prefix="slipstack-page-"))
        self.services = []
        self.not_written = {}  # files of commands that were skipped, and why
        self.environment = {**os.environ, "DESTDIR": str(self.here / "installed"), "PYTHONDONTWRITEBYTECODE": "1", "SLIPSTACK": program.SLIPSTACK}

    def __enter__(self):
        for path in program.REPOSITORY.iterdir():
            if path.name not in ("build", "out", "docs"):
                (self.here / path.name).symlink_to(path)
        shutil.copytree(program.REPOSITORY / "docs", self.here / "docs")  # some commands write there
        (self.here / "build").mkdir()
        (self.here / "build/host").symlink_to(BUILD)
        (self.here / "build/cortex-m4").mkdir()
        for path in (TARGET_BUILD / "bin").glob("*") if (TARGET_BUILD / "bin").is_dir() else ():
            place = self.here / "build/cortex-m4/bin" / path.name
            place.parent.mkdir(exist_ok=True)
            if path.suffix != ".update":  # for a board that is not here: fixtures.FILES
                place.symlink_to(path)
        tools = self.here / ".tools"
        tools.mkdir()
        opener = tools / "xdg-open"
        opener.write_text("#!/bin/sh\nexit 0\n")
        opener.chmod(0o755)
        self.environment["PATH"] = ":".join(map(str, (tools, pathlib.Path(program.SLIPSTACK).parent, pathlib.Path(fixtures.PYTHON).parent,
                                                      self.environment["PATH"])))
        if (BUILD / "python").is_dir():
            self.environment["PYTHONPATH"] = str(BUILD / "python")
        return self

    def __exit__(self, *_):
        self.end_services()
        shutil.rmtree(self.here, ignore_errors=True)

    # --- what a command needs ---

    def provide(self, text):
        """The files that are named and not there; those that a command itself writes are left to it."""
        written = set(files_written(shlex.split(text, comments=True))) if "\n" not in text else set()
        table = {**fixtures.FILES, **fixtures.FILES_OF_PAGES.get(self.page, {})}
        if "logs/*.csv" in text:
            text += " logs/monday.csv"
        for name in NAMES.findall(text):
            path = self.here / name
            if name in table and name not in written and not path.exists():
                path.parent.mkdir(parents=True, exist_ok=True)
                table[name](path)

    def as_typed(self, command):
        text = command.text
        for pattern, replacement in fixtures.STANDS_FOR.items():
            text = re.sub(pattern, replacement, text)
        pattern, options = fixtures.LEFT_OUT.get(self.page, ("$^", ""))
        if re.match(pattern, text):
            text += options
        return text

    # --- what lasts ---

    def start(self, text):
        """`slipstack serve` and `slipstack node` go on until they are ended."""
        words = shlex.split(re.sub(r"\s*&$", "", text), comments=True)
        name = words[1]
        self.end_services(name)
        started = subprocess.Popen([program.SLIPSTACK, *words[1:]], cwd=self.here, env=self.environment, text=True,
                                   stdout=subprocess.PIPE if name == "serve" else subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.services.append((name, started))
        if name == "serve":
            address = started.stdout.readline().strip()
            if not re.fullmatch(r"http://127\.0\.0\.1:\d+/#token=\w+", address):
                return address + started.stderr.read(), "prints no address"
            with urllib.request.urlopen(address, timeout=PATIENCE_S) as answer:
                return address, "" if answer.status == 200 and b"<html" in answer.read() else "serves no page"
        for _ in range(60):
            done = self.shell("slipstack status --can vcan0 --node 5")
            if done.returncode == 0 or started.poll() is not None:
                break
            time.sleep(0.2)
        return done.stdout + done.stderr, "" if done.returncode == 0 and started.poll() is None else "no node answers"

    def end_services(self, name=None):
        """Each ends with 0 by Ctrl-C."""
        for service in [one for one in self.services if name in (None, one[0])]:
            self.services.remove(service)
            service[1].send_signal(signal.SIGINT)
            _, errors = service[1].communicate(timeout=PATIENCE_S)
            if service[1].returncode != 0:
                raise RuntimeError(f"slipstack {service[0]} ends with {service[1].returncode}: {errors}")

    def begin(self, text, file):
        """A command of minutes until its first stages are done, and then Ctrl-C."""
        folder = self.here / re.search(r"--out (\S+)", text)[1]
        before = (folder / file).read_bytes() if (folder / file).exists() else b""
        started = subprocess.Popen(["bash", "-c", f"exec {text}"], cwd=self.here, env=self.environment, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        deadline = time.monotonic() + PATIENCE_S

        def begun():
            return (folder / file).exists() and (folder / file).read_bytes() not in (b"", before)

        while time.monotonic() < deadline and started.poll() is None and not begun():
            time.sleep(0.2)
        went_on = started.poll() is None and begun()
        started.send_signal(signal.SIGINT)
        output, _ = started.communicate(timeout=PATIENCE_S)
        self.shell("slipstack object --can vcan0 --node 5 reset")  # what is ended so may leave the drive enabled
        return output, "" if went_on else f"{folder / file} did not come"

    # --- typing ---

    def shell(self, text):
        """In bash, whose variables go on to the next command."""
        kept = self.here / ".environment"
        script = f"set -o pipefail\n{text}\nstatus=$?\nenv -0 > {shlex.quote(str(kept))}\nexit $status"
        # Into files: what goes on in the background holds nothing up.
        with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
            done = subprocess.run(["bash", "-c", script], cwd=self.here, env=self.environment, stdout=output, stderr=errors,
                                  stdin=subprocess.DEVNULL, timeout=PATIENCE_S)
            for file in (output, errors):
                file.seek(0)
            done.stdout, done.stderr = output.read(), errors.read()
        if kept.exists():
            self.environment = dict(entry.split("=", 1) for entry in kept.read_text().split("\0") if "=" in entry)
            kept.unlink()
        return done

    def type(self, command):
        entry = not_typed(command)
        if self.page in fixtures.PAGES_OF_OTHER_TESTS:
            entry = fixtures.NotTyped("", "the whole page", fixtures.PAGES_OF_OTHER_TESTS[self.page])
        if entry:
            command.outcome, command.why = "not typed", entry.reason + (f" ({entry.test})" if entry.test else "")
            return
        began = time.monotonic()
        try:
            getattr(self, f"do_{command.kind}")(command)
        except fixtures.Absent as reason:
            command.outcome, command.why = "skipped", str(reason)
        except (subprocess.TimeoutExpired, subprocess.CalledProcessError, OSError, RuntimeError) as error:
            command.outcome, command.why = "failed", f"{error} {getattr(error, 'stderr', '')}"
        command.seconds = time.monotonic() - began

    def fail(self, command, why):
        command.outcome, command.why = "failed", why

    def do_typed(self, command):
        text = self.as_typed(command)
        words = shlex.split(text, comments=True) if "\n" not in text else []
        if "can0" in text and not self.bus:
            self.not_written |= dict.fromkeys(files_written(words), "no CAN bus here")
            raise fixtures.Absent("no CAN bus here")
        for word in words:
            if word in self.not_written and not (self.here / word).exists():
                raise fixtures.Absent(f"{word} was not written: {self.not_written[word]}")
        if "-M mps2" in text or "--board mps2" in text:
            self.need("qemu-system-arm", "build/cortex-m4/bin/slipstack-mps2-an386.elf")
        if text.startswith(("candump", "cansend", "mpirun", "octave", "qemu-system-arm")):
            self.need(text.split()[0])
        if text.startswith("chrt") and self.shell("chrt -r 10 true").returncode != 0:
            raise fixtures.Absent("this user may not have a real-time priority")
        self.provide(text)
        if re.search(r"can0|^cansend", text) and not re.match("slipstack node", text) and not any(name == "node" for name, _ in self.services):
            self.start(fixtures.NODE)
        if "can0" in text and self.page in fixtures.BEFORE:
            self.end_services("node")
            self.start(fixtures.NODE)
        for before in fixtures.BEFORE.get(self.page, ()) if "can0" in text else ():
            done = self.shell(before)
            if done.returncode != 0:
                return self.fail(command, f"{before}: {done.stderr}")
        if re.match("slipstack (serve|node)( |$)", text) and "--help" not in text:
            command.output, why = self.start(text)
            return self.fail(command, why) if why else None
        for pattern, (file, reason) in fixtures.BEGUN.items():
            if re.fullmatch(pattern, text):
                command.output, why = self.begin(text, file)
                command.why = f"begun only: {reason}"
                return self.fail(command, f"{why}: {command.output}") if why else None
        done = self.shell(text)
        command.output = done.stdout + done.stderr
        refused = command.shown[:1] and re.match(r"slipstack: |toolchain/", command.shown[0])
        if done.returncode != (2 if refused else 0):
            return self.fail(command, f"status {done.returncode}: {command.output[-1500:]}")
        missing = [name for name in files_written(shlex.split(text, comments=True)) if not self.is_written(self.here / name)]
        if missing:
            self.fail(command, f"not written, or without rows: {missing}")

    @staticmethod
    def is_written(path):
        """Whether a file or folder is there, and something in it: of a table rows, of a result what its schema says."""
        if path.suffix == ".json" and path.is_file():
            try:
                program.published(path.read_text())
            except (AssertionError, KeyError, ValueError) as error:
                raise RuntimeError(f"{path.name}: {error}") from error
        if path.suffix == ".csv" and path.is_file():
            return sum(line[:1].isdigit() for line in path.read_text().splitlines()) > 10
        return path.is_dir() or path.is_file() and path.stat().st_size > 0

    def need(self, *names):
        for name in names:
            if not ((self.here / name).exists() if "/" in name else shutil.which(name)):
                raise fixtures.Absent(f"{name} is not there")

    def do_mentioned(self, command):
        """The command and the options that a sentence names are in its help."""
        words = command.text.rstrip(",").split()
        name = [word for word in words if not word.startswith("-")]
        if words[0] == "mpirun":
            self.need("mpirun")
        done = self.shell(shlex.join([*(words[:3] if words[0] == "python3" else name), "--help"]))
        command.output = done.stdout + done.stderr
        missing = [word for word in words[1:] if word.startswith("--") and word not in command.output and words[0] != "mpirun"]
        if done.returncode != 0 or missing:
            self.fail(command, f"status {done.returncode}, not in its help: {missing}")

    def do_test_program(self, command):
        """A program of the tests, minutes long: it is there, and a filter selects some of its tests."""
        name, *options = shlex.split(re.sub(r"^(\w+=\S+ )+", "", command.text))
        path = BUILD / "bin" / pathlib.Path(name).name
        if not path.exists():
            raise fixtures.Absent(f"{path.name} is not built")
        chosen = [option for option in options if option.startswith("--gtest_filter")]
        done = subprocess.run([path, "--gtest_list_tests", *chosen], capture_output=True, text=True, timeout=PATIENCE_S)
        if chosen and (done.returncode != 0 or "\n  " not in done.stdout):
            self.fail(command, "selects no test")

    def do_script(self, command):
        """A bench of minutes: it is there and has the options."""
        name, *options = shlex.split(command.text)
        text = (self.here / name).read_text()
        missing = [option for option in options if option.startswith("--") and option not in text]
        if missing:
            self.fail(command, f"has no option {missing}")

    def do_ctest(self, command):
        """CTest itself runs it; here only whether it selects anything (typed_page_test.py)."""

    def once(self, command, kind):
        """All blocks of a page in a language of its own are one session, typed where the first stands."""
        blocks = [block for block in commands(self.page)[0] if block.kind == kind]
        return None if blocks[0] is not command else "\n".join([block.text for block in blocks] + [fixtures.ASKED.get(self.page, "")])

    def do_python(self, command):
        text = self.once(command, "python")
        if text is None:
            return
        if not (BUILD / "python").is_dir():
            raise fixtures.Absent("the package slipstack was not built")
        for module in re.findall(r"^import (\w+)", text, re.MULTILINE):
            if module != "slipstack" and self.shell(f"python3 -c 'import {module}'").returncode != 0:
                raise fixtures.Absent(f"python3-{module} is not installed")
        self.provide(text)
        self.run_script(command, "page.py", text, "python3 -B page.py")

    def do_matlab(self, command):
        text = self.once(command, "matlab")
        if text is None:
            return
        self.need("octave-cli")
        self.provide(re.sub(r"fopen\('[^']*', 'w'\)", "", text))
        self.run_script(command, "page.m", text, "octave-cli --no-init-file --no-history page.m")

    def run_script(self, command, name, text, line):
        (self.here / name).write_text(text)
        done = self.shell(line)
        command.output = done.stdout + done.stderr
        if done.returncode != 0:
            self.fail(command, f"status {done.returncode}: {command.output[-1500:]}")

    def do_c(self, command):
        """The statements of a page about a header, in a program; what they name and do not declare is the caller's."""
        includes = [line for line in command.text.splitlines() if line.startswith("#include")]
        statements = [line for line in command.text.splitlines() if not line.startswith("#include")]
        declared = "".join(f"static float {name};\n" for name in
                           ("time_s", "position_m", "velocity_mps", "acceleration_mps2", "force_N")) + "static int position_steps;\n"
        (self.here / "page.c").write_text("\n".join([*includes, declared, "int main(void) {", *statements, "return force_N != force_N;", "}"]))
        done = self.shell("cc -std=c99 -Wall -Wextra -Werror page.c -o page && ./page")
        if done.returncode != 0:
            self.fail(command, done.stderr)

    def do_cmake(self, command):
        """The lines of a page in the build of a program that includes what its C++ block includes."""
        place = self.here / "user"
        place.mkdir()
        block, = [block for block in commands(self.page)[1] if block.language == "cpp"]
        (place / "main.cpp").write_text(block.text + "\nint main() { slipstack::FrictionModel<float> model; return model.force().total_N != 0.0f; }\n")
        package, *rest = command.text.splitlines()
        (place / "CMakeLists.txt").write_text("\n".join(["cmake_minimum_required(VERSION 3.25)", "project(user LANGUAGES CXX)", package,
                                                         "add_executable(my_firmware main.cpp)", *rest]))
        done = self.shell(f"cmake -S user -B user/build -DCMAKE_PREFIX_PATH={self.here}/installed/usr/local && cmake --build user/build && user/build/my_firmware")
        command.output = done.stdout + done.stderr
        if done.returncode != 0:
            self.fail(command, command.output)
