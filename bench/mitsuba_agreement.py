#!/usr/bin/env python3
"""Renders tests/scenes/mitsuba/*.xml with Mitsuba 3, as what tests/tests/proofs/importers.rs compares with.

usage: mitsuba_agreement.py [--spp N] [--batches N] [SCENE.xml ...]

Needs `pip install mitsuba` (the committed images: 3.9.1, variant scalar_rgb, on a CPU). Each scene is
rendered by the integrator that it names in independent batches, each with a seed of its own. The EXR in
tests/references/mitsuba holds the mean (R, G, B) and its standard error (se.R, se.G, se.B), the rounding
to half floats included. Without arguments all scenes are rendered, in about two minutes on two cores.
"""
import argparse
import pathlib

import mitsuba as mi
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent / "tests"
SCENES = ROOT / "scenes" / "mitsuba"
REFERENCES = ROOT / "references" / "mitsuba"
# Relative rounding error of a half float: uniform within half a unit of 2^-10.
ROUNDING = 2.0**-11 / 3.0**0.5
CHANNELS = ["R", "G", "B", "se.R", "se.G", "se.B"]


def batches(path, n, spp):
    """`n` independent images."""
    scene = mi.load_file(str(path))
    return np.stack([np.array(mi.render(scene, spp=spp, seed=seed), dtype=np.float64) for seed in range(n)])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spp", type=int, default=24, help="samples a pixel in a batch")
    parser.add_argument("--batches", type=int, default=16)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    arguments = parser.parse_args()
    mi.set_variant("scalar_rgb")
    REFERENCES.mkdir(parents=True, exist_ok=True)
    # What others include is no scene with a sensor.
    scenes = arguments.scenes or [p for p in sorted(SCENES.glob("*.xml")) if "<sensor" in p.read_text()]
    for path in scenes:
        images = batches(path, arguments.batches, arguments.spp)[..., :3]
        mean = images.mean(0)
        error = images.std(0, ddof=1) / arguments.batches**0.5
        error = np.hypot(error, ROUNDING * mean)
        planes = np.concatenate([mean, error], -1).astype(np.float16)
        bitmap = mi.Bitmap(planes, mi.Bitmap.PixelFormat.MultiChannel, CHANNELS)
        out = REFERENCES / (path.stem + ".exr")
        bitmap.write(str(out))
        off = error.mean() / mean.mean()
        print(f"{path.stem}: mean {mean.mean():.5f}, standard error of a pixel {100 * off:.2f} %", flush=True)


if __name__ == "__main__":
    main()
