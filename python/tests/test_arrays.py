# SPDX-License-Identifier: Apache-2.0
"""Arrays of any kind and layout draw the same picture; those that are as the library keeps them are not copied."""
import gc
import subprocess
import sys

import numpy as np
import ovoid
import ovoid._data
import pytest
from conftest import SMALL, bumps

LAST_BITS = 1e-4  # sums in another order of axes differ by some 1e-6 on image sheets


def pixels(data, **settings):
    return ovoid.render(data, **SMALL, **settings).numpy()


@pytest.mark.parametrize("change", [
    np.asfortranarray,
    lambda a: np.ascontiguousarray(a[:, :, ::-1])[:, :, ::-1],
    lambda a: np.repeat(np.repeat(a, 2, 0), 3, 2)[::2, :, ::3],
    lambda a: np.ascontiguousarray(a.transpose(1, 2, 0)).transpose(2, 0, 1),
    lambda a: a[..., np.newaxis],
    lambda a: a.tolist(),
    lambda a: memoryview(a),
    lambda a: np.ma.masked_array(a, mask=False),
    lambda a: np.rec.fromarrays([a], names="density"),
])
def test_layouts(array, expected, change):
    settings = {}
    changed = change(array)
    if isinstance(changed, list):  # numpy makes 64 bits of these
        expected = pixels(array.astype("i8"))
    assert (pixels(changed, **settings) == expected).all()


