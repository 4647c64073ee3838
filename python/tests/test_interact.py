# SPDX-License-Identifier: Apache-2.0
"""The widget: its controls are moved as a browser would move them, by setting their values."""
import subprocess
import sys
import threading
import time

import numpy as np
import ovoid
import ovoid._interact
import pytest
from conftest import SMALL, bumps, png

SETTLED_S = 30  # of machines that have other things to do; a picture takes some milliseconds


@pytest.fixture
def interact(monkeypatch):
    """`ovoid.interact`, whose widgets are soon at rest, and closed in the end."""
    pytest.importorskip("ipywidgets")
    monkeypatch.setattr(ovoid._interact, "_REST_S", 0.02)
    made = []

    def make(*args, **settings):
        made.append(ovoid.interact(*args, **{**SMALL, **settings}))
        return made[-1]

    yield make
    for widget in made:
        widget.close()


def settled(widget):
    assert widget._queue.rest(SETTLED_S)
    return bytes(widget._image.value)


# --- who draws when


class Slow:
    """Draws by waiting, and remembers what was asked for."""

    def __init__(self, moving_s=0.03, still_s=0.03, rest=0.1):
        self.state, self.moving, self.stills, self.stopped = 0, [], [], 0
        self.moving_s, self.still_s = moving_s, still_s
        self.queue = ovoid._interact.NewestFirst(self.draw_moving, self.draw_still, rest)

    def ask(self, state):
        self.state = state
        self.queue.ask()

    def draw_moving(self, check):
        state = self.state
        time.sleep(self.moving_s)
        self.moving.append(state)

    def draw_still(self, check):
        state, until = self.state, time.monotonic() + self.still_s
        try:
            while time.monotonic() < until:
                check(0.5)
                time.sleep(0.005)
        except ovoid._interact._Outdated:
            self.stopped += 1
            raise
        self.stills.append(state)


def test_states_that_came_meanwhile_are_passed_over():
    """With a queue all hundred would be drawn, and the last long after it was asked for."""
    slow = Slow()
    for state in range(1, 101):
        slow.ask(state)
        time.sleep(0.002)
    assert slow.queue.rest(SETTLED_S)
    assert 1 <= len(slow.moving) < 60 and slow.moving == sorted(set(slow.moving))
    assert slow.moving[-1] == 100 and slow.stills[-1] == 100


def test_a_still_waits_for_rest():
    slow = Slow(moving_s=0.001, rest=0.3)
    for state in range(1, 6):
        slow.ask(state)
        time.sleep(0.02)
    assert slow.moving and not slow.stills
    assert slow.queue.rest(SETTLED_S) and slow.stills == [5]
    assert not any(thread.name == "ovoid.interact" for thread in threading.enumerate())


def test_a_still_is_given_up_for_something_newer():
    slow = Slow(still_s=SETTLED_S)
    slow.ask(1)
    time.sleep(0.3)
    slow.still_s = 0.01
    slow.ask(2)
    assert slow.queue.rest(SETTLED_S / 2)
    assert slow.stopped == 1 and slow.stills == [2]


def test_a_picture_that_fails_stops_nothing(caplog):
    failing = ovoid._interact.NewestFirst(lambda check: 1 / 0, lambda check: None, 0.01)
    failing.ask()
    assert failing.rest(SETTLED_S) and "ZeroDivisionError" in caplog.text


@pytest.mark.parametrize("pixel_ms, field_ms", [(0.001, 0), (0.02, 10), (0.5, 200)])
def test_sizes_fit_the_time(pixel_ms, field_ms):
    """Of machines on which a pixel, and a field, cost so much. Fails where the size swings, or stays smaller than it need be."""
    size = ovoid._interact.MovingSize(640, 480, 0.6)

    def cost_s(rung):
        factor, coarseness = size.rungs[rung]
        return (640 * 480 / factor**2 * pixel_ms / 2**coarseness + field_ms / 8**coarseness) / 1000

    used = []
    for _ in range(40):
        used.append(size.rung)
        size.learn(cost_s(size.rung))
    best = next((rung for rung in range(len(size.rungs)) if cost_s(rung) <= size.seconds), len(size.rungs) - 1)
    assert set(used[-10:]) == {best}
    assert size.rungs[0] == (1, 0) and size.rungs[-1][0] == 8


# --- the widget


