# SPDX-License-Identifier: Apache-2.0
"""Steps of time in memory draw as their files do, to the byte, and share their memory."""
import datetime
import gc
import json
import subprocess
import sys

import numpy as np
import ovoid
import pytest
from conftest import FLAGS, PROGRAM, SMALL, block, bumps, data_of, heat_at, png
from test_states import stand_in

PLACE = {"spacing": (0.5, 1, 2), "origin": (3, -4, 5)}


def moved(step):
    """Bumps that go along x and grow."""
    return np.roll(bumps(), 3 * step, axis=2) // (3 - step % 3)


def swarm(step):
    """Particles that move and swell, with their numbers."""
    rng = np.random.default_rng(5)
    xyz = rng.normal(size=(300, 3)) + [0.8 * step, 0.3 * step**2, 0]
    return ovoid.particles(xyz, {"heat": heat_at(xyz / 4 + 0.5), "id": np.arange(300)}, h=np.full(300, 0.4))


def bent(step):
    points, cells, heat = block()
    return ovoid.mesh(points + [0.4 * step, 0, 0.1 * step * points[:, 0].max()], {"hexahedron": cells}, {"heat": heat * (1 + step)})


KINDS = {"lattice": (moved, ".nrrd", PLACE), "particles": (swarm, ".npz", {}), "mesh": (bent, ".vtu", {})}


def in_both(tmp_path, kind, count=4):
    """A series in memory, and the names of files of its steps."""
    make, ending, place = KINDS[kind]
    steps = [make(step) for step in range(count)]
    paths = [str(tmp_path / f"{kind}-{step}{ending}") for step in range(count)]
    for path, step in zip(paths, steps):
        ovoid.write(path, step, **place)
    return ovoid.series(steps, **place), paths


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("settings", [
    {},
    {"step": 2},
    {"time": 1.5},
    {"time": 0.25, "colorbar": True},
    {"step": 3, "motion_blur": 2},
    {"time": 2.5, "motion_blur": "1.5,1"},
    {"step": 1, "mode": "maximum"},
])
def test_as_files(tmp_path, kind, settings):
    given = {"array": "heat"} if kind == "particles" else {}
    series, paths = in_both(tmp_path, kind)
    picture = ovoid.render(series, **settings, **given, **SMALL)
    assert png(picture) == png(ovoid.render(paths, **settings, **given, **SMALL))
    flags = [word for name, value in {**settings, **given}.items() for word in (f"--{name.replace('_', '-')}", *([] if value is True else [str(value)]))]
    output = tmp_path / "program.png"
    subprocess.run([PROGRAM, "render", *paths, *flags, *FLAGS, "-o", str(output)], check=True, capture_output=True)
    assert png(picture) == output.read_bytes()
    if settings:
        assert png(picture) != png(ovoid.render(series, **given, **SMALL))


@pytest.mark.parametrize("settings", [{"hyperslice": (1, 0, 0, 1, 8)}, {"hyperslice": (0, 0, 0.5, 1, 5), "slice_spacing": 2},
                                      {"hyperslice": (0, 0, 0, 1, 1.5), "slice_method": "extracted", "points": 2}])
def test_hyperslices(tmp_path, settings):
    series, paths = in_both(tmp_path, "lattice")
    assert png(ovoid.render(series, **settings, **SMALL)) == png(ovoid.render(paths, **settings, **SMALL))


@pytest.mark.parametrize("kind", KINDS)
def test_a_written_series_is_the_same(tmp_path, kind):
    """With times, which a list of files does not name."""
    make, _, place = KINDS[kind]
    series = ovoid.series([make(step) for step in range(12)], times=np.cumsum([0.1] * 12), **place)
    ovoid.write(tmp_path / "data.pvd", series)
    for settings in ({"time": 0.37}, {"step": 4, "motion_blur": 0.25}):
        picture = ovoid.render(series, **settings, **SMALL)
        assert picture.command.startswith("ovoid render data.pvd ")
        assert png(picture) == png(ovoid.render(tmp_path / "data.pvd", **settings, **SMALL))
    assert ovoid.info(tmp_path / "data.pvd")["times"] == ovoid.info(series)["times"] == list(np.cumsum([0.1] * 12))


