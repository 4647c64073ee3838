#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Draws the screenshots of the window in docs again, or those named: viewer_pictures.sh [NAME...]. Each is what the window does by
# docs/viewer/NAME.txt, on sample data. Without a display it takes a virtual one (Xvfb).
set -euo pipefail
cd "$(dirname "$0")/.."
bin=$PWD/build/release/bin
docs=$PWD/docs
folder=$(mktemp -d)
display=
finish() {
  if [ -n "$display" ]; then kill "$display" || true; fi
  rm -rf "$folder"
}
trap finish EXIT

if [ -z "${DISPLAY:-}" ]; then
  if ! command -v Xvfb >/dev/null; then
    echo "viewer_pictures.sh: there is neither a display nor Xvfb (package xvfb)" >&2
    exit 1
  fi
  Xvfb -displayfd 3 -screen 0 1920x1200x24 3>"$folder/display" 2>/dev/null &
  display=$!
  for _ in $(seq 100); do
    if [ -s "$folder/display" ]; then break; fi
    sleep 0.1
  done
  DISPLAY=:$(cat "$folder/display")
  export DISPLAY
fi
export OVOID_INTERFACE_SCALE=1

cd "$folder"
ln -s "$docs" docs
"$bin/ovoid" make head -o head.nrrd --size 192
# A rod into the head, of 24 sides.
awk 'BEGIN {
  for (i = 0; i < 24; i++) for (e = 0; e < 2; e++)
    print "v", 0.6 - 0.5 * e + 0.04 * cos(i * 0.2618), -0.9 + 0.8 * e + 0.04 * sin(i * 0.2618), 0.85 - 0.5 * e
  for (i = 0; i < 24; i++) { j = (i + 1) % 24; print "f", 2 * i + 1, 2 * j + 1, 2 * j + 2, 2 * i + 2 }
  printf "f"; for (i = 0; i < 24; i++) printf " %d", 2 * i + 1; print ""
}' >lead.obj
"$bin/ovoid" make fin -o fin.vtu
"$bin/ovoid" make solid -o star.vtu --levels 0
"$bin/ovoid" make tornado --size 64 --steps 24 --lattice cc4 --type uint8 -o tornado.h5

picture() {  # NAME, then the words of `ovoid view`
  local name=$1
  shift
  if [ -z "$wanted" ] || [[ " $wanted " == *" $name "* ]]; then
    "$bin/ovoid" view "$@" --script "docs/viewer/$name.txt" 2>"$name.err" || { cat "$name.err" >&2; exit 1; }
    echo "Drew docs/images/viewer-$name.png"
  fi
}
wanted=$*
picture window head.nrrd
picture looks2d head.nrrd
picture space head.nrrd --preset ct-skin
picture scene head.nrrd --opacity=-300:0,0:0.03,250:0.06,1000:0.15 --add lead.obj --add-color 1,0.75,0.1 --azimuth 55 --elevation 20
picture time tornado.h5 --mode isosurface --iso 128 --view -y --azimuth 30 --elevation 25
picture fields fin.vtu --array pressure --view -x --azimuth 40 --elevation 30
picture compare head.nrrd
picture fit fin.vtu --array density --view -x --azimuth 130 --elevation 30
picture solid star.vtu --view top --elevation -50 --azimuth 12
