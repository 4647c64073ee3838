# SPDX-License-Identifier: Apache-2.0
"""Pictures are the program's, to the byte, and come out in every form that Python's programs take."""
import io
import json
import shlex
import subprocess

import numpy as np
import ovoid
import pytest
from conftest import PROGRAM, SMALL, bumps, drawn_by_program, png

FLAGS = ("--size", "96x72")


def test_of_files(tmp_path, array):
    path = tmp_path / "bumps.nrrd"
    ovoid.write(path, array, spacing=(1, 2, 3), origin=(-5, 0, 7))
    expected = drawn_by_program(path, *FLAGS)
    assert png(ovoid.render(path, **SMALL)) == expected
    assert png(ovoid.render(str(path), **SMALL)) == expected
    assert png(ovoid.render(ovoid.read(path), **SMALL)) == expected
    assert png(ovoid.render(array, spacing=(1, 2, 3), origin=(-5, 0, 7), **SMALL)) == expected


@pytest.mark.parametrize("flags, settings", [
    (("--colormap", "magma", "--range", "20,180", "--opacity", "20:0,180:1"), {"cmap": "magma", "clim": (20, 180), "opacity": "linear"}),
    (("--opacity", "0:0,50:0.25,200:1"), {"opacity": [(0, 0), (50, 0.25), (200, 1)]}),
    (("--background", "1,1,1", "--no-shade"), {"background": (1, 1, 1), "shade": False}),
    (("--mode", "maximum", "--view", "+x"), {"blending": "maximum", "cpos": "yz"}),
    (("--mode", "minimum", "--thick-slice", "0,0,1,6.25,3"), {"blending": "minimum", "thick_slice": (0, 0, 1, 6.25, 3)}),
    (("--mode", "isosurface", "--iso", "60:red:0.3,90"), {"mode": "isosurface", "iso": [(60, "red", 0.3), 90]}),
    (("--mode", "xray", "--colorbar=Sum"), {"mode": "xray", "colorbar": "Sum"}),
    (("--clip", "1,0,0,9", "--clip", "0,1,0,4.5"), {"clip": [(1, 0, 0, 9), (0, 1, 0, 4.5)]}),
    (("--crop", "2:20,:,3:"), {"crop": [(2, 20), slice(None), (3, None)]}),
    (("--azimuth", "30", "--colorbar", "--axes"), {"azimuth": np.float32(30), "show_scalar_bar": True, "axes": True}),
    (("--mode", "isosurface", "--iso", "90", "--light", "1,1,0"), {"mode": "isosurface", "iso": 90, "light": (1, 1, 0)}),
])
def test_settings_mean_the_flags(tmp_path, array, flags, settings):
    path = tmp_path / "bumps.nrrd"
    ovoid.write(path, array)
    expected = drawn_by_program(path, *FLAGS, *flags)
    assert png(ovoid.render(array, **SMALL, **settings)) == expected
    assert expected != drawn_by_program(path, *FLAGS)  # else the flags would not be tested


def test_opacities_spread_over_the_values(tmp_path, array):
    lo, hi = int(array.min()), int(array.max())
    expected = ovoid.render(array, opacity=[(lo, 0), ((lo + hi) / 2, 0.1), (hi, 0.8)], **SMALL).numpy()
    assert (ovoid.render(array, opacity=[0, 0.1, 0.8], **SMALL).numpy() == expected).all()
    within = ovoid.render(array, opacity=np.array([0, 0.8]), clim=np.array([20, 90]), **SMALL).numpy()
    assert (within == ovoid.render(array, opacity=[(20, 0), (90, 0.8)], clim=(20, 90), **SMALL).numpy()).all()
    steep = [(20 + 70 * i / 64, int(255 / (1 + np.exp(-5 * (i - 32) / 32))) / 255) for i in range(65)]
    curve = ovoid.render(array, opacity="sigmoid_5", clim=(20, 90), **SMALL)
    assert (curve.numpy() == ovoid.render(array, opacity=steep, clim=(20, 90), **SMALL).numpy()).all()
    falling = ovoid.render(array, opacity="sigmoid_5_r", clim=(20, 90), **SMALL).state["flags"]["opacity"].split(",")
    assert [pair.split(":")[1] for pair in falling][::-1] == [pair.split(":")[1] for pair in curve.state["flags"]["opacity"].split(",")]
    path = tmp_path / "a.nrrd"
    ovoid.write(path, array)
    with pytest.raises(ovoid.InvalidArgument, match="spread over clim"):
        ovoid.render(path, opacity=[0, 1])


