"""Rays a second of Embree, one ray at a time on one thread, beside `midway bench rays`.

    pip install numpy embreex
    python3 bench/embree_rays.py MIDWAY [TRIANGLES [RAYS]]

Writes bumpy balls to a file, has Midway and Embree trace rays from anywhere in their bounds in any
direction through them in turn, three times each, and prints millions of rays per second of CPU time.
Midway's rays and Embree's are different draws of the same distribution. Embree's closest hits include
what the binding takes to hand rays over one by one: an upper bound of that is its time for rays that miss
everything, which is printed too.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

ROWS = 16


def balls(n_triangles, rng):
    """Vertices and triangles: a jittered lattice of bumpy balls of 1024 triangles."""
    n_balls = max(1, -(-n_triangles // (4 * ROWS * ROWS)))
    side = int(np.ceil(n_balls ** (1 / 3)))
    row, column = np.meshgrid(np.arange(ROWS + 1), np.arange(2 * ROWS), indexing="ij")
    theta, phi = np.pi * row / ROWS, 2 * np.pi * column / (2 * ROWS)
    unit = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    r, c = np.meshgrid(np.arange(ROWS), np.arange(2 * ROWS), indexing="ij")
    at = lambda r, c: (r * 2 * ROWS + c % (2 * ROWS)).ravel()
    a, b, lower, d = at(r, c), at(r, c + 1), at(r + 1, c), at(r + 1, c + 1)
    faces = np.concatenate([np.stack([a, b, d], -1), np.stack([a, d, lower], -1)])
    vertices, triangles = [], []
    for ball in range(n_balls):
        place = np.array([ball % side, ball // side % side, ball // side // side]) + 0.4 * rng.random(3)
        bumps = 0.9 + 0.2 * rng.random((len(unit), 1))
        vertices.append(place + (0.15 + 0.2 * rng.random()) * bumps * unit)
        triangles.append(faces + ball * len(unit))
    return np.concatenate(vertices).astype(np.float32), np.concatenate(triangles).astype(np.int32)


def random_rays(low, high, n, rng):
    directions = rng.normal(size=(n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return (low + rng.random((n, 3)) * (high - low)).astype(np.float32), directions.astype(np.float32)


def embree(scene, origins, directions, query):
    start = time.process_time()
    hits = scene.run(origins, directions, query=query)
    return len(origins) / (time.process_time() - start) * 1e-6, float(np.mean(np.asarray(hits) >= 0))


def midway(program, obj, n_rays, question):
    command = [program, "bench", "rays", str(obj), "--device", "cpu", "--threads", "1", "--rays", str(n_rays),
               "--json", "--only", f"wide,plain,random,{question}"]
    result = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return result["rows"][0]["mrays_per_cpu_second"], result["rows"][0]["hit_share"]


def main():
    program = sys.argv[1]
    n_triangles, n_rays = (int(x) for x in (sys.argv[2:] + ["1030000", "262144"][len(sys.argv) - 2 :])[:2])
    rng = np.random.default_rng(1)
    vertices, triangles = balls(n_triangles, rng)
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, vertices, triangles)
    low, high = vertices.min(0), vertices.max(0)
    origins, directions = random_rays(low, high, n_rays, rng)
    embree(scene, origins[:1000], directions[:1000], "INTERSECT")
    with tempfile.TemporaryDirectory() as folder:
        obj = Path(folder) / "balls.obj"
        lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in triangles + 1]
        obj.write_text("\n".join(lines) + "\n")
        for _ in range(3):
            for question, query in [("closest", "INTERSECT"), ("any", "OCCLUDED")]:
                theirs, theirs_hit = embree(scene, origins, directions, query)
                ours, ours_hit = midway(program, obj, n_rays, question)
                print(f"{question:8} Embree {theirs:.3f} ({theirs_hit:.1%} hit)  Midway {ours:.3f} ({ours_hit:.1%} hit)"
                      f"  ratio {ours / theirs:.2f}")
    away, _ = embree(scene, origins + 10 * (high - low), np.abs(directions), "INTERSECT")
    print(f"rays that miss everything: Embree {away:.3f}")


if __name__ == "__main__":
    main()
