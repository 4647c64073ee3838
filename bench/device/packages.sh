#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fetches the packages that a machine with a graphics processor and no network needs for bench/device/build.sh, compiler and CMake
# aside: packages.sh FOLDER. Some 25 MiB; nothing is installed.
set -euo pipefail
folder=${1:?"packages.sh FOLDER"}
mkdir -p "$folder"
cd "$folder"
apt-get download \
  libeigen3-dev libfmt-dev libfmt9 nlohmann-json3-dev libcli11-dev libpng-dev libpng16-16 zlib1g-dev zlib1g libbz2-dev libbz2-1.0 \
  libopenexr-dev libopenexr-3-1-30 libimath-dev libimath-3-1-29 libdeflate-dev voro++-dev libvoro++1 libhwy-dev libhwy1 \
  libvulkan-dev libvulkan1 libvulkan-volk-dev glslang-tools pkgconf pkgconf-bin libpkgconf3
du -sh .