def test_one_opacity_for_all_values(array):
    lo, hi = int(array.min()), int(array.max())
    assert (ovoid.render(array, opacity=0.3, **SMALL).numpy() == ovoid.render(array, opacity=[(lo, 0.3), (hi, 0.3)], **SMALL).numpy()).all()


@pytest.mark.parametrize("given", [["black", "#ff0000", (1, 1, 0)], np.array([[0, 0, 0, 0.5], [1, 0, 0, 1], [1, 1, 0, 1]])])
@pytest.mark.parametrize("settings", [{}, {"clim": (20, 90)}])
def test_colours_spread_over_the_range(tmp_path, array, given, settings):
    """Evenly, as those of a map that has a name: over clim, or what shows without it. Of files, too, whose values are not known here."""
    picture = ovoid.render(array, cmap=given, **settings, **SMALL)
    values = np.linspace(*picture.look["RGBPoints"][::len(picture.look["RGBPoints"]) - 4], 3)
    assert picture.look["RGBPoints"] == pytest.approx([*[values[0], 0, 0, 0], *[values[1], 1, 0, 0], *[values[2], 1, 1, 0]])
    named = ovoid.render(array, cmap="magma", **settings, **SMALL).look["RGBPoints"]
    assert (values[0], values[2]) == pytest.approx((named[0], named[-4]))
    ovoid.write(tmp_path / "a.nrrd", array)
    assert png(ovoid.render(tmp_path / "a.nrrd", cmap=given, **settings, **SMALL)) == png(picture)


def test_colour_maps_of_matplotlib(array):
    """By their names where there is such a map here, else by their colours."""
    class Map:
        N = 256

        def __init__(self, name):
            self.name = name

        def __call__(self, at):
            return at, at * at, 1 - at, 1.0

    assert ovoid.render(array, cmap=Map("magma_r"), **SMALL).state["flags"]["colormap"] == "magma_r"
    points = np.reshape(ovoid.render(array, cmap=Map("other"), clim=(0, 1), **SMALL).look["RGBPoints"], (-1, 4))
    assert len(points) > 30 and abs(points[:, 1:] - np.array([Map("")(at)[:3] for at in points[:, 0]])).max() < 1e-3


def test_one_spacing_for_all_axes(tmp_path, array):
    expected = ovoid.render(array, spacing=(0.5, 0.5, 0.5), **SMALL)
    assert png(ovoid.render(array, spacing=np.float32(0.5), **SMALL)) == png(expected)
    array.tofile(tmp_path / "a.raw")
    assert png(ovoid.render(tmp_path / "a.raw", dims=(28, 24, 20), type="uint8", spacing=0.5, **SMALL)) == png(expected)


def test_camera_of_three_points(array):
    first = ovoid.render(array, **SMALL)
    camera = first.camera
    again = ovoid.render(array, cpos=(camera["position"], camera["focal_point"], camera["view_up"]), **SMALL)
    assert (again.numpy() == first.numpy()).all()
    assert (ovoid.render(array, camera=camera, **SMALL).numpy() == first.numpy()).all()


def test_particles_of_files(tmp_path):
    xyz = np.random.default_rng(3).normal(size=(400, 3))
    cloud = ovoid.particles(xyz, {"speed": np.linspace(0, 1, 400)}, h=np.full(400, 0.3))
    path = tmp_path / "cloud.npz"
    ovoid.write(path, cloud)
    assert png(ovoid.render(cloud, array="speed", **SMALL)) == drawn_by_program(path, *FLAGS, "--array", "speed")


def test_command_and_state(tmp_path, array):
    path = tmp_path / "my bumps.nrrd"
    ovoid.write(path, array)
    picture = ovoid.render(path, cmap="magma", clim=(10, 150), **SMALL)
    words = shlex.split(picture.command)
    assert words[:3] == ["ovoid", "render", str(path)]
    output = tmp_path / "again.png"
    subprocess.run([PROGRAM, *words[1:-1], str(output)], check=True, capture_output=True)
    assert output.read_bytes() == png(picture)
    assert picture.state["flags"] == {"size": "96x72", "colormap": "magma", "range": "10,150"} or \
        picture.state["flags"] == {"colormap": "magma", "range": "10,150", "size": "96x72"}


