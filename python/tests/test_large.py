# SPDX-License-Identifier: Apache-2.0
"""Arrays that memory does not hold, by a limit that is small."""
import numpy as np
import ovoid
import pytest
from conftest import SMALL, bumps

LIMITED = {"memory_limit": "1M", "kernel": "catmull-rom", **SMALL}


class Lazy:
    """What can be read in blocks alone."""

    def __init__(self, values, chunks=None):
        self.values, self.chunks, self.read = values, chunks, []
        self.shape, self.dtype = values.shape, values.dtype

    def __getitem__(self, block):
        self.read.append(block)
        return self.values[block]


@pytest.fixture(scope="module")
def large():
    return bumps((64, 80, 96))


@pytest.fixture(scope="module")
def drawn(large):
    return ovoid.render(large, kernel="catmull-rom", **SMALL).numpy()


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    """Nothing stays behind in the folder of temporary files."""
    import tempfile

    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr(tempfile, "tempdir", None)
    yield folder
    assert not list(folder.iterdir())


def stayed(picture):
    return any("are read from a file" in note for note in picture.notes)


@pytest.mark.parametrize("order", ["<", ">"])
def test_memory_maps_stay_in_their_files(tmp_path, large, drawn, order):
    values = large if order == "<" else large.astype(">u2")
    path = tmp_path / "a file, of numbers.raw"
    with open(path, "wb") as file:
        file.write(b"header of 17 bytes" + values.tobytes())
    mapped = np.memmap(path, values.dtype, "r", 18, values.shape)
    picture = ovoid.render(mapped, **LIMITED)
    assert stayed(picture)
    assert (picture.numpy() == ovoid.render(values, kernel="catmull-rom", **SMALL).numpy()).all()
    part = ovoid.render(mapped[8:], **LIMITED)
    assert stayed(part) and (part.numpy() == ovoid.render(values[8:], kernel="catmull-rom", **SMALL).numpy()).all()


def test_other_memory_maps_are_copied(tmp_path, large):
    path = tmp_path / "array.raw"
    large.tofile(path)
    mapped = np.memmap(path, large.dtype, "r", shape=large.shape)[:, ::-1]
    picture = ovoid.render(mapped, **LIMITED)
    assert stayed(picture) and (picture.numpy() == ovoid.render(large[:, ::-1], kernel="catmull-rom", **SMALL).numpy()).all()


@pytest.mark.parametrize("chunks", [None, (16, 32, 96), (20, 33, 50), ((30, 34), (80,), (96,)), "odd"])
def test_blocks_are_read_once(large, drawn, chunks):
    lazy = Lazy(large, chunks)
    picture = ovoid.render(lazy, **LIMITED)
    assert stayed(picture) and (picture.numpy() == drawn).all()
    times = np.zeros(large.shape, int)
    for block in lazy.read:
        times[block] += 1
    assert (times == 1).all()
    if isinstance(chunks, tuple):
        edges = set(np.cumsum((0, *chunks[0]))) if isinstance(chunks[0], tuple) else set(range(0, 65, chunks[0])) | {64}
        assert {block[0].start for block in lazy.read} <= edges


def test_what_memory_holds_is_read_as_a_whole(large, drawn):
    lazy = Lazy(large)
    picture = ovoid.render(lazy, kernel="catmull-rom", **SMALL)
    assert not stayed(picture) and (picture.numpy() == drawn).all()


def test_other_types_stay_as_floats(large):
    doubles = large / 200.0
    picture = ovoid.render(Lazy(doubles), **LIMITED)
    assert stayed(picture) and (picture.numpy() == ovoid.render(doubles.astype("f4"), kernel="catmull-rom", **SMALL).numpy()).all()


def test_masked_floats_are_missing(large):
    values = np.ma.masked_greater(large.astype("f4"), 150)
    picture = ovoid.render(Lazy(values), **LIMITED)
    assert stayed(picture) and (picture.numpy() == ovoid.render(values, kernel="catmull-rom", **SMALL).numpy()).all()
    with pytest.raises(ovoid.OutOfMemory, match="masked"):
        ovoid.render(Lazy(np.ma.masked_greater(large, 150)), **LIMITED)


def test_place_and_unit_are_kept(large):
    placed = ovoid.Scene(Lazy(large), spacing=(1, 2, 3), origin=(4, 5, 6), **LIMITED)
    assert placed.slice("z", size=8).extent == ovoid.Scene(large, spacing=(1, 2, 3), origin=(4, 5, 6), kernel="catmull-rom").slice("z", size=8).extent


def test_a_source_that_fails_in_the_middle(large):
    class Failing(Lazy):
        def __getitem__(self, block):
            if len(self.read) == 3:
                raise OSError("the disk is gone")
            return super().__getitem__(block)

    with pytest.raises(OSError, match="the disk is gone"):
        ovoid.render(Failing(large, (16, 80, 96)), **LIMITED)


def test_blocks_of_another_shape_are_refused(large):
    class Short(Lazy):
        def __getitem__(self, block):
            return super().__getitem__(block)[:-1]

    with pytest.raises(ovoid.InvalidArgument, match="block"):
        ovoid.render(Short(large), **LIMITED)


def test_too_little_disk_is_told_before(large, monkeypatch):
    import os

    monkeypatch.setattr(os, "statvfs", lambda folder: type("disk", (), {"f_bavail": 10, "f_frsize": 100}))
    with pytest.raises(ovoid.OutOfMemory, match="TMPDIR"):
        ovoid.render(Lazy(large), **LIMITED)


def test_memory_stays_within_the_limit():
    """A process of its own takes values of an array of 128 MiB, with 16 MiB for its samples."""
    import subprocess
    import sys

    script = """
import resource, numpy as np, ovoid

class Layers:
    shape, dtype = (512, 512, 512), np.dtype("u1")
    layer = np.add.outer(np.arange(512), np.arange(512)).astype("u1") // 2
    def __getitem__(self, block):
        return np.broadcast_to(self.layer[block[1:]], tuple(part.stop - part.start for part in block))

def taken(array, **settings):
    return ovoid.sample(array, [(30, 40, 5), (100, 20, 500)], kernel="catmull-rom", **settings).value

taken(np.zeros((64, 64, 64)))
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
assert abs(taken(Layers(), memory_limit="16M") - (35, 60)).max() < 0.5
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
"""
    done = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True)
    assert float(done.stdout) < 96  # the pages, a block of 16 MiB, a slab in which ranges are found and its ranges
