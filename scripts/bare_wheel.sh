#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes a wheel and draws with it in a bare system of the distribution, where none of its libraries is installed. Needs root.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh nightly
make --no-print-directory wheel
bare=$PWD/build/nightly/bare
if [[ ! -x $bare/usr/bin/python3 ]]; then
  rm -rf "$bare"
  debootstrap --variant=minbase --include=python3-numpy,python3-venv bookworm "$bare" >/dev/null
fi
rm -rf "$bare/root/env" "$bare"/root/ovoid-*.whl
cp build/package/ovoid-*.whl "$bare/root"
chroot "$bare" sh -c 'cd /root && python3 -m venv --system-site-packages env && env/bin/pip install -q --no-index ovoid-*.whl &&
  env/bin/python -c "import numpy, ovoid; ovoid.render(numpy.random.rand(32, 32, 32)).save(\"picture.png\")"'
[[ -s $bare/root/picture.png ]]
echo "wheel: 1 passed, 0 failed"
