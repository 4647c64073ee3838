# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Python package share."""
import os
import subprocess

import numpy as np
import ovoid
import pytest

PROGRAM = os.environ["OVOID_PROGRAM"]
SMALL = {"size": (96, 72)}


def bumps(dims=(20, 24, 28), dtype="u1"):
    """A field (z, y, x) that has no symmetry, so that an axis in the wrong place shows."""
    z, y, x = np.meshgrid(*(np.linspace(0, 1, n) for n in dims), indexing="ij")
    field = np.exp(-20 * ((x - 0.3) ** 2 + (y - 0.5) ** 2 + (z - 0.6) ** 2)) + 0.6 * np.exp(-40 * ((x - 0.8) ** 2 + (y - 0.7) ** 2 + (z - 0.2) ** 2))
    return (field * (200 if np.dtype(dtype).kind != "f" else 1)).astype(dtype)


def drawn_by_program(path, *flags):
    """The bytes of the program's picture of a file."""
    output = str(path) + ".program.png"
    subprocess.run([PROGRAM, "render", str(path), *flags, "-o", output], check=True, capture_output=True)
    with open(output, "rb") as file:
        return file.read()


def png(picture):
    return picture._repr_png_()


@pytest.fixture
def array():
    return bumps()


@pytest.fixture
def expected(array):
    """The picture of `array`, as the others shall be."""
    return ovoid.render(array, **SMALL).numpy()
