// The viewer in a real browser: `node view.mjs PROGRAM OUT`. PROGRAM is the built midway; screenshots
// and the saved picture go to OUT. Ends with status 1 at the first thing that is not as it should be.

import { strict as assert } from "node:assert";
import { execFileSync, spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { createRequire } from "node:module";
import { chromium } from "playwright-core";

const [program, out] = process.argv.slice(2).map((path) => resolve(path));
const scenes = resolve(import.meta.dirname, "../../scenes");
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const PORT = 7411;
const SLOW = 60_000;

mkdirSync(out, { recursive: true });
const profile = mkdtempSync(join(tmpdir(), "midway-browser-"));
let passed = 0;
let server;

/** Starts the viewer and waits for the line that says where it is. */
async function start() {
  const line = ["view", join(scenes, "cornell-box.gltf"), "--no-open", "--port", PORT, "--height", 128, "--device", "cpu"];
  server = spawn(program, line.map(String), { stdio: ["ignore", "pipe", "inherit"] });
  const said = await new Promise((done, failed) => {
    server.stdout.once("data", (data) => done(String(data)));
    server.once("exit", (code) => failed(new Error(`the server ended with ${code}`)));
  });
  assert.match(said, /^view: http:\/\/127\.0\.0\.1:7411\//);
}

async function kill() {
  const ended = new Promise((done) => server.once("exit", done));
  server.kill("SIGKILL");
  await ended;
}

async function step(name, act) {
  const began = Date.now();
  await act();
  passed += 1;
  console.log(`ok ${passed} ${name} (${Date.now() - began} ms)`);
}

await start();
const context = await chromium.launchPersistentContext(profile, {
  executablePath: "/usr/bin/chromium",
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  viewport: { width: 1180, height: 760 },
  colorScheme: "dark",
  acceptDownloads: true,
});
context.setDefaultTimeout(SLOW);
const page = context.pages()[0] ?? await context.newPage();
const complaints = [];
let expectOffline = false;
page.on("console", (message) => {
  if (message.type() === "error" && !expectOffline) complaints.push(message.text());
});
page.on("pageerror", (error) => complaints.push(String(error)));

const figure = (id) => page.textContent(`#${id}`);
const samples = async () => Number((await figure("f-samples")).replace(/\D.*$|,/g, ""));
const wait = (condition, value) => page.waitForFunction(condition, value, { timeout: SLOW, polling: 50 });
const shot = (name) => page.screenshot({ path: join(out, `${name}.png`) });

/** Mean and spread of the picture's pixels on the canvas. */
const seen = () => page.evaluate(() => {
  const canvas = document.getElementById("picture");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let [sum, squares, n] = [0, 0, 0];
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] === 0) continue;
    const value = (data[i] + data[i + 1] + data[i + 2]) / 3;
    sum += value;
    squares += value * value;
    n += 1;
  }
  return { mean: sum / n, spread: Math.sqrt(Math.max(0, squares / n - (sum / n) ** 2)), n };
});

/** The picture's red, as it is on the canvas. */
const picture = () => page.evaluate(() => {
  const canvas = document.getElementById("picture");
  const { data, width, height } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return { width, height, red: Array.from(data.filter((_, i) => i % 4 === 0)) };
});

/** How far two pictures are apart, a pixel. */
const distance = (a, b) => {
  assert.deepEqual([a.width, a.height], [b.width, b.height]);
  return a.red.reduce((sum, value, i) => sum + Math.abs(value - b.red[i]), 0) / a.red.length;
};

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

