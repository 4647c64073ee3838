# SPDX-License-Identifier: Apache-2.0
"""States: what a picture, a file or a window says, drawn again; and the window itself."""
import json
import os
import stat
import sys

import numpy as np
import ovoid
import pytest
from conftest import PROGRAM, SMALL


def test_a_state_draws_the_same(array):
    settings = {"cmap": "magma", "azimuth": 30, "shade": False, "clip": [(1, 0, 0, 9), (0, 1, 0, 4)], "opacity": [(40, 0), (120, 1)], **SMALL}
    picture = ovoid.render(array, **settings)
    assert (ovoid.render(array, state=picture.state).numpy() == picture.numpy()).all()
    assert (ovoid.Scene(array, state=json.loads(json.dumps(picture.state))).render().numpy() == picture.numpy()).all()


@pytest.mark.parametrize("given", [{"azimuth": 50}, {"colormap": "viridis"}, {"cmap": "viridis"}, {"shade": True}, {"no_shade": False}, {"view": "front"}])
def test_what_is_given_beats_a_state(array, given):
    before = {"cmap": "magma", "shade": False, "camera": ovoid.render(array, azimuth=20, **SMALL).camera, **SMALL}
    expected = {**before, **given}
    for name, beaten in (("colormap", "cmap"), ("no_shade", "shade"), ("view", "camera")):
        if name in given:
            del expected[beaten]
    state = ovoid.render(array, **before).state
    assert (ovoid.render(array, state=state, **given).numpy() == ovoid.render(array, **expected).numpy()).all()


def test_a_state_file_names_its_data(tmp_path, array):
    ovoid.write(tmp_path / "in.nrrd", array)
    picture = ovoid.render(tmp_path / "in.nrrd", azimuth=40, **SMALL)
    (tmp_path / "look.json").write_text(json.dumps({**picture.state, "inputs": ["in.nrrd"]}))
    assert (ovoid.render(state=tmp_path / "look.json").numpy() == picture.numpy()).all()
    assert (ovoid.render(state=picture.state).numpy() == picture.numpy()).all()


@pytest.mark.parametrize("state, words", [
    (3, "expected a dict"),
    ({}, "is no state"),
    ({"ovoid_state": 1, "inputs": [], "flags": []}, "is no state"),
    ({"ovoid_state": 1, "inputs": [], "flags": {"nonsense": "1"}}, "nonsense"),
    ("missing.json", "missing.json"),
])
def test_what_is_no_state(array, state, words):
    with pytest.raises(ovoid.Error, match=words):
        ovoid.render(array, state=state)


def test_pictures_speak_dlpack(array):
    picture = ovoid.render(array, **SMALL)
    assert (np.from_dlpack(picture) == picture.numpy()).all()


def stand_in(tmp_path, monkeypatch, body):
    """A program in the place of the window's, which notes how it was called."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for name in ("ovoid", "ovoid-viewer"):
        path = folder / name
        path.write_text(f"#!{sys.executable}\nimport json, sys\nwords = sys.argv[1:]\nkept = words[words.index('--save-state') + 1]\n"
                        f"inputs = words[words.index('--') + 1:]\n{body}\n")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setattr(sys.modules["ovoid._view"], "program", lambda: str(folder / "ovoid"))


@pytest.fixture
def view_module():
    import ovoid._view

    return ovoid._view


WRITES = "json.dump({'ovoid_state': 1, 'inputs': inputs, 'flags': {'azimuth': '15', 'size': '96x72'}}, open(kept, 'w'))"


def test_a_window_gives_back_its_state(tmp_path, monkeypatch, array, view_module):
    stand_in(tmp_path, monkeypatch, "assert words[:3] == ['view', '--colormap', 'magma'] and open(inputs[0], 'rb').read(4) == b'NRRD'\n" + WRITES)
    state = ovoid.view(array, cmap="magma")
    assert state["inputs"] == [] and state["flags"] == {"azimuth": "15", "size": "96x72"}
    assert (ovoid.render(array, state=state).numpy() == ovoid.render(array, azimuth=15, **SMALL).numpy()).all()


def test_a_window_on_files_and_other_data(tmp_path, monkeypatch, array, view_module):
    stand_in(tmp_path, monkeypatch, WRITES)
    ovoid.write(tmp_path / "in.nrrd", array)
    assert ovoid.view(str(tmp_path / "in.nrrd"))["inputs"] == [str(tmp_path / "in.nrrd")]
    assert ovoid.view(ovoid.particles(np.eye(3)))["inputs"] == []
    assert ovoid.view() == {"ovoid_state": 1, "program": ovoid.__version__, "inputs": [], "flags": {"azimuth": "15", "size": "96x72"}}


def test_a_window_that_was_closed_without_data(tmp_path, monkeypatch, view_module):
    stand_in(tmp_path, monkeypatch, "pass")
    assert ovoid.view() is None


def test_a_window_that_cannot_open(tmp_path, monkeypatch, array, view_module):
    stand_in(tmp_path, monkeypatch, "sys.exit('ovoid: error: no display')")
    with pytest.raises(ovoid.Unsupported, match="no display"):
        ovoid.view(array)


def test_no_window_installed(monkeypatch, array, view_module):
    monkeypatch.setattr(view_module.os, "access", lambda *_: False)
    with pytest.raises(ovoid.Unsupported, match="not installed"):
        ovoid.view(array)


@pytest.mark.skipif(not os.path.exists("/usr/bin/xvfb-run") or not os.path.exists(os.path.join(os.path.dirname(PROGRAM), "ovoid-viewer")),
                    reason="no virtual screen, or no window")
def test_the_window_itself(tmp_path, monkeypatch, array, view_module):
    """A script turns the view and closes the window; what it gives back is drawn."""
    (tmp_path / "turn.txt").write_text("wait loaded\nwait full\ndrag left picture 60,20\nwait full\nclose\n")
    program = tmp_path / "ovoid"
    program.write_text(f"#!/bin/sh\nshift\nexec xvfb-run -a {PROGRAM} view --script {tmp_path}/turn.txt \"$@\"\n")
    program.chmod(0o755)
    monkeypatch.setattr(view_module, "program", lambda: str(program))
    state = ovoid.view(array, cmap="magma")
    assert state["inputs"] == []
    left = ovoid.render(array, state=state, size=(96, 72))
    assert left.camera["position"] != ovoid.render(array, **SMALL).camera["position"]
    expected = ovoid.render(array, cmap="magma", camera=left.camera, **SMALL)
    assert abs(left.rgba - expected.rgba).max() < 0.02 and left.rgba.max() > 0.3
