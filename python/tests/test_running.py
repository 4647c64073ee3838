# SPDX-License-Identifier: Apache-2.0
"""Threads, Ctrl-C, forks, memory over many pictures, what an import costs, and the examples of the documentation."""
import doctest
import importlib
import inspect
import os
import re
import resource
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import ovoid
import ovoid._data
import ovoid._scene
import ovoid._settings
import pytest
from conftest import SMALL, bumps

ROOT = os.path.normpath(os.path.join(os.path.dirname(__file__), "..", ".."))
DOCS = os.path.join(ROOT, "docs", "python.md")


def test_other_threads_run_while_it_draws():
    """A thread counts while a picture is drawn; with the lock held it could not."""
    counts, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counts[0] += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    started, before = time.perf_counter(), counts[0]
    ovoid.render(bumps((48, 48, 48)), size=(300, 200), backend="reference", threads=1)
    seconds, counted = time.perf_counter() - started, counts[0] - before
    done.set()
    counter.join()
    assert counted > 50 * seconds  # a fifth of a second's thousand is room for a busy machine


def test_two_threads_draw(array, expected):
    results = [None, None]

    def draw(i):
        results[i] = [ovoid.render(array, **SMALL).numpy() for _ in range(5)]

    threads = [threading.Thread(target=draw, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((pixels == expected).all() for result in results for pixels in result)


def test_two_threads_share_a_scene(array, expected):
    scene = ovoid.Scene(array, **SMALL)
    results = []
    threads = [threading.Thread(target=lambda: results.append(scene.render().numpy())) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4 and all((pixels == expected).all() for pixels in results)


def test_ctrl_c_stops_a_frame():
    """The picture takes most of a minute; a stop takes some 0.02 s, and here a second for machines that have other things to do."""
    array = bumps((64, 64, 64))
    sent = []

    def interrupt():
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        ovoid.render(array, size=(1200, 900), backend="reference", threads=1)
    stopped = time.perf_counter()
    timer.join()
    assert sent and stopped - sent[0] < 1
    assert ovoid.render(array, **SMALL).numpy().std() > 5


def test_progress_that_fails_stops_a_frame():
    core = ovoid.Scene(bumps((64, 64, 64)))._core

    def fail(fraction):
        raise ZeroDivisionError(f"at {fraction}")

    with pytest.raises(ZeroDivisionError):
        core.draw(["--size", "2000x1500", "--backend", "reference"], {}, False, fail)


def test_progress_rises():
    core, told = ovoid.Scene(bumps((48, 48, 48)))._core, []
    core.draw(["--size", "300x200", "--backend", "reference"], {}, False, told.append)
    assert told[-1] == 1 and told == sorted(told)
    assert ovoid.render(bumps(), progress=True, **SMALL).width == 96


def test_many_pictures_take_no_memory(array):
    def resident():
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * resource.getpagesize()

    def draw(count):
        for _ in range(count):
            ovoid.render(array, size=(48, 36)).numpy()

    draw(50)
    before = resident()
    draw(250)
    assert resident() - before < 8 << 20  # each picture and its field take some 100 KB


def test_forked_processes_draw(array, expected):
    scene = ovoid.Scene(array, **SMALL)
    scene.render()
    child = os.fork()
    if child == 0:
        same = (scene.render().numpy() == expected).all() and (ovoid.render(array, **SMALL).numpy() == expected).all()
        os._exit(0 if same else 1)
    deadline = time.time() + 20
    while time.time() < deadline:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            assert status == 0
            return
        time.sleep(0.05)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    pytest.fail("the forked process hangs")


def test_the_end_of_the_process_is_quiet():
    script = "import numpy, ovoid; s = ovoid.Scene(numpy.arange(27.0).reshape(3, 3, 3)); s.render(size=(9, 9)); import builtins; builtins.kept = s"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stderr == ""


def test_stubs_are_the_modules(tmp_path):
    """But for pybind11's metaclass and its constructors, which take anything."""
    pytest.importorskip("mypy")
    allowed = tmp_path / "allowed"
    allowed.write_text("\n".join(f"ovoid._core.{name}{end}" for name in ("Data", "Picture", "Scene") for end in ("", ".__init__")))
    config = tmp_path / "config"
    config.write_text("[mypy]\nignore_missing_imports = true\n")  # tqdm, where it is, has no stubs
    done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "ovoid", "--ignore-missing-stub", "--ignore-unused-allowlist", "--allowlist",
                           str(allowed), "--mypy-config-file", str(config)], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stdout


def test_import_brings_neither_numpy_nor_others():
    """They would take longer than all else."""
    script = "import ovoid, sys; print([name for name in ('numpy', 'tqdm', 'xarray', 'dask', 'h5py', 'IPython') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_numpys_sizes_are_not_asked_of_pybind11():
    """Before 2.12 it finds 0 with numpy 2, which is not in the distribution: every array was refused. So these words are looked for."""
    folder = os.path.join(ROOT, "python", "core")
    for name in os.listdir(folder):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            assert not re.search(r"[.>](itemsize|nbytes)\(\)", file.read()), name


def test_every_setting_is_told():
    told = ovoid.settings()
    help_text = subprocess.run([os.environ["OVOID_PROGRAM"], "render", "--list-flags"], capture_output=True, text=True, check=True).stdout
    flags = {line.split("\t")[0].split(",")[-1][2:].replace("-", "_") for line in help_text.splitlines()}
    of_runs = {"help", "output", "save_look", "part", "pick", "pick_report", "state", "repeat", "profile", "dry_run"}
    assert set(told) == flags - of_runs


@pytest.mark.parametrize("module", ["_scene", "_data", "_functions", "_meshes", "_picture", "_series", "_settings"])
def test_examples_of_docstrings(tmp_path, monkeypatch, module):
    monkeypatch.chdir(tmp_path)
    found = doctest.testmod(importlib.import_module(f"ovoid.{module}"))
    assert found.attempted > 0 and found.failed == 0


def _public():
    """Every function and class that users call, and their methods, by name."""
    for name in ovoid.__all__:
        thing = getattr(ovoid, name)
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            yield from ((f"{name}.{method}", value) for method, value in vars(thing).items() if inspect.isfunction(value) and not method.startswith("_"))
        elif inspect.isfunction(thing):
            yield name, thing


@pytest.mark.parametrize("name, function", _public())
def test_docstrings_are_complete(name, function):
    """In numpydoc's sections: every argument, what comes back, and of functions what they raise."""
    text = inspect.getdoc(function)
    sections = dict(re.findall(r"(?ms)^(\w+)\n-+\n(.*?)(?=^\w+\n-+\n|\Z)", text))
    told = {word.strip().lstrip("*") for line in re.findall(r"(?m)^(\S.*)$", sections.get("Parameters", "")) for word in line.split(" : ")[0].split(",")}
    assert told == set(inspect.signature(function).parameters) - {"self"}
    assert len(text.splitlines()[0]) > 10 and text.splitlines()[0].endswith(".")
    makes_nothing = name in ("animate", "write", "Picture.save", "Interactive.close")
    assert makes_nothing or {"Returns", "Yields"} & set(sections)
    assert "." in name or "Raises" in sections


def test_examples_of_the_page(tmp_path, monkeypatch):
    """Every block of the page runs, one after the other, in one folder."""
    with open(DOCS, encoding="utf-8") as file:
        blocks = re.findall(r"^```python\n(.*?)^```", file.read(), re.DOTALL | re.MULTILINE)
    assert len(blocks) > 5
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks:
        exec(compile(block, DOCS, "exec"), names)


def test_the_readmes_lines_make_its_picture():
    """OVOID_UPDATE_GOLDEN=1 writes the picture anew."""
    path = os.path.join(ROOT, "docs", "images", "python.png")
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
        text = file.read()
    assert "](docs/images/python.png)" in text
    lines = re.search(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)[1].splitlines()
    names = {}
    exec("\n".join(lines[:-1]), names)
    picture = eval(lines[-1], names)
    if os.environ.get("OVOID_UPDATE_GOLDEN"):
        picture.save(path)
    (kept,) = ovoid.read([path, path]).arrays.values()  # one is no volume
    assert abs(kept[0].astype(int) - picture.numpy()[..., :3]).max() <= 2  # SIMD targets differ in the last digit
