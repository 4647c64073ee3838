#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fuzzes every reader for a while: fuzz.sh SECONDS [TARGET...]. Builds with clang in build/fuzz; the corpora grow in
# build/fuzz/corpus from run to run, and an input that breaks a reader is left in build/fuzz/found and named. Exit code 0: nothing found.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${1:?"usage: fuzz.sh SECONDS [TARGET...]"}
targets=("${@:2}")
((${#targets[@]})) || targets=(nrrd npy nifti metaimage slc slice tiff zarr xdmf netcdf raw_name dicom dicom_codec vtk_header plot3d netcdf_header vdb_header gltf look look_2d label_table camera point_text npz ply lammps relevant_runs)
build=build/fuzz

launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
# Instrumentation goes into the library too: libFuzzer is led by the branches that the readers take.
cmake -S . -B "$build" -G Ninja -DOVOID_VTK_MAPPERS=OFF -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ \
  -DCMAKE_CXX_FLAGS="-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer -UNDEBUG" \
  -DOVOID_FUZZ=ON -DOVOID_IO_VTK=OFF -DOVOID_IO_HDF5=OFF -DOVOID_IO_OPENVDB=OFF -DOVOID_TESTS=OFF "${launcher[@]}" >"$build.log" 2>&1 ||
  { cat "$build.log" >&2; exit 1; }
ninja -C "$build" -j "${JOBS:-$(nproc)}" write_seeds "${targets[@]/#/fuzz_}" >"$build.log" 2>&1 ||
  { tail -50 "$build.log" >&2; exit 1; }

"$build/bin/write_seeds" "$build/seeds"
mkdir -p "$build/found"
failed=()
for target in "${targets[@]}"; do
  mkdir -p "$build/corpus/$target"
  echo "fuzz: $target for $seconds s"
  # 64 KiB hold every construct; deflate makes at most 64 MiB of them, and a reader may take as much again.
  leaks=1
  [[ $target != dicom* ]] || leaks=0  # GDCM's codecs forget memory when a stream is damaged
  ASAN_OPTIONS=detect_leaks=$leaks "$build/bin/fuzz_$target" -detect_leaks=$leaks \
    -max_total_time="$seconds" -timeout=10 -report_slow_units=1 -rss_limit_mb=1024 -malloc_limit_mb=128 \
    -max_len=65536 -print_final_stats=1 \
    -artifact_prefix="$build/found/$target-" "$build/corpus/$target" "$build/seeds/$target" >"$build/$target.log" 2>&1 ||
    { failed+=("$target"); tail -40 "$build/$target.log" >&2; }
  grep -E "number_of_executed_units|slowest_unit_time_sec|peak_rss_mb" "$build/$target.log" || true
done
if ((${#failed[@]})); then
  echo "fuzz: FAILED: ${failed[*]}; the inputs are in $build/found" >&2
  exit 1
fi
echo "fuzz: nothing found"