def test_the_first_picture_is_that_of_render(interact, array):
    given = {**SMALL, "cmap": "magma", "azimuth": 20}
    widget, expected = interact(array, **given), ovoid.render(array, **given)
    assert bytes(widget._image.value) == png(expected)
    assert widget.settings == {"colormap": "magma", "azimuth": 20, **SMALL} and widget.command == expected.command
    assert widget.controls["azimuth"].value == 20 and widget.controls["colormap"].value == "magma"


def test_controls_change_the_picture(interact, array):
    widget = interact(array)
    lo, hi = widget.controls["range"].value
    changes = {"azimuth": 70.0, "elevation": -20.0, "roll": 10.0, "zoom": 2.0, "range": (lo, hi / 2), "opacity_factor": 0.5, "colormap": "magma"}
    shown = bytes(widget._image.value)
    for name, value in changes.items():
        widget.controls[name].value = value
        now = settled(widget)
        assert now != shown, name
        shown = now
    assert widget.settings["azimuth"] == 70 and widget.settings["range"] == (lo, hi / 2)
    assert shown == png(ovoid.render(array, **widget.settings)) == png(widget.picture) == png(widget.view.render())
    assert widget._image.format == "png" and widget._frames[-1][:3] == (True, 96, 72)
    for name in changes:
        widget.controls[name].value = widget._start[name]
    assert settled(widget) == png(ovoid.render(array, **SMALL))


@pytest.mark.parametrize("mode", ["maximum", "mean", "xray", "isosurface"])
def test_modes(interact, array, mode):
    widget = interact(array, opacity=[(20, 0), (150, 0.5)])
    widget.controls["opacity_factor"].value = 2.0
    widget.controls["range"].value = (10.0, 100.0)
    widget.controls["mode"].value = mode
    shown = settled(widget)
    assert widget._message.value == "" and shown == png(ovoid.render(array, **widget.settings))
    assert widget.settings["mode"] == mode and ("iso" in widget.settings) == (mode == "isosurface")
    assert widget.controls["opacity_factor"].disabled and widget.controls["iso"].disabled == (mode != "isosurface")


@pytest.mark.parametrize("settings", [
    {"azimuth": 40, "elevation": 20, "roll": 10, "zoom": 1.5},
    {"azimuth": 40, "zoom": 1.5, "projection": "parallel"},
    {"cpos": "xz", "view_angle": 40},
    {"cpos": [(80, -60, 40), (14, 12, 10), (0, 0, 1)], "azimuth": 15},
])
def test_the_camera_stays_where_something_else_moves(interact, array, settings):
    widget = interact(array, **settings)
    before = widget.picture.camera
    widget.controls["colormap"].value = "magma"
    settled(widget)
    after = widget.picture.camera
    assert widget._message.value == ""
    for name, value in before.items():
        assert np.allclose(after[name], value, rtol=1e-6, atol=1e-6), name


def test_turning_is_that_of_render(interact, array):
    """From where the camera was before it was turned: a camera that was turned has lost the axis that it was turned about."""
    widget = interact(array, azimuth=10, elevation=30)
    widget.controls["azimuth"].value = 100.0
    settled(widget)
    directions = [np.subtract(camera["position"], camera["focal_point"])
                  for camera in (widget.picture.camera, ovoid.render(array, azimuth=100, elevation=30, **SMALL).camera)]
    ours, expected = (direction / np.linalg.norm(direction) for direction in directions)
    assert np.allclose(ours, expected, atol=1e-6)


def test_while_it_moves_pictures_are_small(interact):
    z, y, x = np.mgrid[-1:1:64j, -1:1:64j, -1:1:64j]
    widget = interact(np.exp(-3 * (x**2 + y**2 + z**2)), size=(640, 480))
    formats = []
    widget._image.observe(lambda change: formats.append(bytes(change["new"])[:3]), "value")
    for _ in range(10):
        widget.controls["azimuth"].value += 5
        time.sleep(0.05)
    settled(widget)
    moving = [frame for frame in widget._frames if not frame[0]]
    assert moving and moving[0][1] < 640
    assert formats[0] == b"\xff\xd8\xff" and formats[-1] == b"\x89PN"


def test_transparent_pictures_stay_so(interact, array):
    widget = interact(array, background="none")
    seen = []
    widget._image.observe(lambda change: seen.append(bytes(change["new"])[:3]), "value")
    widget.controls["zoom"].value = 2.0
    settled(widget)
    assert len(seen) >= 2 and set(seen) == {b"\x89PN"}


