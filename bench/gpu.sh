#!/usr/bin/env bash
# Midway on a GPU machine that has nothing but what is carried there: the built programs and the
# scenes. Renders A, B and C by path, light and each join, two seeds each, and prints Mrays/s,
# Msamples/s and the expected relMSE from the two seeds.
#
# usage: bench/gpu.sh OUT [SECONDS [SIZE [DEVICE]]]
#
# Before: cargo build --release -p midway -p xtask, and copy target/release/midway and
# target/release/xtask to bin/ (or name them by MIDWAY and XTASK), the scenes to SCENES.
set -euo pipefail
cd "$(dirname "$0")/.."

out=$1
seconds=${2:-10}
size=${3:-512}
device=${4:-gpu}
program() { if [ -x "bin/$1" ]; then echo "bin/$1"; else echo "target/release/$1"; fi; }
midway=${MIDWAY:-$(program midway)}
xtask=${XTASK:-$(program xtask)}
scenes=${SCENES:-../shared/scenes/yardstick}
[ -d "$scenes" ] || scenes=scenes
mkdir -p "$out"

declare -A integrators=(
    [path]="--integrator path"
    [light]="--integrator light"
    [full]="--integrator bdpt --join full"
    [k-step]="--integrator bdpt --join k-step --k 3"
    [k-step-importance]="--integrator bdpt --join k-step --k 3 --join-choice importance"
    [single-step]="--integrator bdpt --join single-step"
    [pool-k-step]="--integrator bdpt --join k-step --k 3 --light-paths pool"
    [pool-full]="--integrator bdpt --join full --light-paths pool"
)
order=(path light full k-step k-step-importance single-step pool-k-step pool-full)

# The value of a number in a JSON line.
number() { sed -n "s/.*\"$1\":\([-+0-9.eE]*\).*/\1/p" | tail -1; }

"$midway" devices
printf '%-4s %-18s %10s %10s %10s %12s %12s\n' scene integrator samples Mrays/s Msamples/s relMSE trimmed
for file in "$scenes"/*.gltf; do
    scene=$(basename "$file" .gltf)
    for name in "${order[@]}"; do
        for seed in 1 2; do
            image=$out/${scene}_${name}_$seed
            # shellcheck disable=SC2086 # flags are words
            "$midway" render "$file" ${integrators[$name]} --time "${seconds}s" --width "$size" --height "$size" \
                --seed "$seed" --device "$device" --progress json --quiet -o "$image.exr" > "$image.jsonl"
        done
        end=$(grep '"event":"end"' "$image.jsonl")
        samples=$(number samples <<< "$end")
        pace=$(number mrays_per_second <<< "$end")
        taken=$(number seconds <<< "$end")
        errors=$("$xtask" half "$out/${scene}_${name}_1.exr" "$out/${scene}_${name}_2.exr")
        awk -v scene="${scene%%-*}" -v name="$name" -v n="$samples" -v pace="$pace" -v s="$taken" -v size="$size" \
            -v relmse="$(number relmse <<< "$errors")" -v trimmed="$(number relmse_trimmed <<< "$errors")" \
            'BEGIN { printf "%-4s %-18s %10d %10.1f %10.2f %12.3e %12.3e\n", scene, name, n, pace, n * size * size / s / 1e6, relmse, trimmed }'
    done
done | tee "$out/table.txt"
