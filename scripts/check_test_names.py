#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that are chosen by name must be there: check_test_names.py [BUILD_FOLDER]

Presets leave tests out by patterns, and tests/CMakeLists.txt chooses tests for the device by others. Each must match a test of the
release build, so that a test that is renamed is not lost without a word.
"""
import fnmatch
import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def main(build):
    listed = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], check=True, capture_output=True, text=True)
    names = [test["name"] for test in json.loads(listed.stdout)["tests"]]
    lost = []
    for preset in json.loads((ROOT / "CMakePresets.json").read_text())["configurePresets"]:
        excluded = preset.get("cacheVariables", {}).get("OVOID_TEST_EXCLUDE", "")
        lost += [f"CMakePresets.json, {preset['name']}: '{one}'" for one in excluded.split(":")
                 if one and not any(fnmatch.fnmatchcase(name, one) for name in names)]
    patterns = re.search(r'TEST_FILTER "([^"]+)"', (ROOT / "tests/CMakeLists.txt").read_text()).group(1)
    lost += [f"tests/CMakeLists.txt: '{one}'" for one in patterns.split(":")
             if not any(fnmatch.fnmatchcase(name, f"vulkan.{one}") for name in names)]
    print("\n".join(f"{one}: matches no test" for one in lost) or f"{len(names)} tests")
    return int(bool(lost))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build" / "release"))
