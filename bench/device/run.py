#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Times the vulkan back end on this machine's device and prints one table: bench/device/run.py [--quick] [--only WORD...] [--within SECONDS].

Every scene is drawn once and checked, then timed (ovoid bench). Times are the device's own, from its clock, and those of whole frames,
which also read the picture back. Rows with a switch tell what an optimisation brings; fragment-centric ones are METHOD's comparison:
every sample visits every kernel of its block.
"""
import argparse
import json
import os
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TAPS = 64  # kernels that reach a sample at the default kernel: 4 x 4 x 4
HD, UHD = "1920x1080", "3840x2160"

# What is asked of one large data-centre device: scene, frames per second of device time.
AIMS = {f"head-256-{HD}-soft": 240, f"head-512-{HD}-soft": 60, f"blobs-1000000-{HD}-soft": 120, f"blobs-10000000-{HD}-soft": 30}

# The published factor of each optimisation (METHOD 4.3), and the switch that turns it off.
SWITCHES = {"--no-stop": "early splat elimination: about 2", "--no-pack": "four slabs at once: about 3", "--no-skip": "empty space: not given"}


def scenes(quick):
    """(scene, flags) in the order of the table."""
    if quick:
        sizes, counts, pictures = (64,), (1000,), ("96x72",)
    else:
        sizes, counts, pictures = (128, 256, 512, 1024), (100_000, 1_000_000, 10_000_000, 100_000_000), (HD, UHD)
    for picture in pictures:
        for size in sizes:
            for look in ("soft", "opaque"):
                yield f"head-{size}-{picture}-{look}", []
        for count in counts:
            for look in ("soft", "opaque"):
                yield f"blobs-{count}-{picture}-{look}", []
    picture, size, count = pictures[0], sizes[min(1, len(sizes) - 1)], counts[min(1, len(counts) - 1)]
    for magnification in (2, 4, 8):
        for way in ("off", "auto"):
            yield f"head-{size}-{picture}-soft-x{magnification}", ["--post-convolution", way]
        yield f"blobs-{count}-{picture}-soft-x{magnification}", []
    for switch in ("--no-skip", "--no-stop"):
        yield f"head-{size}-{picture}-opaque", [switch]
    for switch in SWITCHES:
        yield f"blobs-{count}-{picture}-opaque", [switch]
    yield f"blobs-{counts[0]}-{picture}-soft", ["--evaluate", "gather"]


def measure(program, scene, flags, device):
    command = [program, "bench", scene, "--backend", "vulkan", "--json", "--frames", "30", *flags]  # clocks rise while it works
    if device is not None:
        command += ["--device", str(device)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900)
    if done.returncode != 0:
        return {"error": done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"exit code {done.returncode}"}
    return json.loads(done.stdout)


def row(scene, flags, result, peak):
    if "error" in result:
        return f"| {scene} {' '.join(flags)} | {result['error']} | | | | | |"
    drawn = result["scenes"][0]
    stages = {name: ms for name, ms in drawn["stages_ms"].items() if name not in ("plan", "read back")}  # the processor's
    device_ms = sum(stages.values())
    samples = drawn["samples"]
    needed = TAPS * (samples["reconstructed"] + 3 * samples["gradients"]) if scene.startswith("head") else 0
    share = needed / (device_ms / 1e3) / peak["fma_per_second"] if device_ms and needed else 0
    longest = ", ".join(f"{name} {ms:.2f}" for name, ms in sorted(stages.items(), key=lambda item: -item[1])[:3])
    aim = AIMS.get(scene) if not flags else None
    return (f"| {scene} {' '.join(flags)} | {device_ms:.2f} | {1e3 / device_ms if device_ms else 0:.0f} | {drawn['frame_ms']['median']:.2f} | "
            f"{f'{share:.3f}' if share else ''} | {longest} | {f'>= {aim}' if aim else ''} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "device", "bin", "ovoid"))
    parser.add_argument("--peak", default=os.path.join(ROOT, "build", "device", "bin", "device_peak"))
    parser.add_argument("--device", type=int, help="index (ovoid info --devices)")
    parser.add_argument("--quick", action="store_true", help="small scenes: to try the script, not to publish")
    parser.add_argument("--only", nargs="+", metavar="WORD", help="the rows that hold one of these words: head-512, 1920x1080, --no-stop")
    parser.add_argument("--within", type=float, default=float("inf"), metavar="SECONDS", help="begin no row after so long, for a borrowed machine")
    parser.add_argument("--output", help="a folder for every number, as JSON")
    arguments = parser.parse_args()
    peak = json.loads(subprocess.run([arguments.peak] + ([str(arguments.device)] if arguments.device is not None else []),
                                     check=True, capture_output=True, text=True).stdout)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip() or "unknown"
    print(f"{peak['device']}, {peak['driver']}; commit {commit}; measured peaks: {peak['fma_per_second'] / 1e12:.2f} T multiply-adds and "
          f"{peak['bytes_per_second'] / 1e9:.0f} GB copied (read and written) per second\n")
    print("| scene | device ms | frames/s | whole frame ms | FMA share | longest stages, ms | aim, frames/s |")
    print("|---|---:|---:|---:|---:|---|---:|", flush=True)
    results = []
    start = time.monotonic()
    for scene, flags in scenes(arguments.quick):
        if arguments.only and not any(word in " ".join([scene, *flags]) for word in arguments.only):
            continue
        if time.monotonic() - start > arguments.within:
            print(f"\nMore rows were not begun: {arguments.within:.0f} s are over.")
            break
        result = measure(arguments.program, scene, flags, arguments.device)
        results.append({"scene": scene, "flags": flags, "result": result})
        print(row(scene, flags, result, peak), flush=True)
    print("\nSwitches, and what the method's own implementation gained in 2005: " + "; ".join(f"{s}: {g}" for s, g in SWITCHES.items()))
    if arguments.output:
        os.makedirs(arguments.output, exist_ok=True)
        with open(os.path.join(arguments.output, "device.json"), "w", encoding="ascii") as file:
            json.dump({"peak": peak, "commit": commit, "results": results}, file, indent=1)
    return 1 if any("error" in one["result"] for one in results) else 0


if __name__ == "__main__":
    sys.exit(main())