def test_a_written_series_keeps_its_space_and_units(tmp_path):
    """Which stand in no file of VTK's."""
    affine = np.diag([2.0, 3, 4, 1])
    series = ovoid.series([moved(step) for step in range(3)], times=[0, 5, 10], time_unit='m"s', affine=affine, space="RAS")
    ovoid.write(tmp_path / "scan.pvd", series)
    again = ovoid.info(tmp_path / "scan.pvd")
    assert (again["time_unit"], again["space"]) == ('m"s', "RAS")
    assert png(ovoid.render(tmp_path / "scan.pvd", step=1, **SMALL)) == png(ovoid.render(series, step=1, **SMALL))
    mixed = ovoid.series([ovoid.lattice(moved(0), space="LPS"), moved(1)])
    with pytest.raises(ovoid.InvalidArgument, match="one patient space"):
        ovoid.write(tmp_path / "mixed.pvd", mixed)


def test_of_a_whole_array(tmp_path):
    """(t, z, y, x), (t, z, y, x, component), fields, masked values and memory maps."""
    steps = np.stack([moved(step) for step in range(3)])
    expected = ovoid.render(ovoid.series(list(steps)), time=0.5, **SMALL).numpy()
    same = {"time": 0.5, **SMALL}
    assert (ovoid.render(ovoid.series(steps), **same).numpy() == expected).all()
    assert (ovoid.render(ovoid.series(steps[..., None]), **same).numpy() == expected).all()
    assert (ovoid.render(ovoid.series(np.rec.fromarrays([steps], names="heat")), **same).numpy() == expected).all()
    assert (ovoid.render(ovoid.series(np.asfortranarray(steps)), **same).numpy() == expected).all()
    mask = np.zeros(steps.shape, bool)
    mask[1, :, :5] = True
    holes = [np.where(gap, np.nan, step).astype("f4") for gap, step in zip(mask, steps)]
    assert (ovoid.render(ovoid.series(np.ma.masked_array(steps, mask)), **same).numpy() == ovoid.render(ovoid.series(holes), **same).numpy()).all()
    np.save(tmp_path / "steps.npy", steps)
    mapped = np.load(tmp_path / "steps.npy", mmap_mode="r")
    series = ovoid.series(mapped)
    assert np.shares_memory(series.steps[2].arrays["values"], mapped)
    assert (ovoid.render(series, memory_limit="1M", **same).numpy() == expected).all()
    flat = ovoid.series(steps[:, 5])  # (t, y, x)
    assert (ovoid.render(flat, step=1, **SMALL).numpy() == ovoid.render(steps[1, 5], **SMALL).numpy()).all()


def test_memory_is_shared():
    steps = [moved(step) for step in range(3)]
    whole = np.stack(steps)
    before = [sys.getrefcount(one) for one in (*steps, whole)]
    several, one = ovoid.series(steps), ovoid.series(whole)
    for number in range(3):
        assert np.shares_memory(several.steps[number].arrays["values"], steps[number])
        assert np.shares_memory(one.steps[number].arrays["values"], whole[number])
    picture = ovoid.render(several, time=1.5, motion_blur=1, **SMALL)
    ovoid.render(one, step=2, **SMALL)
    del several, one, picture
    gc.collect()
    assert [sys.getrefcount(one) for one in (*steps, whole)] == before


def test_arrays_live_as_long_as_the_series():
    scene = ovoid.Scene(ovoid.series([moved(step) for step in range(3)]), **SMALL)
    gc.collect()
    np.full((3, 20, 24, 28), 255, "u1")  # takes memory that was let go
    assert (scene.render(time=0.5).numpy() == ovoid.render(ovoid.series([moved(step) for step in range(3)]), time=0.5, **SMALL).numpy()).all()


def test_films(tmp_path):
    series, paths = in_both(tmp_path, "lattice")
    look = {"clim": (0, 120), **SMALL}
    for frames in ({"time": [0, 0.5, 2.75]}, {"step": range(3)}):
        drawn = [png(picture) for picture in ovoid.Scene(series, **look).view().frames(**frames)]
        assert drawn == [png(picture) for picture in ovoid.Scene(paths, **look).view().frames(**frames)]
        assert len(set(drawn)) == 3
    ovoid.animate(ovoid.Scene(series, **look).view().frames(step=range(4)), tmp_path / "film.gif")
    assert (tmp_path / "film.gif").read_bytes()[:3] == b"GIF"
    ovoid.animate(series, tmp_path / "path.gif", camera_path=[{"frame": 0}, {"frame": 2, "azimuth": 40}], step=1, **look)


