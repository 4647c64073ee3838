#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the program without VTK, GDCM and HDF5, checks it on this machine's device and times it: build.sh [PACKAGES] [run.py's
# ARGUMENT...]. PACKAGES is a folder of what packages.sh has fetched; without it the system's are taken.
set -euo pipefail
cd "$(dirname "$0")/../.."

settings=()
if [[ $# -gt 0 && -d $1 ]]; then
  prefix=$(mktemp -d)
  for package in "$1"/*.deb; do dpkg -x "$package" "$prefix"; done
  shift
  library=$prefix/usr/lib/$(uname -m)-linux-gnu
  export PATH=$prefix/usr/bin:$PATH LD_LIBRARY_PATH=$library:$prefix/lib/$(uname -m)-linux-gnu:${LD_LIBRARY_PATH:-}
  export PKG_CONFIG_SYSROOT_DIR=$prefix PKG_CONFIG_PATH=$library/pkgconfig:$prefix/usr/share/pkgconfig
  settings+=("-DCMAKE_PREFIX_PATH=$prefix/usr" "-DCMAKE_LIBRARY_ARCHITECTURE=$(uname -m)-linux-gnu")
fi
cmake -S . -B build/device -G "$(command -v ninja >/dev/null && echo Ninja || echo 'Unix Makefiles')" -DCMAKE_BUILD_TYPE=Release \
  -DOVOID_IO_VTK=OFF -DOVOID_IO_GDCM=OFF -DOVOID_IO_HDF5=OFF -DOVOID_IO_OPENVDB=OFF -DOVOID_SIMD=few -DOVOID_TESTS=OFF -DOVOID_DEVICE_BENCH=ON \
  -DCMAKE_UNITY_BUILD=ON -DOVOID_PCH=ON "${settings[@]}"
cmake --build build/device --target ovoid_program device_peak -j "$(nproc)"

program=build/device/bin/ovoid
"$program" info --devices
# Checked before it is timed: the device's pictures against the reference's.
folder=$(mktemp -d)
"$program" make head --size 48 -o "$folder/head.nrrd"
"$program" make blobs --count 3000 -o "$folder/blobs.ply"
for data in head.nrrd blobs.ply; do
  for backend in reference vulkan; do
    "$program" render "$folder/$data" -o "$folder/$data-$backend.npy" --size 240x180 --post-convolution off --sheets image --backend "$backend"
  done
  python3 bench/device/compare.py "$folder/$data-reference.npy" "$folder/$data-vulkan.npy" 60
done
python3 bench/device/run.py "$@"
