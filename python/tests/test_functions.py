# SPDX-License-Identifier: Apache-2.0
"""What the program's other commands do, against the program itself and formulas."""
import json
import subprocess

import numpy as np
import ovoid
import pytest
from conftest import PROGRAM, bumps


def ramp(dims=(16, 16, 16)):
    """Twice the index along x."""
    return np.broadcast_to(2.0 * np.arange(dims[2]), dims)


def report_of_program(command, path, output, *flags):
    report = str(output) + ".json"
    subprocess.run([PROGRAM, command, str(path), "-o", str(output), "--report", report, *flags], check=True, capture_output=True)
    with open(report, encoding="utf-8") as file:
        return json.load(file)


def without_time(report):
    return {name: value for name, value in report.items() if name != "seconds"}


@pytest.mark.parametrize("command, settings, flags", [("fit", {"psnr": 35}, ["--psnr", "35"]), ("simplify", {"tolerance": "2%"}, ["--tolerance", "2%"])])
def test_what_the_program_makes(tmp_path, array, command, settings, flags):
    ovoid.write(tmp_path / "in.nrrd", array)
    expected = report_of_program(command, tmp_path / "in.nrrd", tmp_path / "expected.h5", *flags)
    kept = getattr(ovoid, command)(array, tmp_path / "kept.h5", **settings)
    of_file = getattr(ovoid, command)(str(tmp_path / "in.nrrd"), **settings)
    assert without_time(kept.report) == without_time(of_file.report) == without_time(expected)
    samples = ovoid.read(tmp_path / "expected.h5").arrays["values"]
    assert (kept.arrays["values"] == samples).all() and (of_file.arrays["values"] == samples).all()
    assert abs(samples.astype(float) - array).max() <= kept.report["greatest_error"] + 0.5
    assert kept.source == str(tmp_path / "kept.h5") and of_file.source == command


def test_kernels_are_fitted_to_particles(tmp_path):
    cloud = ovoid.particles(np.random.default_rng(1).normal(size=(400, 3)))
    fitted = ovoid.fit(cloud, kernels=50, refine=0)
    assert fitted.kind == "kernels" and len(fitted.positions) == fitted.report["kernels"] == 50
    assert fitted.report["source_kernels"] == 400
    assert ovoid.render(fitted, size=(48, 36)).numpy().std() > 0


def test_progress_of_a_fit_is_told(array, monkeypatch):
    told = []

    class Bar:
        n = 0

        def __init__(self, **_):
            pass

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def update(self, more):
            self.n += more
            told.append(self.n)

    monkeypatch.setitem(__import__("sys").modules, "tqdm", type("tqdm", (), {"tqdm": Bar}))
    ovoid.fit(bumps((32, 32, 32)), psnr=45, progress=True)
    assert told[-1] == 100 and told == sorted(told)


def test_resampled_to_a_grid_as_the_program_does(tmp_path, array):
    ovoid.write(tmp_path / "in.nrrd", array, spacing=(1, 2, 3))
    subprocess.run([PROGRAM, "convert", str(tmp_path / "in.nrrd"), "--size", "12", "-o", str(tmp_path / "out.nrrd")], check=True, capture_output=True)
    expected = ovoid.read(tmp_path / "out.nrrd")
    made = ovoid.resample(array, 12, spacing=(1, 2, 3))
    assert np.array_equal(made.arrays["values"], expected.arrays["values"], equal_nan=True) and made.matrix == expected.matrix


def test_resampled_to_another_lattice_and_kernels():
    body_centred = ovoid.resample(bumps(), lattice="bcc")
    assert body_centred.kind == "lattice" and body_centred.arrays["values"].size < bumps().size
    kernels = ovoid.resample(ovoid.particles(np.random.default_rng(1).normal(size=(50, 3))), kernels=True)
    assert kernels.kind == "kernels" and len(kernels.positions) == 50


def test_samples_of_a_ramp():
    places = np.random.default_rng(3).uniform(4, 11, size=(2, 5, 3))
    found = ovoid.sample(ramp(), places, spacing=(0.5, 1, 1), origin=(2, 0, 0), kernel="bspline")
    assert found.value.shape == (2, 5) and found.gradient.shape == (2, 5, 3)
    inside = (places[..., 0] > 3.5) & (places[..., 0] < 8)
    assert found.is_defined[inside].all() and inside.any()
    assert abs(found.value - 4 * (places[..., 0] - 2))[inside].max() < 0.05
    assert abs(found.gradient - (4, 0, 0))[inside].max() < 0.05


