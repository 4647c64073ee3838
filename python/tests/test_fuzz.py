# SPDX-License-Identifier: Apache-2.0
"""Arguments of any kind draw a picture, or raise ovoid.Error: never another exception, never a crash.

OVOID_FUZZ=N tries N examples of each test, at random, instead of the few of the suite, which are always the same ones. OVOID_FUZZ_LOG=FILE keeps the newest call."""
import os
import tempfile

import numpy as np
import ovoid
import ovoid._settings
import pytest

os.environ.setdefault("HYPOTHESIS_STORAGE_DIRECTORY", os.path.join(tempfile.gettempdir(), "ovoid-hypothesis"))  # else where the tests run
hypothesis = pytest.importorskip("hypothesis")
st = pytest.importorskip("hypothesis.strategies")

COUNT = int(os.environ.get("OVOID_FUZZ", "0"))
LOG = os.environ.get("OVOID_FUZZ_LOG")
TINY = {"size": (9, 7), "threads": 1}
# Of the settings that name what lies outside of the process, or ask it for more than a test has.
OUTSIDE = {"data_folder", "memory_limit", "device", "device_memory", "backend", "tile", "threads", "size", "progress"}


def fuzzed(share, **arguments):
    """Runs a test on a share of the examples."""
    settings = hypothesis.settings(max_examples=max(1, int((COUNT or 100) * share)), deadline=None, derandomize=not COUNT, database=None,
                                   suppress_health_check=list(hypothesis.HealthCheck))
    return lambda test: settings(hypothesis.given(**arguments)(test))


def tried(call, *arguments, **settings):
    """What a call returns, or None where it refuses, with words."""
    if LOG:  # where a crash or a hang leaves no other trace
        with open(LOG, "w", encoding="utf-8", errors="replace") as file:
            file.write(f"{call.__qualname__} {arguments!r} {settings!r}")
    try:
        return call(*arguments, **settings)
    except ovoid.Error as error:
        assert str(error).strip() and error.code
        return None


numbers = st.one_of(st.integers(-3, 300), st.floats(allow_nan=True, allow_infinity=True, width=64), st.integers(-2**70, 2**70))
words = st.one_of(st.sampled_from(["", "magma", "xray", "isosurface", "+x", "auto", "off", "all", "none", "1,2", "1:2", ":", ",", "{}", "[]", "true", "gaussian:1"]),
                  st.text(max_size=8))
values = st.recursive(st.one_of(st.none(), st.booleans(), numbers, words, st.binary(max_size=4), st.slices(9)),
                      lambda inner: st.one_of(st.lists(inner, max_size=5), st.tuples(inner, inner), st.tuples(inner, inner, inner),
                                              st.dictionaries(st.one_of(words, st.sampled_from(["position", "focal_point", "view_up", "Points", "RGBPoints"])),
                                                              inner, max_size=4)), max_leaves=8)
# Where most of the forms that flags have are hit, so that more than refusals are tried.
likely = st.one_of(values, st.floats(0, 1), st.integers(0, 20), st.tuples(st.floats(-9, 9), st.floats(-9, 9)),
                   st.lists(st.tuples(st.floats(0, 200), st.floats(0, 1)), min_size=1, max_size=4), st.tuples(*[st.floats(-30, 30)] * 4))


def form_values(name):
    """Values for a setting, the words of its form among them."""
    form = ovoid._settings.table()[name][2] if name in ovoid._settings.table() else ""
    given = [word for word in form.split("|") if word.islower()]
    return st.one_of(likely, st.sampled_from(given)) if given else likely


NAMES = sorted(set(ovoid.settings()) - OUTSIDE | {"cmap", "clim", "cpos", "blending", "opacity", "scalars", "shade", "nonsense"})

