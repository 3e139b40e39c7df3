#!/usr/bin/env bash
# Draws the gallery's scenes, simulates each at a small size, runs the portrait, and writes docs/gallery/NAME.jpg: what the
# phone sees, the disparity that the pipeline found (orange: behind the focus, blue: in front), the portrait, and the true
# photograph. Takes about ten minutes on two cores, after a build with tools/demo.sh.
#   tools/gallery.sh [NAME ...]       (default: all of scenes/gallery/)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
dualpixel=build/release/tools/dualpixel work=build/gallery
names=("$@")
[ $# -gt 0 ] || mapfile -t names < <(basename -s .json scenes/gallery/*.json)
mkdir -p docs/gallery

# Linear light to a display's sRGB, exposed to the brightness of a scene metered for a mean of .18.
encoded() { oiiotool "$1" --ch R,G,B --mulc "$3" --clamp:min=0:max=1 --colorconvert linear sRGB -d uint8 -o "$2"; }

for name in "${names[@]}"; do
  folder=$work/$name
  rm -rf "$folder"
  "$dualpixel" scene "scenes/gallery/$name.json" --set width_px=448 -o "$folder" >/dev/null
  "$dualpixel" simulate "$folder/scene.json" -o "$folder/capture" --set burst.frames=1 \
    --set render.samples_per_pixel=64 --set render.photograph_samples_per_pixel=64
  "$dualpixel" portrait "$folder/capture" -o "$folder/portrait" --mode dp --match-lens f/3.3@41mm-equivalent >/dev/null
  encoded "$folder/portrait/input.exr" "$folder/1.png" 2
  # one channel to three: white where the focus is, orange behind, blue in front; .3 DP pixels are full color
  oiiotool "$folder/portrait/maps.exr" --ch R=disparity_dp_px,G=disparity_dp_px,B=disparity_dp_px --mulc 1.667 --addc 0.5 \
    --clamp:min=0:max=1 --colormap 0.1,0.35,0.7,0.96,0.96,0.96,0.72,0.32,0.03 -d uint8 -o "$folder/2.png"
  encoded "$folder/portrait/portrait.exr" "$folder/3.png" 2
  encoded "$folder/capture/truth/photograph.exr" "$folder/4.png" 2
  oiiotool "$folder"/[1-4].png --mosaic:pad=4 4x1 --resize 1120x0 --compression jpeg:80 -o "docs/gallery/$name.jpg"
done
