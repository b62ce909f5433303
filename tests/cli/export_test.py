#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`slipstack export` as a user types it: the header, standard output, and what is refused in one line."""

import pathlib
import shutil
import subprocess
import tempfile
import unittest

import program

MODEL = """format = 'slipstack model 1'
[source]
log = 'log.csv'
samples = 1000
holdout_rmse_N = 0.1
noise_floor_N = 0.1
relative_error = 0.01
{effects}
[target]
holdout_rmse_N = 0.1
{target}"""
EFFECT = """
[[{under}effect]]
id = '{id}'
"""
VALUE = """
    [[{under}effect.{kind}]]
    name = '{name}'
    unit = '{unit}'
    value = {value}
    standard_error = 0.0
"""


def model_file(*effects):
    """The text of a model of (id, [(kind, name, unit, value)...])."""
    texts = {}
    for under in ("", "target."):
        texts[under] = ""
        for identity, values in effects:
            texts[under] += EFFECT.format(under=under, id=identity)
            for kind, name, unit, value in values:
                texts[under] += VALUE.format(under=under, kind=kind, name=name, unit=unit, value=value)
    return MODEL.format(effects=texts[""], target=texts["target."])


VISCOUS = ("viscous", [("gain", "viscous", "N s/m", 5.5)])
HYSTERESIS = ("presliding_hysteresis", [("shape", "slip_distance", "rad", 0.01), ("gain", "stiffness", "N m/rad", 200.0)])
RESONANCE = ("structural_resonance", [("gain", "modal_mass", "kg", 1.5), ("gain", "modal_damping_mass", "kg", 0.0),
                                      ("gain", "rigid_mass", "kg", 0.0), ("shape", "frequency", "Hz", 40.0),
                                      ("shape", "damping", "1", 0.02)])


class Export(unittest.TestCase):
    def setUp(self):
        self.here = pathlib.Path(tempfile.mkdtemp(prefix="slipstack-test-"))
        self.addCleanup(shutil.rmtree, self.here)
        pathlib.Path(self.here, "axis.toml").write_text(model_file(VISCOUS))
        pathlib.Path(self.here, "arm.toml").write_text(model_file(VISCOUS, RESONANCE))

    def export(self, *arguments):
        return program.run("export", *arguments, cwd=self.here)

    def test_a_program_in_c_uses_it(self):
        done = self.export("axis.toml", "--c", "friction.h")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(b"friction_init() and friction_step()", done.stdout)
        if shutil.which("cc") is None:
            self.skipTest("cc is not installed")
        pathlib.Path(self.here, "main.c").write_text(
            '#include <stdio.h>\n#include "friction.h"\nint main(void) {\n  friction_motion motion = {0};\n'
            "  friction_state state;\n  motion.velocity_mps = 2.0F;\n  friction_init(&state, &motion);\n"
            '  printf("%g\\n", (double)friction_step(&state, &motion));\n  return 0;\n}\n')
        subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "main.c", "-o", "main"], cwd=self.here, check=True)
        printed = subprocess.run([pathlib.Path(self.here, "main")], capture_output=True, text=True, check=True).stdout
        self.assertEqual(printed, "11\n")

    def test_standard_output_is_the_file(self):
        self.assertEqual(self.export("axis.toml", "--c", "friction.h").returncode, 0)
        done = self.export("axis.toml", "--c", "-")
        self.assertEqual(done.stdout.decode(), pathlib.Path(self.here, "friction.h").read_text())

    def test_names_and_precision(self):
        text = self.export("axis.toml", "--c", "-", "--scalar", "double", "--name", "x_axis").stdout.decode()
        self.assertIn("static inline double x_axis_step(x_axis_state *state, const x_axis_motion *motion)", text)
        self.assertNotIn("float", text)
        self.assertNotIn("@", text)

    def test_a_rotary_axis_has_angles_and_torques(self):
        rotary = model_file(("viscous", [("gain", "viscous", "N m s/rad", 5.5)]), HYSTERESIS)
        pathlib.Path(self.here, "joint.toml").write_text("axis = 'rotary'\n" + rotary.replace("rmse_N ", "rmse_Nm ").replace("floor_N ", "floor_Nm "))
        done = self.export("joint.toml", "--c", "joint.h", "--name", "joint")
        self.assertEqual(done.returncode, 0, done.stderr)
        header = pathlib.Path(self.here, "joint.h").read_text()
        self.assertIn("JOINT_STEP_RAD", header)
        self.assertIn("the torque in N m", header)
        if shutil.which("cc") is None:
            self.skipTest("cc is not installed")
        pathlib.Path(self.here, "main.c").write_text(
            '#include <stdio.h>\n#include "joint.h"\nint main(void) {\n  joint_motion motion = {0};\n'
            "  joint_state state;\n  motion.velocity_radps = 2.0F;\n  joint_init(&state, &motion);\n"
            "  motion.position_steps = (int)(0.001F / JOINT_STEP_RAD);\n"
            '  printf("%.3g\\n", (double)joint_step(&state, &motion));\n'
            '  return state.torque_Nm == joint_step(&state, &motion) ? 0 : 1;\n}\n')
        subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "main.c", "-o", "main"], cwd=self.here, check=True)
        printed = subprocess.run([pathlib.Path(self.here, "main")], capture_output=True, text=True, check=True).stdout
        self.assertEqual(printed, "11.2\n")  # 5.5 N m s/rad at 2 rad/s, and a spring of 200 N m/rad over 1 mrad

    def test_what_is_refused(self):
        for arguments, what in (
                (("axis.toml",), "--c is required"),
                (("axis.toml", "--c", "f.h", "--name", "1x"), "--name '1x': give a letter"),
                (("axis.toml", "--c", "f.h", "--scalar", "half"), "--scalar"),
                (("axis.toml", "--c", "f.h", "--scalar", "double", "--step", "1e-6"), "--step: only of --scalar float"),
                (("axis.toml", "--c", "axis.toml"), "axis.toml"),
                (("none.toml", "--c", "f.h"), "none.toml"),
                (("arm.toml", "--c", "f.h"), "arm.toml: an effect of this model goes on from tick to tick; give --rate"),
                (("arm.toml", "--c", "nowhere/f.h", "--rate", "1e4"), "nowhere/f.h")):
            with self.subTest(arguments):
                done = self.export(*arguments)
                self.assertEqual(done.returncode, 2, done)
                self.assertEqual(done.stderr.count(b"\n"), 1, done.stderr)
                self.assertIn(what, done.stderr.decode())
                self.assertEqual(done.stdout, b"")
                self.assertFalse(pathlib.Path(self.here, "f.h").exists())
        self.assertEqual(self.export("arm.toml", "--c", "f.h", "--rate", "1e4").returncode, 0)


if __name__ == "__main__":
    program.main()
