# SPDX-License-Identifier: Apache-2.0
"""Objects of other packages draw as the files that hold the same; memory that is as the library has it is shared.

Of packages that may not be here, objects that can do the same stand for theirs; where they are, they are tried, too.
"""
import gc
import subprocess
import sys
import types
import weakref

import numpy as np
import ovoid
import pytest
from conftest import FLAGS, SMALL, bumps, data_of, drawn_by_program, pixels, png

PLACES = {"spacing": (0.5, 0.25, 0.125), "origin": (-3, 4, 10), "direction": [[0, -1, 0], [1, 0, 0], [0, 0, 1]]}


# Tables.

class Column:
    def __init__(self, values):
        self.values = values

    def to_numpy(self, **settings):
        return np.array([settings["na_value"] if one is None else one for one in self.values], settings["dtype"]) if settings else self.values


class Table:
    """What pandas.DataFrame can do."""

    def __init__(self, columns):
        self._columns = columns

    @property
    def columns(self):
        return list(self._columns)

    def __getitem__(self, name):
        return Column(self._columns[name])

    def to_numpy(self):
        raise AssertionError("would copy all columns, of one type")


def table_columns():
    xyz = np.random.default_rng(4).normal(size=(300, 3))
    return xyz, {"x": xyz[:, 0], "Y": xyz[:, 1], "z": xyz[:, 2], "warm": xyz[:, 0] ** 2, "name": np.array(["a"] * 300),
                 "h": np.full(300, 0.3), "mass": np.arange(300.0) + 1, "count": np.array([1, None] * 150, object)}


def test_tables(tmp_path):
    tables = [Table]
    try:
        tables.append(__import__("pandas").DataFrame)
    except ImportError:
        pass
    xyz, columns = table_columns()
    special = {"h": columns["h"], "mass": columns["mass"]}
    for table in (kind(columns) for kind in tables):
        cloud = ovoid.particles(table)
        assert list(cloud.arrays) == ["warm", "count", "h", "mass"] and "'name' is left out" in cloud.notes[0]
        assert np.isnan(cloud.arrays["count"]).sum() == 150
        assert np.shares_memory(cloud.arrays["warm"], table["warm"].to_numpy())
        assert (pixels(table) == pixels(ovoid.particles(xyz, {"warm": columns["warm"], "count": cloud.arrays["count"]}, **special))).all()
        assert (pixels(ovoid.particles(table, "warm")) == pixels(ovoid.particles(xyz, {"warm": columns["warm"]}, **special))).all()
        for wanted, words in (("warn", "has no column 'warn'; did you mean warm"), ("name", "column 'name': expected numbers"),
                              (5, "has no column '5'")):
            with pytest.raises(ovoid.InvalidArgument, match=words):
                ovoid.particles(table, wanted)
    plain = {name: columns[name] for name in ("x", "Y", "z")}
    assert (pixels(Table(plain)) == pixels(ovoid.particles(xyz))).all()  # their density
    np.savetxt(tmp_path / "a.csv", np.column_stack([xyz, columns["warm"]]), delimiter=",", header="x,Y,z,warm", comments="", fmt="%.17g")
    assert png(ovoid.render(Table({**plain, "warm": columns["warm"]}), **SMALL)) == drawn_by_program(tmp_path / "a.csv", *FLAGS)
    with pytest.raises(ovoid.InvalidArgument, match="has no column y; expected x, y, z. Its columns: x, z"):
        ovoid.render(Table({name: columns[name] for name in "xz"}))
    with pytest.raises(ovoid.InvalidArgument, match="column 'x': expected numbers"):
        ovoid.render(Table({**plain, "x": columns["name"]}))
    with pytest.raises(ovoid.InvalidArgument, match=r"shape \(0, 3\)"):
        ovoid.render(Table({name: np.zeros(0) for name in "xyz"}))


# yt.

class Quantity(np.ndarray):
    """What unyt's arrays can do: centimetres and metres."""

    def __new__(cls, values, units):
        made = np.asarray(values).view(cls)
        made.units = units
        return made

    def __array_finalize__(self, other):
        self.units = getattr(other, "units", "dimensionless")

    def to(self, units):
        return Quantity(np.asarray(self) * {"m": 1, "cm": 100}[units] / {"m": 1, "cm": 100}[self.units], units)