def test_what_cannot_be_drawn_is_told_beside_the_picture(interact, array):
    widget = interact(array, ambient=0.3)
    shown = bytes(widget._image.value)
    widget.controls["mode"].value = "maximum"  # which is not lit
    assert settled(widget) == shown and "--ambient: has no effect with --mode maximum" in widget._message.value
    widget.controls["mode"].value = "isosurface"
    assert settled(widget) != shown and widget._message.value == ""


def test_an_empty_picture_says_why(interact, array):
    widget = interact(array, clim=(300, 400))
    widget.controls["azimuth"].value = 30.0
    settled(widget)
    assert widget._message.value.startswith("nothing shows: ")
    widget.controls["range"].value = (0.0, 200.0)
    settled(widget)
    assert widget._message.value == ""


def test_colours_without_a_name(interact, array):
    for given in (["black", (1, 0.5, 0)], np.array([[0, 0, 0], [1, 0.5, 0]])):
        widget = interact(array, cmap=given)
        assert widget.controls["colormap"].options[0][0] == "as given"
        widget.controls["range"].value = (10.0, 100.0)
        assert settled(widget) == png(ovoid.render(array, **{**widget.settings, "colormap": given}))


def test_steps_of_series(interact, tmp_path):
    paths = [tmp_path / f"a_{i}.nrrd" for i in range(3)]
    for i, path in enumerate(paths):
        ovoid.write(path, np.roll(bumps(), 3 * i, axis=2))
    widget = interact(paths, step=0)
    assert (widget.controls["step"].min, widget.controls["step"].max) == (0, 2)
    widget.controls["step"].value = 2
    assert settled(widget) == png(ovoid.render(paths, **widget.settings)) and widget.settings["step"] == 2
    in_memory = interact(ovoid.series([np.roll(bumps(), 3 * i, axis=2) for i in range(3)]), step=0)
    assert (in_memory.controls["step"].min, in_memory.controls["step"].max) == (0, 2)
    in_memory.controls["step"].value = 2
    assert settled(in_memory) == settled(widget)


@pytest.mark.parametrize("data", [
    np.zeros((4, 4, 4), "u1"),
    np.kron(np.arange(8).reshape(2, 2, 2), np.ones((6, 6, 6))).astype("u1"),
    ovoid.particles(np.random.default_rng(1).normal(size=(300, 3))),
])
def test_other_data(interact, data):
    widget = interact(data)
    widget.controls["azimuth"].value = 30.0
    assert settled(widget) == png(widget.picture) and widget._message.value == ""


def test_fields_that_are_coarse_for_a_while(array):
    """Coarse fields look like the field; they are let go with it, and full pictures do not change."""
    z, y, x = np.mgrid[-1:1:64j, -1:1:64j, -1:1:64j]
    scene = ovoid.Scene(np.exp(-5 * (x**2 + y**2 + z**2)), size=(48, 36))
    full = scene.render().rgba
    for coarseness in (1, 2):
        coarse = scene._draw(scene.settings, False, None, coarseness).rgba
        assert 0 < abs(coarse - full).max() < 0.2 * coarseness
    assert (scene.render().rgba == full).all()
    smooth = scene._draw({**scene.settings, "kernel": "gaussian:2"}, False, None, 1).rgba
    assert abs(smooth - coarse).max() > 0.01

def test_what_stands_beside_is_in_moving_pictures(tmp_path):
    """A red plate before the data hides them in a quick picture as in a full one."""
    (tmp_path / "plate.obj").write_text("v -40 -40 -9\nv 80 -40 -9\nv 80 80 -9\nv -40 80 -9\nf 1 2 3 4\n", encoding="utf-8")
    scene = ovoid.Scene(bumps((32, 32, 32)), add=tmp_path / "plate.obj", add_color="red", view="-z", **SMALL)
    middle = [scene._draw(scene.settings, False, None, coarseness).rgba[36, 48] for coarseness in (0, 1)]
    assert middle[0][0] > 0.3 and middle[0][1] < 0.05
    assert abs(middle[1] - middle[0]).max() < 0.02



