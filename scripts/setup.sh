#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the distribution's packages that groups of work need: setup.sh program [build] [test] [check] [clang] [bench] [nightly].
# Does nothing, in a few milliseconds, when they are all there. Debian 12, Ubuntu 24.04 and later.
set -euo pipefail

# Comments say why a package is here when its name does not.
declare -A groups=(
  # The library and the program: what a first picture needs. make and g++ are what the newcomer brings; named so that a container
  # without them gets them. Of HDF5 the library sees the headers alone.
  [program]="make g++ cmake ninja-build pkg-config
    libeigen3-dev libfmt-dev nlohmann-json3-dev libcli11-dev
    libpng-dev libjpeg-dev libgif-dev zlib1g-dev libbz2-dev libblosc-dev libzstd-dev liblz4-dev libopenexr-dev libpugixml-dev
    libvulkan-dev libvulkan-volk-dev glslang-tools spirv-tools
    voro++-dev libhwy-dev libhdf5-dev"
  # The readers' programs, the window, Python, VTK's mappers (wrapped by python3-vtk9's tools), MPI.
  [build]="ccache python3
    libvtk9-dev libgdcm-dev libseccomp-dev libopenvdb-dev libtbb-dev
    libglfw3-dev libimgui-dev libgl-dev
    python3-vtk9 python3-numpy pybind11-dev python3-dev
    libopenmpi-dev openmpi-bin
    libvulkan1"
  # Tests of the vulkan back end run on Mesa's software driver, with the validation layer looking on; the window is tested on a virtual
  # screen (xvfb) with Mesa's software driver (libgl1-mesa-dri).
  # The .deb's dependencies are found by dpkg-dev's dpkg-shlibdeps and file.
  # The Python package is tested by pytest, its stubs by mypy, its arguments by hypothesis, the notebooks by nbconvert; xarray, dask,
  # h5py, zarr, Pillow, meshio, pandas, nibabel and yt where they happen to be.
  # Its wheel is made with patchelf, and tested in a virtual environment (python3-venv).
  [test]="git lld libgtest-dev libgmock-dev
    mesa-vulkan-drivers vulkan-validationlayers
    dpkg-dev file
    python3-pytest mypy patchelf python3-venv
    python3-hypothesis python3-nbconvert python3-ipykernel python3-ipywidgets
    xvfb xauth libgl1-mesa-dri fonts-dejavu-core"
  [check]="git clang-format clang-tidy"
  # The builds under sanitizers, and the fuzzers.
  [clang]="clang"
  # The GPU peer draws with Mesa's software driver on a virtual screen; zfp's bytes stand beside those of fitted scans.
  [bench]="xvfb xauth libgl1-mesa-dri zfp"
  # A bare system that a wheel is tried in.
  [nightly]="debootstrap"
)

if ! command -v dpkg-query >/dev/null; then
  echo "setup: no dpkg here, so nothing is installed; the packages are named in scripts/setup.sh" >&2
  exit 0
fi

wanted=()
for group in "$@"; do
  read -r -d '' -a packages <<<"${groups[$group]:?"setup: unknown group '$group'"}" || true
  wanted+=("${packages[@]}")
done

as_root=()
((EUID == 0)) || as_root=(sudo)

# Installs those of the named packages that are missing.
ensure() {
  local installed package said free missing=()
  installed=$(dpkg-query -W -f '${Package} ${db:Status-Abbrev}\n' "$@" 2>/dev/null || true)
  for package in "$@"; do
    [[ $'\n'$installed == *$'\n'"$package ii"* ]] || missing+=("$package")
  done
  ((${#missing[@]})) || return 0

  echo "setup: installing ${#missing[@]} packages (minutes, once): ${missing[*]}"
  if ((EUID != 0)) && ! command -v sudo >/dev/null; then
    echo "setup: not root and no sudo; please install: ${missing[*]}" >&2
    exit 1
  fi
  # What apt says is kept from people only while all goes well.
  if ! said=$({ "${as_root[@]}" apt-get update -qq -o DPkg::Lock::Timeout=300 &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y -qq -o DPkg::Lock::Timeout=300 --no-install-recommends "${missing[@]}"; } 2>&1 </dev/null); then
    tail -n 15 <<<"$said" >&2
    free=$(df --output=avail -m /var/cache/apt 2>/dev/null | tail -n 1 | tr -d ' ')
    if ((${free:-10000} < 2000)); then
      echo "setup: the packages could not be installed: the disk has $free MB left, and they need some 2000" >&2
    else
      echo "setup: the packages could not be installed (apt's last lines stand above). Is there a network? Call it again: it goes on where it was." >&2
    fi
    exit 1
  fi
}

ensure "${wanted[@]}"
# clang's package does not bring the libraries of its sanitizers, and these have its version in their name.
if [[ " $* " == *" clang "* && ! -e $(clang --print-file-name=libclang_rt.asan-"$(uname -m)".a) ]]; then
  version=$(clang -dumpversion)
  ensure "libclang-rt-${version%%.*}-dev"
fi
