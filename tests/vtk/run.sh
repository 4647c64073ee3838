#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs a test of the mappers for VTK on a virtual screen with Mesa's software driver: run.sh PYTHON TEST.py [TEST...]. Ends with 77, which
# ctest shows as skipped, and says why, where something that it needs is missing.
set -euo pipefail
python=$1
shift
if ! command -v Xvfb >/dev/null; then
  echo "skipped: no Xvfb (package xvfb)"
  exit 77
fi
if ! "$python" -c 'import numpy, vtkmodules.vtkRenderingVolumeOpenGL2' 2>/dev/null; then
  echo "skipped: $python has no numpy and vtkmodules (packages python3-numpy, python3-vtk9)"
  exit 77
fi
# The server finds a free number by itself and tells it, so that tests beside each other do not take the same, and stays as it is when the
# last window closes, since the next may open at that moment.
number=$(mktemp)
Xvfb -displayfd 3 -screen 0 1280x1024x24 -nolisten tcp -noreset 3>"$number" >/dev/null 2>&1 &
server=$!
trap 'kill $server 2>/dev/null; rm -f "$number"' EXIT
until [[ -s $number ]]; do
  kill -0 $server 2>/dev/null || { echo "Xvfb has not started" && exit 1; }
  sleep 0.05
done
DISPLAY=:$(<"$number") LIBGL_ALWAYS_SOFTWARE=1 PYTHONDONTWRITEBYTECODE=1 "$python" "$@"
