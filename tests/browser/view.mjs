// The viewer in a real browser: `node view.mjs PROGRAM OUT [PARTS]`. PROGRAM is the built midway; screenshots
// and saved pictures go to OUT; PARTS are some of those below, by commas. Ends with status 1 at the first
// thing that is not as it should be.

import { strict as assert } from "node:assert";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { files } from "./files.mjs";
import { others } from "./others.mjs";
import { Server, distance, headerOf, inBrowser, midway, out, scenes, step } from "./support.mjs";

const PORT = 7411;
const HEIGHT = 128;
const scene = join(scenes, "cornell-box.gltf");
const start = () => Server.start(["view", scene, "--no-open", "--port", PORT, "--height", HEIGHT, "--device", "cpu"]);
/** The radians of a drag across the picture's height, as stage.js has it. */
const ORBIT = 3.2;

const PARTS = { pictures, steers, keyboard, files, looks, others };
const wanted = process.argv[4]?.split(",") ?? Object.keys(PARTS);

let server = await start();
try {
  await inBrowser(async (viewer) => {
    await viewer.page.goto(server.url);
    for (const part of wanted) await PARTS[part](viewer);
  });
} finally {
  await server.kill();
}

async function pictures(viewer) {
  const { page } = viewer;
  await step("the page shows a picture that is not black", async () => {
    await viewer.wait(() => Number(document.body.dataset.frame) > 0);
    await viewer.isNotBlack();
    assert.match(await page.textContent("#scene-name"), /cornell-box\.gltf/);
  });

  await step("it converges", async () => {
    await viewer.moreThan(40);
    await viewer.anew(() => page.click("#restart"));
    await viewer.moreThan(0);
    const [early, first] = await viewer.still();
    await viewer.moreThan(4 * early);
    const [, later] = await viewer.still();
    await viewer.moreThan(16 * early);
    const [, last] = await viewer.still();
    const [before, after] = [distance(first, last), distance(later, last)];
    assert.ok(after < 0.8 * before, `${before} to ${after}`);
    await viewer.shot("converged");
  });

  await step("what is saved has the bits of midway render", async () => {
    await viewer.anew(() => page.click("#restart"));
    await viewer.moreThan(15);
    const saved = await viewer.save(() => page.click("#save-exr"), "saved.exr");
    assert.equal(saved.suggested, "cornell-box.exr");
    const { samples } = headerOf(saved.path);
    assert.ok(samples > 15, `${samples} samples`);
    const rendered = join(out, "rendered.exr");
    const render = (seed) => midway("render", scene, "--integrator", "path", "--height", HEIGHT, "--spp", samples,
      "--seed", seed, "--device", "cpu", "--quiet", "-o", rendered);
    const apart = () => JSON.parse(midway("compare", saved.path, rendered, "--json")).rmse;
    render(1);
    assert.ok(apart() > 0, "another seed is another picture");
    render(0);
    assert.equal(apart(), 0);
  });
}

