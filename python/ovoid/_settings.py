# SPDX-License-Identifier: Apache-2.0
"""Settings as keywords: the program's flags with underscores, PyVista's words for some of them, and values of Python as the text
that a flag takes. Which flags there are, and what form their values have, is the program's own table."""
import functools
import json
import math
import numbers
import os
import re

from . import _core
from ._errors import InvalidArgument, UnknownSetting

_TOGGLE, _VALUE, _REPEATABLE, _OPTIONAL = range(4)

# PyVista's and VTK's words that mean the same.
_ALIASES = {
    "transfer_function": "tf",
    "cmap": "colormap",
    "clim": "range",
    "window_size": "size",
    "scalars": "array",
    "opacity_unit_distance": "unit_distance",
    "log_scale": "log",
    "show_scalar_bar": "colorbar",
}
_BLENDINGS = {"composite": "composite", "maximum": "maximum", "minimum": "minimum", "average": "mean"}
# What others call a setting that has no single word here.
_OF_OTHERS = {
    "vmin": "the range of the colours is clim=(LO, HI)",
    "vmax": "the range of the colours is clim=(LO, HI)",
    "figsize": "size=(WIDTH, HEIGHT) are pixels",
    "dpi": "size=(WIDTH, HEIGHT) are pixels",
    "width": "size=(WIDTH, HEIGHT) are pixels",
    "height": "size=(WIDTH, HEIGHT) are pixels",
    "alpha": "opacities are opacity=...",
    "color": "colours are cmap=..., of isosurfaces iso=[(VALUE, COLOUR)], of surfaces beside the data add_color=...",
    "threshold": "isosurfaces are mode=\"isosurface\", iso=VALUE",
    "levels": "isosurfaces are mode=\"isosurface\", iso=VALUE",
    "isosurface": "isosurfaces are mode=\"isosurface\", iso=VALUE",
    "interactive": "ovoid.interact(data) has sliders, ovoid.view(data) is a window",
    "notebook": "ovoid.interact(data) has sliders, ovoid.view(data) is a window",
    "title": "the colour bar's is colorbar=\"TITLE\"",
}
# PyVista's planes that are seen from where one of the program's views is, with the same axis up.
_CPOS = {"xy": "+z", "xz": "-y", "yz": "+x"}


@functools.lru_cache(maxsize=None)
def table(command="render"):
    """Name with underscores -> (flag, kind, form, text), in the order of the program's help for a command."""
    return {name.replace("-", "_"): (name, kind, form, text) for name, kind, form, text in _core.settings(command)}


def settings(command="render"):
    """All settings of `render`, or of another command, and what they mean.

    Parameters
    ----------
    command : str
        "render", "fit", "simplify", or "convert", whose settings `resample` takes.

    Returns
    -------
    dict of str to str
        The sentence of the program's help for each name, with the form of the value in front.

    Raises
    ------
    InvalidArgument
        For another command.

    Examples
    --------
    >>> import ovoid
    >>> ovoid.settings()["zoom"]
    'FACTOR: above 1 comes nearer'
    """
    return {name: f"{form}: {text}" if form else text for name, (_, _, form, text) in table(command).items()}


def _is_sequence(value):
    return not isinstance(value, (str, bytes, dict, os.PathLike)) and hasattr(value, "__iter__") and getattr(value, "ndim", 1) != 0


def _depth(value, most=3):
    """How many sequences stand in one another: 0 of one value."""
    return 1 + max((_depth(one, most - 1) for one in value), default=0) if most and _is_sequence(value) else 0


def _scalar(value):
    if value is None:
        return ""
    if hasattr(value, "item") and getattr(value, "ndim", None) == 0:
        value = value.item()
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        return str(int(value))
    if isinstance(value, numbers.Real) and not isinstance(value, bool):
        return repr(float(value))
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def _json(value):
    """A look or a camera, with numbers of numpy's as such."""
    try:
        return json.dumps(value, default=lambda one: one.tolist() if hasattr(one, "tolist") else json.dumps(one))
    except (TypeError, ValueError, RecursionError) as error:
        raise InvalidArgument(f"{value!r}: cannot be written as JSON: {error}") from None


