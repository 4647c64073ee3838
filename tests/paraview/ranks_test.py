# SPDX-License-Identifier: Apache-2.0
"""One picture of one process and of several: pvbatch ranks_test.py OvoidVolume.so FOLDER [REPRESENTATION [FOLDER_OF_PICTURES]]. A single
process keeps its pictures in FOLDER, several compare theirs with these. Fails if a box's picture does not join to the next one's: if
ranks place their sheets by their own data, leave out neighbours' samples, or are composited in the wrong order. FOLDER holds
adaptive.vthb (adaptive_grid.py)."""
import os
import sys

import numpy as np
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

SIZE = 200
# Of 255. A rank's picture is rounded to 8 bits, and so is each step of the compositor, which rounds down: 1 for each of up to three.
BOUND = 3


def wavelet():
    source = simple.Wavelet()
    source.WholeExtent = [-12, 12] * 3
    return source


def cells(source):
    return simple.PointDatatoCellData(Input=source)


def jittered_points():
    centers = simple.CellCenters(Input=cells(wavelet()))
    centers.VertexCells = 1
    moved = simple.Calculator(Input=centers)
    moved.CoordinateResults = 1
    moved.Function = ("(coordsX+0.3*sin(7*coordsY+3*coordsZ))*iHat+(coordsY+0.3*sin(5*coordsZ+2*coordsX))*jHat"
                      "+(coordsZ+0.3*sin(11*coordsX+coordsY))*kHat")
    return moved


def adaptive(folder):
    reader = simple.XMLUniformGridAMRReader(FileName=[os.path.join(folder, "adaptive.vthb")])
    reader.CellArrayStatus = ["RTData"]
    reader.DefaultNumberOfLevels = 0
    return reader


def pictures(folder, plugin, representation, out):
    """The data's kinds, and what their pictures are called."""
    simple.LoadPlugin(plugin, remote=False, ns=globals())
    scenes = {"image": (wavelet(), "POINTS"), "mesh": (simple.Tetrahedralize(Input=wavelet()), "POINTS"),
              "boxes": (simple.AppendDatasets(Input=[cells(wavelet())]), "CELLS"), "points": (jittered_points(), "POINTS"),
              "adaptive": (adaptive(folder), "CELLS")}
    names = {}
    for kind, (source, place) in scenes.items():
        view = simple.CreateView("RenderView")
        view.ViewSize = [SIZE, SIZE]
        view.UseColorPaletteForBackground = 0
        view.Background = [0, 0, 0]
        view.OrientationAxesVisibility = 0
        view.UseFXAA = 0  # of one process alone, and blurs outlines
        display = simple.Show(source, view)
        if representation not in display.GetProperty("Representation").Available:
            simple.Delete(view)
            continue
        simple.ColorBy(display, (place, "RTData"))
        display.SetRepresentationType(representation)
        display.RescaleTransferFunctionToDataRange(False)
        if hasattr(display, "OvoidImageSheets"):
            display.OvoidImageSheets = 1
        simple.Render(view)
        view.CameraFocalPoint = [0, 0, 0]
        view.CameraPosition = [50, 37, 58]
        view.CameraViewUp = [0, 1, 0]
        names[kind] = os.path.join(out, kind + ".png")
        simple.SaveScreenshot(names[kind], view, ImageResolution=[SIZE, SIZE])
        simple.Delete(view)
    return names


def pixels(name):
    reader = vtkPNGReader()
    reader.SetFileName(name)
    reader.Update()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())[:, :3].astype(int)


def main(plugin, folder, representation="Ovoid volume", pictures_folder=None):
    ranks = servermanager.vtkProcessModule.GetProcessModule().GetNumberOfLocalPartitions()
    out = os.path.join(pictures_folder or folder, str(ranks))
    os.makedirs(out, exist_ok=True)
    failures = 0
    for kind, name in pictures(folder, plugin, representation, out).items():
        alone = pixels(os.path.join(out, "..", "1", kind + ".png"))
        difference = np.abs(pixels(name) - alone).max(axis=1)
        beyond = (difference > BOUND).mean()
        print(f"{representation}, {kind}, {ranks} ranks: max {difference.max()}, over 1: {(difference > 1).mean():.2%}, "
              f"over {BOUND}: {beyond:.2%}", flush=True)
        failures += beyond > 0 or (alone.max(axis=1) > 20).mean() < 0.1
    return failures


if __name__ == "__main__":
    if main(*sys.argv[1:]) and sys.argv[3:4] != ["Volume"]:
        raise SystemExit("pictures differ")