class Snapshot:
    field_list = [("all", "warm")]
    derived_field_list = [("all", "particle_mass"), ("all", "smoothing_length"), ("all", "warm"), ("gas", "density")]
    particle_types = ("all", "io")
    default_field = ("gas", "density")

    def all_data(self):
        return Region(self)


class Region:
    def __init__(self, ds):
        xyz = np.random.default_rng(5).normal(size=(300, 3))
        self.ds, self.field_data = ds, {}
        self.fields = {("all", "particle_position"): Quantity(xyz, "cm"), ("all", "particle_mass"): Quantity(np.arange(300.0) + 1, "g"),
                       ("all", "smoothing_length"): Quantity(np.full(300, 0.003), "m"), ("all", "warm"): Quantity(xyz[:, 0] ** 2, "K")}

    def get_data(self):
        raise AssertionError("is called by nobody here")

    def __getitem__(self, field):
        return self.fields[field]


class CoveringGrid:
    def __init__(self, density):
        self.ds, self.field_data, self.density = Snapshot(), {}, density
        self.left_edge, self.right_edge = Quantity([1.0, 2, 3], "cm"), None
        self.dds, self.ActiveDimensions = Quantity([0.001, 0.002, 0.003], "m"), np.array(density.shape)

    def get_data(self):
        raise AssertionError("is called by nobody here")

    def __getitem__(self, field):
        return {("gas", "density"): Quantity(self.density, "g/cm**3")}[field]


def test_yt():
    region = Snapshot().all_data()
    xyz, mass, warm = (np.asarray(region.fields["all", name]) for name in ("particle_position", "particle_mass", "warm"))
    h = np.full(300, 0.3)
    expected = pixels(ovoid.particles(xyz, h=h, mass=mass))
    assert (pixels(region) == expected).all() and (pixels(Snapshot()) == expected).all()
    assert (pixels(ovoid.particles(region, "warm")) == pixels(ovoid.particles(xyz, {"warm": warm}, h=h, mass=mass))).all()
    assert (pixels(ovoid.particles(region, h=2 * h)) == pixels(ovoid.particles(xyz, h=2 * h, mass=mass))).all()
    assert {array["name"]: array["unit"] for array in ovoid.info(ovoid.particles(region, [("all", "warm")]))["arrays"]}["warm"] == "K"
    assert np.shares_memory(data_of(region).positions, region.fields["all", "particle_position"])
    for field, words in (("cold", "yt finds no such field"), ([("io", "a"), ("all", "b")], "expected those of one type"),
                         (("gas", "a"), "no type of particles")):
        with pytest.raises(ovoid.InvalidArgument, match=words):
            ovoid.particles(region, field)
    region.ds.particle_types = ()
    with pytest.raises(ovoid.InvalidArgument, match="has no particles; give a lattice"):
        ovoid.render(region)
    field = bumps(dtype="f8")
    expected = data_of(field, spacing=(0.1, 0.2, 0.3), origin=(1.05, 2.1, 3.15))
    assert (pixels(CoveringGrid(field.T)) == pixels(expected)).all()
    assert np.allclose(data_of(CoveringGrid(field.T)).matrix, expected.matrix, rtol=0, atol=1e-12)


def test_yt_itself():
    yt = pytest.importorskip("yt")
    yt.set_log_level(50)
    xyz = np.random.default_rng(6).normal(size=(300, 3))
    fields = {f"particle_position_{axis}": xyz[:, i] for i, axis in enumerate("xyz")}
    everything = yt.load_particles({**fields, "particle_mass": np.arange(300.0) + 1}, bbox=np.array([[-6.0, 6]] * 3)).all_data()
    assert (pixels(everything) == pixels(ovoid.particles(xyz, mass=np.arange(300.0) + 1))).all()
    field = bumps(dtype="f8")
    ds = yt.load_uniform_grid({"density": (field.T.copy(), "g/cm**3")}, field.T.shape, bbox=np.array([[0.0, 2.8], [0, 2.4], [0, 2]]))
    grid = ds.covering_grid(0, ds.domain_left_edge, ds.domain_dimensions)
    expected = data_of(field, spacing=(0.1, 0.1, 0.1), origin=(0.05, 0.05, 0.05))
    assert abs(pixels(grid).astype(int) - pixels(expected)).max() <= 1
    assert np.allclose(data_of(grid).matrix, expected.matrix)


