# SPDX-License-Identifier: Apache-2.0
"""The project's own files, for the checks."""
import os
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def project_files(*patterns):
    """Paths relative to the root of tracked and not yet tracked files that match the git patterns; all if none is given."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", "--", *patterns]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return sorted({path for path in listed.split("\0") if path and os.path.isfile(os.path.join(ROOT, path))})


def read_text(path):
    with open(os.path.join(ROOT, path), encoding="utf-8", errors="surrogateescape") as file:
        return file.read()


def git(*words):
    """What a git command prints, by lines."""
    return subprocess.run(["git", *words], cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()


def changed_since(commit):
    """Files that differ from a commit, those that git does not know yet among them."""
    return git("diff", "--name-only", commit) + git("ls-files", "--others", "--exclude-standard")
