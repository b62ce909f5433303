#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Man pages and completions say what --help says: every command has a page with all its options and their texts, and bash
and zsh complete them."""

import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import program

SIMULATOR = program.SLIPSTACK_SIM


def help_of(words):
    """What --help prints: the options that it lists, and the commands below."""
    executable = {"slipstack": program.SLIPSTACK, "slipstack-sim": SIMULATOR}[words[0]]
    done = subprocess.run([executable, *words[1:], "--help"], capture_output=True, text=True, check=True)
    return done.stdout


def options_of(text):
    """Long and short options at the begin of the lines of a help text, of the command itself."""
    own = text.split("Subcommands:")[0].split("SUBCOMMANDS:")[0]
    found = set()
    for line in own.splitlines():
        if match := re.match(r"  (-\S+)", line):
            found.update(match.group(1).rstrip(",").split(","))
    return found


def commands_of(text):
    below = text.split("Subcommands:")
    if len(below) < 2:
        return []
    return re.findall(r"^  (\w[\w-]*) ", below[1].split("\n\n")[0], re.MULTILINE)


class Manual(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="slipstack-manual-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.pages = cls.folder / "man"
        done = program.run("manual", cls.pages, cwd=cls.folder)
        if done.returncode != 0:
            raise RuntimeError(done.stderr.decode())
        cls.commands = {("slipstack",): help_of(["slipstack"])}
        waiting = [("slipstack",)]
        while waiting:
            path = waiting.pop()
            for name in commands_of(cls.commands[path]):
                cls.commands[path + (name,)] = help_of(path + (name,))
                waiting.append(path + (name,))
        for shell in ("bash", "zsh"):
            done = program.run("completion", shell, cwd=cls.folder)
            (cls.folder / shell).write_bytes(done.stdout)

    def test_help_was_understood(self):
        self.assertGreater(len(self.commands), 25)
        self.assertIn(("slipstack", "experiment", "plan"), self.commands)
        self.assertIn("--stepwise", options_of(self.commands["slipstack", "diagnose"]))

    def test_one_page_for_each_command(self):
        expected = {"-".join(path) + ".1" for path in self.commands}
        expected |= {"slipstack-sim.1", "slipstack-sim-log.1", "slipstack-sim-effects.1"}
        self.assertEqual({page.name for page in self.pages.iterdir()}, expected)

    def shown(self, path):
        """The page as man shows it, in one line without its breaks."""
        page = (self.pages / ("-".join(path) + ".1")).read_text()
        return re.sub(r"\s+", " ", subprocess.run(["man", "--nh", "--nj", "-l", "-"], input=page, env={"MANWIDTH": "400", "LANG": "C.UTF-8",
                      "PATH": "/usr/bin:/bin"}, capture_output=True, text=True, check=True).stdout)

    def test_pages_say_what_help_says(self):
        if not shutil.which("man"):
            self.skipTest("man is not installed (man-db)")
        for path, text in self.commands.items():
            page = self.shown(path)
            for option in options_of(text):
                self.assertIn(option, page, path)
            # The texts of the options, word for word.
            for line in re.findall(r"^  +-\S+.*?  (\w.{20,})$", text, re.MULTILINE):
                self.assertIn(re.sub(r"\s+", " ", line.strip()), page, path)

    def test_pages_are_without_fault(self):
        if not shutil.which("groff"):
            self.skipTest("groff is not installed")
        for page in sorted(self.pages.iterdir()):
            done = subprocess.run(["groff", "-man", "-Kutf8", "-Tutf8", "-ww", "-z", str(page)], capture_output=True, text=True)
            # "-ww" tells of everything; words that cannot be broken are no fault.
            faults = [line for line in done.stderr.splitlines() if "break" not in line and "adjust" not in line]
            self.assertEqual(faults, [], page.name)

    def completed(self, line):
        """What bash offers behind a line, by the function that it would call."""
        words = line.split(" ")
        quoted = " ".join("'" + word.replace("'", "'\\''") + "'" for word in words)
        script = (f". {self.folder / 'bash'}; COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; _slipstack; "
                  "printf '%s\\n' \"${COMPREPLY[@]}\"")
        done = subprocess.run(["bash", "-uc", script], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.stderr, "", line)
        return set(done.stdout.split())

    def test_bash_completes_commands_and_options(self):
        for path, text in self.commands.items():
            line = " ".join(path)
            self.assertEqual(self.completed(line + " -"), options_of(text), line)
            below = commands_of(text)
            if below:
                self.assertEqual(self.completed(line + " "), set(below), line)

    def test_bash_completes_values(self):
        (self.folder / "files").mkdir(exist_ok=True)
        (self.folder / "files/axis.toml").touch()
        self.assertEqual(self.completed("slipstack fit log.csv --criterion "), {"force", "simulation"})
        self.assertEqual(self.completed("slipstack compare log.csv --model files/a"), {"files/axis.toml"})
        self.assertEqual(self.completed("slipstack compare files/"), {"files/axis.toml"})
        self.assertEqual(self.completed("slipstack serve --session fil"), {"files"})
        self.assertEqual(self.completed("slipstack add log.csv --effect visc"), {"viscous"})
        self.assertEqual(self.completed("slipstack fit --effects inertia,visc"), {"inertia,viscous"})
        self.assertEqual(self.completed("slipstack fit --horizon "), set(), "a number cannot be guessed")
        self.assertIn("files", self.completed("slipstack diagnose --stepwise "), "a flag takes no value")

    def test_zsh_completes(self):
        if not shutil.which("zsh"):
            self.skipTest("zsh is not installed (toolchain/install full)")
        script = f"""
autoload -Uz compinit; compinit -u -D
. {self.folder / 'zsh'}
_arguments() {{ print -rl -- "$@" >> {self.folder / 'specifications'} }}
_slipstack_diagnose
(( ${{+functions[_slipstack_experiment_plan]}} )) && print defined $_comps[slipstack]
"""
        done = subprocess.run(["zsh", "-f"], input=script, capture_output=True, text=True, cwd=self.folder)
        self.assertEqual((done.stdout, done.stderr), ("defined _slipstack\n", ""))
        specifications = (self.folder / "specifications").read_text()
        for option in options_of(self.commands["slipstack", "diagnose"]):
            self.assertIn(f"{option}[", specifications)
        self.assertRegex(specifications, r"(?m)^--model\[.*\]:FILE:_files$")
        self.assertRegex(specifications, r"(?m)^--stepwise\[[^]]*\]$")

    def test_wrong_use(self):
        for arguments in (["completion", "fish"], ["completion"], ["manual"], ["manual", ""], ["manual", "/dev/null/x"]):
            done = program.run(*arguments, cwd=self.folder)
            self.assertEqual(done.returncode, 2, arguments)
            self.assertEqual(done.stderr.count(b"\n"), 1)


if __name__ == "__main__":
    program.main()