def camera_path_text(value):
    """Keys of a camera as JSON, or the name of the file that they are in."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    text = _json(value)
    if "NaN" in text or "Infinity" in text:
        raise InvalidArgument(f"camera_path = {value!r}: expected finite numbers")
    return text if text.startswith("[") else f"[{text}]"


def _of_label(value):
    """What a label has; of a colour the form without commas, which stand between labels."""
    if not _is_sequence(value):
        return _scalar(value)
    try:
        parts = [float(part) for part in value]
    except (TypeError, ValueError, OverflowError):
        parts = []
    if len(parts) != 3 or not all(0 <= part <= 1 for part in parts):
        raise InvalidArgument(f"{value!r}: expected a colour: three numbers from 0 to 1, or text")
    return "#" + "".join(f"{round(255 * part):02x}" for part in parts)


def _label_table(table):
    """Names, or (name, colour, opacity), of labels by their numbers, as the JSON that a file of them may be."""
    expected = 'expected {number: "name"}, or {number: ("name", colour, opacity)}'
    found = {}
    for label, entry in table.items():
        is_number = isinstance(label, numbers.Integral) and not isinstance(label, bool)
        if not is_number and not (isinstance(label, str) and re.fullmatch("-?[0-9]+", label)):  # as JSON has them
            raise InvalidArgument(f"label_table: {label!r} is no label; {expected}")
        parts = [entry] if isinstance(entry, str) else list(entry) if isinstance(entry, (list, tuple)) else []
        if not 1 <= len(parts) <= 3 or not isinstance(parts[0], str):
            raise InvalidArgument(f"label_table: {label}: {entry!r}: {expected}")
        if len(parts) > 1 and parts[1] is not None:
            parts[1] = _core.color_text(_of_label(parts[1])) if isinstance(parts[1], str) else _of_label(parts[1])
        found[str(int(label))] = parts[0] if isinstance(entry, str) else parts
    return _json(found)


def _text(value, form):
    """A value as the text that the program takes: tuples with the separators of the form."""
    if isinstance(value, dict) and form.startswith("LABEL="):
        return ",".join(f"{_scalar(label)}={_of_label(one)}" for label, one in value.items())
    if isinstance(value, dict) or (isinstance(value, (list, tuple)) and any(isinstance(one, dict) for one in value)):  # a look is a list
        return _json(value)
    if not _is_sequence(value):
        return _scalar(value)
    outer = "x" if re.search("[A-Z]x[A-Z]", form) else ","
    inner = ":" if ":" in form else ","
    parts = []
    for part in value:
        if isinstance(part, slice):
            part = (part.start, part.stop)
        parts.append(inner.join(_scalar(number) for number in part) if _is_sequence(part) else "" if part is None else _scalar(part))
    return outer.join(parts)


def _depth_of(form):
    """The same of one value of a form: 2 of pairs, 1 of several numbers."""
    return 2 if re.match("[A-Z]+:", form) else 1 if "," in form or form in ("COLOR", "PLANE") else 0


def _check_file_names(name, value):
    for one in value if isinstance(value, (list, tuple)) else [value]:
        if not isinstance(one, (str, os.PathLike)):
            other = ", or a place in the volume itself: over=ovoid.lattice(array, affine=...)" if name == "over_transform" else ""
            raise InvalidArgument(f"{name}: is {type(one).__name__}, expected the name of a file{other}")


def _words_of(name, value, command):
    flag, kind, form, _ = table(command)[name]
    if form == "FILE":
        _check_file_names(name, value)
    if name == "label_table":
        if not isinstance(value, dict):
            _check_file_names(name, value)
        else:
            value = _label_table(value)
    if kind == _TOGGLE:
        if not (isinstance(value, int) and value in (0, 1) or type(value).__name__ in ("bool", "bool_")):  # numpy's, of 2 and before
            raise InvalidArgument(f"{name} = {value!r}: expected True or False")
        if value:
            return [f"--{flag}"]
        return [f"--no-{flag}"] if f"no_{name}" in table(command) else []
    if kind == _OPTIONAL:
        if isinstance(value, bool):
            return [f"--{flag}"] if value else []
        return [f"--{flag}={_text(value, form)}"]
    if kind == _REPEATABLE and _is_sequence(value):
        values = [list(one) if _is_sequence(one) else one for one in value]
        if any(isinstance(one, (str, os.PathLike)) for one in values) or _depth(values) > _depth_of(form) or not values:
            return [word for one in values for word in (f"--{flag}", _text(one, form))]
    return [f"--{flag}", _text(value, form)]


def _camera(cpos):
    """PyVista's camera position as the flag that says the same."""
    if isinstance(cpos, str):
        if cpos not in _CPOS:
            raise InvalidArgument(f"cpos = {cpos!r}: expected one of {', '.join(_CPOS)}, or (position, focal point, view up)")
        return "view", _CPOS[cpos]
    try:
        position, focal_point, view_up = ([float(number) for number in point] for point in cpos)
    except (TypeError, ValueError, OverflowError):
        raise InvalidArgument(f"cpos = {cpos!r}: expected three points: position, focal point, view up") from None
    return "camera", {"position": position, "focal_point": focal_point, "view_up": view_up}