async function steers(viewer) {
  const { page } = viewer;
  await step("it orbits by mouse and by keys", async () => {
    // Between two pictures of one view is their noise alone.
    const look = async (name) => {
      await viewer.moreThan(30);
      await viewer.pause();
      const picture = await viewer.picture();
      const { rows } = headerOf((await viewer.save(() => page.click("#save-exr"), name)).path);
      await viewer.goOn();
      return { picture, rows };
    };
    const box = await (await page.$("#picture")).boundingBox();
    const [dx, dy] = [0.1 * box.height, -0.05 * box.height];
    const drag = (sign) => viewer.anew(async () => {
      await page.mouse.move(box.x + 300, box.y + 300);
      await page.mouse.down();
      await page.mouse.move(box.x + 300 + sign * dx, box.y + 300 + sign * dy, { steps: 12 });
      await page.mouse.up();
    });
    const before = await look("before.exr");
    await drag(1);
    assert.equal(await page.evaluate(() => document.getElementById("cameras").selectedIndex), -1);
    await viewer.shot("moving");
    const turned = await look("turned.exr");
    // The matrix has the camera's axes in its columns: backwards is the third.
    const back = ({ rows }) => [rows[0][2], rows[1][2], rows[2][2]];
    const yaw = ({ rows }) => Math.atan2(rows[0][2], rows[2][2]);
    const pitch = (view) => Math.asin(back(view)[1]);
    const apart = (a, b) => Math.abs(Math.atan2(Math.sin(a - b), Math.cos(a - b)));
    assert.ok(apart(yaw(turned) - yaw(before), -0.1 * ORBIT) < 0.01, `${yaw(before)} to ${yaw(turned)}`);
    assert.ok(apart(pitch(turned) - pitch(before), -0.05 * ORBIT) < 0.01, `${pitch(before)} to ${pitch(turned)}`);
    await drag(-1);
    const again = await look("again.exr");
    const [noise, moved] = [distance(before.picture, again.picture), distance(before.picture, turned.picture)];
    assert.ok(moved > 4 * noise, `${moved} by the orbit, ${noise} between two pictures of one view`);
    await page.focus("#picture");
    await viewer.anew(async () => {
      for (let i = 0; i < 4; i++) await page.keyboard.press("ArrowLeft");
    });
    const byKeys = await look("keys.exr");
    assert.ok(apart(yaw(byKeys) - yaw(again), -4 * 0.08) < 0.01, `${yaw(again)} to ${yaw(byKeys)}`);
    await page.keyboard.press("+");
    await page.keyboard.press("f");
    await viewer.moreThan(4);
    await page.selectOption("#cameras", "0");
  });

  await step("integrator and K change", async () => {
    await page.focus("#picture");
    await page.keyboard.press("4");
    await viewer.says("f-integrator", "join=full");
    await page.keyboard.press("5");
    await viewer.says("f-integrator", "k=3");
    await page.fill("#k", "6");
    await viewer.says("f-integrator", "k=6");
    await viewer.isNotBlack();
    await viewer.says("f-noise", "%");
    await page.waitForTimeout(1500);
    await viewer.shot("bdpt");
    await viewer.says("plot-note", "relMSE");
    await page.locator("#plot-note").scrollIntoViewIfNeeded();
    await viewer.shot("plot");
  });

  await step("exposure, tone map and layer change", async () => {
    await viewer.moreThan(30);
    await page.selectOption("#tone", "linear");
    await viewer.pause();
    const before = await viewer.picture();
    await page.focus("#picture");
    await viewer.another(async () => {
      for (let i = 0; i < 2; i++) await page.keyboard.press("]");
    });
    assert.equal(Number(await page.inputValue("#exposure")), 1);
    await viewer.rest();
    const after = await viewer.picture();
    // A stop doubles the light; by the linear tone map that is what sRGB says, where neither end is cut.
    const light = (byte) => (byte <= 10 ? byte / 3294.6 : ((byte / 255 + 0.055) / 1.055) ** 2.4);
    const ratios = [...before.bytes.keys()].filter((i) => i % 4 < 3 && before.bytes[i] > 60 && before.bytes[i] < 160)
      .map((i) => light(after.bytes[i]) / light(before.bytes[i])).sort((a, b) => a - b);
    assert.ok(ratios.length > 1000, `${ratios.length} bytes`);
    const median = ratios[ratios.length >> 1];
    assert.ok(Math.abs(median - 2) < 0.05, `a stop is a factor of ${median}`);
    await viewer.another(async () => {
      for (let i = 0; i < 2; i++) await page.keyboard.press("[");
      await page.keyboard.press("t");
    });
    await viewer.wait(() => document.getElementById("tone").value === "agx");
    await viewer.rest();
    assert.ok(distance(before, await viewer.picture()) > 5, "AgX is another picture");
    await viewer.goOn();
    await page.focus("#picture");
    await page.keyboard.press("Tab");
    await page.keyboard.press("Tab");
    await viewer.wait(() => document.getElementById("layer").value === "normal");
    await page.waitForTimeout(1000);
    await viewer.shot("normals");
    await viewer.anew(() => page.selectOption("#layer", "beauty"));
    await page.waitForTimeout(1300); // what the server says of controls counts again
    assert.equal(await page.inputValue("#layer"), "beauty");
    assert.equal(Number(await page.inputValue("#exposure")), 0);
  });

  await step("what is decoded late replaces nothing newer", async () => {
    await viewer.pause();
    const frame = () => page.evaluate(() => Number(document.body.dataset.frame));
    const before = await frame();
    await page.evaluate(() => {
      const decode = window.createImageBitmap;
      window.createImageBitmap = (jpeg) => {
        window.createImageBitmap = decode; // this one alone is late
        window.held = new Promise((go) => { window.letGo = go; }).then(() => decode(jpeg));
        return window.held;
      };
    });
    await page.focus("#picture");
    await page.keyboard.press("]");
    await viewer.wait(() => "letGo" in window);
    await page.keyboard.press("[");
    await viewer.wait((before) => Number(document.body.dataset.frame) > before, before);
    const newest = await frame();
    await page.evaluate(async () => {
      window.letGo();
      await window.held;
      await new Promise((done) => setTimeout(done, 100));
    });
    assert.equal(await frame(), newest);
    await viewer.goOn();
  });

  await step("lights are mixed without rendering anew", async () => {
    const dim = (stops) => page.locator("#light-0").evaluate((slider, value) => {
      slider.value = value;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }, stops);
    const bright = (await viewer.seen()).mean;
    await viewer.anew(() => dim(-2));
    await viewer.moreThan(8);
    await viewer.sees(({ mean }) => mean < 0.7 * bright, `two stops down, ${bright} before`);
    const [before, forgotten] = [await viewer.samples(), await viewer.forgotten()];
    await dim(1);
    await viewer.sees(({ mean }) => mean > 1.1 * bright, `a stop up, ${bright} before`);
    await viewer.moreThan(before);
    assert.equal(await viewer.forgotten(), forgotten, "the samples were forgotten");
    await page.locator("#lights").scrollIntoViewIfNeeded();
    await viewer.shot("lights");
    await page.click("#reset-lights");
    assert.equal(await page.inputValue("#light-0"), "0");
    await viewer.sees(({ mean }) => Math.abs(mean / bright - 1) < 0.1, `${bright} before`);
  });

  await step("two integrators stand side by side", async () => {
    await page.selectOption("#method", "1");
    await page.selectOption("#compare", "3");
    await viewer.wait(() => !document.getElementById("divider").hidden && !document.getElementById("right-name").hidden);
    await page.fill("#divider", "35");
    await page.waitForTimeout(2500);
    await viewer.shot("split");
    await page.selectOption("#compare", "");
    await viewer.wait(() => document.getElementById("right-name").hidden);
  });

  await step("pause holds the picture", async () => {
    await viewer.pause();
    const held = await viewer.samples();
    await page.waitForTimeout(600);
    assert.equal(await viewer.samples(), held);
    await viewer.goOn();
    await viewer.moreThan(held);
    // What is begun anew while it is paused has a first picture.
    await viewer.pause();
    const samples = await viewer.samples();
    await viewer.another(() => page.click("#restart"));
    await viewer.rest();
    await viewer.isNotBlack();
    const anew = await viewer.samples();
    assert.ok(anew > 0 && anew < samples, `${anew} after ${samples}`);
    await viewer.goOn();
    await viewer.moreThan(anew);
  });

  await step("a page that comes anew has the camera as it was turned", async () => {
    const eye = async () => headerOf((await viewer.save(() => page.click("#save-exr"), "eye.exr")).path).rows.map((row) => row[3]);
    const scene = await eye();
    await page.focus("#picture");
    for (let i = 0; i < 5; i++) await page.keyboard.press("ArrowLeft");
    await page.waitForTimeout(600); // it rests
    const turned = await eye();
    assert.ok(Math.hypot(...turned.map((value, i) => value - scene[i])) > 0.1, `${scene} to ${turned}`);
    await page.reload();
    await viewer.says("scene-name", "cornell-box");
    await viewer.moreThan(2);
    await page.focus("#picture");
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("ArrowRight");
    await page.waitForTimeout(600);
    const again = await eye();
    assert.ok(Math.hypot(...again.map((value, i) => value - turned[i])) < 1e-3, `${turned} to ${again}`);
    await viewer.anew(() => page.selectOption("#cameras", "0"));
  });

  await step("a black picture says why", async () => {
    await page.selectOption("#tone", "aces"); // by AgX the lamp can still be seen
    await page.fill("#exposure", "-12");
    await viewer.says("black", "exposure is too low");
    await viewer.shot("black");
    await page.fill("#exposure", "0");
    await page.selectOption("#tone", "agx");
    await viewer.wait(() => document.getElementById("black").hidden);
  });
}