def test_what_is_told(tmp_path):
    series, paths = in_both(tmp_path, "lattice")
    told, of_files = ovoid.info(series), ovoid.info(paths)
    assert told["steps"] == of_files["steps"] == 4 and told["times"] == [] and series.times is None
    assert repr(series) == "<ovoid.Data lattice 'array', 28 x 24 x 20: values, 4 steps>"
    assert [len(series.steps), len(series.steps[0].steps)] == [4, 1]
    timed = ovoid.series([moved(step) for step in range(4)], times=[0, 1, 2, 4.5], time_unit="ms")
    assert ovoid.info(timed)["time_unit"] == "ms" and timed.times.tolist() == [0, 1, 2, 4.5]
    assert ovoid.render(timed, time=1.25, **SMALL).notes == ["time 1.25: between steps 1 and 2, 25 % of the second"]
    nothing = ovoid.series([np.zeros((8, 8, 8)), bumps((8, 8, 8), "f8")])
    assert "array: step 1 of 2, the first that varies; choose with --step" in ovoid.render(nothing, **SMALL).notes


def test_the_other_commands(tmp_path):
    series, paths = in_both(tmp_path, "lattice")
    places = np.random.default_rng(1).uniform((3, -4, 5), (10, 10, 30), (20, 3))
    for settings in ({"step": 2}, {"time": 2.25}):
        assert np.array_equal(ovoid.sample(series, places, **settings).value, ovoid.sample(paths, places, **settings).value, equal_nan=True)
        assert (ovoid.slice(series, "z", size=32, **settings).values == ovoid.slice(paths, "z", size=32, **settings).values).all()
        assert (ovoid.histogram(series, **settings)[0] == ovoid.histogram(paths, **settings)[0]).all()
        grids = [next(iter(ovoid.resample(data, 16, **settings).arrays.values())) for data in (series, paths)]
        assert np.array_equal(*grids, equal_nan=True)
    assert ovoid.fit(series, psnr=30, step=1).report["kernels"] == ovoid.fit(paths, psnr=30, step=1).report["kernels"]


def test_opacities_spread_over_all_steps():
    steps = [moved(step) for step in range(3)]
    ends = min(step.min() for step in steps), max(step.max() for step in steps)
    expected = ovoid.render(ovoid.series(steps), step=0, opacity=[(ends[0], 0), (ends[1], 0.5)], **SMALL)
    assert png(ovoid.render(ovoid.series(steps), step=0, opacity=[0, 0.5], **SMALL)) == png(expected)


def test_steps_of_data(tmp_path):
    """Files, data with times of their own, and a step of a series."""
    series, paths = in_both(tmp_path, "lattice")
    same = {"time": 1.5, **SMALL}
    expected = png(ovoid.render(series, **same))
    assert png(ovoid.render(ovoid.series(paths), **same)) == expected
    assert png(ovoid.render(ovoid.series([ovoid.read(path) for path in paths]), **same)) == expected
    assert png(ovoid.render(ovoid.series(series.steps), **same)) == expected
    assert png(ovoid.render(series.steps[1], **SMALL)) == png(ovoid.render(paths[1], **SMALL))
    timed = ovoid.series(series.steps, times=[1, 2, 4, 8])
    ovoid.write(tmp_path / "timed.pvd", timed)
    read = ovoid.series([ovoid.read(tmp_path / "timed.pvd", step=step) for step in range(4)])
    assert read.times.tolist() == [1, 2, 4, 8]
    alone = ovoid.read(tmp_path / "timed.pvd", step=2)  # one step in memory, whatever its file holds
    assert ovoid.render(alone, **SMALL)._core.num_steps == 1


def test_dates():
    steps = [moved(step) for step in range(3)]
    start = datetime.datetime(2024, 5, 17, 12)
    dates = [start, start + datetime.timedelta(minutes=1), start + datetime.timedelta(minutes=3)]
    for times in (dates, np.array(dates, "M8[ns]"), np.array([0, 60, 180], "m8[s]"), [date - start for date in dates]):
        series = ovoid.series(steps, times)
        assert series.times.tolist() == [0, 60, 180] and ovoid.info(series)["time_unit"] == "s"
    assert ovoid.series(steps, dates, time_unit="seconds")._core.time_unit == "seconds"


class Coordinate:
    """What xarray's coordinates can do."""

    def __init__(self, values, **attrs):
        self.values, self.attrs = np.asarray(values), attrs


