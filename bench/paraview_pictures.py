# SPDX-License-Identifier: Apache-2.0
"""What several ranks change in a picture, side by side: paraview_pictures.py OUT.png [FOLDER]. Draws every kind of data in ParaView with
one process and with four, as "Volume" and as "Ovoid volume" (tests/paraview/run.sh ranks, which prints the numbers), keeps the pictures
in FOLDER, and puts them together: in rows both representations on four ranks, and then their differences from one rank, 40 times. Needs
the plugin that scripts/paraview.sh builds, and python3-vtk9."""
import os
import subprocess
import sys
import tempfile

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOImage import vtkPNGReader, vtkPNGWriter

KINDS = ("image", "mesh", "boxes", "adaptive", "points")
NAMES = ("Volume", "Ovoid volume")
ROOM = 4  # pixels between pictures
RUN = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "tests", "paraview", "run.sh")


def picture(path):
    """Rows from the bottom; None where there is none."""
    if not os.path.exists(path):
        return None
    reader = vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    width, height, _ = reader.GetOutput().GetDimensions()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(height, width, -1)[:, :, :3].astype(int)


def row(pictures):
    size = next(p.shape for p in pictures if p is not None)
    cells = [np.full(size, 255) if p is None else p for p in pictures]
    wide = [np.pad(cell, ((ROOM, 0), (ROOM, 0), (0, 0)), constant_values=255) for cell in cells]
    return np.concatenate(wide, axis=1)


def main(out, folder=None):
    folder = os.path.abspath(folder or tempfile.mkdtemp())
    of_four, differences = [], []
    for name in NAMES:
        kept = os.path.join(folder, name.replace(" ", "-"))
        subprocess.run([RUN, "ranks", name, kept], check=name != "Volume")
        four = [picture(os.path.join(kept, "4", kind + ".png")) for kind in KINDS]
        one = [picture(os.path.join(kept, "1", kind + ".png")) for kind in KINDS]
        of_four.append(row(four))
        differences.append(row([None if a is None or b is None else np.clip(40 * np.abs(a - b), 0, 255) for a, b in zip(four, one)]))
    pixels = np.concatenate((of_four + differences)[::-1]).astype(np.uint8)
    image = vtkImageData()
    image.SetDimensions(pixels.shape[1], pixels.shape[0], 1)
    image.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(pixels).reshape(-1, 3), deep=1))
    writer = vtkPNGWriter()
    writer.SetFileName(out)
    writer.SetInputData(image)
    writer.Write()


if __name__ == "__main__":
    main(*sys.argv[1:])
