#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the plugin for ParaView 5.11 and tests it, on one process and on four, without installing ParaView: Debian's packages (whose python3-paraview conflicts
# with python3-vtk9) are downloaded by apt and unpacked in build/paraview/root. With a folder that ParaView is installed under, that one is
# taken: paraview.sh [PREFIX]. Leaves the plugin in build/paraview/build/lib/OvoidVolume.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$PWD/build/paraview
root=${1:-$folder/root/usr}

if [[ $# == 0 && ! -d $root ]]; then
  mkdir -p "$folder/packages"
  (cd "$folder/packages" && apt-get download paraview paraview-dev python3-paraview)
  rm -rf "$folder/root.part"
  for package in "$folder"/packages/*.deb; do dpkg -x "$package" "$folder/root.part"; done
  mv "$folder/root.part" "$folder/root"
fi
scripts/build.sh release ovoid_program ovoid_reader ovoid_viewer ovoid_mappers ovoid_team ovoid_package
cmake --install build/release --prefix "$folder/ovoid" >"$folder/install.log"
cmake -S bindings/paraview -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DPython3_EXECUTABLE=/usr/bin/python3 \
  -DCMAKE_PREFIX_PATH="$folder/ovoid;$root" --log-level=WARNING
cmake --build "$folder/build"
echo "$root" >"$folder/prefix"  # where the tests find ParaView: these, and those of ctest from now on
tests/paraview/run.sh plugin
tests/paraview/run.sh ranks
