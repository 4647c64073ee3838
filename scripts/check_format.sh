#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Names the C++ sources that differ from what .clang-format makes of them; --fix rewrites them.
set -euo pipefail
cd "$(dirname "$0")/.."

sources() {
  git ls-files -z --cached --others --exclude-standard -- '*.h' '*.cpp' |
    while IFS= read -r -d '' file; do [[ ! -e $file ]] || printf '%s\0' "$file"; done
}

if [[ ${1:-} == --fix ]]; then
  sources | xargs -0 --no-run-if-empty -n 16 -P "$(nproc)" clang-format -i
  exit
fi
unformatted=$(sources | xargs -0 --no-run-if-empty -n 16 -P "$(nproc)" clang-format --dry-run 2>&1 |
  sed -nE 's/^([^:]+):[0-9]+:[0-9]+: warning.*/\1: not formatted (make format)/p' | sort -u)
[[ -z $unformatted ]] || { echo "$unformatted"; exit 1; }