def _named_opacities(name):
    """PyVista's opacities of a name, evenly spaced; the name itself if it is none of them."""
    found = re.fullmatch("(linear|sigmoid(?:_(?P<steepness>[0-9]{1,2}))?)(?P<reversed>_r)?", name)
    if not found and re.match("[A-Za-z_]+", name):
        raise InvalidArgument(f"opacity = {name!r}: expected numbers, (value, opacity) pairs, or linear or sigmoid_STEEPNESS, with _r "
                              f"reversed{_core.did_you_mean(name, ['linear', 'sigmoid'])}")
    if not found:
        return name
    opacities = [0, 1]
    if name.startswith("sigmoid"):
        steepness = int(found["steepness"] or 10)
        # Between 65 the curve is within 0.005 of straight up to a steepness of 20. It has 256 levels, so that it ends in 0.
        opacities = [int(255 / (1 + math.exp(-steepness * i / 32))) / 255 for i in range(-32, 33)]
    return opacities[::-1] if found["reversed"] else opacities


def _opacities(opacity, span):
    """PyVista's opacities, one, named or evenly spaced over `span`, two values or what returns them, as pairs of value and opacity."""
    if isinstance(opacity, str):
        opacity = _named_opacities(opacity)
    elif isinstance(opacity, numbers.Real) and not isinstance(opacity, bool):
        opacity = [opacity, opacity]
    if not _is_sequence(opacity):
        return opacity
    opacity = list(opacity)
    if not opacity or any(_is_sequence(point) or isinstance(point, str) for point in opacity):
        return opacity
    ends = span() if callable(span) else span
    if not _is_sequence(ends):
        raise InvalidArgument("opacity: numbers without values are spread over clim, two numbers that are not given; expected (value, opacity) pairs")
    try:
        lo, hi = (float(end) for end in ends)
        step = (hi - lo) / max(1, len(opacity) - 1)
        return [(lo + i * step, float(number)) for i, number in enumerate(opacity)]
    except (TypeError, ValueError, OverflowError):
        raise InvalidArgument(f"opacity = {opacity!r}, over {ends!r}: expected numbers from 0 to 1 over two values") from None


