#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""One picture by 1 to 4 processes of this machine: processes.py FILE[+FILE...][@ARRAY]...

Each process has one thread, so that more of them than processors only take turns. Milliseconds of each stage are those of the slowest
process, medians of three runs; megabytes are the peak of the largest process."""
import json
import os
import statistics
import subprocess
import sys
import tempfile

from magnification import OVOID
from tables import grid

COUNTS, RUNS, SIZE = (1, 2, 3, 4), 3, "1024x768"
STAGES = ("load_ms", "model_ms", "draw_ms", "exchange_ms", "composite_ms")


def words_of(text):
    files, _, array = text.partition("@")
    return files.split("+") + (["--array", array] if array else [])


def measured(words, count, folder):
    out = os.path.join(folder, "profile.json")
    # Open MPI binds a process to a processor unless told otherwise, and refuses root and more processes than processors.
    environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                       OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_mpi_yield_when_idle="1")
    subprocess.run(["mpirun", "--bind-to", "none", "-n", str(count), OVOID, "render", *words, "--size", SIZE, "--threads", "1",
                    f"--profile={out}", "-o", os.path.join(folder, "picture.npy")], check=True, capture_output=True, env=environment)
    with open(out, encoding="utf-8") as file:
        return json.load(file)


def slowest(profile, stage):
    value = profile[stage]
    return value["greatest"] if isinstance(value, dict) else value


def main():
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for text in sys.argv[1:]:
            for count in COUNTS:
                runs = [measured(words_of(text), count, folder) for _ in range(RUNS)]
                times = [statistics.median(slowest(run, stage) for run in runs) for stage in STAGES]
                rows.append([os.path.basename(text), str(count)] + [f"{time:.0f}" for time in times] +
                            [f"{runs[0]['bytes_sent'] / 1e6:.1f}", f"{max(slowest(run, 'peak_mib') for run in runs):.0f}"])
    print("\n".join(grid(["data", "processes", "load", "model", "draw", "exchange", "composite", "MB sent", "peak MiB"], rows)))


main()
