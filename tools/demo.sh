#!/usr/bin/env bash
# The main job from end to end: simulate a burst, run the portrait, score it, write the report.
#   tools/demo.sh [OUTPUT_DIR]        (default: demo-output)
if [[ ${1:-} == -* ]] || [ $# -gt 1 ]; then
  sed -n '2,3s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 2
fi
out=$(realpath -m "${1:-$(dirname "${BASH_SOURCE[0]}")/../demo-output}")
set --  # setup.sh would take them for packages
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

step() { echo "== $(date +%T) $1" >&2; }
step "Building: some 8 minutes on two cores, the first time"
cmake --preset release -DDUALPIXEL_TESTS=OFF -DDUALPIXEL_WERROR=OFF >/dev/null
cmake --build --preset release >&2
dualpixel=build/release/tools/dualpixel

step "Simulating a burst of the portrait with its truth: some 9 minutes on two cores"
"$dualpixel" simulate build/release/scenes/portrait.json -o "$out/capture"
for mode in dp dp+seg; do
  step "Portrait by $mode, and its score: seconds"
  "$dualpixel" portrait "$out/capture" -o "$out/$mode" --mode "$mode"
  echo "== $mode"
  "$dualpixel" score "$out/capture" "$out/$mode"
done
step "Report: seconds"
"$dualpixel" report "$out/dp" "$out/dp+seg" -o "$out/report.html"
echo "Open $out/report.html in a browser."