def _color(value):
    """A colour's red, green and blue as text: of a name, or of three numbers, the fourth of which may be its opacity."""
    if isinstance(value, str):
        text = _core.color_text(value)
        return [f"{int(text[i:i + 2], 16) / 255:.4g}" for i in (1, 3, 5)]
    try:
        parts = [float(part) for part in value][:4]
    except (TypeError, ValueError, OverflowError):
        parts = []
    if len(parts) < 3 or not all(0 <= part <= 1 for part in parts):
        raise InvalidArgument(f"cmap: {value!r}: expected a colour: three numbers from 0 to 1, or text")
    return [f"{part:.4g}" for part in parts[:3]]


_PIECES = 64  # of a colour map of matplotlib's; between them colours go straight, within 1/255 of the smooth ones


def colors(cmap):
    """A colour map as the program takes it: its name, or colours evenly spaced, of a list or of matplotlib's."""
    if callable(cmap) and hasattr(cmap, "name") and hasattr(cmap, "N"):
        name = str(cmap.name)
        if name.removesuffix("_r") in _core.color_map_names():
            return name
        cmap = [cmap(i / _PIECES) for i in range(_PIECES + 1)]
    if not _is_sequence(cmap):
        return cmap
    steps = list(cmap)
    if not any(_is_sequence(color) or isinstance(color, str) for color in steps):
        return ",".join(_scalar(number) for number in steps)  # value, red, green, blue, ...
    if len(steps) < 2:
        raise InvalidArgument(f"cmap = {cmap!r}: expected two colours or more")
    return ",".join(part for i, color in enumerate(steps) for part in (f"{i / (len(steps) - 1):.6g}", *_color(color)))


def _unknown(name, command):
    if command == "render" and name in _OF_OTHERS:
        return UnknownSetting(f"{name}: unknown setting; {_OF_OTHERS[name]}")
    of_render = [*_ALIASES, "cpos", "blending", "spacing", "origin", "direction", "affine", "space", "state"]
    known = [*table(command), *(of_render if command == "render" else [])]
    return UnknownSetting(f"{name}: unknown setting{_core.did_you_mean(name, known)}")


def canonical(given, span=None, command="render"):
    """Settings by the program's names alone. `span` tells the range of an array's values, where it is known."""
    chosen = {}

    def choose(name, key, value):
        if key in chosen:
            raise InvalidArgument(f"{name}: says the same as another setting; give one of them")
        chosen[key] = value

    for name, value in given.items():
        if value is None:
            continue
        key = _ALIASES.get(name, name)
        if command != "render" and key not in table(command):
            key = name
        if key in table(command):
            choose(name, key, value)
        elif key == "cpos" and command == "render":
            choose(name, *_camera(value))
        elif key == "blending" and command == "render":
            if not isinstance(value, str) or value not in _BLENDINGS:
                raise InvalidArgument(f"blending = {value!r}: expected one of {', '.join(_BLENDINGS)}")
            choose(name, "mode", _BLENDINGS[value])
        elif f"no_{key}" in table(command) and isinstance(value, bool):
            if not value:
                choose(name, f"no_{key}", True)
        else:
            raise _unknown(name, command)
    if "colormap" in chosen:
        chosen["colormap"] = colors(chosen["colormap"])
    if isinstance(chosen.get("spacing"), numbers.Real) and not isinstance(chosen["spacing"], bool):
        chosen["spacing"] = (chosen["spacing"],) * 3
    if "opacity" in chosen:
        ends = chosen["range"] if "range" in chosen else (lambda: span(chosen.get("array")) if span else None)
        chosen["opacity"] = _opacities(chosen["opacity"], ends)
    return chosen


def words(chosen, command="render"):
    """Canonical settings as words of a command line."""
    found = []
    for name, value in chosen.items():
        of_name = _words_of(name, value, command)
        if any("\0" in word for word in of_name):  # where a word would end without a word
            raise InvalidArgument(f"{name} = {value!r}: holds a NUL")
        found += of_name
    return found


def words_for(command, given):
    """Settings of a command as words of its command line."""
    return words(canonical(given, command=command), command)