const check = async (name) => {
  const { violations } = await page.evaluate(() => window.axe.run());
  assert.deepEqual(violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target).join(" ")}`), [], name);
};

try {
  await step("the page shows a picture that is not black", async () => {
    await page.goto(`http://127.0.0.1:${PORT}/`);
    await wait(() => Number(document.body.dataset.frame) > 0);
    const { mean, spread, n } = await seen();
    assert.ok(mean > 10 && spread > 10 && n > 10_000, JSON.stringify({ mean, spread, n }));
    assert.match(await page.textContent("#scene-name"), /cornell-box\.gltf/);
  });

  await step("it converges", async () => {
    const more = (n) => Number(document.getElementById("f-samples").textContent.replace(/,/g, "")) > n;
    await wait(more, 40);
    const long = await samples();
    await page.click("#restart");
    await wait((n) => Number(document.getElementById("f-samples").textContent.replace(/,/g, "")) < n, long);
    const [early, first] = [Math.max(await samples(), 4), await picture()];
    await wait(more, 4 * early);
    const later = await picture();
    await wait(more, 8 * early);
    const last = await picture();
    const [before, after] = [distance(first, last), distance(later, last)];
    assert.ok(after < 0.8 * before, `${before} to ${after}`);
    await shot("converged");
  });

  await step("it orbits by mouse and by keys", async () => {
    const before = await page.evaluate(() => document.getElementById("picture").toDataURL());
    const input = () => page.evaluate(() => Number(document.body.dataset.input));
    const box = await (await page.$("#picture")).boundingBox();
    await page.mouse.move(box.x + 300, box.y + 300);
    await page.mouse.down();
    for (let i = 1; i <= 12; i++) await page.mouse.move(box.x + 300 + 6 * i, box.y + 300 + 2 * i);
    await page.mouse.up();
    await wait((last) => Number(document.body.dataset.input) > last, 0);
    const dragged = await input();
    assert.equal(await page.evaluate(() => document.getElementById("cameras").selectedIndex), -1);
    await shot("moving");
    await page.focus("#picture");
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("+");
    await wait((last) => Number(document.body.dataset.input) > last, dragged);
    assert.notEqual(await page.evaluate(() => document.getElementById("picture").toDataURL()), before);
    await page.keyboard.press("f");
    await wait(() => Number(document.getElementById("f-samples").textContent) > 4);
  });

  await step("integrator and K change", async () => {
    await page.selectOption("#cameras", "0");
    await page.focus("#picture");
    await page.keyboard.press("4");
    await wait(() => document.getElementById("f-integrator").textContent.includes("join=full"));
    await page.keyboard.press("5");
    await wait(() => document.getElementById("f-integrator").textContent.includes("k=3"));
    await page.fill("#k", "6");
    await wait(() => document.getElementById("f-integrator").textContent.includes("k=6"));
    assert.ok((await seen()).mean > 10);
    await wait(() => document.getElementById("f-noise").textContent.includes("%"));
    await page.waitForTimeout(1500);
    await shot("bdpt");
    await wait(() => document.getElementById("plot-note").textContent.includes("relMSE"));
    await page.locator("#plot-note").scrollIntoViewIfNeeded();
    await shot("plot");
  });

  await step("exposure, tone map and layer change", async () => {
    const before = (await seen()).mean;
    await page.focus("#picture");
    for (let i = 0; i < 4; i++) await page.keyboard.press("]");
    await wait((mean) => {
      const canvas = document.getElementById("picture");
      const { data } = canvas.getContext("2d").getImageData(canvas.width / 2, canvas.height / 2, 1, 1);
      return data[0] + data[1] + data[2] > 1.1 * mean;
    }, before);
    await page.keyboard.press("t");
    await wait(() => document.getElementById("tone").value === "aces");
    await page.keyboard.press("Tab");
    await page.keyboard.press("Tab");
    await wait(() => document.getElementById("layer").value === "normal");
    await page.waitForTimeout(1000);
    await shot("normals");
    await page.selectOption("#layer", "beauty");
    await page.focus("#picture");
    for (let i = 0; i < 4; i++) await page.keyboard.press("[");
    await page.waitForTimeout(2000);
    assert.equal(await page.inputValue("#layer"), "beauty");
    assert.equal(Number(await page.inputValue("#exposure")), 0);
  });

  await step("lights are mixed without rendering anew", async () => {
    const dim = (stops) => page.locator("#light-0").evaluate((slider, value) => {
      slider.value = value;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }, stops);
    const bright = (await seen()).mean;
    await dim(-2);
    await wait((least) => {
      const count = Number(document.getElementById("f-samples").textContent.replace(/,/g, ""));
      return count > least;
    }, 8);
    await page.waitForTimeout(1000);
    const [mixed, before] = [(await seen()).mean, await samples()];
    assert.ok(mixed < 0.7 * bright, `${mixed} of ${bright}`);
    await dim(1);
    await page.waitForTimeout(1500);
    assert.ok((await seen()).mean > 1.1 * bright, "a stop up is brighter");
    assert.ok(await samples() > before, "the samples were forgotten");
    await page.locator("#lights").scrollIntoViewIfNeeded();
    await shot("lights");
    await page.click("#reset-lights");
    assert.equal(await page.inputValue("#light-0"), "0");
    await page.waitForTimeout(1500);
    const reset = (await seen()).mean;
    assert.ok(Math.abs(reset / bright - 1) < 0.1, `${reset} of ${bright}`);
  });

  await step("two integrators stand side by side", async () => {
    await page.selectOption("#method", "1");
    await page.selectOption("#compare", "3");
    await wait(() => !document.getElementById("divider").hidden && !document.getElementById("right-name").hidden);
    await page.fill("#divider", "35");
    await page.waitForTimeout(2500);
    await shot("split");
    await page.selectOption("#compare", "");
    await wait(() => document.getElementById("right-name").hidden);
  });

  await step("pause holds the picture", async () => {
    await page.click("#pause");
    await wait(() => document.getElementById("pause").textContent === "Go on");
    await page.waitForTimeout(600);
    const held = await samples();
    await page.waitForTimeout(600);
    assert.equal(await samples(), held);
    await page.click("#pause");
    await wait((n) => Number(document.getElementById("f-samples").textContent.replace(/,/g, "")) > n, held);
  });

  await step("an EXR is saved that midway compare accepts", async () => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save-exr")]);
    assert.equal(download.suggestedFilename(), "cornell-box.exr");
    const path = join(out, "saved.exr");
    await download.saveAs(path);
    const said = JSON.parse(execFileSync(program, ["compare", path, path, "--json"]));
    assert.equal(said.rmse, 0);
  });

  await step("a black picture says why", async () => {
    await page.fill("#exposure", "-12");
    await wait(() => /exposure is too low/.test(document.getElementById("black").textContent));
    await shot("black");
    await page.fill("#exposure", "0");
    await wait(() => document.getElementById("black").hidden);
  });

  await step("files are dropped on it", async () => {
    await page.setInputFiles("#file", [join(scenes, "lamp.gltf"), join(scenes, "lamp.bin")]);
    await wait(() => document.getElementById("scene-name").textContent.includes("lamp.gltf"));
    await wait(() => Number(document.getElementById("f-samples").textContent.replace(/,/g, "")) > 4);
    const { mean, spread } = await seen();
    assert.ok(mean > 2 && spread > 2, JSON.stringify({ mean, spread }));
    const data = await page.evaluateHandle(() => {
      const dropped = new DataTransfer();
      dropped.items.add(new File(["no scene"], "notes.txt"));
      return dropped;
    });
    await page.dispatchEvent("body", "drop", { dataTransfer: data });
    await wait(() => /scene/.test(document.getElementById("notice").textContent));
    await shot("lamp");
  });

  await step("a variant of materials is chosen by keys", async () => {
    const hidden = () => page.evaluate(() => document.getElementById("materials").hidden);
    assert.ok(await hidden(), "a scene without variants offers some");
    await page.setInputFiles("#file", withVariants());
    await wait(() => document.getElementById("scene-name").textContent.includes("lamps.gltf"));
    assert.ok(!await hidden(), "a scene with variants offers none");
    const names = await page.$$eval("#variant option", (options) => options.map((one) => one.textContent));
    assert.deepEqual(names, ["default", "Red", "Blue"]);
    const shows = (wanted) => wait((channel) => {
      const canvas = document.getElementById("picture");
      const [red, , blue] = canvas.getContext("2d").getImageData(canvas.width / 2, canvas.height / 2, 1, 1).data;
      return channel === "red" ? red > 2 * blue : blue > 2 * red;
    }, wanted);
    await shows("red");
    await page.focus("#variant");
    await page.keyboard.press("End");
    await shows("blue");
    assert.equal(await page.inputValue("#variant"), "1");
    await shot("variants");
    await page.keyboard.press("Home");
    await shows("red");
    assert.equal(await page.inputValue("#variant"), "");
    await page.evaluate(axe);
    await check("variants");
  });

  await step("it comes back when the server does", async () => {
    expectOffline = true;
    await kill();
    await wait(() => document.body.classList.contains("offline"));
    await start();
    await wait(() => !document.body.classList.contains("offline"));
    await wait(() => document.getElementById("scene-name").textContent.includes("cornell-box"));
    await wait(() => Number(document.getElementById("f-samples").textContent.replace(/,/g, "")) > 2);
    expectOffline = false;
  });

  await step("axe finds nothing, dark, light, small, and in the help", async () => {
    await page.evaluate(axe);
    await check("dark");
    await page.emulateMedia({ colorScheme: "light" });
    await check("light");
    await page.waitForTimeout(500);
    await shot("light");
    await page.setViewportSize({ width: 390, height: 780 });
    await check("phone");
    await page.waitForTimeout(500);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), "it scrolls sideways");
    await shot("phone");
    await page.setViewportSize({ width: 1180, height: 760 });
    await page.emulateMedia({ colorScheme: "dark" });
    await page.focus("#picture");
    await page.keyboard.press("?");
    await page.waitForSelector("#help[open]");
    await check("help");
    await shot("help");
    await page.keyboard.press("Escape");
  });

  await step("the console stayed silent", () => assert.deepEqual(complaints, []));
  console.log(`\n${passed} passed, 0 failed`);
} catch (error) {
  await shot("failed").catch(() => {});
  console.error(error);
  console.error(`console: ${JSON.stringify(complaints)}`);
  process.exitCode = 1;
} finally {
  await context.close().catch(() => {});
  server.kill("SIGKILL");
  rmSync(profile, { recursive: true, force: true });
}