# Images with a place of their own.

AFFINE = np.array([[-2, 0.1, 0, 10], [0, 2, 0.3, -5], [0.1, 0, 3, 4], [0, 0, 0, 1.0]])


class Proxy:
    """What nibabel.arrayproxy.ArrayProxy can do."""

    def __init__(self, stored, slope, inter):
        self.stored, self.slope, self.inter = stored, slope, inter

    def get_unscaled(self):
        return self.stored

    def __array__(self, *_):
        return self.stored * self.slope + self.inter


class Image:
    def __init__(self, dataobj, affine=AFFINE):
        self.dataobj, self.affine = dataobj, affine


def test_nibabel(tmp_path, array):
    xyz = np.asfortranarray(array.T)
    ours = data_of(Image(xyz))
    assert ours.space == "RAS" and np.allclose(ours.matrix, AFFINE[:3]) and np.shares_memory(ours.arrays["values"], xyz)
    ovoid.write(tmp_path / "a.nrrd", array, affine=AFFINE, space="RAS")
    for view in ("anterior", "left"):
        expected = drawn_by_program(tmp_path / "a.nrrd", *FLAGS, "--view", view)
        assert png(ovoid.render(Image(xyz), view=view, **SMALL)) == expected
        assert png(ovoid.render(Image(np.ascontiguousarray(xyz)), view=view, **SMALL)) == expected
        assert png(ovoid.render(array, affine=AFFINE, space="RAS", view=view, **SMALL)) == expected
    scaled = Image(Proxy(xyz, 2.0, 5.0))
    assert np.shares_memory(data_of(scaled).arrays["values"], xyz)
    assert ovoid.info(scaled)["arrays"][0]["range"] == [2.0 * array.min() + 5, 2.0 * array.max() + 5]
    assert (pixels(scaled, opacity=[0, 1]) == pixels(scaled, opacity=[(2.0 * array.min() + 5, 0), (2.0 * array.max() + 5, 1)])).all()
    vectors = np.stack([xyz, xyz], axis=-1)[:, :, :, np.newaxis]
    assert data_of(Image(vectors)).arrays["values"].shape == (*array.shape, 2)
    assert (data_of(Image(vectors)).arrays["values"][..., 1] == array).all()
    with pytest.raises(ovoid.InvalidArgument, match=r"expected one volume \(x, y, z\), as by image.slicer"):
        ovoid.render(Image(np.stack([xyz, xyz], axis=-1)))
    with pytest.raises(ovoid.InvalidArgument, match="has no affine"):
        ovoid.render(Image(xyz, None))
    with pytest.raises(ovoid.InvalidArgument, match="say themselves where they are"):
        ovoid.render(Image(xyz), space="LPS")
    nibabel = pytest.importorskip("nibabel")
    for name, image in (("a.nii", nibabel.Nifti1Image(xyz, AFFINE)), ("b.nii.gz", nibabel.Nifti1Image(xyz / 7.0, AFFINE, dtype="i2"))):
        nibabel.save(image, tmp_path / name)
        assert png(ovoid.render(nibabel.load(tmp_path / name), **SMALL)) == drawn_by_program(tmp_path / name, *FLAGS)


def test_simpleitk(array):
    """The view of an image does not keep it there, so that the data must."""
    package = types.ModuleType("standing_for_simpleitk")

    class ItkImage:
        __module__ = "standing_for_simpleitk.inner"
        values = array

        def GetSize(self):
            return array.shape[::-1]

        def GetSpacing(self):
            return PLACES["spacing"]

        def GetOrigin(self):
            return PLACES["origin"]

        def GetDirection(self):
            return tuple(np.ravel(PLACES["direction"]))

    itk = ItkImage()
    with pytest.raises(ovoid.InvalidArgument, match="give numpy's array"):
        ovoid.render(itk)
    package.GetArrayViewFromImage = lambda image: image.values.view()
    sys.modules[package.__name__] = package
    try:
        expected = data_of(array, space="LPS", **PLACES)
        assert (pixels(itk, view="anterior") == pixels(expected, view="anterior")).all() and data_of(itk).matrix == expected.matrix
        ours, kept = data_of(itk), weakref.ref(itk)
        assert np.shares_memory(ours.arrays["values"], array)
        del itk
        gc.collect()
        assert kept() is not None
        del ours
        gc.collect()
        assert kept() is None
    finally:
        del sys.modules[package.__name__]


