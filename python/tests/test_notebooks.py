# SPDX-License-Identifier: Apache-2.0
"""The notebooks of examples/notebooks run from nothing, and show what the stored ones show."""
import os
import sys

import pytest

SCRIPTS = os.path.join(os.path.dirname(__file__), "..", "..", "scripts")
FOLDER = os.path.join(SCRIPTS, "..", "examples", "notebooks")
NAMES = sorted(name for name in os.listdir(FOLDER) if name.endswith(".ipynb"))


@pytest.fixture
def notebooks(monkeypatch):
    """scripts/notebooks.py as a module."""
    pytest.importorskip("nbconvert")
    pytest.importorskip("ipykernel")
    monkeypatch.syspath_prepend(SCRIPTS)
    monkeypatch.setenv("PYDEVD_DISABLE_FILE_VALIDATION", "1")  # a warning of ipykernel's about Python itself
    import notebooks

    yield notebooks
    sys.modules.pop("notebooks")


def test_there_are_some():
    assert len(NAMES) >= 6


@pytest.mark.parametrize("name", NAMES)
def test_runs_and_shows_what_is_stored(notebooks, tmp_path, name):
    """Fails where a cell fails, and where it shows fewer or more pictures than on the web page."""
    path = os.path.join(FOLDER, name)
    stored = notebooks.read(path)
    if any("ovoid.interact(" in cell.source for cell in stored.cells):
        pytest.importorskip("ipywidgets")
    assert sum(notebooks.pictures(stored)) > 0
    book = notebooks.executed(path, str(tmp_path))
    assert notebooks.pictures(book) == notebooks.pictures(stored)
    shown = [output.data["image/png"] for cell in book.cells for output in cell.get("outputs", []) if "image/png" in output.get("data", {})]
    assert shown and all(png.startswith("iVBORw0KGgo") for png in shown)  # PNG's first bytes in base 64


def test_they_are_small():
    """All who clone the project take them along."""
    assert sum(os.path.getsize(os.path.join(FOLDER, name)) for name in NAMES) < 300_000
