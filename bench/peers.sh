#!/usr/bin/env bash
# Midway beside other renderers on this machine's cores, interleaved, for equal time: `path` and
# Mitsuba's scalar path on A, `bdpt` full and LuxCore's BIDIRCPU on B and C (its roulette off: it is
# biased with it on). Needs ../shared (peers' scripts, scenes, references) and network for pip.
#
# usage: bench/peers.sh [SECONDS [ROUNDS]]    prints a table; keeps everything in $MIDWAY_BENCH_DIR
#                                             (default: $TMPDIR/midway-bench)
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${1:-10}
rounds=${2:-3}
root=$PWD
shared=$root/../shared
work=${MIDWAY_BENCH_DIR:-${TMPDIR:-/tmp}/midway-bench}
[ -d "$shared/peers" ] || { echo "bench/peers.sh: ../shared/peers is not there" >&2; exit 3; }

# The peers' scripts look for their scenes beside themselves and for the references one level up.
mkdir -p "$work/peers" "$work/out"
cp "$shared"/peers/*.py "$work/peers/"
ln -sfn "$shared/references" "$work/references"
if [ ! -x "$work/venv/bin/python" ]; then
    python3 -m venv "$work/venv"
    "$work/venv/bin/pip" install --quiet mitsuba pyluxcore numpy OpenEXR
fi
python=$work/venv/bin/python
[ -d "$work/peers/scenes/C" ] || (cd "$work/peers" && "$python" gen_scenes.py scenes)

cargo build --release
midway=$root/target/release/midway
scenes=$shared/scenes/yardstick
log=$work/runs.jsonl
: > "$log"

# Appends a run's JSON line, its engine marked with the round.
keep() { grep '^{' | sed "s/\"engine\": \"/&#$round /" | tee -a "$log"; }

ours() { # scene, file, flags
    local scene=$1 file=$2
    shift 2
    "$python" bench/ours.py "$midway" "$scene" "$scenes/$file" "$seconds" "$work/out/${scene}_midway_$round" --seed "$round" "$@" | keep
}

mitsuba() { # scene
    (cd "$work/peers" && "$python" render_mitsuba.py --scene "$1" --variant scalar_rgb --engine path \
        --seconds "$seconds" --seed "$round" --threads "$(nproc)" --out "$work/out/$1_mitsuba_$round") | keep
}

luxcore() { # scene
    (cd "$work/peers" && "$python" render_lux.py --scene "$1" --engine BIDIRCPU --depth 16 \
        --set path.russianroulette.depth=1000 --seconds "$seconds" --seed "$round" --threads "$(nproc)" \
        --out "$work/out/$1_luxcore_$round") | keep
}

for round in $(seq "$rounds"); do
    ours A A-cornell.gltf --integrator path
    mitsuba A
    ours B B-caustic.gltf --integrator bdpt
    luxcore B
    ours C C-lamp.gltf --integrator bdpt
    luxcore C
done

echo
(cd "$work/peers" && "$python" table.py "$log")
