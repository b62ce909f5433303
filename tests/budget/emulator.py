# SPDX-License-Identifier: Apache-2.0
"""Runs an image in the emulator; used by the checks beside it."""

import pathlib
import shutil
import subprocess
import sys

SKIP = 77  # ctest's SKIP_RETURN_CODE
QEMU = "qemu-system-arm"
TIMEOUT_S = 300
PACKAGES = {
    QEMU: "package qemu-system-arm",
    "arm-none-eabi-g++": "packages gcc-arm-none-eabi, libstdc++-arm-none-eabi-newlib",
    "arm-none-eabi-nm": "package binutils-arm-none-eabi",
    "arm-none-eabi-objdump": "package binutils-arm-none-eabi",
}


def skip(reason):
    print(f"SKIP: {reason}")
    sys.exit(SKIP)


def fail(reason):
    print(f"FAIL: {reason}")
    sys.exit(1)


def require_tool(tool):
    """Ends with SKIP unless this program of the cross tools, or the emulator, is installed."""
    if shutil.which(tool) is None:
        skip(f"{tool} is not installed ({PACKAGES[tool]})")


def require(image):
    """Ends with SKIP unless the emulator and the image are there."""
    require_tool(QEMU)
    if not pathlib.Path(image).is_file():
        require_tool("arm-none-eabi-g++")
        fail(f"{image} is missing: cmake --preset cortex-m4 && cmake --build --preset cortex-m4")


def start(image, arguments=()):
    """The finished process of the emulator; ends with FAIL if the image does not end."""
    semihosting = ["enable=on", "target=native", "arg=image", *(f"arg={a}" for a in arguments)]
    command = [
        QEMU, "-M", "mps2-an386", "-icount", "shift=10", "-display", "none", "-monitor", "none",
        "-serial", "stdio", "-semihosting-config", ",".join(semihosting), "-kernel", str(image),
    ]  # fmt: skip
    try:
        return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        fail(f"{image} did not end within {TIMEOUT_S} s")


def run(image, arguments=()):
    """Output lines of the image, run to its end; ends with FAIL if its status is not 0."""
    done = start(image, arguments)
    if done.returncode != 0:
        print(done.stdout[-2000:] + done.stderr[-2000:])
        fail(f"{image} ended with status {done.returncode}")
    return done.stdout.splitlines()