def test_saved_as_the_program_saves(tmp_path, array):
    path = tmp_path / "bumps.nrrd"
    ovoid.write(path, array)
    picture = ovoid.render(path, **SMALL)
    for ending in (".png", ".jpg", ".exr", ".npy"):
        subprocess.run([PROGRAM, "render", str(path), *FLAGS, "-o", str(tmp_path / ("program" + ending))], check=True, capture_output=True)
        picture.save(tmp_path / ("python" + ending))
        assert (tmp_path / ("python" + ending)).read_bytes() == (tmp_path / ("program" + ending)).read_bytes()
    assert (np.load(tmp_path / "python.npy") == picture.rgba).all()


def test_bytes_are_those_of_files(tmp_path, array):
    picture = ovoid.render(array, colorbar=True, **SMALL)
    for ending in (".png", ".jpg"):
        picture.save(tmp_path / ("a" + ending))
        assert picture.encode(ending) == (tmp_path / ("a" + ending)).read_bytes()
    assert len(picture.encode(".jpg", quality=20)) < len(picture.encode(".jpg"))
    for arguments, words in (((".exr",), "expected .png or .jpg"), ((".jpg", 0), "quality = 0"), ((".jpg", "good"), "quality = 'good'")):
        with pytest.raises(ovoid.InvalidArgument, match=words):
            picture.encode(*arguments)
    with pytest.raises(ovoid.InvalidArgument, match="cannot be transparent"):
        ovoid.render(array, background="none", **SMALL).encode(".jpg")


def test_the_look_comes_back(array):
    picture = ovoid.render(array, cmap="magma", clim=(20, 180), **SMALL)
    assert picture.look["RGBPoints"][0] == 20 and picture.look["RGBPoints"][-4] == 180
    again = ovoid.render(array, tf=picture.look, **SMALL)
    assert (again.numpy() == picture.numpy()).all() and again.look == picture.look


def test_frames_of_a_scene_find_the_look_once():
    """What the default look is made of is read once: half a second of the samples of a large scan, for every frame otherwise."""
    scene = ovoid.Scene(bumps(), **SMALL)
    looks = [scene.render(azimuth=azimuth, **more).look for azimuth in (0, 30) for more in ({}, {"kernel": "gaussian"}, {"mode": "maximum"})]
    assert looks[:3] == looks[3:] and looks[0] != looks[2]
    assert looks == [ovoid.render(bumps(), azimuth=azimuth, **more, **SMALL).look
                     for azimuth in (0, 30) for more in ({}, {"kernel": "gaussian"}, {"mode": "maximum"})]


def test_forms(array):
    picture = ovoid.render(array, **SMALL)
    pixels = np.asarray(picture)
    assert pixels.shape == (72, 96, 4) and pixels.dtype == np.uint8
    assert (pixels == picture.numpy()).all() and pixels.std() > 10
    image = pytest.importorskip("PIL.Image")
    assert (np.asarray(image.open(io.BytesIO(png(picture))).convert("RGBA")) == pixels).all()
    assert set(picture._repr_mimebundle_()) == {"text/plain", "image/png"}
    assert picture._repr_mimebundle_(include={"image/png"})["image/png"] == png(picture)


def test_depth_lies_on_the_data(array):
    picture = ovoid.render(array, mode="isosurface", iso=90, **SMALL)
    finite = np.isfinite(picture.depth)
    assert picture.depth.shape == (72, 96) and 0 < finite.sum() < finite.size
    distance = np.linalg.norm(np.subtract(picture.camera["position"], picture.camera["focal_point"]))
    assert (abs(picture.depth[finite] - distance) < 30).all()
    assert (picture.rgba[..., 3][finite] > 0).all()


def test_profile(array):
    profile = ovoid.render(array, profile=True, **SMALL).profile
    assert profile["frame_ms"]["median"] > 0 and profile["stages_ms"] and profile["size"] == [96, 72]
    assert not ovoid.render(array, **SMALL).profile["stages_ms"]


def test_views_model_once(array):
    scene = ovoid.Scene(bumps(), **SMALL)
    first = scene.render()
    assert first.profile["model_ms"] > 0
    turned = scene.render(azimuth=40, cmap="magma")
    assert turned.profile["model_ms"] == 0
    assert (turned.numpy() == ovoid.render(array, azimuth=40, cmap="magma", **SMALL).numpy()).all()
    smoothed = scene.render(kernel="gaussian")  # another field
    assert smoothed.profile["model_ms"] > 0
    assert (smoothed.numpy() == ovoid.render(array, kernel="gaussian", **SMALL).numpy()).all()
    assert (scene.render().numpy() == first.numpy()).all()


