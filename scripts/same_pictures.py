#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the bytes of pictures of two commits, on one machine: same_pictures.py BEFORE [AFTER] [--only PART] [--match TEXT].

BEFORE and AFTER are commits, which are built in build/same/COMMIT, or folders that hold a release build; without AFTER it is build/release as
it stands. Drawn are the command lines of tests/doors/commands.txt, the calls of tests/doors/calls.py, the windows of tests/doors/window.txt and,
where there is mpirun, pictures by two and four processes, all of data that BEFORE makes (tests/doors/data.txt). Prints what differs, and by how
much; exits with 1 if anything does. No picture is kept: bytes depend on the machine's SIMD target.
"""
import argparse
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DOORS = ROOT / "tests" / "doors"
USUAL = ["--size", "160x120", "--threads", "2"]
LIMIT_SECONDS = 300
BY_PROCESSES = ("head.nrrd", "fin.vtu", "galaxy.npz")


def lines_of(name):
    return [line for line in (DOORS / name).read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]


def build_of(commit):
    """The folder of a release build of a commit."""
    if (Path(commit) / "bin" / "ovoid").exists():
        return Path(commit).resolve()
    number = subprocess.run(["git", "rev-parse", "--verify", f"{commit}^{{commit}}"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()
    tree = ROOT / "build" / "same" / number[:12]
    if not tree.exists():
        subprocess.run(["git", "clone", "--quiet", "--shared", ROOT, tree], check=True)
        subprocess.run(["git", "checkout", "--quiet", number], cwd=tree, check=True)
    subprocess.run(["scripts/build.sh", "release"], cwd=tree, check=True, stdout=subprocess.DEVNULL)
    return tree / "build" / "release"


def run(words, folder, build, **more):
    environment = dict(os.environ, PATH=f"{build / 'bin'}:{os.environ['PATH']}", PYTHONPATH=str(build / "python"))
    try:
        done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, timeout=LIMIT_SECONDS, check=False, **more)
    except subprocess.TimeoutExpired:
        return "took too long"
    return "" if done.returncode == 0 else f"exit code {done.returncode}: {done.stderr.strip()[-300:]}"


def command(line, out):
    ending, words = line.split(maxsplit=1)
    words = [str(out / f"picture.{ending}") if word == "OUT" else word for word in shlex.split(words)]
    name = words[0]
    if name in ("render", "animate"):
        flags = [*USUAL]
        if "--size" in words:
            flags = flags[2:]
        words += flags
    return ["ovoid", *words]


def script_of(line, out):
    first, *acts = [part.strip() for part in line.split(" | ")]
    script = out / "script.txt"
    script.write_text("\n".join(["wait full", *acts, "wait full", f"picture {out / 'picture.png'}"]) + "\n", encoding="utf-8")
    return ["xvfb-run", "-a", "ovoid-viewer", *shlex.split(first), "--size", "340x240", "--backend", "cpu", "--script", str(script)]


def jobs(parts):
    """Name, and what makes the words of a folder for what it writes."""
    if "commands" in parts:
        for line in lines_of("commands.txt"):
            yield line, lambda out, line=line: command(line, out)
    if "python" in parts:
        yield "calls.py", lambda out: ["/usr/bin/python3", str(DOORS / "calls.py"), str(out)]
    if "window" in parts and shutil.which("xvfb-run"):
        for line in lines_of("window.txt"):
            yield f"window {line}", lambda out, line=line: script_of(line, out)
    if "processes" in parts and shutil.which("mpirun"):
        for data in BY_PROCESSES:
            for count in ("2", "4"):
                yield f"{count} processes {data}", lambda out, data=data, count=count: [
                    "mpirun", "--allow-run-as-root", "--oversubscribe", "-n", count, "ovoid-mpi", data, "-o", str(out / "picture.png"), *USUAL]


def difference(before, after):
    """A line on two files; empty: they are the same."""
    if not after.exists() or not before.exists():
        return f"{before.name}: {'only after' if after.exists() else 'only before'}"
    one, two = before.read_bytes(), after.read_bytes()
    if one == two:
        return ""
    try:
        import numpy as np  # pylint: disable=import-outside-toplevel
        if before.suffix == ".npy":
            a, b = np.load(before), np.load(after)
        else:
            from PIL import Image  # pylint: disable=import-outside-toplevel
            a, b = (np.asarray(Image.open(path), dtype=float) for path in (before, after))
        if a.shape != b.shape:
            return f"{before.name}: {a.shape} before, {b.shape} after"
        apart = np.abs(a.astype(float) - b.astype(float))
        return f"{before.name}: {np.count_nonzero(apart)} numbers differ, by {apart.max():g} at most"
    except Exception:  # pylint: disable=broad-exception-caught
        return f"{before.name}: differs"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before")
    parser.add_argument("after", nargs="?", default=str(ROOT / "build" / "release"))
    parser.add_argument("--only", default="commands,python,window,processes", help="parts, by commas")
    parser.add_argument("--match", default="", help="only what has this text in its line")
    options = parser.parse_args()
    builds = [build_of(options.before), build_of(options.after)]
    differing = failed = count = 0
    with tempfile.TemporaryDirectory() as temporary:
        data = Path(temporary) / "data"
        data.mkdir()
        for line in lines_of("data.txt"):
            if said := run(["ovoid", *shlex.split(line)], data, builds[0]):
                sys.exit(f"{line}: {said}")
        for name, words in jobs(options.only.split(",")):
            if options.match not in name:
                continue
            outs, said = [], []
            for number, build in enumerate(builds):
                out = Path(temporary) / "out"
                out.mkdir()
                said.append(run(words(out), data, build))
                outs.append(out.rename(Path(temporary) / f"out{number}"))
            lines = [difference(outs[0] / file, outs[1] / file) for file in
                     sorted({path.name for out in outs for path in out.iterdir()} - {"script.txt", "frames.ovoid", "picture.ovoid"})]
            lines = [line for line in lines if line]
            if said[0] != said[1]:
                lines.append(f"before: {said[0] or 'well'}; after: {said[1] or 'well'}")
            elif said[0]:
                failed += 1
                print(f"FAILED before and after: {name}\n    {said[0]}", flush=True)
            count += 1
            if lines:
                differing += 1
                print(f"DIFFERS: {name}", *lines, sep="\n    ", flush=True)
            for out in outs:
                shutil.rmtree(out)
    print(f"{count} compared, {differing} differ, {failed} cannot be drawn")
    sys.exit(1 if differing or failed else 0)


if __name__ == "__main__":
    main()
