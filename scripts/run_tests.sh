#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs the tests of a built preset and counts them: run_tests.sh PRESET [CTEST ARGUMENT...].
set -euo pipefail
cd "$(dirname "$0")/.."

preset=$1
shift
junit=$PWD/build/$preset/junit.xml
rm -f "$junit"
status=0
ctest --preset "$preset" --parallel "${JOBS:-$(nproc)}" --no-tests=error \
  --output-junit "$junit" "$@" || status=$?
python3 scripts/tally.py junit "$preset" "$junit"
exit "$status"
