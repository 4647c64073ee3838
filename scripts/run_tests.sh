#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs the tests of a built preset and counts them: run_tests.sh PRESET [CTEST ARGUMENT...].
set -euo pipefail
cd "$(dirname "$0")/.."

preset=$1
shift
# Two at once in one folder would write each other's results.
exec 9>"build/$preset/lock"
if ! flock -n 9; then
  echo "tests: build/$preset is being built or tested already, waiting for that" >&2
  flock 9
fi
junit=$PWD/build/$preset/junit.xml
shards=$PWD/build/$preset/shards  # what test programs say that run many tests in a process
rm -rf "$junit" "$shards"
status=0
ctest --preset "$preset" --parallel "${JOBS:-$(nproc)}" --no-tests=error \
  --output-junit "$junit" "$@" 9>&- || status=$?
python3 scripts/tally.py junit "$preset" "$junit" "$shards"
exit "$status"
