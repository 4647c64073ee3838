# SPDX-License-Identifier: Apache-2.0
"""Ovoid draws volumes straight from their points: ``ovoid.render(array)`` is a picture.

What draws is loaded by the first name that is used, so that the import costs a few milliseconds.
"""
import importlib
import sys

_MODULES = {
    "_data": ("Data", "info", "lattice", "particles", "read", "write"),
    "_meshes": ("mesh",),
    "_errors": ("Cancelled", "DeviceLost", "Error", "FileFormat", "FileWrite", "InvalidArgument", "NotFound", "OutOfMemory",
                "UnknownSetting", "Unsupported"),
    "_functions": ("Samples", "Slice", "fit", "histogram", "resample", "sample", "simplify", "slice"),
    "_interact": ("Interactive", "interact"),
    "_picture": ("Picture",),
    "_scene": ("Scene", "View", "animate", "render"),
    "_series": ("series",),
    "_settings": ("settings",),
    "_view": ("view",),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}

__all__ = sorted([*_MODULE_OF, "__version__"])


def __getattr__(name):
    if name == "__version__":
        value = importlib.import_module("._core", __name__).version
    elif name in _MODULE_OF:
        value = getattr(importlib.import_module("." + _MODULE_OF[name], __name__), name)
    else:
        raise AttributeError(f"module 'ovoid' has no attribute '{name}'", name=name, obj=sys.modules[__name__])  # Python finds a like one
    globals()[name] = value
    return value


def __dir__():
    return __all__