async function keyboard(viewer) {
  const { page } = viewer;
  const press = async (...keys) => { for (const key of keys) await page.keyboard.press(key); };
  const focused = () => page.evaluate(() => document.activeElement.id);

  await step("regions and places are chosen by keys alone", async () => {
    await page.focus("#picture");
    await press("c", "ArrowLeft", "ArrowLeft", "ArrowUp", "Enter");
    for (let i = 0; i < 10; i++) await press("ArrowRight", "ArrowDown");
    await viewer.shot("region");
    await viewer.isAccessible("a region by keys");
    await press("Enter");
    await viewer.wait(() => document.getElementById("region").getAttribute("aria-pressed") === "true");
    // Two steps of a fortieth left of the middle, one above; ten right and down from there.
    const { window } = headerOf((await viewer.save(() => page.click("#save-exr"), "region.exr")).path);
    const [left, top, right, bottom] = [0.45, 0.475, 0.7, 0.725].map((v) => v * HEIGHT).map(Math.floor);
    assert.deepEqual(window, [left, top, right, bottom]);
    await press("c");
    await viewer.wait(() => document.getElementById("region").getAttribute("aria-pressed") === "false");
    const before = await page.evaluate(() => document.body.dataset.input);
    await press("x", "Shift+ArrowUp", "ArrowLeft", "Enter");
    await viewer.wait((last) => document.body.dataset.input !== last, before);
    await press("x");
    assert.ok(await page.isVisible("#cross"));
    await press("Escape");
    assert.ok(!await page.isVisible("#cross") && await focused() === "picture");
    await page.selectOption("#cameras", "0");
  });

  await step("keys go on where a control has the focus, and Escape leads back", async () => {
    const exposure = async () => Number(await page.inputValue("#exposure"));
    await page.focus("#tone");
    await press("]");
    assert.equal(await exposure(), 0.5);
    await press("[");
    assert.equal(await page.inputValue("#tone"), "agx");
    const input = await page.evaluate(() => Number(document.body.dataset.input));
    await page.focus("#restart");
    await page.keyboard.down("d");
    await viewer.wait((last) => Number(document.body.dataset.input) > last, input);
    await page.keyboard.up("d");
    await press("Escape");
    assert.equal(await focused(), "picture");
    await press("Escape");
    assert.equal(await focused(), "pause");
    await page.evaluate(() => document.activeElement.blur());
    const turned = await page.evaluate(() => Number(document.body.dataset.input));
    await press("ArrowRight");
    await viewer.wait((last) => Number(document.body.dataset.input) > last, turned);
    await page.selectOption("#cameras", "0");
  });

  await step("signs act in the picture alone where that is chosen", async () => {
    const chosen = () => page.$$eval("#method, #exposure, #cameras", (all) => all.map((one) => one.value));
    await page.focus("#picture");
    await press("?");
    await page.check("#keys-alone");
    await viewer.isAccessible("the choice of keys");
    await press("Escape");
    await page.reload();
    await viewer.moreThan(2);
    await viewer.says("scene-name", "cornell-box");
    const before = await chosen();
    await page.focus("#pause");
    await press("4", "f", "[");
    assert.deepEqual(await chosen(), before);
    await press("Escape", "4");
    await viewer.says("f-integrator", "join=full");
    await press("?");
    await page.uncheck("#keys-alone");
    await press("Escape");
    await page.focus("#pause");
    await press("2");
    await viewer.wait(() => document.getElementById("f-integrator").textContent.startsWith("path "));
  });

  await step("cameras are saved and deleted by keys", async () => {
    const names = () => page.$$eval("#saved option", (options) => options.map((one) => one.textContent));
    assert.deepEqual(await names(), ["none"]);
    await page.focus("#save-camera");
    await press("Enter", "Enter", "Enter");
    assert.deepEqual(await names(), ["choose", "view 1", "view 2", "view 3"]);
    await page.selectOption("#saved", "1");
    await page.focus("#delete-camera");
    await press("Enter");
    assert.deepEqual(await names(), ["choose", "view 1", "view 3"]);
    assert.ok(await page.isDisabled("#delete-camera") && await focused() === "saved");
    await page.selectOption("#saved", "0");
    await page.focus("#saved");
    await press("Delete");
    await page.focus("#save-camera");
    await press("Enter");
    assert.deepEqual(await names(), ["choose", "view 3", "view 4"]);
    await page.reload();
    await viewer.moreThan(2);
    await viewer.says("saved", "view 4");
    assert.deepEqual(await names(), ["choose", "view 3", "view 4"]);
  });

  await step("a PNG is saved as it is shown", async () => {
    const png = async (name) => readFileSync((await viewer.save(() => page.click("#save-png"), name)).path);
    await viewer.anew(() => page.selectOption("#layer", "normal"));
    await viewer.moreThan(2);
    await viewer.pause();
    const shown = await viewer.picture();
    const saved = await page.evaluate(async (bytes) => {
      const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))]));
      const canvas = new OffscreenCanvas(1, 1);
      canvas.getContext("2d").drawImage(bitmap, -bitmap.width / 2, -bitmap.height / 2);
      return Array.from(canvas.getContext("2d").getImageData(0, 0, 1, 1).data);
    }, (await png("normals-saved.png")).toString("base64"));
    const at = 4 * ((shown.height >> 1) * shown.width + (shown.width >> 1));
    // JPEG on the page, eight bits in the file.
    saved.forEach((byte, i) => assert.ok(Math.abs(byte - shown.bytes[at + i]) <= 6, `${saved} in the file`));
    await viewer.goOn();
    await page.selectOption("#layer", "beauty");
  });
}

