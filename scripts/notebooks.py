#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The notebooks of examples/notebooks, each executed from nothing: notebooks.py [--store] [NOTEBOOK...]

Tells how long each took; fails where a cell does, or shows no picture where the stored notebook has one. With --store it writes what
the cells show back into the notebooks: pictures as JPEGs, without films and what changes from run to run. Needs python3-nbconvert and
python3-ipykernel, with --store python3-pil, and the package on PYTHONPATH."""
import base64
import glob
import io
import os
import sys
import time

import nbformat
from nbconvert.preprocessors import ExecutePreprocessor

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "examples", "notebooks")
KEPT = ("text/plain", "image/jpeg")
QUALITY = 75  # of stored pictures
TIMEOUT_S = 120  # of a cell


class Runner(ExecutePreprocessor):
    def on_comm_open_jupyter_widget(self, msg):
        """Widgets are not kept, and those of ipywidgets 6 would not be understood."""


def notebooks():
    return sorted(glob.glob(os.path.join(FOLDER, "*.ipynb")))


def read(path):
    return nbformat.read(path, as_version=4)


def executed(path, folder="."):
    """The notebook with what its cells show now; they run in `folder`. Raises nbclient's CellExecutionError where a cell fails."""
    book = read(path)
    for cell in book.cells:
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    runner = Runner(timeout=TIMEOUT_S, kernel_name="python3", record_timing=False, store_widget_state=False)
    return runner.preprocess(book, {"metadata": {"path": folder}})[0]


def pictures(book):
    """For each code cell how many pictures it shows."""
    return [sum(any(kind in ("image/png", "image/jpeg") for kind in output.get("data", {})) for output in cell.outputs)
            for cell in book.cells if cell.cell_type == "code"]


def smaller(png):
    """A PNG as a JPEG, both in base 64."""
    from PIL import Image

    packed = io.BytesIO()
    Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB").save(packed, "JPEG", quality=QUALITY, optimize=True)
    return base64.b64encode(packed.getvalue()).decode()


def strip(book):
    """Takes away what changes from run to run, and what is large."""
    book.metadata.pop("widgets", None)
    book.metadata.language_info = {"name": "python"}
    for cell in book.cells:
        if cell.cell_type != "code":
            continue
        for output in cell.outputs:
            if "data" in output:
                if "image/png" in output.data:
                    output.data["image/jpeg"] = smaller(output.data["image/png"])
                output.data = {kind: value for kind, value in output.data.items() if kind in KEPT}
        cell.outputs = [output for output in cell.outputs if output.output_type != "stream" or output.name == "stdout"]
        cell.metadata.pop("execution", None)


def main(words):
    is_storing = "--store" in words
    failed = False
    for path in [word for word in words if word != "--store"] or notebooks():
        begin = time.monotonic()
        book = executed(path)
        took = time.monotonic() - begin
        stands = is_storing or pictures(book) == pictures(read(path))
        failed |= not stands
        if is_storing:
            strip(book)
            nbformat.write(book, path)
        print(f"{os.path.basename(path)}: {took:.1f} s, {os.path.getsize(path) / 1000:.0f} kB" + ("" if stands else
              f": shows {pictures(book)} pictures in its cells, the stored one has {pictures(read(path))}; --store"))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
