# SPDX-License-Identifier: Apache-2.0
"""What goes wrong, in the words of the program."""


class Error(Exception):
    """What the library refuses or cannot do.

    Attributes
    ----------
    code : str
        The library's name for the kind of error, such as ``"file-format"``.
    """

    code = "invalid-argument"


class InvalidArgument(Error, ValueError):
    """A value outside its documented range."""


class UnknownSetting(InvalidArgument, TypeError):
    """A setting of a name that there is not; the message suggests one."""


class NotFound(Error, FileNotFoundError):
    """A path that does not exist or cannot be read."""

    code = "file-not-found"


class FileFormat(Error, ValueError):
    """A file that contradicts itself or is not what its header says."""

    code = "file-format"


class Unsupported(Error, NotImplementedError):
    """What this build or this version of a format cannot do."""

    code = "unsupported"


class FileWrite(Error, OSError):
    """A file that cannot be written; nothing is left behind."""

    code = "file-write"


class OutOfMemory(Error, MemoryError):
    """Memory that the system, or a limit, does not grant."""

    code = "out-of-memory"


class DeviceLost(Error, RuntimeError):
    """The graphics device stopped working; the next picture starts it anew."""

    code = "device-lost"


class Cancelled(Error):
    """Work that was stopped."""

    code = "cancelled"


_OF_CODES = {kind.code: kind for kind in (InvalidArgument, NotFound, FileFormat, Unsupported, FileWrite, OutOfMemory, DeviceLost, Cancelled)}


def error_of(code, words):
    """The exception of a code; the extension module raises it."""
    return _OF_CODES[code](words)