def test_affine_is_spacing_origin_direction(array):
    matrix = np.eye(4)
    matrix[:3, :3] = np.array(PLACES["direction"]) * PLACES["spacing"]
    matrix[:3, 3] = PLACES["origin"]
    expected = pixels(array, **PLACES)
    assert (pixels(array, affine=matrix) == expected).all() and (pixels(array, affine=matrix[:3].tolist()) == expected).all()
    assert data_of(array, affine=matrix).matrix == data_of(array, **PLACES).matrix == matrix[:3].tolist()
    assert data_of(array, affine=matrix).space == "none"


def test_spaces_name_views(array):
    """The left of a patient is at +x in LPS, and at -x in RAS."""
    for space, view in (("LPS", "+x"), ("RAS", "-x")):
        left, side = (ovoid.render(array, space=space, view=name, **SMALL).camera for name in ("left", view))
        assert np.allclose(np.subtract(left["position"], left["focal_point"])[1:], 0)
        assert np.allclose(left["position"], side["position"])


@pytest.mark.parametrize("placement, words", [
    ({"affine": np.eye(3)}, "expected 4 x 4 numbers"),
    ({"affine": AFFINE.T}, "the last row is 0, 0, 0, 1"),
    ({"affine": np.diag([1, 0, 1, 1])}, "no two along a line"),
    ({"affine": AFFINE * np.nan}, "expected 4 x 4 numbers"),
    ({"affine": "wide"}, "expected 4 x 4 numbers"),
    ({"affine": AFFINE, "spacing": (1, 1, 1)}, "give one of them"),
    ({"space": "LAS"}, "space = 'LAS': expected LPS or RAS"),
    ({"space": 5}, "space = '5': expected LPS or RAS"),
    ({"spacee": "LPS"}, "did you mean space"),
])
def test_bad_places(array, placement, words):
    with pytest.raises(ovoid.InvalidArgument, match=words):
        ovoid.render(array, **placement)


def test_places_are_not_for_files(tmp_path, array):
    ovoid.write(tmp_path / "a.nrrd", array)
    for placement in ({"affine": AFFINE}, {"space": "LPS"}):
        with pytest.raises(ovoid.InvalidArgument, match="are for arrays"):
            ovoid.render(tmp_path / "a.nrrd", **placement)


class Exchanged:
    """Memory that DLPack alone tells of."""

    def __init__(self, values, device=(1, 0)):
        self.values, self.device = values, device

    def __dlpack__(self, **settings):
        return self.values.__dlpack__(**settings)

    def __dlpack_device__(self):
        return self.device


def test_dlpack(array, expected):
    assert (pixels(Exchanged(array)) == expected).all()
    assert np.shares_memory(data_of(Exchanged(array)).arrays["values"], array)
    xyz = np.random.default_rng(7).normal(size=(50, 3))
    assert np.shares_memory(ovoid.particles(Exchanged(xyz)).positions, xyz)
    with pytest.raises(ovoid.InvalidArgument, match="lies in the memory of CUDA:1; copy it to the host's first"):
        ovoid.render(Exchanged(array, (2, 1)))
    with pytest.raises(ovoid.InvalidArgument, match="xyz: lies in the memory of device 99:0"):
        ovoid.particles(Exchanged(xyz, (99, 0)))
    with pytest.raises(ovoid.InvalidArgument, match="cannot be taken by DLPack"):
        ovoid.render(Exchanged(array.astype(">f4")))

    class OnDevice:
        shape, dtype = (3, 3, 3), "float32"

        def __array__(self, *_):
            raise TypeError("can't convert a tensor on cuda:0 to numpy")

    with pytest.raises(ovoid.InvalidArgument, match="can't convert a tensor on cuda:0"):
        ovoid.render(OnDevice())


def test_nothing_of_others_is_imported():
    script = ("import sys, numpy, ovoid; ovoid.render(numpy.arange(27.0).reshape(3, 3, 3), size=(9, 9)); "
              "print([name for name in ('vtk', 'vtkmodules', 'meshio', 'pandas', 'yt', 'nibabel', 'SimpleITK') if name in sys.modules])")
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
