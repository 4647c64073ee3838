#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Tests the plugin that scripts/paraview.sh has built: run.sh plugin | ranks [REPRESENTATION], on a virtual screen with Mesa's software
# driver. Ends with 77, which ctest shows as skipped, and says why, where something is missing.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
folder=$here/../../build/paraview
plugin=$folder/build/lib/OvoidVolume/OvoidVolume.so
skip() { echo "skipped: $1" && exit 77; }
[[ -f $plugin && -f $folder/prefix ]] || skip "no plugin for ParaView: scripts/paraview.sh builds it"
command -v Xvfb >/dev/null || skip "no Xvfb (package xvfb)"
prefix=$(<"$folder/prefix")
[[ $1 == plugin ]] || command -v mpiexec >/dev/null || skip "no mpiexec (package openmpi-bin)"

# The server finds a free number by itself and tells it, so that tests beside each other do not take the same, and stays as it is when the
# last process leaves, since the next may come at that moment.
scratch=$(mktemp -d)
Xvfb -displayfd 3 -screen 0 1280x1024x24 -nolisten tcp -noreset 3>"$scratch/number" >/dev/null 2>&1 &
server=$!
trap 'kill $server 2>/dev/null; rm -rf "$scratch"' EXIT
until [[ -s $scratch/number ]]; do
  kill -0 $server 2>/dev/null || { echo "Xvfb has not started" && exit 1; }
  sleep 0.05
done
export DISPLAY=:$(<"$scratch/number") LIBGL_ALWAYS_SOFTWARE=1 PYTHONDONTWRITEBYTECODE=1
export LD_LIBRARY_PATH=$prefix/lib/$(gcc -print-multiarch) PYTHONPATH=$prefix/lib/python3/dist-packages

if [[ $1 == plugin ]]; then
  "$prefix/bin/pvpython" "$here/adaptive_grid.py" "$scratch/adaptive.vthb"
  "$prefix/bin/pvpython" "$here/plugin_test.py" "$plugin" "$scratch"
  "$prefix/bin/pvpython" "$here/plugin_test.py" "$plugin" "$scratch" load
else
  "$prefix/bin/pvpython" "$here/adaptive_grid.py" "$scratch/adaptive.vthb"
  # Open MPI's names for: as root in a container, and more processes than processors.
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  for ranks in 1 4; do
    mpiexec --oversubscribe -n $ranks "$prefix/bin/pvbatch" "$here/ranks_test.py" "$plugin" "$scratch" "${@:2}"
  done
fi