async function looks(viewer) {
  const { page } = viewer;
  await step("it comes back when the server does", async () => {
    viewer.expectsOffline = true;
    await server.kill();
    await viewer.wait(() => document.body.classList.contains("offline"));
    await viewer.says("offline", "trying again");
    await viewer.shot("offline");
    server = await start();
    await viewer.wait(() => !document.body.classList.contains("offline"));
    await viewer.says("scene-name", "cornell-box");
    await viewer.moreThan(2);
    viewer.expectsOffline = false;
  });

  await step("axe finds nothing, dark, light, small, and in the help", async () => {
    await viewer.isAccessible("dark");
    await page.emulateMedia({ colorScheme: "light" });
    await viewer.isAccessible("light");
    await page.waitForTimeout(500);
    await viewer.shot("light");
    await page.setViewportSize({ width: 390, height: 780 });
    await viewer.isAccessible("phone");
    await page.waitForTimeout(500);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), "it scrolls sideways");
    await viewer.shot("phone");
    await page.focus("#picture");
    await page.keyboard.press("?");
    await page.waitForSelector("#help[open]");
    await viewer.shot("phone-help");
    await page.keyboard.press("Escape");
    await page.setViewportSize({ width: 1180, height: 760 });
    await page.emulateMedia({ colorScheme: "dark" });
    await page.keyboard.press("?");
    await page.waitForSelector("#help[open]");
    await viewer.isAccessible("help");
    await viewer.shot("help");
    await page.keyboard.press("Escape");
  });
}
