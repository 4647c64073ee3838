#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs the checks that are not tests, all of them or those named: check.sh [NAME...]. Prints `ok NAME` or the findings.
set -uo pipefail
cd "$(dirname "$0")/.." || exit

declare -A checks=(
  [text]="python3 scripts/check_text.py"
  [dependencies]="python3 scripts/check_dependencies.py"
  [references]="python3 scripts/check_references.py"
  [unity]="python3 scripts/check_unity.py"
  [format]="scripts/check_format.sh"
  [licences]="python3 scripts/check_licences.py build/release/bin/ovoid build/release/bin/ovoid-viewer build/release/bin/ovoid-read build/release/bin/ovoid-read-vdb scripts/licences.txt"
  [hardening]="python3 scripts/check_binaries.py --hardened build/release/bin/ovoid build/release/bin/ovoid-viewer build/release/bin/ovoid-mpi build/release/bin/ovoid-read build/release/bin/ovoid-read-vdb build/release/bin/libovoid.so build/release/python"
  [tidy]="python3 scripts/check_tidy.py"
)
names=("$@")
((${#names[@]})) || names=(text dependencies references unity format licences hardening tidy)

passed=0
failed=0
for name in "${names[@]}"; do
  command=${checks[$name]:?"check: no check is called '$name'"}
  if output=$($command 2>&1); then
    echo "ok $name${output:+: $(tail -n 1 <<<"$output")}"
    ((++passed))
  else
    printf 'FAILED %s\n%s\n' "$name" "$output"
    [[ -z ${OVOID_TALLY:-} ]] || printf -- '--- check %s failed:\n%s\n' "$name" "$(tail -n 40 <<<"$output")" >>"$OVOID_TALLY.failed"
    ((++failed))
  fi
done
python3 scripts/tally.py add checks "$passed" "$failed" 0
echo "checks: $passed passed, $failed failed"
((failed == 0))
