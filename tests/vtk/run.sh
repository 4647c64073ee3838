#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs a test of the mappers for VTK on a virtual screen with Mesa's software driver: run.sh PYTHON TEST.py [TEST...]. Ends with 77, which
# ctest shows as skipped, and says why, where something that it needs is missing.
set -euo pipefail
python=$1
shift
if ! command -v xvfb-run >/dev/null; then
  echo "skipped: no xvfb-run (package xvfb)"
  exit 77
fi
if ! "$python" -c 'import numpy, vtkmodules.vtkRenderingVolumeOpenGL2' 2>/dev/null; then
  echo "skipped: $python has no numpy and vtkmodules (packages python3-numpy, python3-vtk9)"
  exit 77
fi
export LIBGL_ALWAYS_SOFTWARE=1 PYTHONDONTWRITEBYTECODE=1
exec xvfb-run --auto-servernum "$python" "$@"
