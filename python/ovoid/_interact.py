# SPDX-License-Identifier: Apache-2.0
"""A picture with sliders for notebooks, of ipywidgets' own widgets: no JavaScript is brought along.

Changes come from the kernel's main thread. A thread of its own draws the newest state: small JPEGs while something moves, and a PNG
of full size when nothing has moved for a while. States that came while it drew are passed over, so no picture waits in a queue. The
thread lives only while there is something to draw. It is no daemon, since a daemon in the middle of a picture crashes the end of the
process; instead it stops drawing when the main thread has ended.
"""
import json
import logging
import math
import threading
import time

from . import _core, _settings, _state
from ._errors import Error, Unsupported
from ._scene import Scene, View

_log = logging.getLogger("ovoid")

_REST_S = 0.3  # without a change, until the full picture is drawn
_MOVING_S = 0.08  # for a moving picture, so that with its way to the browser ten come in a second
_MOVING_QUALITY = 80
_FACTORS = [2 ** (k / 4) for k in range(-16, 17)]  # what zoom and opacity can be multiplied by
_NO_LOOK = "as it is"  # the colour map that the look has without one
_AS_GIVEN = "as given"  # colours that have no name
# Settings that a camera says already, and those that mean nothing in some modes.
_OF_CAMERAS = ("view", "fit", "projection", "view_angle")
_OF_LAYERS = ("unit_distance", "gradient_opacity")
_VIEW_MIME = "application/vnd.jupyter.widget-view+json"


def _widgets():
    try:
        import ipywidgets
    except ImportError:
        raise Unsupported("interact: needs ipywidgets, which is not installed: pip install ipywidgets, or Debian's python3-ipywidgets; "
                          "render() shows pictures without it") from None
    return ipywidgets


class _Outdated(Exception):
    """Stops a picture that nobody will look at."""


class MovingSize:
    """How large, and of how coarse a field, pictures can be while something moves, so that each takes `seconds`.

    Sizes stand on rungs, each of which is taken to halve the time of the one before until it was measured. When a rung takes longer
    than it did, or less, all others are taken to have changed alike.

    Parameters
    ----------
    width, height : int
        Pixels of the full picture.
    spacings : float
        How many spacings of the field one of its pixels is wide.
    """

    def __init__(self, width, height, spacings, seconds=_MOVING_S):
        self.width, self.height, self.seconds = width, height, seconds
        # (how many times smaller, how often the field is made coarser: so that its spacing is about a pixel)
        factors = [2 ** (k / 2) for k in range(7)]
        self.rungs = [(factor, max(0, round(math.log2(spacings * factor)))) for factor in factors]
        self.rungs += [(factors[-1], self.rungs[-1][1] + more) for more in (1, 2)]
        self.rung = len(self.rungs) - 1
        self._taken = {}

    @property
    def coarseness(self):
        return self.rungs[self.rung][1]

    @property
    def size(self):
        factor = self.rungs[self.rung][0]
        return max(1, round(self.width / factor)), max(1, round(self.height / factor))

    def _expected(self, rung):
        nearest = min(self._taken, key=lambda known: abs(known - rung))
        return self._taken[nearest] * 2.0 ** (nearest - rung)

    def learn(self, taken):
        """A picture of this size took so many seconds."""
        if self.rung in self._taken:  # half way, as times scatter
            change = math.sqrt(taken / self._taken[self.rung])
            self._taken = {rung: seconds * change for rung, seconds in self._taken.items()}
        else:
            self._taken[self.rung] = taken
        fits = [rung for rung in range(len(self.rungs)) if self._expected(rung) <= self.seconds]
        self.rung = fits[0] if fits else len(self.rungs) - 1


