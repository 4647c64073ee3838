# SPDX-License-Identifier: Apache-2.0
"""What cannot be drawn is refused in words."""
import subprocess

import numpy as np
import ovoid
import ovoid._settings
import pytest
from conftest import PROGRAM, SMALL, bumps


@pytest.mark.parametrize("data, words", [
    (np.zeros((0, 3, 3)), r"shape \(0, 3, 3\), expected at least one value"),
    (np.zeros(7), r"shape \(7,\), expected \(z, y, x\)"),
    (np.zeros((2, 2, 2, 2, 2)), r"shape \(2, 2, 2, 2, 2\), expected"),
    (np.zeros((2, 2, 2, 5)), r"shape \(2, 2, 2, 5\), whose last axis is not that of 1 to 4, 6 or 9 components"),
    (np.array(3.0), r"shape \(\), expected"),
    (np.array([[[None, {}]]]), "holds object, expected numbers"),
    (np.zeros((2, 2, 2), complex), "holds complex128, expected numbers"),
    (np.zeros((2, 2, 2), "M8[s]"), "expected numbers"),
    (np.full((3, 3, 3), "a"), "expected numbers"),
    ([[[1, 2], [3]]], "inhomogeneous|sequence|object"),
    (np.full((3, 3, 3), np.nan), "none of its 27 samples is finite"),
    (object(), "holds object, expected numbers"),
    ({"heat": np.zeros((3, 3, 3))}, "is a dict of 'heat', expected an array, such as one of these"),
    (np.zeros((4, 3)), r"has the shape \(4, 3\), which places x, y, z have: expected ovoid.particles\(array\)"),
    (None, "none given"),
])
def test_arrays(data, words):
    with pytest.raises(ovoid.InvalidArgument, match=words) as caught:
        ovoid.render(data, **SMALL)
    assert isinstance(caught.value, ValueError) and caught.value.code == "invalid-argument"


@pytest.mark.parametrize("placement, words", [
    ({"spacing": (-1, 1, 1)}, "expected a number > 0, or three along x, y, z"),
    ({"spacing": (1, 1)}, "expected a number > 0, or three along x, y, z"),
    ({"spacing": 0}, "spacing = 0: expected a number > 0"),
    ({"spacing": True}, "spacing = True: expected a number > 0"),
    ({"spacing": "wide"}, "expected a number > 0, or three along x, y, z"),
    ({"origin": (np.nan, 0, 0)}, "origin"),
    ({"direction": np.zeros((3, 3))}, "columns are the axes"),
    ({"direction": [1, 2]}, "columns are the axes"),
])
def test_placement(placement, words):
    with pytest.raises(ovoid.InvalidArgument, match=words):
        ovoid.render(bumps(), **SMALL, **placement)


@pytest.mark.parametrize("settings, words", [
    ({"colormp": "magma"}, "colormp: unknown setting; did you mean colormap?"),
    ({"windowsize": (3, 3)}, "did you mean window_size?"),
    ({"output": "x.png"}, "output: unknown setting"),
    ({"vmax": 3}, "the range of the colours is clim="),
    ({"figsize": (6, 4)}, r"size=\(WIDTH, HEIGHT\) are pixels"),
    ({"cmap": ["red"]}, "expected two colours or more"),
    ({"cmap": ["red", "reddish"]}, "'reddish': expected a colour"),
    ({"cmap": [(0, 0, 0), (0, 2, 0)]}, r"\(0, 2, 0\): expected a colour"),
    ({"opacity": "sigmod"}, "opacity = 'sigmod': expected numbers, .*did you mean sigmoid?"),
    ({"opacity": 1.5}, "OPACITY in .0, 1."),
    ({"cmap": "magmma"}, "did you mean magma?"),
    ({"size": (0, 5)}, "--size '0x5'"),
    ({"size": 5}, "--size '5'"),
    ({"zoom": "near"}, "--zoom 'near': expected a number"),
    ({"iso": 3}, "--iso: needs --mode isosurface"),
    ({"axes": "yes"}, "axes = 'yes': expected True or False"),
    ({"cmap": "magma", "colormap": "gray"}, "give one of them"),
    ({"cpos": "up"}, "cpos = 'up': expected one of"),
    ({"cpos": [(1, 2), 3]}, "expected three points"),
    ({"blending": "median"}, "blending"),
    ({"blending": [1, 2]}, "blending"),
    ({"log": np.zeros(3)}, "expected True or False"),
    ({"step": 2}, "--step: is for data in time, these are one step"),
    ({"motion_blur": 2}, "--motion-blur: is for data in time"),
    ({"mass": 2}, "--mass: is for particles"),
    ({"component": 5}, "component"),
    ({"camera": {"position": [1, 2]}}, "must have 3 elements"),
])
def test_settings(settings, words):
    with pytest.raises(ovoid.InvalidArgument, match=words.replace("?", r"\?")):
        ovoid.render(bumps(), **{**SMALL, **settings})


