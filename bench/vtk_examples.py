#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""VTK's own examples of volume rendering with its mapper and with Ovoid's: vtk_examples.py OUT_FOLDER EXAMPLE.py...

Each example runs twice, in a process of its own: as it is, and with the name of VTK's mapper replaced. What else would wait for a person
(an interactor's Start) is left out, and comparisons with stored pictures take the picture instead. Writes OUT_FOLDER/NAME.png, VTK's picture
on the left, and says what Ovoid's mapper did not draw. VTK's sources have the examples (Rendering/Volume/Testing/Python; of Debian,
`apt-get source vtk9`); VTK_DATA_ROOT names the folder that holds their Data. Needs python3-vtk9, a display (xvfb-run) and the Python module
ovoid_vtk on the path."""
import contextlib
import os
import re
import subprocess
import sys
import tempfile

GRID_MAPPERS = r"\bvtk(FixedPointVolumeRayCast|GPUVolumeRayCast|SmartVolume)Mapper\b"
MESH_MAPPERS = r"\bvtk(ProjectedTetrahedra|OpenGLProjectedTetrahedra|UnstructuredGridVolumeRayCast|UnstructuredGridVolumeZSweep)Mapper\b"
SECONDS = 300


def replaced(source):
    source = re.sub(GRID_MAPPERS, "vtkOvoidVolumeMapper", source)
    return re.sub(MESH_MAPPERS, "vtkOvoidUnstructuredGridVolumeMapper", source)


def run_example(path, is_ovoids, picture):
    """In this process; the last window's picture."""
    import vtk
    import vtk.test.Testing as testing
    from ovoid_vtk import vtkOvoid
    windows = []
    plain = vtk.vtkRenderWindow

    def window():
        made = plain()
        made.SetOffScreenRendering(1)
        windows.append(made)
        return made
    vtk.vtkRenderWindow = window
    vtk.vtkOvoidVolumeMapper = vtkOvoid.vtkOvoidVolumeMapper
    vtk.vtkOvoidUnstructuredGridVolumeMapper = vtkOvoid.vtkOvoidUnstructuredGridVolumeMapper
    testing.compareImage = lambda *_args, **_named: 0
    testing.interact = lambda: None
    folder = os.path.dirname(os.path.abspath(path))
    sys.path.insert(0, folder)

    def run(name):
        with open(name, encoding="utf-8") as file:
            source = file.read()
        source = re.sub(r"^.*\.Start\(\)\s*$", "", source, flags=re.MULTILINE)
        return compile(replaced(source) if is_ovoids else source, name, "exec")

    class Finder:  # modules beside the example are examples, too
        @staticmethod
        def find_spec(name, _path=None, _target=None):
            from importlib.machinery import ModuleSpec
            beside = os.path.join(folder, name + ".py")
            return ModuleSpec(name, Finder) if os.path.exists(beside) else None

        @staticmethod
        def create_module(_spec):
            return None

        @staticmethod
        def exec_module(module):
            exec(run(os.path.join(folder, module.__name__ + ".py")), module.__dict__)
    sys.meta_path.insert(0, Finder)
    scope = {"__name__": "example"}
    exec(run(path), scope)
    for value in list(scope.values()):  # tests of VTK's are classes with methods
        if isinstance(value, type) and issubclass(value, testing.vtkTest) and value is not testing.vtkTest:
            for method in [name for name in dir(value) if name.startswith("test")]:
                getattr(value(method), method)()
    windows[-1].Render()
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(windows[-1])
    grab.ReadFrontBufferOff()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(picture)
    writer.SetInputConnection(grab.GetOutputPort())
    writer.Write()


def side_by_side(pictures, out):
    from vtk import vtkImageAppend
    from vtkmodules.vtkIOImage import vtkPNGReader, vtkPNGWriter
    append = vtkImageAppend()
    for picture in pictures:
        reader = vtkPNGReader()
        reader.SetFileName(picture)
        append.AddInputConnection(reader.GetOutputPort())
    writer = vtkPNGWriter()
    writer.SetFileName(out)
    writer.SetInputConnection(append.GetOutputPort())
    writer.Write()


def drawn(path, is_ovoids, picture):
    """Lines that say what went wrong."""
    command = [sys.executable, os.path.abspath(__file__), "--run", str(int(is_ovoids)), path, picture]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    lines = [line for line in (done.stdout + done.stderr).split("\n") if "vtkOvoid" in line or "Error:" in line and "vtk" not in line]
    return sorted({re.sub(r"^.*\(0x[0-9a-f]+\): ", "", line) for line in lines})


def main(out, *examples):
    os.makedirs(out, exist_ok=True)
    print("| example | with Ovoid's mapper |\n|---|---|")
    for path in examples:
        name = os.path.basename(path)[:-3]
        with tempfile.TemporaryDirectory() as folder:
            pictures = [os.path.join(folder, f"{which}.png") for which in ("vtk", "ovoid")]
            said = [drawn(path, i == 1, picture) for i, picture in enumerate(pictures)]
            if not all(os.path.exists(picture) for picture in pictures):
                which = "VTK" if not os.path.exists(pictures[0]) else "Ovoid"
                print(f"| {name} | no picture of {which}'s: {'; '.join(said[which == 'Ovoid'])[:160]} |", flush=True)
                continue
            side_by_side(pictures, os.path.join(out, name + ".png"))
        print(f"| {name} | {'; '.join(said[1]) or 'drawn'} |", flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "--run":
        with contextlib.suppress(SystemExit):
            run_example(sys.argv[3], sys.argv[2] == "1", sys.argv[4])
    else:
        main(*sys.argv[1:])
