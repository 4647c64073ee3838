# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Python package share."""
import os
import subprocess

import numpy as np
import ovoid
import ovoid._data
import pytest

PROGRAM = os.environ["OVOID_PROGRAM"]
SMALL = {"size": (96, 72)}
FLAGS = ("--size", "96x72")  # the same


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


def data_of(data, **placement):
    return ovoid._data.data_of(data, **placement)


def pixels(data, **settings):
    return ovoid.render(data, **SMALL, **settings).numpy()


def heat_at(places):
    """No symmetry, so that a point in the wrong place shows."""
    return np.exp(-8 * ((places - [0.3, 0.5, 0.6]) ** 2).sum(-1)) + 0.6 * np.exp(-20 * ((places - [0.8, 0.7, 0.2]) ** 2).sum(-1))


def block(n=6):
    """Nodes of a bent cube, hexahedra between them by their nodes, and values of nodes."""
    z, y, x = np.meshgrid(*[np.linspace(0, 1, n)] * 3, indexing="ij")
    points = np.column_stack([(x + 0.2 * y * y).ravel(), y.ravel(), (z * (1 + x)).ravel()])
    first = np.arange(n**3).reshape(n, n, n)[:-1, :-1, :-1].reshape(-1, 1)
    return points, first + [0, 1, n + 1, n, n * n, n * n + 1, n * n + n + 1, n * n + n], heat_at(points)


@pytest.fixture
def array():
    return bumps()


@pytest.fixture
def expected(array):
    """The picture of `array`, as the others shall be."""
    return ovoid.render(array, **SMALL).numpy()