def test_names_that_there_are_not_are_type_errors():
    with pytest.raises(TypeError):
        ovoid.render(bumps(), colour="red")


def test_the_words_are_the_programs(tmp_path):
    for flags, settings in ((["--size", "0x0"], {"size": "0x0"}), (["--zoom", "-1"], {"zoom": -1}), (["--tf", "gone.json"], {"tf": "gone.json"})):
        path = tmp_path / "a.nrrd"
        ovoid.write(path, bumps())
        told = subprocess.run([PROGRAM, "render", str(path), *flags, "-o", str(tmp_path / "a.png")], capture_output=True, text=True, check=False)
        with pytest.raises(ovoid.Error) as caught:
            ovoid.render(path, **settings)
        assert told.returncode != 0 and str(caught.value) in told.stderr


def test_other_packages_words_are_no_settings_here():
    """Else the hint hides a setting."""
    assert not set(ovoid._settings._OF_OTHERS) & {*ovoid.settings(), *ovoid._settings._ALIASES}


def test_an_empty_picture_says_why(caplog):
    """As a warning, which Python shows without any settings for logging; other notes are information."""
    ovoid.render(bumps(), clim=(300, 400), **SMALL)
    (record,) = [record for record in caplog.records if record.levelname == "WARNING"]
    assert record.name == "ovoid" and record.getMessage().startswith("nothing shows: the data's values are 0 to ")
    caplog.clear()
    ovoid.render(bumps(), **SMALL)
    assert not caplog.records


def test_names_that_are_not_there_suggest_others():
    with pytest.raises(AttributeError) as caught:
        ovoid.rendr
    assert caught.value.name == "rendr" and caught.value.obj is ovoid  # of which Python makes "Did you mean"


def test_what_is_no_path(tmp_path):
    """Without the whole array in the message."""
    for call, words in ((lambda: ovoid.write(bumps(), tmp_path / "a.nrrd"), "path: is ndarray, expected the name of a file"),
                        (lambda: ovoid.read([bumps(), bumps()]), "path: is a list, expected the name of a file"),
                        (lambda: ovoid.render("a\0.nrrd"), r"path = 'a\x00.nrrd': holds a NUL"),
                        (lambda: ovoid.render(bumps(), **SMALL).save("a\0.png"), "path = "),
                        (lambda: ovoid.write("a\0.nrrd", bumps()), "path = "),
                        (lambda: ovoid.render(bumps(), tf="a\0.json"), r"tf = 'a\x00.json': holds a NUL")):
        with pytest.raises(ovoid.InvalidArgument) as caught:
            call()
        assert str(caught.value).startswith(words) and len(str(caught.value)) < 100


def test_films_are_refused_before_they_are_drawn(tmp_path, monkeypatch):
    drawn = []
    frames = (drawn.append(1) or ovoid.render(bumps(), size=size) for size in ((8, 8), (8, 9)))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ovoid.Unsupported, match="ffmpeg, which is not on PATH"):
        ovoid.animate(frames, tmp_path / "a.mp4")
    assert not drawn
    with pytest.raises(ovoid.InvalidArgument, match=r"pictures\[1\]: is 8 x 9, expected 8 x 8"):
        ovoid.animate(frames, tmp_path / "a.gif")