class NewestFirst:
    """Draws on a thread of its own what was asked for last.

    Parameters
    ----------
    moving, still : callable
        Called as ``moving(check)`` for the newest state, and as ``still(check)`` when it has been the newest for `rest` seconds.
        `check` takes any arguments and raises when the work is for nothing: of a still, as soon as something newer is asked for.
    """

    def __init__(self, moving, still, rest):
        self._moving, self._still, self._rest_s = moving, still, rest
        self._changed = threading.Condition()
        self._newest, self._drawn = 0, 0  # numbers of states; the drawn one as a moving picture
        self._when = 0.0
        self._thread = None

    def ask(self):
        """There is a new state."""
        with self._changed:
            self._newest += 1
            self._when = time.monotonic()
            self._changed.notify_all()
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="ovoid.interact")
                self._thread.start()

    def rest(self, timeout=None):
        """Waits until nothing is left to draw. Returns whether that is so."""
        with self._changed:
            return self._changed.wait_for(lambda: self._thread is None, timeout)

    def _next(self):
        """What is to be drawn now, the number of its state, and what it calls."""
        with self._changed:
            while self._newest == self._drawn:
                left = self._when + self._rest_s - time.monotonic()
                if left <= 0 or not threading.main_thread().is_alive():
                    return self._still, self._newest
                self._changed.wait(min(left, 0.1))
            return self._moving, self._newest

    def _run(self):
        while True:
            draw, number = self._next()
            is_still = draw == self._still

            def check(*_, is_still=is_still, number=number):
                if not threading.main_thread().is_alive() or is_still and number != self._newest:
                    raise _Outdated

            try:
                check()
                draw(check)
            except _Outdated:
                pass
            except Exception:  # the next state may do better
                _log.exception("a picture failed")
            with self._changed:
                self._drawn = number
                if is_still and number == self._newest or not threading.main_thread().is_alive():
                    self._thread = None
                    self._changed.notify_all()
                    return


def _own_names(settings):
    """Settings by the program's names; values stay as they were given but for words that name other settings."""
    own = {}
    for name, value in settings.items():
        if value is None:
            continue
        given = _settings.canonical({name: value}) if name in ("cpos", "blending") else {_settings._ALIASES.get(name, name): value}
        own.update(given)
    if "colormap" in own:
        own["colormap"] = _settings.colors(own["colormap"])
    return own


def _label(factor):
    return f"{factor:.3g}"


