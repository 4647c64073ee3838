# SPDX-License-Identifier: Apache-2.0
"""Small HDF5 files, made through the C library, which is there wherever the program is built."""
import ctypes
import ctypes.util
from pathlib import Path

KINDS = {"f8": ("DOUBLE", ctypes.c_double), "f4": ("FLOAT", ctypes.c_float), "i8": ("INT64", ctypes.c_int64),
         "u1": ("UINT8", ctypes.c_uint8)}


def library():
    for name in ("hdf5_serial", "hdf5"):
        if found := ctypes.util.find_library(name):
            h5 = ctypes.CDLL(found)
            break
    else:
        raise SystemExit("no HDF5 library to make files with: install libhdf5-dev")
    h, p, s = ctypes.c_int64, ctypes.c_void_p, ctypes.c_char_p
    for name, result, arguments in (
            ("open", ctypes.c_int, []), ("Fcreate", h, [s, ctypes.c_uint, h, h]), ("Fclose", ctypes.c_int, [h]),
            ("Gcreate2", h, [h, s, h, h, h]), ("Gclose", ctypes.c_int, [h]), ("Screate", h, [ctypes.c_int]),
            ("Screate_simple", h, [ctypes.c_int, p, p]), ("Tcopy", h, [h]), ("Tset_size", ctypes.c_int, [h, ctypes.c_size_t]),
            ("Dcreate2", h, [h, s, h, h, h, h, h]), ("Dwrite", ctypes.c_int, [h, h, h, h, h, p]),
            ("Acreate_by_name", h, [h, s, s, h, h, h, h, h]), ("Awrite", ctypes.c_int, [h, h, p]),
            ("Aclose", ctypes.c_int, [h]), ("Dclose", ctypes.c_int, [h])):
        function = getattr(h5, f"H5{name}")
        function.restype, function.argtypes = result, arguments
    h5.H5open()
    return h5


class Hdf5File:
    """with Hdf5File(path) as file: file.group("g"), file.dataset("g/d", "f8", values, dims), file.attribute(...)."""

    def __init__(self, path):
        self.h5 = library()
        self.file = self.h5.H5Fcreate(str(Path(path)).encode(), 2, 0, 0)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.h5.H5Fclose(self.file)

    def group(self, name):
        self.h5.H5Gclose(self.h5.H5Gcreate2(self.file, name.encode(), 0, 0, 0))

    def dataset(self, name, kind, values, dims=None):
        kind, space, data = self._numbers(kind, values, dims or [len(values)])
        made = self.h5.H5Dcreate2(self.file, name.encode(), kind, space, 0, 0, 0)
        self.h5.H5Dwrite(made, kind, 0, 0, 0, data)
        self.h5.H5Dclose(made)

    def attribute(self, name, key, value, kind="i8"):
        if isinstance(value, bytes):
            data, space = ctypes.create_string_buffer(value), self.h5.H5Screate(0)
            kind = self.h5.H5Tcopy(self._type("C_S1"))
            self.h5.H5Tset_size(kind, len(value))
        else:
            kind, space, data = self._numbers(kind, value, [len(value)])
        made = self.h5.H5Acreate_by_name(self.file, name.encode(), key.encode(), kind, space, 0, 0, 0)
        self.h5.H5Awrite(made, kind, data)
        self.h5.H5Aclose(made)

    def _type(self, name):
        return ctypes.c_int64.in_dll(self.h5, f"H5T_{name}_g").value

    def _numbers(self, kind, values, dims):
        name, c_type = KINDS[kind]
        sizes = (ctypes.c_uint64 * len(dims))(*dims)
        return (self._type(f"NATIVE_{name}"), self.h5.H5Screate_simple(len(dims), sizes, None),
                (c_type * len(values))(*values))
