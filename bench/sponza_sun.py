#!/usr/bin/env python3
"""Sponza by one directional light, untextured (tables 4 and 5), by other renderers.

usage: sponza_sun.py export --scene sponza-sun.gltf --out FOLDER
       sponza_sun.py mitsuba|luxcore --scene sponza-sun.gltf --seconds S --seed N --out OUT
                     [--variant cuda_ad_rgb] [--engine BIDIRCPU] [--size 768x512] [--threads N]

`export` writes FOLDER/sponza-sun.xml, which Midway renders; the others render, print a JSON line and write
OUT.exr. Needs numpy, OpenEXR and mitsuba or pyluxcore. The scene's surfaces are all of one diffuse grey, so
that they are one mesh; its normals are left out, since no two renderers shade smooth ones alike. Seconds are
of the clock from when the renderer has all it needs: Mitsuba's kernels are compiled by a first pass that
does not count. LuxCore's roulette is off: with it, its bidirectional engine is biased. Two runs with
different seeds and `xtask half A.exr B.exr` give the expected error.
"""
import argparse
import json
import math
import os
import pathlib
import tempfile
import time

import numpy as np

# Samples of a pixel in one of Mitsuba's passes.
PASS_SAMPLES = 16
# Edges of LuxCore's paths at most: with its roulette off, light paths end by it.
LUXCORE_DEPTH = 16
DTYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC3": 3}


class Scene:
    """A glTF file of one node with meshes, one directional light and one camera, each placed by a node."""

    def __init__(self, path):
        self.file = json.loads(path.read_text(encoding="utf-8"))
        self.buffer = (path.parent / self.file["buffers"][0]["uri"]).read_bytes()
        nodes = {key: node for node in self.file["nodes"] for key in ("mesh", "camera") if key in node}
        sun_node = next(node for node in self.file["nodes"] if "KHR_lights_punctual" in node.get("extensions", {}))
        sun = self.file["extensions"]["KHR_lights_punctual"]["lights"][0]
        self.albedo = self.file["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][0]
        self.irradiance = [c * sun["intensity"] for c in sun["color"]]
        self.sun_direction = -axis(sun_node, 2)
        self.eye = axis(nodes["camera"], 3)
        self.target = self.eye - axis(nodes["camera"], 2)
        self.up = axis(nodes["camera"], 1)
        self.fov = math.degrees(self.file["cameras"][0]["perspective"]["yfov"])
        self.mesh = self.file["meshes"][nodes["mesh"]["mesh"]]
        self.scale = np.float32(nodes["mesh"]["scale"][0])

    def accessor(self, index):
        accessor = self.file["accessors"][index]
        view = self.file["bufferViews"][accessor["bufferView"]]
        width = WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        data = np.frombuffer(self.buffer, DTYPES[accessor["componentType"]], accessor["count"] * width, start)
        return data.reshape(-1, width)

    def write_ply(self, path):
        vertices, faces, first = [], [], 0
        for primitive in self.mesh["primitives"]:
            position = self.accessor(primitive["attributes"]["POSITION"]) * self.scale
            vertices.append(position)
            faces.append(self.accessor(primitive["indices"]).reshape(-1, 3).astype(np.int32) + first)
            first += len(position)
        vertices, faces = np.vstack(vertices), np.vstack(faces)
        rows = np.empty(len(faces), [("n", "u1"), ("at", "<i4", 3)])
        rows["n"], rows["at"] = 3, faces
        names = "".join(f"property float {name}\n" for name in "xyz")
        header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n{names}"
                  f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        path.write_bytes(header.encode() + vertices.astype("<f4").tobytes() + rows.tobytes())


def words(values):
    return ", ".join(repr(float(v)) for v in values)


def export(args, scene):
    """As a Mitsuba scene, which Midway reads."""
    folder = pathlib.Path(args.out)
    folder.mkdir(parents=True, exist_ok=True)
    scene.write_ply(folder / "court.ply")
    (folder / "sponza-sun.xml").write_text(f"""<scene version="3.0.0">
  <sensor type="perspective">
    <float name="fov" value="{scene.fov}"/>
    <string name="fov_axis" value="y"/>
    <transform name="to_world">
      <lookat origin="{words(scene.eye)}" target="{words(scene.target)}" up="{words(scene.up)}"/>
    </transform>
    <film type="hdrfilm">
      <integer name="width" value="{args.size[0]}"/>
      <integer name="height" value="{args.size[1]}"/>
      <rfilter type="box"/>
    </film>
  </sensor>
  <emitter type="directional">
    <vector name="direction" value="{words(scene.sun_direction)}"/>
    <rgb name="irradiance" value="{words(scene.irradiance)}"/>
  </emitter>
  <shape type="ply">
    <string name="filename" value="court.ply"/>
    <boolean name="face_normals" value="true"/>
    <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="{scene.albedo}"/></bsdf></bsdf>
  </shape>
</scene>
""", encoding="utf-8")


def axis(node, column):
    return np.array(node["matrix"][4 * column:4 * column + 3], np.float32)


def floats(values):
    return [float(v) for v in values]


def mitsuba(args, scene, ply):
    import mitsuba as mi
    mi.set_variant(args.variant)
    width, height = args.size
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb",
            "component_format": "float32", "rfilter": {"type": "box"}}
    view = mi.ScalarTransform4f().look_at(origin=floats(scene.eye), target=floats(scene.target), up=floats(scene.up))
    grey = {"type": "rgb", "value": scene.albedo}
    loaded = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": -1, "rr_depth": 5},
        "sensor": {"type": "perspective", "fov": scene.fov, "fov_axis": "y", "near_clip": 0.01, "far_clip": 1e4,
                   "to_world": view, "film": film, "sampler": {"type": "independent"}},
        "sun": {"type": "directional", "direction": floats(scene.sun_direction),
                "irradiance": {"type": "rgb", "value": scene.irradiance}},
        "court": {"type": "ply", "filename": str(ply), "face_normals": True,
                  "bsdf": {"type": "twosided", "inside": {"type": "diffuse", "reflectance": grey}}},
    })

    def render_pass(number):
        return np.array(mi.render(loaded, spp=PASS_SAMPLES, seed=args.seed * 100_003 + number), np.float64)

    render_pass(0)
    total, passes, start = 0.0, 0, time.perf_counter()
    while time.perf_counter() - start < args.seconds:
        passes += 1
        total = total + render_pass(passes)
    return total / passes, passes * PASS_SAMPLES, time.perf_counter() - start


