// Files that come to the page: dropped, chosen, or refused.

import { strict as assert } from "node:assert";
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { out, scenes, step } from "./support.mjs";

/** A scene of a triangle that glows red, or blue in a variant, as files to be uploaded. */
function withVariants() {
  const positions = Buffer.from(new Float32Array([-9, -9, -2, 9, -9, -2, 0, 9, -2]).buffer);
  const document = {
    asset: { version: "2.0" },
    extensionsUsed: ["KHR_materials_variants"],
    extensions: { KHR_materials_variants: { variants: [{ name: "Red" }, { name: "Blue" }] } },
    scenes: [{ nodes: [0, 1] }],
    nodes: [{ mesh: 0 }, { camera: 0 }],
    cameras: [{ type: "perspective", perspective: { yfov: 0.5, znear: 0.1 } }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, material: 0, extensions: { KHR_materials_variants: {
      mappings: [{ material: 0, variants: [0] }, { material: 1, variants: [1] }] } } }] }],
    materials: [{ emissiveFactor: [0.5, 0, 0] }, { emissiveFactor: [0, 0, 0.5] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3" }],
    bufferViews: [{ buffer: 0, byteLength: positions.length }],
    buffers: [{ byteLength: positions.length, uri: "lamps.bin" }],
  };
  const file = (name, buffer) => ({ name, mimeType: "application/octet-stream", buffer });
  return [file("lamps.gltf", Buffer.from(JSON.stringify(document))), file("lamps.bin", positions)];
}

/** A sky of one colour in RGBE, by rows that are not compressed. */
const SKY = Buffer.concat([
  Buffer.from("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n"),
  Buffer.from(Array(32).fill([64, 128, 192, 129]).flat()),
]);

export async function files(viewer) {
  const { page } = viewer;
  await step("a folder, a sky and other files are dropped on it", async () => {
    const folder = join(out, "my lamp");
    mkdirSync(join(folder, "notes"), { recursive: true });
    // The scene's file refers to what lies beside its folder, but within what is dropped.
    for (const part of ["scenes", "parts"]) mkdirSync(join(folder, part), { recursive: true });
    const scene = readFileSync(join(scenes, "lamp.gltf"), "utf8");
    assert.ok(scene.includes('"lamp.bin"'));
    writeFileSync(join(folder, "scenes", "lamp.gltf"), scene.replace('"lamp.bin"', '"../parts/lamp.bin"'));
    copyFileSync(join(scenes, "lamp.bin"), join(folder, "parts", "lamp.bin"));
    writeFileSync(join(folder, "notes", "read me.txt"), "not a scene");
    await viewer.anew(() => viewer.drop(folder));
    await viewer.says("scene-name", "lamp.gltf");
    await viewer.moreThan(4);
    await viewer.isNotBlack();
    await viewer.shot("lamp");
    await viewer.pause();
    const dark = (await viewer.seen()).mean;
    await viewer.goOn();
    writeFileSync(join(out, "sky.hdr"), SKY);
    await viewer.drop(join(out, "sky.hdr"));
    await viewer.wait(() => document.getElementById("env-strength").value === "1");
    await viewer.moreThan(4);
    await viewer.sees(({ mean }) => mean > 1.1 * dark, `under a sky, ${dark} without`);
    // What another page drags here has no files of this machine's.
    const data = await page.evaluateHandle(() => {
      const dropped = new DataTransfer();
      dropped.items.add(new File(["no scene"], "notes.txt"));
      return dropped;
    });
    await page.dispatchEvent("body", "drop", { dataTransfer: data });
    await viewer.says("notice", "Nothing in there is a scene");
    rmSync(folder, { recursive: true });
  });

  await step("a variant of materials is chosen by keys", async () => {
    const hidden = () => page.evaluate(() => document.getElementById("materials").hidden);
    assert.ok(await hidden(), "a scene without variants offers some");
    await page.setInputFiles("#file", withVariants());
    await viewer.says("scene-name", "lamps.gltf");
    assert.ok(!await hidden(), "a scene with variants offers none");
    const names = await page.$$eval("#variant option", (options) => options.map((one) => one.textContent));
    assert.deepEqual(names, ["default", "Red", "Blue"]);
    const shows = (wanted) => viewer.wait((channel) => {
      const canvas = document.getElementById("picture");
      const [red, , blue] = canvas.getContext("2d").getImageData(canvas.width / 2, canvas.height / 2, 1, 1).data;
      return channel === "red" ? red > 2 * blue : blue > 2 * red;
    }, wanted);
    await shows("red");
    await page.focus("#variant");
    await page.keyboard.press("End");
    await shows("blue");
    assert.equal(await page.inputValue("#variant"), "1");
    await viewer.shot("variants");
    await page.keyboard.press("Home");
    await shows("red");
    assert.equal(await page.inputValue("#variant"), "");
    await viewer.isAccessible("variants");
  });
}
