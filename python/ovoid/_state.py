# SPDX-License-Identifier: Apache-2.0
"""States: what is looked at and how, as `Picture.state`, windows and state files have it."""
import json
import os

from . import _core
from ._errors import InvalidArgument


def read(path):
    """A state file as a dict, with its inputs as they can be opened from here."""
    inputs, flags = _core.read_state(os.fspath(path))
    return {"ovoid_state": 1, "program": _core.version, "inputs": inputs, "flags": json.loads(flags)}


def merged(state, settings):
    """Inputs of a state, and its flags as settings under those that are given."""
    if state is None:
        return [], dict(settings)
    if not isinstance(state, dict):
        if not isinstance(state, (str, os.PathLike)):
            raise InvalidArgument(f"state = {state!r}: expected a dict as Picture.state, or a state file")
        state = read(state)
    inputs, flags = state.get("inputs", []), state.get("flags")
    if state.get("ovoid_state") != 1 or not isinstance(flags, dict) or not isinstance(inputs, list):
        raise InvalidArgument("state: is no state: expected a dict as Picture.state, with \"ovoid_state\": 1, \"inputs\" and \"flags\"")
    from . import _settings

    given = _settings.canonical(settings)
    kept = {name.replace("-", "_"): value for name, value in flags.items()}
    # What is given takes the place of the flag that says the opposite, too.
    beaten = {*given, *(f"no_{name}" for name in given), *(name[3:] for name in given if name.startswith("no_"))}
    if "camera" in given or "view" in given:
        beaten |= {"camera", "view"}
    return inputs, {**{name: value for name, value in kept.items() if name not in beaten}, **settings}
