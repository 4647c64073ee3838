#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Configures a preset if that is due, then builds it: build.sh PRESET [-DNAME=VALUE...] [TARGET...].
set -euo pipefail
cd "$(dirname "$0")/.."

preset=$1
shift
folder=build/$preset
settings=()
while [[ ${1:-} == -D* ]]; do
  settings+=("$1")
  shift
done

# A folder that `make run` has made is for a first picture alone.
if [[ $preset == release && ${#settings[@]} == 0 ]]; then
  settings=(-DOVOID_ONLY_PROGRAM=OFF -DOVOID_SIMD=all)
fi

# Two at once in one folder spoil each other's work.
mkdir -p "$folder"
exec 9>"$folder/lock"
if ! flock -n 9; then
  echo "build: another build of $folder is under way, waiting for it" >&2
  flock 9
fi

is_set() {  # whether a -DNAME=VALUE is what the folder is configured with
  local name=${1#-D}
  grep -q "^${name%%=*}:[A-Z]*=${name#*=}\$" "$folder/CMakeCache.txt"
}

# Ninja runs CMake again when a CMakeLists.txt changes, but does not know of the presets.
is_due=false
[[ -f $folder/build.ninja && ! CMakePresets.json -nt $folder/build.ninja ]] || is_due=true
for setting in "${settings[@]}"; do
  $is_due || is_set "$setting" || is_due=true
done
if $is_due; then
  # A folder that was moved here from another place, or was made by another CMake, does not fit.
  if [[ -f $folder/CMakeCache.txt ]] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" "$folder/CMakeCache.txt"; then
    echo "build: $folder was configured for another checkout; it is made anew" >&2
    find "$folder" -mindepth 1 -maxdepth 1 ! -name lock -exec rm -rf {} +
  fi
  launcher=()
  if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  fi
  cmake --preset "$preset" "${launcher[@]}" "${settings[@]}" --log-level=NOTICE
  touch "$folder/build.ninja"
fi

# Another checkout of the same sources compiles to the same objects.
export CCACHE_BASEDIR=${CCACHE_BASEDIR:-$PWD} CCACHE_NOHASHDIR=true
# Without these ccache keeps nothing that used a precompiled header.
export CCACHE_SLOPPINESS=${CCACHE_SLOPPINESS:-pch_defines,time_macros,include_file_mtime,include_file_ctime}

# A unit takes up to 1.5 GB of memory.
jobs=${JOBS:-$(nproc)}
memory=$(awk '/^MemAvailable/ {print int($2 / 1500000)}' /proc/meminfo 2>/dev/null || true)
((${memory:-$jobs} >= jobs)) || jobs=$((memory > 0 ? memory : 1))

targets=()
(($# == 0)) || targets=(--target "$@")
status=0
cmake --build "$folder" --parallel "$jobs" "${targets[@]}" || status=$?
if ((status)); then  # compilers say it in the midst of much else
  free=$(df --output=avail -m "$folder" 2>/dev/null | tail -n 1 | tr -d ' ')
  ((${free:-1000} >= 100)) || echo "build: the disk that $folder is on is full ($free MB left): a build takes some 1000 MB; call it again when there is room" >&2
fi
exit "$status"