class Interactive:
    """A picture of data, with sliders; made by `interact`.

    Attributes
    ----------
    widget : ipywidgets.Box
        What is shown.
    controls : dict of str to ipywidgets.Widget
        The sliders and lists by the names of their settings; setting the `value` of one does what moving it does.
    """

    def __init__(self, data, placement, settings):
        self._toolkit = _widgets()
        self._scene = Scene(data, **placement, memory_limit=settings.get("memory_limit"))
        self._given = _own_names(settings)
        first = View(self._scene, self._given).render()
        self._size = MovingSize(first.width, first.height, _pixel_of(first) / first._core.sampling_distance)
        self._full = (first.width, first.height)
        self._last = (dict(self._given), first)  # the last picture of full size, and its settings
        self._camera = json.loads(first._core.unturned)
        self._is_opaque = self._given.get("background") not in ("none", "transparent")
        self._frames = []  # (is still, width, height, seconds): of the last pictures
        self._start = {}
        self._make_widgets(first)
        self._queue = NewestFirst(self._draw_moving, self._draw_still, _REST_S)

    # --- the state

    @property
    def settings(self):
        """dict: settings of the picture, as `render` takes them; those that were given, while nothing has been moved."""
        settings = dict(self._given)
        changes = {name: control.value for name, control in self.controls.items() if control.value != self._start[name]}
        if not changes:
            return settings
        # The camera of the first picture: else what shows would be fitted into the picture anew for every frame, and breathe.
        for name in _OF_CAMERAS:
            settings.pop(name, None)
        settings["camera"] = self._camera
        for name, value in changes.items():
            if name == "opacity_factor":
                settings["unit_distance"] = self._unit_distance / value
            elif name == "range":
                settings.pop("window", None)
                settings["range"] = tuple(value)
            elif name == "step":
                settings.pop("time", None)
                settings["step"] = value
            else:
                settings[name] = value
        mode = settings.get("mode", "composite")
        if mode == "isosurface":
            settings["iso"] = self.controls["iso"].value
        unwanted = [] if mode == "isosurface" else ["iso"]
        unwanted += [] if mode == "composite" else _OF_LAYERS
        unwanted += ["opacity"] if mode in ("xray", "isosurface") else []
        unwanted += ["range"] if mode == "xray" and "range" in changes else []  # integrals have another
        return {name: value for name, value in settings.items() if name not in unwanted}

    @property
    def view(self):
        """View: of the data, with the settings of the picture."""
        return View(self._scene, self.settings)

    @property
    def picture(self):
        """Picture: of full size."""
        settings, picture = self._last
        wanted = self.settings
        return picture if settings == wanted else View(self._scene, wanted).render()

    @property
    def command(self):
        """str: the command line of the picture, as `Picture.command`."""
        return self.picture.command

    # --- widgets

    def _make_widgets(self, first):
        kit = self._toolkit
        lo, hi = first._core.values
        self._unit_distance = first._core.unit_distance
        self.controls = {}
        for name, ends in (("azimuth", (-180, 180)), ("elevation", (-89, 89)), ("roll", (-180, 180))):
            value = float(self._given.get(name, 0))
            self._add(name, kit.FloatSlider(value=value, min=min(ends[0], value), max=max(ends[1], value), step=1))
        self._add_factor("zoom", float(self._given.get("zoom", 1)), "zoom")
        self._add_range(first, lo, hi)
        self._add_factor("opacity_factor", 1.0, "opacity")
        self._add_list("colormap", _NO_LOOK, [(_NO_LOOK, None)] + [(name, name) for name in _core.color_map_names()])
        modes = [name for name in _settings.table()["mode"][2].split("|") if name != "mip"]  # another word for maximum
        self._add_list("mode", self._given.get("mode", "composite"), [(name, name) for name in modes])
        if lo < hi:
            iso = float(self._given.get("iso", lo + (hi - lo) / 2))
            self._add("iso", kit.FloatSlider(value=iso, min=min(lo, iso), max=max(hi, iso), step=_step(lo, hi)))
        else:
            self.controls["mode"].options = [(name, name) for name in modes if name != "isosurface"]
        if first._core.num_steps > 1 and "hyperslice" not in self._given:
            self._add("step", kit.IntSlider(value=first._core.step, min=0, max=first._core.num_steps - 1))
        self._enable()
        self._image = kit.Image(value=first.encode(".png"), format="png", width=str(first.width), height=str(first.height))
        self._message = kit.Label(value="")
        for control in self.controls.values():
            control.observe(self._on_change, "value")
        self.widget = kit.HBox([kit.VBox(list(self.controls.values())), kit.VBox([self._image, self._message])])

    def _add(self, name, control, title=None):
        control.description = title or name
        self.controls[name], self._start[name] = control, control.value

    def _add_factor(self, name, value, title):
        factors = sorted({*_FACTORS, value})
        options = [(_label(factor), factor) for factor in factors]
        self._add(name, self._toolkit.SelectionSlider(options=options, value=value), title)

    def _add_list(self, name, value, options):
        given = self._given.get(name)
        if given is not None and given not in [one for _, one in options]:
            options = [(_AS_GIVEN if "," in str(given) else str(given), given), *options]
        value = given if given is not None else dict(options)[value]
        self._add(name, self._toolkit.Dropdown(options=options, value=value))

    def _add_range(self, first, lo, hi):
        points = first.look.get("RGBPoints") or []
        if not points or not lo < hi:
            return  # labels have colours of their own
        ends = (points[0], points[-4])
        lo, hi = (ends[0] if self._given.get("log") else min(lo, ends[0])), max(hi, ends[1])
        self._add("range", self._toolkit.FloatRangeSlider(value=ends, min=lo, max=hi, step=_step(lo, hi)))

    def _enable(self):
        """Controls that say nothing in a mode cannot be moved."""
        mode = self.controls["mode"].value
        for name, is_of_use in (("iso", mode == "isosurface"), ("opacity_factor", mode == "composite"), ("range", mode != "xray")):
            if name in self.controls:
                self.controls[name].disabled = not is_of_use

    def _on_change(self, change):
        if change["owner"] is self.controls["mode"]:
            self._enable()
        self._queue.ask()

    def close(self):
        """Takes the widgets away, and lets the data go."""
        for control in self.controls.values():
            control.unobserve_all()
        self._queue.rest()
        for control in (*self.controls.values(), self._image, self._message, *self.widget.children, self.widget):
            control.close()
        self._scene = None

    # --- drawing, on the thread of the queue

    def _draw(self, check, size=None, coarseness=0):
        """A picture of the newest state, and the seconds it took; None: it cannot be drawn. `size`: if not that of the settings."""
        started = time.monotonic()
        try:
            settings = self.settings
            picture = self._scene._draw(settings if size is None else {**settings, "size": size}, False, check, coarseness)
        except Error as error:
            self._message.value = str(error)
            return None
        self._message.value = picture._why_empty
        for note in picture.notes:
            _log.info("%s", note)
        if size is None:
            self._last = (settings, picture)
        return picture, max(1e-3, time.monotonic() - started - _preparing_s(picture))

    def _show(self, picture, ending, quality, is_still, seconds):
        started = time.monotonic()
        data = picture.encode(ending, quality) if quality else picture.encode(ending)
        kind = "png" if ending == ".png" else "jpeg"
        if self._image.format != kind:
            self._image.format = kind
        self._image.value = data
        seconds += time.monotonic() - started
        self._frames = [*self._frames[-99:], (is_still, picture.width, picture.height, seconds)]
        return seconds

    def _draw_moving(self, check):
        drawn = self._draw(check, self._size.size, self._size.coarseness)
        if drawn is None:
            return
        ending, quality = (".jpg", _MOVING_QUALITY) if self._is_opaque else (".png", None)
        self._size.learn(self._show(drawn[0], ending, quality, False, drawn[1]))

    def _draw_still(self, check):
        drawn = self._draw(check, None)
        if drawn is not None:
            self._show(drawn[0], ".png", None, True, drawn[1])

    # --- showing

    def _ipython_display_(self):
        """Of ipywidgets 6 alone, which shows by messages; those after it by _repr_mimebundle_."""
        kit = self._toolkit
        if kit.version_info[0] >= 7 or not kit.Widget._version_validated:
            raise NotImplementedError
        self.widget._ipython_display_()

    def _repr_mimebundle_(self, include=None, exclude=None):
        """The widget, and for what cannot show widgets the picture."""
        return {"text/plain": repr(self), "image/png": bytes(self.picture.encode(".png")), _VIEW_MIME: self.widget.get_view_spec()}

    def __repr__(self):
        return f"<ovoid.Interactive {self._full[0]} x {self._full[1]}>"