class Named:
    """And its arrays."""

    def __init__(self, data, dims, coords=None, name=None, attrs=None):
        self.data, self.dims, self.coords, self.name, self.attrs = data, dims, coords or {}, name, attrs or {}
        self.shape, self.dtype = data.shape, data.dtype

    def __getitem__(self, where):
        raise AssertionError("its data are taken")

    def __array__(self, *_):
        return self.data


def named(dims=("time", "z", "y", "x"), times=(0, 0.5, 2), **attrs):
    places = {"z": Coordinate(5 + 3.0 * np.arange(20)), "y": Coordinate(np.arange(24.0)), "x": Coordinate(0.5 * np.arange(28))}
    if times is not None:
        places[dims[0]] = Coordinate(times, **attrs)
    return Named(np.stack([moved(step) for step in range(3)]), dims, places, "heat", {"units": "K"})


def test_arrays_of_xarray_in_time():
    placed = {"spacing": (0.5, 1, 3), "origin": (0, 0, 5)}
    series = ovoid.series([moved(step) for step in range(3)], times=[0, 0.5, 2], **placed)
    expected = png(ovoid.render(series, time=0.75, **SMALL))
    whole = named(units="ms")
    assert png(ovoid.render(whole, time=0.75, **SMALL)) == expected
    told = ovoid.info(whole)
    assert (told["times"], told["time_unit"], told["arrays"][0]["name"], told["arrays"][0]["unit"]) == ([0, 0.5, 2], "ms", "heat", "K")
    assert np.shares_memory(data_of(whole).steps[1].arrays["heat"], whole.data)
    assert ovoid.info(named(dims=("t", "z", "y", "x"), times=None))["times"] == []
    assert data_of(named(dims=("T", "z", "y", "x"))).times.tolist() == [0, 0.5, 2]
    dates = np.array(["2024-05-17", "2024-05-18", "2024-05-20"], "M8[ns]")
    assert data_of(named(dims=("when", "z", "y", "x"), times=dates)).times.tolist() == [0, 86400, 259200]
    assert ovoid.series(named(dims=("frame", "z", "y", "x"))).times.tolist() == [0, 0.5, 2]  # named as such
    assert ovoid.series(named(), times=[3, 4, 5]).times.tolist() == [3, 4, 5]
    with pytest.raises(ovoid.InvalidArgument, match="coordinates of their own"):
        ovoid.series(whole, spacing=(1, 1, 1))
    with pytest.raises(ovoid.InvalidArgument, match="coordinates of their own"):
        ovoid.render(whole, spacing=(1, 1, 1))


def test_four_axes_without_time():
    colours = Named(np.stack([bumps()] * 3, axis=-1), ("z", "y", "x", "component"))
    assert len(data_of(colours).steps) == 1
    with pytest.raises(ovoid.InvalidArgument, match=r"all steps by ovoid\.series\(array\)"):
        ovoid.render(np.zeros((5, 8, 8, 8)))


def test_xarrays_own(array):
    xarray = pytest.importorskip("xarray")
    whole = xarray.DataArray(np.stack([moved(step) for step in range(3)]), dims=("time", "z", "y", "x"), coords={"time": [0, 0.5, 2]})
    assert png(ovoid.render(whole, time=0.75, **SMALL)) == png(ovoid.render(ovoid.series(list(whole.data), [0, 0.5, 2]), time=0.75, **SMALL))