def test_samples_where_nothing_is():
    found = ovoid.sample(ramp(), [(-50, 0, 0)])
    assert not found.is_defined[0] and np.isnan(found.value[0]) and np.isnan(found.gradient).all() and found.weight[0] == 0
    assert ovoid.sample(ramp(), np.empty((0, 3))).value.shape == (0,)


def test_many_places_have_the_values_of_few(array):
    places = np.random.default_rng(4).uniform(2, 18, size=(6000, 3))
    scene = ovoid.Scene(array)
    many, few = scene.sample(places), scene.sample(places[:100])
    assert np.array_equal(many.value[:100], few.value, equal_nan=True) and np.array_equal(many.gradient[:100], few.gradient, equal_nan=True)


@pytest.mark.parametrize("normal, axes", [("x", ((0, 1, 0), (0, 0, 1))), ("y", ((1, 0, 0), (0, 0, 1))), ("z", ((1, 0, 0), (0, 1, 0)))])
def test_slices_have_the_values_of_samples(array, normal, axes):
    scene = ovoid.Scene(array, spacing=(1, 1.5, 0.5), origin=(3, 2, 1))
    flat = scene.slice(normal, size=24)
    height, width = flat.values.shape
    assert max(height, width) == 24
    assert np.allclose(flat.u / np.linalg.norm(flat.u), axes[0]) and np.allclose(flat.v / np.linalg.norm(flat.v), axes[1])
    places = flat.origin + flat.u * np.arange(width)[None, :, None] + flat.v * np.arange(height)[:, None, None]
    assert np.allclose(flat.values, scene.sample(places).value, atol=1e-3, equal_nan=True)
    lengths = [np.linalg.norm(axis) for axis in (flat.u, flat.v)]
    assert np.isclose(flat.extent[1] - flat.extent[0], width * lengths[0]) and np.isclose(flat.extent[3] - flat.extent[2], height * lengths[1])


def test_slice_through_a_place_at_a_slant(array):
    normal = np.array([1.0, 2.0, -1.0])
    flat = ovoid.slice(array, normal * 7, 9.5, size=20)
    corners = flat.origin + np.array([0, 1])[:, None] * (flat.u + flat.v)
    assert np.allclose(corners @ (normal / np.linalg.norm(normal)), 9.5) and abs(flat.u @ flat.v) < 1e-12
    assert np.isfinite(flat.values).any() and np.asarray(flat) is flat.values


def test_histogram_counts_every_value():
    values = np.repeat(np.arange(6, dtype="u1"), 36).reshape(6, 6, 6)
    counts, edges = ovoid.histogram(values)
    assert counts.tolist() == [36] * 6 and edges.tolist() == [-0.5, 0.5, 1.5, 2.5, 3.5, 4.5, 5.5]
    counts, edges = ovoid.histogram(values, log=True)
    assert counts.sum() == 36 * 5 and np.isclose(edges[-1], 5) and (np.diff(edges) > 0).all()


BAD = [
    (lambda a: ovoid.fit(a), "no goal given"),
    (lambda a: ovoid.fit(a, psnrr=40), "did you mean psnr"),
    (lambda a: ovoid.fit(a, psnr=40, kernels=3), "give one of them"),
    (lambda a: ovoid.fit(a, psnr=40, step=2), "is for data in time"),
    (lambda a: ovoid.fit(a, "fit.png", psnr=40), ".h5"),
    (lambda a: ovoid.fit(a, psnr=40, output="x.h5"), "is no setting here"),
    (lambda a: ovoid.simplify(ovoid.particles(np.eye(3))), "is for lattices"),
    (lambda a: ovoid.simplify(a, tolerance=-1), "tolerance"),
    (lambda a: ovoid.resample(a), "nothing asked for"),
    (lambda a: ovoid.resample(a, "9q"), "expected N or XxYxZ"),
    (lambda a: ovoid.resample(a, 8, cmap="magma"), "unknown setting"),
    (lambda a: ovoid.sample(a, [1, 2]), "expected (..., 3)"),
    (lambda a: ovoid.sample(a, [(1, 2, np.nan)]), "NaN or infinite"),
    (lambda a: ovoid.sample(a, [("a", "b", "c")]), "points"),
    (lambda a: ovoid.slice(a, "w"), "normal = 'w'"),
    (lambda a: ovoid.slice(a, (0, 0, 0)), "not all 0"),
    (lambda a: ovoid.slice(a, "x", np.inf), "finite"),
    (lambda a: ovoid.slice(a, size=0), "1 to 8192"),
    (lambda a: ovoid.histogram(a, bins=3), "unknown setting"),
]


@pytest.mark.parametrize("call, words", BAD)
def test_bad_arguments_are_named(array, call, words):
    with pytest.raises(ovoid.Error) as raised:
        call(array)
    assert words in str(raised.value)