@pytest.mark.parametrize("dtype", ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8", "f2", "g", "?", "q", "Q"])
def test_types(dtype):
    field = (bumps() > 80).astype(dtype) if dtype == "?" else (bumps() // 2).astype(dtype)
    native = pixels(field)
    assert native.std() > 5
    swapped = field.astype(field.dtype.newbyteorder())
    assert (pixels(swapped) == native).all()


def test_masked_values_are_missing(array):
    mask = np.zeros(array.shape, bool)
    mask[:, :, 14:] = True
    holes = array.astype("f4")
    holes[mask] = np.nan
    assert (pixels(np.ma.masked_array(array, mask)) == pixels(holes)).all()
    assert (pixels(holes) != pixels(array)).any()


def test_flat(array):
    assert (pixels(array[5]) == pixels(array[5:6])).all()


def test_vectors():
    vectors = np.stack([bumps(dtype="f4"), bumps(dtype="f4") ** 2, np.zeros_like(bumps(dtype="f4"))], axis=-1)
    assert (pixels(vectors, component=0) == pixels(bumps(dtype="f4"))).all()
    assert (pixels(vectors) != pixels(bumps(dtype="f4"))).any()  # their length


def test_direction_turns(array):
    """The axes x and y exchanged in the world are the axes x and y exchanged in the array, seen from the same place."""
    same = {"camera": ovoid.render(array, **SMALL).camera, "sheets": "image", **SMALL}
    turned = ovoid.render(array.transpose(0, 2, 1), direction=[[0, 1, 0], [1, 0, 0], [0, 0, 1]], **same)
    assert abs(turned.rgba - ovoid.render(array, **same).rgba).max() < LAST_BITS


def test_protocols(array, expected):
    class Interface:
        __array_interface__ = array.__array_interface__
        kept = array

    class Chunked:
        shape, dtype = array.shape, array.dtype

        def __getitem__(self, where):
            return array[where]

    assert (pixels(Interface()) == expected).all()
    assert (pixels(Chunked()) == expected).all()


@pytest.mark.parametrize("module", ["dask.array", "h5py", "zarr"])
def test_friends(tmp_path, array, expected, module):
    friend = pytest.importorskip(module)
    if module == "h5py":
        with friend.File(tmp_path / "a.h5", "w") as file:
            assert (pixels(file.create_dataset("a", data=array, chunks=True)) == expected).all()
    else:
        made = friend.array(array) if module == "zarr" else friend.from_array(array, chunks=8)
        assert (pixels(made) == expected).all()


def test_xarray(array):
    xarray = pytest.importorskip("xarray")
    places = {"z": 5 + 3.0 * np.arange(20), "y": np.arange(24.0), "x": 0.5 * np.arange(28)}
    named = xarray.DataArray(array, dims=("z", "y", "x"), coords=places, name="heat", attrs={"units": "K"})
    expected = pixels(array, spacing=(0.5, 1, 3), origin=(0, 0, 5))
    assert (pixels(named) == expected).all()
    facts = ovoid.info(named)
    assert facts["arrays"][0]["name"] == "heat" and facts["arrays"][0]["unit"] == "K"
    falling = named.isel(y=slice(None, None, -1))  # the same places
    same = {"camera": ovoid.render(named, **SMALL).camera, "sheets": "image", **SMALL}
    assert abs(ovoid.render(falling, **same).rgba - ovoid.render(named, **same).rgba).max() < LAST_BITS
    uneven = named.assign_coords(x=np.arange(28.0) ** 2)
    with pytest.raises(ovoid.InvalidArgument, match="coordinate 'x': is not evenly spaced"):
        ovoid.render(uneven)
    with pytest.raises(ovoid.InvalidArgument, match="coordinates of their own"):
        ovoid.render(named, spacing=(1, 1, 1))


def test_memory_is_shared(array):
    before = sys.getrefcount(array)
    data = ovoid._data.data_of(array)
    assert data.arrays["values"].__array_interface__["data"][0] == array.__array_interface__["data"][0]
    assert sys.getrefcount(array) > before
    del data
    gc.collect()
    assert sys.getrefcount(array) == before
    xyz = np.zeros((5, 3), "f4")
    assert np.shares_memory(ovoid.particles(xyz).positions, xyz)


def test_memory_maps_are_shared(tmp_path, array, expected):
    np.save(tmp_path / "a.npy", array)
    mapped = np.load(tmp_path / "a.npy", mmap_mode="r")
    assert np.shares_memory(ovoid._data.data_of(mapped).arrays["values"], mapped)
    assert (pixels(mapped) == expected).all()


def test_array_lives_as_long_as_what_is_made_of_it(expected):
    """numpy frees the memory when the last holder lets go; what still reads it then draws something else, or crashes."""
    array = bumps()
    data = ovoid._data.data_of(array)
    view = data.arrays["values"]
    scene = ovoid.Scene(data, **SMALL)
    del array, data
    gc.collect()
    np.full((20, 24, 28), 255, "u1")  # takes memory that was let go
    assert (scene.render().numpy() == expected).all()
    del scene
    gc.collect()
    assert (view == bumps()).all()


def test_arrays_are_let_go():
    array = bumps(dtype="f4")
    before = sys.getrefcount(array)
    for _ in range(3):
        ovoid.render(array, **SMALL)
    gc.collect()
    assert sys.getrefcount(array) == before


def test_large_arrays_take_no_second_copy():
    """Peak memory of an array that is shared, and of one of another order, which is copied."""
    script = """
import sys
import numpy, ovoid

def status(key):
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) * 1024 for line in file if line.startswith(key))

side = int(sys.argv[1])
array = numpy.full((side, side, side), 10, "u1", order=sys.argv[2])
array[side // 4:side // 2] = 200
ovoid.render(array[:8, :8, :8], size=(64, 48))
before = status("VmRSS")
ovoid.render(array, size=(64, 48), kernel="gaussian")
print(status("VmHWM") - before)
"""
    side = 256
    shared, copied = (int(subprocess.run([sys.executable, "-c", script, str(side), order], capture_output=True, text=True, check=True).stdout)
                      for order in "CF")
    assert copied - shared > 0.7 * side**3


def test_a_row_of_samples_that_lies_askew():
    """Wide pixels by the finest spacing, along which there is one sample alone. Fails under AddressSanitizer if places are looked at
    that only wider kernels would reach."""
    direction = [(-0.172, 1, 0), (0, -1, -0.18), (0, -0.5, 0)]
    array = np.array([[515], [1025], [34560], [51727], [49374]], "u2")
    settings = {"spacing": (1, 9, 9), "direction": direction, "size": (9, 7), "threads": 1}
    drawn, expected = (ovoid.render(array, **settings, backend=backend).numpy().astype(int) for backend in ("cpu", "reference"))
    assert abs(drawn - expected).max() <= 1


def test_what_is_read_has_the_shape_that_was_told(array):
    class Liar:
        shape, dtype = (20, 24, 28), array.dtype

        def __getitem__(self, block):
            return array[1:]

    with pytest.raises(ovoid.InvalidArgument, match=r"has the shape \(20, 24, 28\), but what is read of it \(19, 24, 28\)"):
        ovoid.render(Liar(), **SMALL)


def test_masks_of_what_is_read_are_kept(array):
    class Masked:
        shape, dtype = array.shape, array.dtype

        def __getitem__(self, block):
            return np.ma.masked_greater(array, 100)[block]

    assert (pixels(Masked()) == pixels(np.ma.masked_greater(array, 100))).all()


def test_data_are_arrays(array):
    """The only one there is, or one by its name, without a copy."""
    data = ovoid.lattice(array)
    assert np.shares_memory(data.numpy(), array) and np.shares_memory(np.asarray(data), array)
    assert np.array(data, dtype="f4").dtype == np.float32 and not np.shares_memory(np.array(data), array)
    cloud = ovoid.particles(np.eye(3), {"a": np.arange(3), "b": np.arange(6).reshape(3, 2)})
    assert cloud.numpy("b").shape == (3, 2) and repr(cloud) == "<ovoid.Data particles 'particles', 3 points: a, b>"
    for given, words in ((None, "array = None: the data have 'a', 'b'"), ("c", "array = 'c': the data have 'a', 'b'")):
        with pytest.raises(ovoid.InvalidArgument, match=words):
            cloud.numpy(given)


def test_scenes_and_views_tell_what_they_are_of(tmp_path, array):
    scene = ovoid.Scene(array, cmap="magma")
    assert repr(scene) == "<ovoid.Scene of <ovoid.Data lattice 'array', 28 x 24 x 20: values> with cmap>"
    assert repr(scene.view(azimuth=3)) == f"<ovoid.View of {scene!r} with azimuth>"
    ovoid.write(tmp_path / "a.nrrd", array)
    assert repr(ovoid.Scene(tmp_path / "a.nrrd")) == f"<ovoid.Scene of {tmp_path}/a.nrrd>"