def test_shown_in_the_notebook(interact, array):
    widget = interact(array)
    shown = widget._repr_mimebundle_()
    assert shown["image/png"] == bytes(widget._image.value)
    assert shown["application/vnd.jupyter.widget-view+json"]["model_id"] == widget.widget.model_id
    assert shown["text/plain"] == "<ovoid.Interactive 96 x 72>"


def test_errors(monkeypatch, array):
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    with pytest.raises(ovoid.Unsupported, match="needs ipywidgets, which is not installed"):
        ovoid.interact(array)
    monkeypatch.undo()
    pytest.importorskip("ipywidgets")
    with pytest.raises(ovoid.UnknownSetting, match="did you mean colormap"):
        ovoid.interact(array, colormp="magma")


def test_the_end_of_the_process_waits_for_no_picture():
    """A thread that drew on would keep the process for most of a minute, or crash it."""
    pytest.importorskip("ipywidgets")
    script = """
import numpy, ovoid, time
widget = ovoid.interact(numpy.random.default_rng(1).random((48, 48, 48)), size=(96, 72))
widget._given.update(backend="reference", threads=1, size=(1200, 900))
widget._size.width, widget._size.height = 9600, 7200
widget.controls["azimuth"].value = 30.0
time.sleep(0.5)
print("end", time.time())
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=50)
    took = time.time() - float(done.stdout.split()[1])
    assert done.returncode == 0 and done.stderr == "" and took < 5


def test_in_a_kernel():
    """As a browser does it: the slider's model is sent a value, and pictures come back, small ones first and in the end a PNG, while
    the kernel is free for cells."""
    pytest.importorskip("ipywidgets")
    pytest.importorskip("ipykernel")
    manager = pytest.importorskip("jupyter_client.manager")
    with manager.run_kernel(kernel_name="python3", stderr=subprocess.DEVNULL) as client:

        def told(message_id=None, until=lambda message: False):
            """Messages of the kernel up to the one that is looked for, or to the end of the answer to a message."""
            found = []
            while True:
                message = client.get_iopub_msg(timeout=SETTLED_S)
                found.append(message)
                is_end = message["msg_type"] == "status" and message["content"]["execution_state"] == "idle"
                if until(message) or is_end and message["parent_header"].get("msg_id") == message_id:
                    return found

        def pictures(messages):
            states = [message["content"]["data"].get("state", {}) for message in messages if message["msg_type"] == "comm_msg"]
            return [state for state in states if "_b64value" in state or "value" in state or "format" in state]

        code = """
import numpy, ovoid
z, y, x = numpy.mgrid[-1:1:32j, -1:1:32j, -1:1:32j]
widget = ovoid.interact(numpy.exp(-3 * (x**2 + y**2 + z**2)), size=(640, 480))
display({"text/plain": " ".join([widget.controls["azimuth"].model_id, widget._image.model_id])}, raw=True)
widget
"""
        answer = told(client.execute(code))
        slider, image = next(message["content"]["data"]["text/plain"] for message in answer if message["msg_type"] == "display_data").split()
        shown = next(message["content"]["data"] for message in answer if message["msg_type"] == "execute_result")
        assert "image/png" in shown and "application/vnd.jupyter.widget-view+json" in shown
        for azimuth in (10.0, 20.0, 30.0):  # in the words of protocols 1 and 2
            data = {"method": "backbone", "sync_data": {"value": azimuth}, "state": {"value": azimuth}, "buffer_paths": []}
            if ovoid._interact._widgets().version_info[0] >= 7:
                data["method"] = "update"
            client.shell_channel.send(client.session.msg("comm_msg", {"comm_id": slider, "data": data}))

        def is_png(message):
            return message["msg_type"] == "comm_msg" and message["content"]["comm_id"] == image \
                and message["content"]["data"].get("state", {}).get("format") == "png"

        came = told(until=is_png)
        assert any(state.get("format") == "jpeg" for state in pictures(came))
        # On a busy machine a PNG may come between two of the values: what counts is where it comes to rest.
        deadline = time.monotonic() + SETTLED_S
        while True:
            answer = told(client.execute("print(widget.settings['azimuth'], widget._frames[-1][:3])"))
            rest = next(message["content"]["text"] for message in answer if message["msg_type"] == "stream")
            if rest == "30.0 (True, 640, 480)\n" or time.monotonic() > deadline:
                break
            time.sleep(0.2)
        assert rest == "30.0 (True, 640, 480)\n"