pairs = st.tuples(st.floats(-1, 5), st.floats(0, 1)).map(lambda pair: (pair[0], pair[0] + pair[1] + 0.01))
GOOD = {  # values that are taken, so that they meet each other
    "mode": st.sampled_from(["composite", "maximum", "mean", "xray"]), "azimuth": st.floats(-400, 400), "elevation": st.floats(-100, 100),
    "roll": st.floats(-180, 180), "zoom": st.floats(1e-3, 1e3), "cmap": st.sampled_from(["magma", "viridis_r", "tab10"]), "clim": pairs, "crop_world": st.just(":0.5,:,:"),
    "opacity": st.lists(st.tuples(st.integers(0, 9), st.floats(0, 1)), min_size=1, max_size=3).map(lambda points: sorted(dict(points).items())),
    "unit_distance": st.floats(1e-6, 1e6), "clip": st.tuples(*[st.integers(-3, 3)] * 3, st.floats(-9, 9)).filter(lambda plane: any(plane[:3])),
    "kernel": st.sampled_from(["bspline", "gaussian", "gaussian:1.5", "catmull-rom"]), "view": st.sampled_from(["+x", "-y", "front"]),
    "projection": st.sampled_from(["parallel", "perspective"]), "sampling_distance": st.floats(0.05, 50), "colorbar": st.booleans(), "axes": st.booleans(),
    "background": st.sampled_from(["white", "none", "0.1,0.2,0.3"]), "occlusion": st.floats(0, 1), "shadows": st.floats(0, 1), "log": st.booleans(),
    "shade": st.booleans(), "sheets": st.sampled_from(["image", "lattice", "auto"]), "classification": st.sampled_from(["sampled", "pre-integrated", "refined"]),
    "slab": st.sampled_from(["mid", "mean"]), "gradient": st.sampled_from(["exact", "central", "corrected"]), "view_angle": st.floats(1, 170),
    "post_convolution": st.sampled_from(["off", "cubic", "bilinear"]), "bounding_box": st.booleans(), "fit": st.sampled_from(["box", "visible"]), "points": st.booleans(),
}


@st.composite
def settings(draw, most=4):
    """Some that are taken and, half of the time, one of any kind."""
    names = draw(st.lists(st.sampled_from(sorted(GOOD)), max_size=most, unique=True))
    chosen = {name: draw(GOOD[name]) for name in names}
    if draw(st.booleans()):
        odd = draw(st.sampled_from(NAMES))
        chosen[odd] = draw(form_values(odd))
    return chosen


dtypes = st.sampled_from(["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8", "g", "?", ">u2", ">f4", ">f8", "c8", "O", "U3", "M8[s]", "V4",
                          [("a", "f4"), ("b", ">i2")]])


@st.composite
def arrays(draw, shapes=None):
    """Of any type, shape, order and stride, with values that are usual and values that are none."""
    dtype = np.dtype(draw(dtypes))
    shape = draw(shapes) if shapes is not None else tuple(draw(st.lists(st.integers(0, 7), max_size=5)) if draw(st.integers(0, 4)) == 0 else draw(st.lists(st.integers(1, 7), min_size=2, max_size=4)))
    raw = draw(st.randoms(use_true_random=False)).randbytes(int(np.prod(shape)) * dtype.itemsize)
    if dtype.kind == "O":
        array = np.full(shape, None)
    elif dtype.kind in "?UM" or draw(st.booleans()):  # bits of any kind; of bool and text some are not allowed
        array = np.arange(int(np.prod(shape))).reshape(shape).astype(dtype) if dtype.kind != "V" else np.zeros(shape, dtype)
    else:
        array = np.frombuffer(raw, dtype).reshape(shape)
    if array.dtype.kind == "f" and array.size and draw(st.booleans()):
        array = array.copy()
        array.reshape(-1)[draw(st.integers(0, array.size - 1))] = draw(st.sampled_from([np.nan, np.inf, -np.inf, 0.0]))
    way = draw(st.integers(0, 5))
    if way == 1:
        array = np.asfortranarray(array)
    elif way == 2 and array.ndim:
        array = array[tuple(slice(None, None, draw(st.sampled_from([1, 2, -1, -2]))) for _ in array.shape)]
    elif way == 3:
        array = array.transpose(draw(st.permutations(range(array.ndim))))
    elif way == 4 and array.ndim and array.dtype.kind not in "OV":
        array = np.ma.masked_array(array, mask=np.arange(array.size).reshape(array.shape) % draw(st.integers(1, 4)) == 0)
    elif way == 5 and array.ndim and array.size:
        array = np.broadcast_to(array[:1], (draw(st.integers(1, 4)), *array.shape[1:]))
    return array


