#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The same data as ParaView 5.11 first shows them, drawn with VTK's Python packages: looks_peer.py OUT_FOLDER INPUT...

Grids as volumes (its colours cool to warm, its straight ramp of opacity from 0 to 1 over the range, its estimate of the unit distance, no
light), meshes as surfaces in those colours, particles as points; seen from +z with y up, all of the box in sight, on its gray-blue. Files
come from `ovoid convert`, so that both see the same numbers. Writes OUT_FOLDER/NUMBER.ppm, 1024 x 768, which scripts/contact_sheet.py takes.
Needs python3-vtk9 and a display (xvfb-run)."""
import json
import os
import subprocess
import sys
import tempfile

import vtk

from magnification import OVOID

SIZE = (1024, 768)


def cool_to_warm(lo, hi):
    colors = vtk.vtkColorTransferFunction()
    colors.SetVectorModeToMagnitude()
    colors.SetColorSpaceToDiverging()
    colors.AddRGBPoint(lo, 0.231373, 0.298039, 0.752941)
    colors.AddRGBPoint(hi, 0.705882, 0.0156863, 0.14902)
    return colors


def volume_of(path, lo, hi):
    reader = vtk.vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    image.GetPointData().SetActiveScalars(image.GetPointData().GetArrayName(0))
    mapper = vtk.vtkFixedPointVolumeRayCastMapper()
    mapper.SetInputData(image)
    opacity = vtk.vtkPiecewiseFunction()
    opacity.AddPoint(lo, 0)
    opacity.AddPoint(hi, 1)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.GetProperty().SetColor(cool_to_warm(lo, hi))
    volume.GetProperty().SetScalarOpacity(opacity)
    volume.GetProperty().SetInterpolationTypeToLinear()
    volume.GetProperty().SetScalarOpacityUnitDistance(image.GetLength() / max(1, image.GetNumberOfCells()) ** (1 / 3))
    return volume


def surface_of(path, array, lo, hi):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputData(grid)
    if grid.GetCellData().HasArray(array):
        mapper.SetScalarModeToUseCellFieldData()
    else:
        mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray(array)
    return colored(mapper, lo, hi)


def points_of(path):
    reader = vtk.vtkDelimitedTextReader()
    reader.SetFileName(path)
    reader.SetHaveHeaders(True)
    reader.DetectNumericColumnsOn()
    table = vtk.vtkTableToPolyData()
    table.SetInputConnection(reader.GetOutputPort())
    table.SetXColumnIndex(0)
    table.SetYColumnIndex(1)
    table.SetZColumnIndex(2)
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(table.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetPointSize(2)
    return actor


def colored(mapper, lo, hi):
    mapper.SetLookupTable(cool_to_warm(lo, hi))
    mapper.SetScalarRange(lo, hi)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    return actor


def prop_of(inputs, folder):
    facts = json.loads(subprocess.run([OVOID, "info", "--json", *inputs], check=True, capture_output=True, text=True).stdout)
    ending = {"lattice": "vti", "mesh": "vtu", "boxes": "vti"}.get(facts["kind"], "csv")
    path = os.path.join(folder, "data." + ending)
    words = ["--size", "128"] if facts["kind"] == "boxes" else []
    subprocess.run([OVOID, "convert", *inputs, "-o", path, *words], check=True, stderr=subprocess.DEVNULL)
    lo, hi = facts["field"]["range"]
    if ending == "vti":
        return volume_of(path, lo, hi)
    return surface_of(path, facts["field"]["array"], lo, hi) if ending == "vtu" else points_of(path)


def draw(inputs, out):
    with tempfile.TemporaryDirectory() as folder:
        renderer = vtk.vtkRenderer()
        renderer.SetBackground(0.32, 0.34, 0.43)
        renderer.AddViewProp(prop_of(inputs, folder))
        window = vtk.vtkRenderWindow()
        window.SetOffScreenRendering(True)
        window.SetSize(*SIZE)
        window.AddRenderer(renderer)
        renderer.ResetCamera()
        window.Render()
        picture = vtk.vtkWindowToImageFilter()
        picture.SetInput(window)
        writer = vtk.vtkPNMWriter()
        writer.SetInputConnection(picture.GetOutputPort())
        writer.SetFileName(out)
        writer.Write()


def main(arguments):
    if len(arguments) < 2:
        sys.exit(__doc__)
    os.makedirs(arguments[0], exist_ok=True)
    for number, word in enumerate(arguments[1:]):
        draw(word.split("+"), os.path.join(arguments[0], f"{number:02}.ppm"))
        print(word, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
