#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a fresh checkout to a picture: what `make run` does. Builds the program for this machine's usual SIMD targets alone, unless the
# folder is configured for more already.
set -euo pipefail
cd "$(dirname "$0")/.."

tell() { printf '\n[%d/3] %s\n' "$1" "$2"; }

tell 1 "packages of the distribution (once)"
scripts/setup.sh program
tell 2 "the library and the program (minutes, once)"
settings=(-DOVOID_ONLY_PROGRAM=ON -DOVOID_SIMD=few)
if grep -qs '^OVOID_ONLY_PROGRAM:BOOL=OFF$' build/release/CMakeCache.txt; then settings=(); fi
scripts/build.sh release "${settings[@]}" ovoid_program
tell 3 "a sample volume and its picture"
scripts/sample.sh