of_six = st.one_of(arrays(st.sampled_from([(6,), (6, 2)])), arrays())
vectors = st.one_of(st.none(), st.tuples(*[st.floats(0.1, 9)] * 3), st.tuples(*[st.floats()] * 3), values)
matrices = st.one_of(st.none(), st.just(np.eye(3)[::-1]), st.lists(st.tuples(*[st.floats(-1, 1)] * 3), min_size=3, max_size=3), values)


def check(picture):
    if picture is None:
        return
    pixels = picture.numpy()
    assert pixels.shape == (7, 9, 4) and pixels.dtype == np.uint8
    assert picture.encode()[:4] == b"\x89PNG" and picture.command and picture.state and picture.depth.shape == (7, 9)


@fuzzed(1, array=arrays(), spacing=vectors, origin=vectors, direction=matrices)
def test_arrays(array, spacing, origin, direction):
    check(tried(ovoid.render, array, spacing=spacing, origin=origin, direction=direction, **TINY))


@fuzzed(2, given=settings(), kind=st.integers(0, 3))
def test_settings(given, kind):
    check(tried(ovoid.render, DATA[kind], **{**given, **TINY}))


@fuzzed(0.5, changes=st.lists(settings(2), min_size=1, max_size=4))
def test_scenes(changes):
    """One scene and its view, through settings that come and go; what is refused changes nothing."""
    scene = ovoid.Scene(DATA[0], **TINY)
    before, view = scene.render().numpy(), scene.view()
    for given in changes:
        check(tried(view.render, **given))
        kept = dict(view.settings)
        if tried(view.update, **given) is None:
            assert view.settings == kept
        check(tried(view.render, **TINY))
    assert (scene.render().numpy() == before).all()


@fuzzed(0.5, xyz=st.one_of(arrays(st.just((6, 3))), arrays()), attributes=st.one_of(st.none(), of_six, st.dictionaries(words, of_six, max_size=2)),
        h=st.one_of(st.none(), of_six), given=settings(2))
def test_particles(xyz, attributes, h, given):
    cloud = tried(ovoid.particles, xyz, attributes, h)
    if cloud is not None:
        check(tried(ovoid.render, cloud, **{**given, **TINY}))


@fuzzed(0.5, n=st.integers(1, 40), seed=st.integers(0, 999), scale=st.sampled_from([0, 1e-300, 1e-30, 1, 1e30, 1e300]),
        h=st.one_of(st.none(), st.floats()), odd=st.sampled_from([0, np.nan, np.inf]), given=settings(2))
def test_particles_of_any_size(n, seed, scale, h, odd, given):
    """Places that lie on each other, apart by all that a float holds, or nowhere."""
    xyz = np.random.default_rng(seed).normal(size=(n, 3)) * scale
    xyz[0, 0] += odd
    cloud = tried(ovoid.particles, xyz, np.arange(float(n)), None if h is None else np.full(n, h))
    if cloud is not None:
        check(tried(ovoid.render, cloud, **{**given, **TINY}))


@fuzzed(0.5, array=arrays(), ending=st.sampled_from([".nrrd", ".nii", ".nii.gz", ".mha", ".npy", ".vti", ".h5", ".raw", ".vtu", ".ply", "", ".xyz"]),
        placement=st.fixed_dictionaries({}, optional={"spacing": vectors, "origin": vectors, "direction": matrices}))
