#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes a sample volume, draws it and prints the picture's path.
set -euo pipefail
cd "$(dirname "$0")/.."

ovoid=build/release/bin/ovoid
$ovoid make marschner-lobb -o build/sample.nrrd
$ovoid render build/sample.nrrd -o build/sample.png
echo "Drew $PWD/build/sample.png"
