#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How the window feels: run.py [--program BUILD/bin/ovoid-viewer] [--size WxH] FILE... prints a table in Markdown.

Replays measure.txt on each file (turn, change one's mind, and with the panel shown drag an opacity point), on the display that there is or on a virtual
one, and tells pictures per second and how late they were. A virtual screen is drawn by the processor, which a desktop's is not.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
HEAD = ("file", "window, ms", "first picture, ms", "turning: pictures/s", "input to picture, ms", "to the full picture, ms",
        "dragging a point: input to picture, ms", "given up within, ms", "interface, ms a frame")


def start_screen():
    """A virtual screen, and its name."""
    read, write = os.pipe()
    screen = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1920x1200x24"], pass_fds=[write],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as pipe:
        return screen, ":" + pipe.readline().strip()


def pair(spread):
    return "-" if not spread else f"{spread['median']:.0f}, {spread['p99']:.0f}"


def row(path, report):
    sections = {section["name"]: section for section in report["sections"]}
    orbit, look, cancel = sections["orbit"], sections["look"], sections["cancel"]
    frames = [section["interface_ms"] for section in (orbit, look)]
    settle = [section["release_to_full_ms"]["max"] for section in (orbit, look) if section["release_to_full_ms"]]
    return (os.path.basename(path), f"{report['window_ms']:.0f}", f"{report['first_picture_ms']:.0f}",
            f"{orbit['pictures_per_second']:.0f}", pair(orbit["input_to_picture_ms"]), f"{max(settle):.0f}" if settle else "-",
            pair(look["input_to_picture_ms"]), f"{cancel['cancel_ms']['max']:.0f}" if cancel["cancel_ms"] else "-",
            pair(max(frames, key=lambda spread: spread["p99"])))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", default="build/release/bin/ovoid-viewer")
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    environment, screen = dict(os.environ), None
    if "DISPLAY" not in environment and "WAYLAND_DISPLAY" not in environment:
        screen, environment["DISPLAY"] = start_screen()
    print("| " + " | ".join(HEAD) + " |")
    print("|" + "---|" * len(HEAD))
    try:
        for path in arguments.files:
            with tempfile.TemporaryDirectory() as folder:
                report = os.path.join(folder, "report.json")
                subprocess.run([arguments.program, path, "--size", arguments.size, "--backend", "cpu", "--no-panel",
                                "--script", os.path.join(HERE, "measure.txt"), "--report", report],
                               check=True, env=environment, stderr=subprocess.DEVNULL)
                with open(report, encoding="utf-8") as file:
                    print("| " + " | ".join(row(path, json.load(file))) + " |", flush=True)
    finally:
        if screen:
            screen.terminate()
    return 0


if __name__ == "__main__":
    sys.exit(main())
