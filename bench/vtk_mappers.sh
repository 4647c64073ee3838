#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs vtk_mappers.py with what `scripts/build.sh release ovoid_mappers` has built, on a virtual screen with Mesa's software driver:
# vtk_mappers.sh [--frames N] [GRID...], grids in any format that `ovoid convert` makes VTI files of.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
words=()
for word in "$@"; do
  if [[ -f $word && $word != *.vti ]]; then
    name=$(basename "$word")
    build/release/bin/ovoid convert "$word" -o "$folder/${name%%.*}.vti" 2>/dev/null
    word=$folder/${name%%.*}.vti
  fi
  words+=("$word")
done
export LIBGL_ALWAYS_SOFTWARE=1 PYTHONPATH=$PWD/build/release/lib/python3/dist-packages
xvfb-run --auto-servernum /usr/bin/python3 bench/vtk_mappers.py "${words[@]}"