def luxcore(args, scene, ply):
    import pyluxcore

    def properties(values):
        props = pyluxcore.Properties()
        for key, value in values.items():
            props.Set(pyluxcore.Property(key, value))
        return props

    pyluxcore.Init(lambda _message: None)
    width, height = args.size
    aspect = width / height
    # LuxCore's picture sits one pixel too low.
    pixel = 2 / height
    loaded = pyluxcore.Scene()
    loaded.Parse(properties({
        "scene.camera.type": "perspective", "scene.camera.lookat.orig": floats(scene.eye),
        "scene.camera.lookat.target": floats(scene.target), "scene.camera.up": floats(scene.up),
        "scene.camera.fieldofview": scene.fov, "scene.camera.autofocus.enable": False,
        "scene.camera.cliphither": 0.01, "scene.camera.clipyon": 1e4,
        "scene.camera.screenwindow": [-aspect, aspect, -1 - pixel, 1 - pixel],
        "scene.lights.sun.type": "sharpdistant", "scene.lights.sun.direction": floats(scene.sun_direction),
        "scene.lights.sun.color": floats(scene.irradiance), "scene.lights.sun.gain": [1.0] * 3,
        "scene.materials.grey.type": "matte", "scene.materials.grey.kd": [scene.albedo] * 3,
        "scene.objects.court.ply": str(ply), "scene.objects.court.material": "grey",
    }))
    config = pyluxcore.RenderConfig(properties({
        "renderengine.type": args.engine, "renderengine.seed": args.seed, "sampler.type": "SOBOL",
        "sampler.sobol.adaptive.strength": 0.0, "film.width": width, "film.height": height,
        "film.filter.type": "NONE", "film.imagepipelines.0.0.type": "NOP", "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": "x.exr", "native.threads.count": args.threads, "film.noiseestimation.step": 0,
        "path.maxdepth": LUXCORE_DEPTH, "light.maxdepth": LUXCORE_DEPTH, "path.pathdepth.total": LUXCORE_DEPTH,
        "path.pathdepth.diffuse": LUXCORE_DEPTH, "path.russianroulette.depth": 1000,
        "path.clamping.variance.maxvalue": 0.0, "lightstrategy.type": "POWER",
    }), loaded)
    session = pyluxcore.RenderSession(config)

    def count():
        session.UpdateStats()
        return session.GetStats().Get("stats.renderengine.total.samplecount").GetFloat()

    session.Start()
    while count() == 0:
        time.sleep(0.02)
    start = time.perf_counter()
    time.sleep(args.seconds)
    session.Pause()
    seconds, samples = time.perf_counter() - start, count()
    film = session.GetFilm()
    pixels = np.empty(film.GetOutputSize(pyluxcore.FilmOutputType.RGB), np.float32)
    film.GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels, 0, True)
    session.Stop()
    return pixels.reshape(height, width, 3)[::-1], samples / (width * height), seconds


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("renderer", choices=["export", "mitsuba", "luxcore"])
    parser.add_argument("--scene", type=pathlib.Path, required=True)
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", required=True)
    parser.add_argument("--variant", default="cuda_ad_rgb")
    parser.add_argument("--engine", default="BIDIRCPU")
    parser.add_argument("--size", type=lambda text: tuple(map(int, text.split("x"))), default=(768, 512))
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    args = parser.parse_args()
    scene = Scene(args.scene)
    if args.renderer == "export":
        export(args, scene)
        return
    import OpenEXR  # before pyluxcore, which crashes otherwise
    with tempfile.TemporaryDirectory() as folder:
        ply = pathlib.Path(folder) / "court.ply"
        scene.write_ply(ply)
        image, samples, seconds = {"mitsuba": mitsuba, "luxcore": luxcore}[args.renderer](args, scene, ply)
    image = np.ascontiguousarray(image, np.float32)
    with OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": image}) as file:
        file.write(args.out + ".exr")
    engine = args.variant if args.renderer == "mitsuba" else args.engine
    print(json.dumps({"renderer": f"{args.renderer} {engine}", "samples": round(samples, 2), "seconds": round(seconds, 2),
                      "mean": [round(float(v), 5) for v in image.mean((0, 1))]}), flush=True)


main()