def test_files(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        ovoid.render(tmp_path / "gone.nrrd")
    assert caught.value.code == "file-not-found" and isinstance(caught.value, ovoid.Error)
    broken = tmp_path / "broken.nrrd"
    broken.write_text("NRRD0004\ntype: float\ndimension: 3\nsizes: 9 9 9\nencoding: raw\n\nabc")
    with pytest.raises(ovoid.FileFormat, match="broken.nrrd"):
        ovoid.read(broken)
    with pytest.raises(ovoid.InvalidArgument, match="are for arrays"):
        ovoid.render(broken, origin=(0, 0, 0))
    with pytest.raises(OSError):
        ovoid.write(tmp_path / "no" / "folder.nrrd", bumps())
    with pytest.raises(ovoid.Unsupported):
        ovoid.write(tmp_path / "a.xyzzy", bumps())
    picture = ovoid.render(bumps(), background="none", **SMALL)
    with pytest.raises(ovoid.InvalidArgument, match="cannot be transparent"):
        picture.save(tmp_path / "a.jpg")
    with pytest.raises(ovoid.InvalidArgument, match="expected a name that ends in"):
        picture.save(tmp_path / "a.bmp")
    with pytest.raises(OSError):
        picture.save(tmp_path / "no" / "a.png")


PLACES = np.random.default_rng(1).random((50, 3))


@pytest.mark.parametrize("draw, words", [
    (lambda: ovoid.render(bumps(), origin=(1e38, 0, 0)), r"bounds = \(1e\+38, .* so far from the origin.*; move the data to the origin, or give lengths"),
    (lambda: ovoid.render(bumps(), origin=(0, 1e308, 0)), "so far from the origin"),
    (lambda: ovoid.render(bumps(), spacing=(1e150,) * 3), r"spacing\[0\] = 1e\+150: must be 1e-100 to 1e\+100; give lengths in another unit"),
    (lambda: ovoid.render(ovoid.particles(PLACES * 1e39, PLACES[:, 0])), r"'particles': its positions extend over .*e\+38, expected 1e-30 to 1e\+37; give lengths in another unit"),
    (lambda: ovoid.render(ovoid.particles(PLACES * 1e-38, PLACES[:, 0])), "extend over"),
    (lambda: ovoid.render(ovoid.particles(PLACES + 1e38, PLACES[:, 0])), "so far from the origin"),
    (lambda: ovoid.render(ovoid.particles(PLACES * 1e-25)), "'particles': its density is up to about .*; give lengths or masses in another unit"),
    (lambda: ovoid.render(ovoid.particles(PLACES * 1e25)), "its density is up to about"),
    (lambda: ovoid.render(ovoid.mesh(np.eye(4, 3) * 1e39, {"tetra": [[0, 1, 2, 3]]}, {"heat": np.arange(4.0)})), "extend over"),
    (lambda: ovoid.render(ovoid.mesh(np.eye(4, 3) + 1e38, {"tetra": [[0, 1, 2, 3]]}, {"heat": np.arange(4.0)})), "so far from the origin"),
])
def test_numbers_that_are_too_large(draw, words):
    """They were told of cameras, shapes and weights, or drew nothing."""
    with pytest.raises(ovoid.InvalidArgument, match=words):
        draw()


@pytest.mark.parametrize("arguments, words", [
    ((np.zeros((5, 2)),), r"xyz: has the shape \(5, 2\)"),
    ((np.zeros((0, 3)),), r"xyz: has the shape \(0, 3\)"),
    ((np.zeros((5, 3)), np.zeros(4)), "values: has the shape"),
    ((np.zeros((5, 3)), None, np.zeros((5, 2, 2))), "h: has the shape"),
])
def test_particles(arguments, words):
    with pytest.raises(ovoid.InvalidArgument, match=words):
        ovoid.particles(*arguments)