def test_labels_stay_labels():
    labels = np.zeros((16, 16, 16), "u1")
    labels[4:9, 4:12, 4:12], labels[9:12, 4:12, 4:12] = 1, 2
    scene = ovoid.Scene(labels, **SMALL)
    first = scene.render()
    assert any("look like labels" in note for note in first.notes)
    again = scene.render()
    assert again.profile["model_ms"] == 0 and again.notes == first.notes
    assert (again.numpy() == first.numpy()).all()


def test_view_keeps_settings(array):
    view = ovoid.Scene(array, **SMALL).view(azimuth=30)
    expected = ovoid.render(array, azimuth=30, zoom=2, **SMALL).numpy()
    assert (view.update(zoom=2).render().numpy() == expected).all()
    frames = list(view.frames(azimuth=[0, 30], elevation=[5, 0]))
    assert (frames[1].numpy() == expected).all() and (frames[0].numpy() != expected).any()
    view.update(azimuth=None, zoom=None)
    assert (view.render().numpy() == ovoid.render(array, **SMALL).numpy()).all()
    with pytest.raises(ovoid.InvalidArgument, match="as many values"):
        list(view.frames(azimuth=[0, 30], elevation=[5]))


def test_films(tmp_path, array):
    view = ovoid.Scene(array, **SMALL).view()
    ovoid.animate(view.frames(azimuth=[0, 90, 180]), tmp_path / "turn.gif", fps=10)
    image = pytest.importorskip("PIL.Image")
    with image.open(tmp_path / "turn.gif") as film:
        assert film.n_frames == 3 and film.size == (96, 72)
    with pytest.raises(ovoid.InvalidArgument, match="no pictures"):
        ovoid.animate([], tmp_path / "none.gif")
    with pytest.raises(ovoid.InvalidArgument, match="expected a film"):
        ovoid.animate([ovoid.render(array, **SMALL)], tmp_path / "film.avi")


@pytest.mark.parametrize("pictures, settings, words", [
    (lambda one: one, {}, "pictures: is one Picture, expected several"),
    (lambda one: 7, {}, "pictures: is one int"),
    (lambda one: [one, one.numpy()], {}, r"pictures\[1\]: is ndarray, expected a Picture"),
    (lambda one: [one], {"frames": 3}, "frames: is for films along a camera_path"),
    (lambda one: [one], {"cmap": "magma"}, "cmap: is for films along a camera_path"),
    (lambda one: [one], {"fps": "fast"}, "fps = 'fast': expected a number"),
])
def test_what_makes_no_film(tmp_path, array, pictures, settings, words):
    with pytest.raises(ovoid.InvalidArgument, match=words):
        ovoid.animate(pictures(ovoid.render(array, size=(16, 12))), tmp_path / "film.gif", **settings)


def test_along_a_path(tmp_path, array):
    view = ovoid.Scene(array, **SMALL).view(cmap="magma", fit="box", view="+x")
    first = view.render()
    camera = view.render(azimuth=50, zoom=1.5).camera
    keys = [{"frame": 0}, {"frame": np.int64(2), "azimuth": 90.0, "zoom": 2}, {"frame": 4, **camera, "position": np.array(camera["position"])}]
    frames = list(view.along(keys))
    assert len(frames) == 5
    assert abs(frames[0].rgba - first.rgba).max() < 1e-4
    assert abs(frames[2].rgba - view.render(azimuth=90, zoom=2).rgba).max() < 1e-4
    assert (frames[4].numpy() == view.render(camera=camera, view=None, fit=None).numpy()).all()
    between = [one.camera["view_angle"] for one in frames]
    assert between[0] > between[1] > between[2]
    # Flags turn all keys, as the program's do.
    assert abs(list(view.update(azimuth=10).along(keys, frames=1))[0].rgba - view.render(azimuth=10).rgba).max() < 1e-4
    (tmp_path / "path.json").write_text(json.dumps([{"frame": 0}, {"frame": 2, "azimuth": 90}]))
    for subject in (array, ovoid.Scene(array, **SMALL), view):
        ovoid.animate(subject, tmp_path / "path.gif", camera_path=tmp_path / "path.json", frames=3, **SMALL)
        assert (tmp_path / "path.gif").read_bytes()[:6] == b"GIF89a"
        (tmp_path / "path.gif").unlink()


