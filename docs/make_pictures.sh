#!/usr/bin/env bash
# Makes the pictures of this folder, or those that are named: docs/make_pictures.sh city marquee
#
# Each is what anybody sees who starts the example and does with mouse and keys what its script says. Needs a display, or
# `xvfb-run -a -s "-screen 0 1280x720x24"` before it, and ImageMagick, which leaves as many colours as are worth it.
set -euo pipefail
cd "$(dirname "$0")/.."
out=out/pictures
mkdir -p $out

example() { cargo run --quiet --release --example "$@"; }
# What it was made as, what it is to be, and what ImageMagick makes of it.
keep() { convert "$1" "${@:3}" "PNG8:docs/$2.png"; }

city() {
    example city -- --play "click 0.195,0.55; move 0.68,0.5; wait 40; shot $out/city.png"
    keep $out/city.png city -resize 1000x -colors 96
}
inspector() {
    cargo run --quiet --release --features inspector --example city -- --entities 2000 \
        --play "key F1; wait 5; click 0.41,0.4; click 0.733,0.087; move 0.25,0.02; wait 20; shot $out/inspector.png"
    keep $out/inspector.png inspector -colors 160
}
structures_2d() {
    example structures -- --structure 2 --play "key End; wait 60; shot $out/structures_2d.png"
    keep $out/structures_2d.png structures_2d -colors 96
}
structures_3d() {
    example structures -- --three-d --play "key End; wait 60; shot $out/structures_3d.png"
    keep $out/structures_3d.png structures_3d -colors 96
}
skinned_picking() {
    local pins="wait 98; click 0.64,0.62; click 0.51,0.49; move 0.5,0.5; wait 2"
    example skinned_picking -- --play "$pins; shot $out/foxes.png; wait 16; shot $out/foxes_later.png"
    keep $out/foxes.png skinned_picking $out/foxes_later.png -append -resize 960x -colors 160
}
line_of_sight() {
    example line_of_sight -- --play "wait 300; shot $out/line_of_sight.png"
    keep $out/line_of_sight.png line_of_sight -colors 200
}
marquee() {
    local lasso="move 0.2,0.5; press; move 0.24,0.32; move 0.34,0.22; move 0.47,0.18; move 0.6,0.2; move 0.7,0.28;
        move 0.76,0.42; move 0.72,0.58; move 0.6,0.68; move 0.47,0.72; move 0.34,0.7; move 0.25,0.63"
    example marquee -- --play "wait 30; hold ShiftLeft; $lasso; wait 10; shot $out/marquee.png"
    keep $out/marquee.png marquee -colors 256
}
culling() {
    example culling -- --play "wait 30; shot $out/culling.png"
    keep $out/culling.png culling -colors 256
}
occlusion() {
    example occlusion -- --play "wait 60; shot $out/occlusion.png"
    keep $out/occlusion.png occlusion -colors 220
}
lod() {
    example lod -- --headless --picture $out/lod.png
    keep $out/lod.png lod -colors 256
}
auto_proxy() {
    cargo run --quiet --release --features simplify --example auto_proxy -- --edges --play "wait 30; shot $out/auto_proxy.png"
    keep $out/auto_proxy.png auto_proxy -crop 1280x630+0+0 +repage -colors 100
}
gizmos() {
    example gizmos -- --headless --pictures $out/gizmos
    keep $out/gizmos/nodes.png gizmos -colors 256
}

all=(city inspector structures_2d structures_3d skinned_picking line_of_sight marquee culling occlusion lod auto_proxy gizmos)
for picture in "${@:-${all[@]}}"; do
    "$picture"
done
