#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts what passed, failed and was skipped, over several runs of tests and checks.

  tally.py junit NAME FILE FOLDER counts a ctest JUnit file, with the tests that GoogleTest's files in FOLDER tell of, prints one
                                  line, adds it to the tally
  tally.py add NAME P F S         adds counts to the tally
  tally.py ran PROGRAM FOLDER     exits 1 unless a test of that program has run, by GoogleTest's files in FOLDER
  tally.py failures               prints how many failures the tally holds
  tally.py sum                    prints what failed, again, and the tally's closing line; exits 1 if anything failed or nothing passed

The tally is the file named by OVOID_TALLY; without that variable nothing is kept. What failed tests said last is kept beside it.
"""
import glob
import os
import sys
import xml.etree.ElementTree as ElementTree


LAST_LINES = 40  # of a failed test's output


def closing_line(passed, failed, skipped):
    return f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else "")


def add(name, passed, failed, skipped):
    path = os.environ.get("OVOID_TALLY")
    if path:
        with open(path, "a", encoding="ascii") as tally:
            tally.write(f"{name} {passed} {failed} {skipped}\n")


def failures_in(shard):
    """What the failed tests of one of GoogleTest's files have to say."""
    if not os.path.exists(shard):
        return
    for test in ElementTree.parse(shard).getroot().iter("testcase"):
        said = "\n".join(failure.get("message") or "" for failure in test.iter("failure")).splitlines()
        if said:
            yield f"{test.get('classname')}.{test.get('name')}:"
            yield from said[:LAST_LINES]


def keep_failures(name, path, shards):
    """The failed tests of a JUnit file, and the end of what they printed: logs are long, and often cut at their beginning."""
    tally = os.environ.get("OVOID_TALLY")
    if not tally:
        return
    with open(tally + ".failed", "a", encoding="utf-8") as kept:
        for case in ElementTree.parse(path).getroot().iter("testcase"):
            if case.get("status") != "fail":
                continue
            said = list(failures_in(os.path.join(shards, case.get("name") + ".xml")))
            said = said or (case.findtext("system-out") or "").strip().splitlines()[-LAST_LINES:]
            kept.write("\n".join([f"--- {name}: {case.get('name')} failed; its last lines:", *said, ""]))


def print_failures():
    path = os.environ["OVOID_TALLY"] + ".failed"
    if os.path.exists(path):
        with open(path, encoding="utf-8") as kept:
            print(kept.read(), end="")


def total():
    counts = [0, 0, 0]
    with open(os.environ["OVOID_TALLY"], encoding="ascii") as tally:
        for line in tally:
            for index, field in enumerate(line.split()[1:]):
                counts[index] += int(field)
    return counts


def count_junit(path, shards):
    """Passed, failed and skipped. A shard, which is a process with many tests, counts as its tests, and once more if it ended badly."""
    counts = [0, 0, 0]
    for case in ElementTree.parse(path).getroot().iter("testcase"):
        status = case.get("status")
        shard = os.path.join(shards, case.get("name") + ".xml")
        if os.path.exists(shard):
            for test in ElementTree.parse(shard).getroot().iter("testcase"):
                failed = test.find("failure") is not None
                counts[1 if failed else 2 if test.get("result") == "skipped" else 0] += 1
        elif status != "fail":
            counts[0 if status == "run" else 2] += 1
        if status == "fail" and not (os.path.exists(shard) and counts[1]):
            counts[1] += 1
    return counts


def main(arguments):
    command = arguments[0] if arguments else ""
    if command == "junit":
        counts = count_junit(arguments[2], arguments[3])
        add(arguments[1], *counts)
        keep_failures(*arguments[1:4])
        print(f"{arguments[1]}: {closing_line(*counts)}")
    elif command == "add":
        add(arguments[1], *(int(value) for value in arguments[2:5]))
    elif command == "ran":
        ran = sum(case.get("result") == "completed" for path in glob.glob(os.path.join(arguments[2], f"{arguments[1]}.*.xml"))
                  for case in ElementTree.parse(path).getroot().iter("testcase"))
        print(f"{ran} tests of {arguments[1]} ran")
        return 0 if ran else 1
    elif command == "failures":
        print(total()[1])
    elif command == "sum":
        counts = total()
        print_failures()
        print(closing_line(*counts))
        return 1 if counts[1] or not counts[0] else 0
    else:
        print(__doc__, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