def test_the_program_goes_the_same_path(tmp_path, array):
    path = tmp_path / "bumps.nrrd"
    ovoid.write(path, array)
    keys = '[{"frame": 0, "elevation": 10}, {"frame": 2, "azimuth": 80, "zoom": 1.5}, {"frame": 3, "position": [90, 10, 10]}]'
    subprocess.run([PROGRAM, "animate", str(path), *FLAGS, "--fit", "box", "--camera-path", keys, "-o", str(tmp_path / "f%d.npy")], check=True, capture_output=True)
    for number, picture in enumerate(ovoid.Scene(path, fit="box", **SMALL).view().along(keys)):
        assert abs(picture.rgba - np.load(tmp_path / f"f{number}.npy")).max() < 1e-4


@pytest.mark.parametrize("keys, error, words", [
    ([], ovoid.FileFormat, "has no keys"),
    ([{"frame": 0}], ovoid.FileFormat, "one key"),
    ({"frame": 0}, ovoid.FileFormat, "one key"),
    ([{"frame": 0}, {"frame": np.nan}], ovoid.InvalidArgument, "expected finite numbers"),
    ([{"frame": 0}, {"frame": 0}], ovoid.FileFormat, "must be greater"),
    ([{"time": 0}, {"time": 1}], ovoid.Unsupported, "at times, expected frames"),
    ([{"frame": 0}, {"frame": 1, "pos": 1}], ovoid.FileFormat, "pos: unknown"),
    ([object()], ovoid.InvalidArgument, "cannot be written as JSON"),
    (7, ovoid.FileFormat, "one key"),
    ([7, 8], ovoid.FileFormat, "must be an object"),
    ("none.json", ovoid.NotFound, "none.json: no such file"),
])
def test_bad_paths(array, keys, error, words):
    view = ovoid.Scene(array, size=(16, 12)).view()
    with pytest.raises(error, match=words):
        list(view.along(keys))
    with pytest.raises(ovoid.InvalidArgument, match="frames = "):
        list(view.along([{"frame": 0}, {"frame": 1}], frames=0))


def test_surfaces_and_slices_in_the_scene(tmp_path, array):
    """A list is a flag that is repeated; colours are tuples or names."""
    for name, z in (("near", 20), ("far", 2)):
        (tmp_path / f"{name}.obj").write_text(f"v 0 0 {z}\nv 28 0 {z}\nv 28 24 {z}\nv 0 24 {z}\nf 1 2 3 4\n")
    files = [tmp_path / "near.obj", tmp_path / "far.obj"]
    try:
        picture = ovoid.render(array, add=files, add_color=[(1, 0, 0), "blue"], view="+z", shade=False, opacity=[(0, 0), (200, 0)], **SMALL)
    except ovoid.Unsupported as error:
        pytest.skip(str(error))
    red, green, blue, _ = picture.rgba[36, 48]
    assert red > 0.99 and green < 0.01 and blue < 0.01
    sliced = ovoid.render(array, slice="axial", slice_map="gray", slice_empty=True, view="+z", opacity=[(0, 0), (200, 0)], **SMALL)
    assert sliced.rgba[36, 48, 3] == 1 and np.ptp(sliced.rgba[36, 48, :3]) < 1e-3


def test_pick_tells_what_the_program_tells(tmp_path, array):
    path = tmp_path / "bumps.nrrd"
    ovoid.write(path, array)
    picture = ovoid.render(array, **SMALL)
    report = tmp_path / "picks.json"
    subprocess.run([PROGRAM, "render", path, *FLAGS, "--pick", "48,36", "--pick", "0,0", "--pick-report", report], check=True)
    told = json.loads(report.read_text())
    for pick in told["picks"]:
        found = picture.pick(*pick["pixel"])
        assert (found.pop("unit"), found.pop("length_unit")) == (told["unit"], told["length_unit"])
        assert found == pick
    assert [pick["shows"] for pick in told["picks"]] == [True, False]
    # What is drawn later changes nothing.
    hit = told["picks"][0]
    x, y, z = hit["position"]
    assert picture.depth[36, 48] == pytest.approx(hit["depth"]) or picture.rgba[36, 48, 3] < 0.5
    assert ovoid.sample(array, [(x, y, z)]).value[0] == pytest.approx(hit["value"], rel=1e-5)
    assert picture.pick(np.int64(48), np.uint8(36))["position"] == hit["position"]


def test_pick_refuses_other_pixels(array):
    picture = ovoid.render(array, **SMALL)
    for x, y in ((96, 0), (0, 72), (-1, 0)):
        with pytest.raises(ovoid.InvalidArgument, match="outside of the picture, expected 0,0 to 95,71"):
            picture.pick(x, y)
    with pytest.raises(TypeError):
        picture.pick(1.5, 2)
