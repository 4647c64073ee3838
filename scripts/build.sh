#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Configures a preset if that is due, then builds it: build.sh PRESET [TARGET...].
set -euo pipefail
cd "$(dirname "$0")/.."

preset=$1
shift
folder=build/$preset
# Ninja re-runs CMake when a CMakeLists.txt changes, but does not know of the presets.
if [[ ! -f $folder/build.ninja || CMakePresets.json -nt $folder/build.ninja ]]; then
  launcher=()
  if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  fi
  cmake --preset "$preset" "${launcher[@]}" --log-level=NOTICE
  touch "$folder/build.ninja"
fi

# Another checkout of the same sources compiles to the same objects.
export CCACHE_BASEDIR=${CCACHE_BASEDIR:-$PWD} CCACHE_NOHASHDIR=true
# Without these ccache keeps nothing that used a precompiled header.
export CCACHE_SLOPPINESS=${CCACHE_SLOPPINESS:-pch_defines,time_macros,include_file_mtime,include_file_ctime}

targets=()
(($# == 0)) || targets=(--target "$@")
cmake --build "$folder" --parallel "${JOBS:-$(nproc)}" "${targets[@]}"