STEPS = [bumps(), bumps() // 2]


@pytest.mark.parametrize("make, words", [
    (lambda: ovoid.series([]), "steps: is empty, expected at least one"),
    (lambda: ovoid.series(iter([])), "steps: is empty"),
    (lambda: ovoid.series(np.zeros((0, 8, 8, 8))), "steps: is empty"),
    (lambda: ovoid.series("scan.nrrd"), "steps: is one str, expected a list of steps"),
    (lambda: ovoid.series(ovoid.lattice(bumps())), "steps: is one Data"),
    (lambda: ovoid.series(3), "steps: is one int"),
    (lambda: ovoid.series(np.zeros((8, 8))), "steps: is one ndarray"),
    (lambda: ovoid.series([bumps(), 3]), r"steps\[1\]: data: has the shape \(\)"),
    (lambda: ovoid.series([bumps(), "abc".encode()]), r"steps\[1\]"),
    (lambda: ovoid.series([bumps(), bumps((20, 24, 27))]), "step 1: has 27 x 24 x 20 samples, step 0 has 28 x 24 x 20: the steps of a series are alike"),
    (lambda: ovoid.series([bumps(), bumps(dtype="f4")]), "step 1: array 'values' is float32, in step 0 uint8"),
    (lambda: ovoid.series([bumps(), np.stack([bumps()] * 3, -1)]), "step 1: array 'values' has 3 components, in step 0 1"),
    (lambda: ovoid.series([bumps(), swarm(0)]), "step 1: holds particles, step 0 lattice"),
    (lambda: ovoid.series([swarm(0), ovoid.particles(np.zeros((3, 3)), {"cold": np.zeros(3)})]), "step 1: has no array 'heat'"),
    (lambda: ovoid.series([ovoid.lattice(bumps()), ovoid.lattice(bumps(), origin=(1, 0, 0))]), "step 1: lies 1 off the place of step 0"),
    (lambda: ovoid.series([ovoid.lattice(bumps()), ovoid.lattice(bumps(), spacing=(1, 2, 1))]), "step 1: its axes are not those of step 0"),
    (lambda: ovoid.series([swarm(0)], spacing=(1, 1, 1)), r"steps\[0\]: spacing, origin"),
    (lambda: ovoid.series([ovoid.series(STEPS)]), r"steps\[0\]: is a series of 2 steps itself, expected one"),
    (lambda: ovoid.series(STEPS, [0]), "times: 1 of 2 steps: expected one each"),
    (lambda: ovoid.series(STEPS, []), "times: 0 of 2 steps: expected one each"),
    (lambda: ovoid.series(STEPS, [1, 0]), r"times\[1\] = 0: expected finite times that rise"),
    (lambda: ovoid.series(STEPS, [1, 1]), r"times\[1\] = 1: expected finite times that rise"),
    (lambda: ovoid.series(STEPS, [np.nan, 1]), r"times\[0\] = nan: expected finite times that rise"),
    (lambda: ovoid.series(STEPS, [0, np.inf]), r"times\[1\] = inf"),
    (lambda: ovoid.series(STEPS, np.array(["2024-05-17", "NaT"], "M8[s]")), r"times\[1\] = nan"),
    (lambda: ovoid.series(STEPS, ["soon", "later"]), "expected a number or a date for each step"),
    (lambda: ovoid.series(STEPS, 3), "times = 3: expected a number or a date for each step"),
    (lambda: ovoid.series(STEPS, [None, None]), "expected a number or a date for each step"),
    (lambda: ovoid.render(ovoid.series(STEPS), step=2), "step 2: expected 0 to 1"),
    (lambda: ovoid.render(ovoid.series(STEPS), step=1, time=1), "give one of them"),
    (lambda: ovoid.render(ovoid.series(STEPS), dims=(1, 2, 3)), "--dims: is for files, these data are in memory"),
    (lambda: ovoid.render(ovoid.series(STEPS[:1]), time=0), r"--time: is for data in time, these are one step; ovoid\.series makes data of several"),
    (lambda: ovoid.render(ovoid.series(STEPS[:1]), motion_blur=1), "--motion-blur: is for data in time, these are one step"),
    (lambda: ovoid.render(bumps(), labels=ovoid.series(STEPS)), "labels: is a series of 2 steps, expected one"),
    (lambda: ovoid.write("a.nrrd", ovoid.series(STEPS)), r"'a\.nrrd': holds one step, the data are a series of 2: expected \.pvd"),
])
def test_what_is_no_series(make, words):
    with pytest.raises(ovoid.InvalidArgument, match=words):
        make()


def test_one_step_is_a_picture(array, expected):
    assert (ovoid.render(ovoid.series([array]), **SMALL).numpy() == expected).all()
    assert (ovoid.render(ovoid.series([array]), step=None, time=None, **SMALL).numpy() == expected).all()


def test_the_window_gets_files(tmp_path, monkeypatch):
    stand_in(tmp_path, monkeypatch, "assert inputs[0].endswith('array.pvd') and open(inputs[0]).read().count('DataSet') == 4\n"
             "json.dump({'ovoid_state': 1, 'inputs': inputs, 'flags': {'step': '1', 'size': '96x72'}}, open(kept, 'w'))")
    series, _ = in_both(tmp_path, "lattice")
    state = ovoid.view(series)
    assert state["inputs"] == [] and json.dumps(state)
    assert png(ovoid.render(series, state=state)) == png(ovoid.render(series, step=1, **SMALL))
