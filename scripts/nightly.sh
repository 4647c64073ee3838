#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What takes longer than a commit's checks may: nightly.sh [PART...]. Each part is done once for a commit: its result and its log stay in
# build/nightly/COMMIT, and the next call goes on with what is not there yet; a part that is named is done again. Exit code 0: no part
# has failed.
set -uo pipefail
cd "$(dirname "$0")/.." || exit

# In the order in which they are done: what finds most for its time comes first.
readonly all=(tests checks alone vulkan asan tsan targets package wheel experiments pictures mutants fuzz)
wanted=("$@")
((${#wanted[@]})) || wanted=("${all[@]}")

commit=$(git rev-parse --short=12 HEAD)
[[ -z $(git status --porcelain) ]] || commit+=-changed
folder=$PWD/build/nightly/$commit
mkdir -p "$folder"
export OVOID_TEST_NIGHTLY=1

part_tests() {  # the release build and all its tests but Vulkan's, the window's memory over ten thousand pictures among them
  make build && scripts/setup.sh test && scripts/build.sh release && scripts/run_tests.sh release -LE vulkan
}
part_checks() {              # every check, clang-tidy over all sources
  make build && scripts/setup.sh check && OVOID_TIDY_BASE=none scripts/check.sh
}
part_alone() { scripts/setup.sh program build test && scripts/build.sh dev; }  # each source by itself: no #include is missing
part_vulkan() {  # all tests of agreement on a Vulkan device, or Mesa's software driver
  scripts/build.sh release agreement_tests ovoid_program && scripts/run_tests.sh release -L vulkan
}
part_asan() {  # unit tests and those of agreement under AddressSanitizer and UndefinedBehaviorSanitizer
  scripts/setup.sh program build test clang && scripts/build.sh asan -DOVOID_SANITIZE_ALL=ON -DOVOID_VULKAN=ON tests_labelled_unit agreement_tests && scripts/run_tests.sh asan -R '_tests\.' -E 'analytic|golden|cli|experiments'
}
part_tsan() {  # unit tests under ThreadSanitizer
  scripts/setup.sh program build test clang && scripts/build.sh tsan -DOVOID_SANITIZE_ALL=ON tests_labelled_unit && scripts/run_tests.sh tsan -L unit
}
part_targets() {  # tests of agreement on each SIMD target of this machine
  scripts/build.sh release agreement_tests || return
  local target status=0
  for target in scalar sse4 avx2 avx3; do
    [[ $target != avx3 ]] || grep -qsw avx512bw /proc/cpuinfo || continue
    OVOID_TEST_TARGET=$target scripts/run_tests.sh release -R '^agreement_tests\.' || status=1
  done
  return $status
}
part_package() { make package && scripts/run_tests.sh release -L install; }
part_wheel() { scripts/bare_wheel.sh; }  # a wheel, tried where none of its libraries is installed
part_experiments() { scripts/build.sh release ovoid_experiments && build/release/bin/ovoid_experiments build/nightly/experiments; }
part_pictures() {  # the commands of the documents, and the notebooks
  scripts/build.sh release && scripts/run_tests.sh release -L docs && PYTHONPATH=build/release/python /usr/bin/python3 scripts/notebooks.py
}
part_mutants() { make mutants COUNT="${MUTANTS:-200}"; }
part_fuzz() { make fuzz SECONDS="${FUZZ_SECONDS:-10}"; }

failed=()
for part in "${wanted[@]}"; do
  if ! declare -F "part_$part" >/dev/null; then
    echo "nightly: there is no part '$part'; the parts are ${all[*]}" >&2
    exit 2
  fi
  if (($# == 0)) && [[ $commit != *-changed && -f $folder/$part.result ]]; then
    echo "nightly $part: done before: $(<"$folder/$part.result")"
    [[ $(<"$folder/$part.result") == passed* ]] || failed+=("$part")
    continue
  fi
  echo "nightly $part: begins"
  start=$SECONDS
  export OVOID_TALLY=$folder/$part.tally
  : >"$OVOID_TALLY"
  if "part_$part" >"$folder/$part.log" 2>&1 </dev/null; then word=passed; else word=FAILED; fi
  counted=$(grep -hE '(passed|failed)' "$folder/$part.log" | tail -n 1)
  echo "$word, $((SECONDS - start)) s: $counted" >"$folder/$part.result"
  echo "nightly $part: $(<"$folder/$part.result")"
  [[ $word == passed ]] || failed+=("$part")
done
# Where nothing has failed clang-tidy need not read again what does not change from here.
if [[ $commit != *-changed && -f $folder/checks.result && $(<"$folder/checks.result") == passed* ]]; then
  echo "nightly: clang-tidy passed over all; to let commits' checks begin from here: git rev-parse HEAD > .ci/tidy-base"
fi
if ((${#failed[@]})); then
  echo "nightly: FAILED: ${failed[*]}; their logs are in $folder" >&2
  exit 1
fi
echo "nightly: all ${#wanted[@]} parts passed for $commit"
