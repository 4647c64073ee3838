# SPDX-License-Identifier: Apache-2.0
"""The program's window, on data that Python holds."""
import os
import shutil
import subprocess
import tempfile

from . import _core, _settings, _state
from ._data import is_path, paths_of
from ._errors import Error, Unsupported

# Formats that keep everything of data of a kind.
_ENDINGS = {"lattice": ".nrrd", "mesh": ".vtu", "particles": ".npz", "kernels": ".ply"}


def program():
    """The program's path: where the package is installed or built, else as a shell finds it. Raises Unsupported."""
    package = os.path.dirname(os.path.abspath(_core.__file__))
    beside = [os.path.normpath(os.path.join(package, *up, "bin", "ovoid")) for up in ([os.pardir] * 2, [os.pardir] * 4)]
    for path in [*beside, shutil.which("ovoid")]:
        if path and os.access(path, os.X_OK) and os.path.exists(os.path.join(os.path.dirname(path), "ovoid-viewer")):
            return path
    raise Unsupported("view: the program 'ovoid' with its window is not installed; in notebooks ovoid.interact turns pictures")


def _file_of(data, folder):
    """Data as a file for another process."""
    core = data._core
    if core.num_steps > 1:
        from . import _data

        path = os.path.join(folder, "array.pvd")
        _data.write(path, data)
        return path
    ending = _ENDINGS.get(core.kind)
    if ending is None:
        raise Unsupported(f"view: data of the kind '{core.kind}' are shown from their file alone: ovoid.view(path)")
    if core.kind == "lattice" and (len(core.array_names) > 1 or not core.is_cartesian):
        ending = ".h5"
    path = os.path.join(folder, "array" + ending)
    core.write(path)
    return path


def _renamed(value, names):
    """A flag's value, or several, with other names for some files."""
    if isinstance(value, list):
        return [_renamed(one, names) for one in value]
    return names.get(value, value) if isinstance(value, str) else value


def view(data=None, *, state=None, **settings):
    """Opens the program's window, and waits until it is closed.

    The window is a process of its own. It gets a copy of arrays in memory.

    Parameters
    ----------
    data : as `render` takes it, optional
        Without it the inputs of `state` are shown, or a window without data.
    state : dict, str or path, optional
        What to begin with: `Picture.state`, what another window gave back, or a state file.
    **settings
        As `render` takes them.

    Returns
    -------
    dict or None
        What was shown at the end, which the setting `state` of `render`, `Scene` and `view` takes. None if nothing was.

    Raises
    ------
    Unsupported
        Where the program or its window is not installed, or there is no screen.
    """
    from ._scene import Scene

    window = program()
    inputs, given = _state.merged(state, settings)
    with tempfile.TemporaryDirectory(prefix="ovoid-") as folder:
        own, copies = None, {}
        if data is None:
            words = _settings.words(_settings.canonical(given))
        else:
            scene = Scene(data, **given)
            words, beside = scene._asked(scene.settings)
            copies = {name: os.path.join(folder, name) for name in beside}
            for name, core in beside.items():
                core.write(copies[name])
            words = [copies.get(word, word) for word in words]
            if is_path(data):
                inputs = paths_of(data)
            else:
                own = _file_of(scene._data, folder)
                inputs = [own]
        kept = os.path.join(folder, "state.json")
        done = subprocess.run([window, "view", *words, "--save-state", kept, "--", *inputs], stdin=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True, errors="replace")
        if done.returncode:
            raise (Unsupported if "display" in done.stderr.lower() else Error)(done.stderr.strip() or f"view: the window ended with {done.returncode}")
        if not os.path.exists(kept):
            return None
        found = _state.read(kept)
        if own is not None and found["inputs"] == [own]:
            found["inputs"] = []
        names = {copy: name for name, copy in copies.items()}
        found["flags"] = {flag: _renamed(value, names) for flag, value in found["flags"].items()}
        return found
