#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The friction core as other programs take it: installed into a prefix and found there, or added as a folder; the
examples of docs/examples on the host and in the emulator print the same forces."""

import pathlib
import shutil
import subprocess
import tempfile
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = REPOSITORY / "docs" / "examples"
TARGET_TOOLS = ("arm-none-eabi-g++", "qemu-system-arm")


class UseLibrary(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.here = pathlib.Path(cls.folder.name)
        cls.prefix = cls.here / "prefix"
        # No compiler and no package is looked for: the paths are wrong on purpose.
        cls.run_command("cmake", "-S", REPOSITORY, "-B", cls.here / "library", "-DSLIPSTACK_LIBRARY_ONLY=ON",
                        "-DCMAKE_CXX_COMPILER=/nowhere/c++")
        cls.run_command("cmake", "--install", cls.here / "library", "--prefix", cls.prefix)

    @staticmethod
    def run_command(*command):
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode != 0:
            raise AssertionError(f"{command}:\n{done.stdout}{done.stderr}")
        return done.stdout

    def build(self, source, name, *options):
        self.run_command("cmake", "-S", source, "-B", self.here / name, *options)
        self.run_command("cmake", "--build", self.here / name)
        return self.here / name

    def host_forces(self):
        if not hasattr(UseLibrary, "forces"):
            build = self.build(EXAMPLES / "host", "host", f"-DCMAKE_PREFIX_PATH={self.prefix}")
            UseLibrary.forces = self.run_command(build / "friction_example").split()
        return UseLibrary.forces

    def test_installed_and_found(self):
        forces = [int(word) for word in self.host_forces()]
        self.assertEqual(len(forces), 200)
        # Back and forth in 100 ticks: the way back repeats itself, the way there begins on the virgin curve only once.
        self.assertEqual(forces[150:200], forces[50:100])
        self.assertNotEqual(forces[100:150], forces[0:50])
        self.assertGreater(max(forces), 1000)
        self.assertLess(min(forces), -1000)

    def test_headers_of_an_installation_include_nothing_outside_it(self):
        source = self.here / "alone.cpp"
        source.write_text("#include <slipstack/friction.h>\nstatic_assert(SLIPSTACK_FRICTION_VERSION >= 100);\n"
                          "int main() { slipstack::FrictionModel<double> model; return model.force().total_N != 0.0; }\n")
        include = self.prefix / "include"
        self.run_command("c++", "-std=c++20", "-Wall", "-Wextra", "-Werror", f"-I{include}", f"-I{include}/slipstack",
                         "-fsyntax-only", source)

    def test_another_version_is_refused(self):
        source = self.here / "version"
        source.mkdir()
        (source / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(version LANGUAGES CXX)\nfind_package(slipstack 99 REQUIRED)\n")
        done = subprocess.run(["cmake", "-S", source, "-B", self.here / "refused", f"-DCMAKE_PREFIX_PATH={self.prefix}"],
                              capture_output=True, text=True)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("compatible with requested version \"99\"", " ".join(done.stderr.split()))

    def test_the_target_prints_what_the_host_prints(self):
        for tool in TARGET_TOOLS:
            if shutil.which(tool) is None:
                self.skipTest(f"{tool} is not installed")
        build = self.build(EXAMPLES / "cortex_m", "target",
                           f"-DCMAKE_TOOLCHAIN_FILE={EXAMPLES / 'cortex_m' / 'toolchain.cmake'}")
        printed = self.run_command("timeout", "60", "qemu-system-arm", "-M", "mps2-an386", "-display", "none",
                                   "-monitor", "none", "-serial", "stdio", "-semihosting",
                                   "-kernel", build / "friction_example.elf")
        self.assertEqual(printed.split(), self.host_forces())


if __name__ == "__main__":
    unittest.main()