def _step(lo, hi):
    """A round number, some 200 of which are between two values."""
    return 10.0 ** math.floor(math.log10((hi - lo) / 100))


def _preparing_s(picture):
    """What went into data and field, which other pictures share."""
    return (picture.profile["load_ms"] + picture.profile["model_ms"]) / 1000


def _pixel_of(picture):
    """How wide a pixel is where the camera looks at, world units."""
    camera = picture.camera
    if camera["parallel_projection"]:
        return 2 * camera["parallel_scale"] / picture.height
    distance = math.dist(camera["position"], camera["focal_point"])
    return 2 * distance * math.tan(math.radians(camera["view_angle"] / 2)) / picture.height


def interact(data=None, *, spacing=None, origin=None, direction=None, affine=None, space=None, state=None, **settings):
    """A picture with sliders, for notebooks.

    It turns as JPEGs, whose size is what ten pictures a second allow, and becomes a PNG when nothing moves. Its first picture is the
    one of `render`; the sliders begin where the settings are. It needs ipywidgets.

    Parameters
    ----------
    data, spacing, origin, direction, affine, space, state
        As `render` takes them.
    **settings
        As `render` takes them.

    Returns
    -------
    Interactive

    Raises
    ------
    Unsupported
        Where ipywidgets is not installed.
    Error
        As `render`.
    """
    inputs, settings = _state.merged(state, settings)
    placement = {"spacing": spacing, "origin": origin, "direction": direction, "affine": affine, "space": space}
    return Interactive(inputs if data is None and inputs else data, placement, settings)