def test_files(array, ending, placement):
    """What is written is read, and told of, or refused."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "a" + ending)
        tried(ovoid.write, path, array, **placement)
        facts = tried(ovoid.info, array, **placement)
        assert facts is None or facts["arrays"]
        data = tried(ovoid.read, path)
        if data is not None:
            assert data.arrays is not None and repr(data) and data.kind and data.positions is not None
            check(tried(ovoid.render, path, **TINY))


@fuzzed(0.5, path=st.one_of(values, st.lists(words, max_size=3)), given=settings(2))
def test_anything(path, given):
    """Where data belong there is something else."""
    for call in (ovoid.render, ovoid.read, ovoid.info, ovoid.Scene):
        tried(call, path, **given)
    picture = ovoid.render(DATA[0], **TINY)
    tried(picture.encode, path, path)
    tried(picture.encode, ".jpg", path)


CORNERS = np.array([[x, y, z] for z in (0, 6) for y, x in ((0, 0), (0, 8), (7, 8), (7, 0))], "f8")


def mostly(usual, odd):
    return st.integers(0, 5).flatmap(lambda which: odd if which == 5 else usual)


kinds = st.sampled_from(["vertex", "line", "triangle", "quad", "tetra", "hexahedron", "wedge", "pyramid", "tetra10", "hexahedron20", "polygon", "poly_line"])
node_numbers = st.one_of(st.integers(-1, 9), numbers)
SIZES = {"vertex": 1, "line": 2, "triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8, "wedge": 6, "pyramid": 5, "tetra10": 10, "hexahedron20": 20}


@st.composite
def cells_of_kind(draw):
    """Cells between eight nodes, most of them of the size that belongs to their kind."""
    kind = draw(kinds)
    size = SIZES.get(kind) or draw(st.integers(2, 6))
    return kind, draw(st.lists(st.lists(draw(mostly(st.just(st.integers(0, 7)), st.just(node_numbers))), min_size=size, max_size=size), min_size=1, max_size=4))


@st.composite
def meshes(draw):
    """Meshes of eight nodes that are flat, folded or without a place, or what `mesh` refuses: None."""
    points = draw(mostly(st.sampled_from([CORNERS, CORNERS[::-1] * [1, 0, 1], np.random.default_rng(3).random((8, 3)) * 8]), arrays(st.sampled_from([(8, 3), (8, 2), (6, 3)]))))
    some_cells = st.lists(cells_of_kind(), min_size=1, max_size=3)
    cells = draw(mostly(st.one_of(some_cells, some_cells.map(dict)), values))
    point_data = draw(mostly(st.just({"heat": np.arange(8.0)}), st.dictionaries(words, arrays(st.just((8,))), max_size=2)))
    cell_data = draw(mostly(st.none(), st.dictionaries(words, arrays(st.sampled_from([(1,), (2,), (3,)])), max_size=1)))
    return tried(ovoid.mesh, points, cells, point_data=point_data, cell_data=cell_data)


@fuzzed(1, mesh=meshes(), within=meshes(), given=settings(2))
def test_meshes(mesh, within, given):
    if mesh is not None:
        check(tried(ovoid.render, mesh, **{**given, **TINY}))
    if within is not None:
        check(tried(ovoid.render, DATA[0], within=within, add=within, **TINY))


as_large = arrays(st.just((7, 8, 9)))  # as DATA[0]
whole = st.builds(lambda dtype, shift: np.roll(DATA[1], shift).astype(dtype), st.sampled_from(["u1", "i8", "f4", "?", ">i2"]), st.integers(0, 99))
elsewhere = st.builds(lambda array, spacing: tried(ovoid.lattice, array, spacing=spacing), arrays(st.sampled_from([(3, 4, 5), (7, 1, 3)])), mostly(st.just((2, 1, 0.5)), vectors))
volumes = mostly(st.one_of(whole, as_large, elsewhere.filter(lambda volume: volume is not None)), st.one_of(arrays(), values))
colors = st.one_of(st.sampled_from(["red", "#123456"]), st.tuples(*[st.floats(0, 1)] * 3))


def of_labels(usual):
    """By number or name."""
    return mostly(st.dictionaries(st.one_of(st.integers(0, 4), st.just("others")), usual, max_size=3), st.one_of(words, st.dictionaries(words, values, max_size=2)))


CUBE = ovoid.mesh(CORNERS, {"hexahedron": [range(8)]}, {"heat": np.arange(8.0)})
placed = mostly(st.one_of(meshes().map(lambda mesh: mesh or CUBE), st.builds(lambda scale: ovoid.particles(CORNERS * scale), st.sampled_from([0, 0.5, 1, 1e30]))), st.one_of(arrays(), words))
BESIDE = {
    "labels": volumes, "over": st.one_of(volumes, st.lists(volumes, max_size=4)), "add": st.one_of(placed, st.lists(placed, min_size=1, max_size=3)), "within": placed,
    "slice": st.one_of(st.sampled_from(["x", "axial=3", "coronal"]), st.lists(st.tuples(*[st.integers(-2, 9)] * 4), max_size=3), values), "slice_labels": st.sampled_from(["lines", "areas", "both", "none"]),
    "flat_labels": st.booleans(), "slice_outline": st.booleans(), "label_color": of_labels(colors), "label_opacity": of_labels(st.floats(0, 1)), "inside_labels": st.one_of(st.integers(0, 4), st.lists(st.integers(0, 4), max_size=3)),
    "over_opacity": st.one_of(GOOD["opacity"], st.lists(GOOD["opacity"], max_size=1)), "over_range": mostly(pairs, st.lists(pairs, max_size=3)), "over_transform": values,
    "add_color": mostly(st.one_of(colors, st.lists(colors, max_size=3)), values), "add_opacity": st.one_of(st.floats(0, 1), st.lists(st.floats(0, 1), max_size=3)),
    "add_radius": st.one_of(st.floats(0, 9), st.lists(st.floats(), max_size=3)), "add_array": st.sampled_from(["heat", ""]), "shadows": st.floats(0, 1),
    "channels": st.sampled_from(["all", "rgb", [0, 1], "values"]), "mixing": st.sampled_from(["added", "averaged"]), "channel_range": st.one_of(pairs, st.lists(pairs, max_size=3)),
}
# What has no effect without another is drawn with it.
NEEDS = {"slice_": "slice", "flat_labels": "slice", "label": "labels", "inside": "labels", "over_": "over", "add_": "add", "mixing": "over", "channel_": "channels"}


@st.composite
def beside(draw):
    names = draw(st.lists(st.sampled_from(sorted(BESIDE)), min_size=1, max_size=4, unique=True))
    needed = [whole for part, whole in NEEDS.items() for name in names if name.startswith(part) and name != whole]
    return {name: draw(BESIDE[name]) for name in dict.fromkeys([*needed, *names])}


@fuzzed(2, things=beside(), given=mostly(st.just({}), settings(1)), kind=mostly(st.just(0), st.integers(1, 3)))
def test_beside(things, given, kind):
    """Labels, further volumes, surfaces, planes and channels, with what belongs to them."""
    check(tried(ovoid.render, DATA[kind], **{**given, **things, **TINY}))


key_words = st.one_of(words, st.sampled_from(["frame", "time", "position", "focal_point", "view_up", "view_angle", "azimuth", "elevation", "roll", "zoom"]))
good_keys = st.fixed_dictionaries({"frame": st.integers(0, 6)}, optional={
    "azimuth": st.floats(-1e6, 1e6), "elevation": st.floats(-200, 200), "roll": st.floats(-200, 200), "zoom": st.floats(1e-3, 1e3),
    "position": st.lists(st.floats(-1e300, 1e300), min_size=3, max_size=3), "focal_point": st.lists(st.floats(-30, 30), min_size=3, max_size=3),
    "view_angle": st.floats(1e-3, 179), "view_up": st.lists(st.integers(-1, 1), min_size=3, max_size=3)})
rising = st.lists(good_keys, min_size=2, max_size=4, unique_by=lambda key: key["frame"]).map(lambda keys: sorted(keys, key=lambda key: key["frame"]))


@fuzzed(0.5, keys=st.one_of(rising, st.lists(st.one_of(good_keys, st.dictionaries(key_words, likely, max_size=4)), max_size=4), values),
        frames=st.one_of(st.integers(1, 4), st.sampled_from([0, -1, 2**70, 2.0, "3", True, []])), given=settings(2))
def test_camera_paths(keys, frames, given):
    view = tried(ovoid.Scene(DATA[0], **TINY).view, **given)
    if view is not None:
        for picture in tried(lambda: list(view.along(keys, frames))) or []:
            check(picture)


def some_data():
    z, y, x = np.mgrid[-1:1:7j, -1:1:8j, -1:1:9j]
    field = np.exp(-2 * (x**2 + y**2 + z**2))
    labels = (4 * field).astype("u1")
    rng = np.random.default_rng(1)
    return [field, labels, np.stack([x, y, z], axis=-1), ovoid.particles(rng.normal(size=(30, 3)), rng.random(30))]


DATA = some_data()
