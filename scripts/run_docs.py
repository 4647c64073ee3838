#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the commands of documentation pages: run_docs.py [--check] PROGRAM PAGE...

Every block marked `sh` is run, in order, by one shell in an empty folder where `docs` is the project's, so that pictures go
where the page shows them. With --check they go to a folder that is thrown away; it fails if a command does, or if the page shows a
picture that no command of it made (pictures that another command of the project makes are named in OTHERS)."""
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BLOCK = re.compile(r"^```sh\n(.*?)^```", re.DOTALL | re.MULTILINE)
PICTURE = re.compile(r"\]\((images/[^)]+)\)")
OTHERS = {"images/contact-sheet.png",  # scripts/contact_sheet.py, from data that are not shipped
          "images/viewer-looks2d.png"}  # scripts/viewer_pictures.sh


def run(program, page, check):
    with open(os.path.join(ROOT, page), encoding="utf-8") as file:
        text = file.read()
    with tempfile.TemporaryDirectory() as folder:
        docs = os.path.join(folder, "docs")
        if check:
            os.makedirs(os.path.join(docs, "images"))
            os.symlink(os.path.join(ROOT, "docs", "looks"), os.path.join(docs, "looks"))
        else:
            os.symlink(os.path.join(ROOT, "docs"), docs)
        environment = dict(os.environ, PATH=os.path.dirname(os.path.abspath(program)) + ":" + os.environ["PATH"])
        script = "set -euo pipefail\n" + "\n".join(BLOCK.findall(text))
        done = subprocess.run(["bash", "-c", script], cwd=folder, env=environment, stdout=subprocess.DEVNULL, check=False)
        if done.returncode:
            sys.exit(f"{page}: a command ended with {done.returncode}")
        for picture in sorted(set(PICTURE.findall(text)) - OTHERS):
            if not os.path.exists(os.path.join(docs, picture)):
                sys.exit(f"{page}: shows {picture}, which none of its commands makes")


def main(arguments):
    check = "--check" in arguments
    arguments = [word for word in arguments if word != "--check"]
    if len(arguments) < 2:
        sys.exit(__doc__)
    for page in arguments[1:]:
        run(arguments[0], page, check)


if __name__ == "__main__":
    main(sys.argv[1:])
