// Servers under test, pages that look at them, and what both need.

import { strict as assert } from "node:assert";
import { execFileSync, spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { chromium } from "playwright-core";

export const [program, out] = process.argv.slice(2, 4).map((path) => resolve(path));
export const scenes = resolve(import.meta.dirname, "../../scenes");
/** Nothing takes longer, on a machine that is busy. */
export const SLOW = 60_000;
/** Within which a picture of what is told comes. */
const PICTURE = 15_000;
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const profile = mkdtempSync(join(tmpdir(), "midway-browser-"));
/** Where servers keep what is uploaded: those that are killed leave it behind. */
const uploads = mkdtempSync(join(tmpdir(), "midway-uploads-"));
process.on("exit", () => rmSync(uploads, { recursive: true, force: true }));
mkdirSync(out, { recursive: true });

/** A server of this program. */
export class Server {
  /** Waits for the lines that say where its page is, on either stream. */
  static async start(line) {
    const server = new Server();
    server.process = spawn(program, line.map(String), { stdio: ["ignore", "pipe", "pipe"], env: { ...process.env, TMPDIR: uploads } });
    const said = await new Promise((done, failed) => {
      let text = "";
      const hear = (data) => {
        text += data;
        if (/view: http\S+\n/.test(text)) done(text);
      };
      server.process.stdout.on("data", hear);
      server.process.stderr.on("data", hear);
      server.process.once("exit", (code) => failed(new Error(`the server ended with ${code}: ${text}`)));
    });
    [, server.url] = said.match(/view: (http\S+)\n/);
    return server;
  }

  async kill() {
    if (this.process.exitCode !== null || this.process.signalCode !== null) return;
    const ended = new Promise((done) => this.process.once("exit", done));
    this.process.kill("SIGKILL");
    await ended;
  }
}

export const midway = (...line) => execFileSync(program, line.map(String), { encoding: "utf8" });

let passed = 0;
export async function step(name, act) {
  const began = Date.now();
  await act();
  passed += 1;
  console.log(`ok ${passed} ${name} (${Date.now() - began} ms)`);
}

/** Runs all of it in a browser; the exit status says how that went. */
export async function inBrowser(act) {
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: "/usr/bin/chromium",
    args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
      "--disable-background-networking", "--disable-component-update", "--disable-sync"],
    viewport: { width: 1180, height: 760 },
    colorScheme: "dark",
    acceptDownloads: true,
  });
  context.setDefaultTimeout(SLOW);
  const viewer = new Viewer(context, context.pages()[0] ?? await context.newPage());
  try {
    await act(viewer);
    await step("the console stayed silent", () => assert.deepEqual(viewer.complaints, []));
    console.log(`\n${passed} passed, 0 failed`);
  } catch (error) {
    await viewer.shot("failed").catch(() => {});
    console.error(error);
    console.error(`console: ${JSON.stringify(viewer.complaints)}`);
    process.exitCode = 1;
  } finally {
    await context.close().catch(() => {});
    rmSync(profile, { recursive: true, force: true });
  }
}

/** The page, and what is seen on it. */
export class Viewer {
  constructor(context, page) {
    Object.assign(this, { context, page, complaints: [], expectsOffline: false });
    page.on("console", (message) => {
      if (message.type() === "error" && !this.expectsOffline) this.complaints.push(message.text());
    });
    page.on("pageerror", (error) => this.complaints.push(String(error)));
  }

  figure(id) { return this.page.textContent(`#${id}`); }

  async samples() { return Number((await this.figure("f-samples")).replace(/,/g, "").replace(/\D.*$/, "")); }

  wait(condition, value) { return this.page.waitForFunction(condition, value, { timeout: SLOW, polling: 50 }); }

  /** Until an element's text has this in it. */
  says(id, text) {
    return this.wait(([id, text]) => document.getElementById(id).textContent.includes(text), [id, text]);
  }

  /** How often samples were forgotten since this was first asked. */
  forgotten() {
    return this.page.evaluate(() => {
      if (window.forgotten === undefined) {
        const figure = document.getElementById("f-samples");
        const count = () => Number(figure.textContent.replace(/,/g, "").replace(/\D.*$/, ""));
        let last = count();
        window.forgotten = 0;
        new MutationObserver(() => {
          const now = count();
          if (now < last) window.forgotten += 1;
          last = now;
        }).observe(figure, { childList: true });
      }
      return window.forgotten;
    });
  }

  /** Until what was shown gave way to pictures of fewer samples, as after a change. */
  async anew(change) {
    const before = await this.forgotten();
    await this.page.waitForTimeout(1000); // figures come a few times a second: fewer are to be seen
    await change();
    await this.wait((before) => window.forgotten > before, before);
  }

  /** The samples, and the picture, while it is paused. */
  async still() {
    await this.pause();
    const still = [await this.samples(), await this.picture()];
    await this.goOn();
    return still;
  }

  /** Until another picture is shown, as after a change while all is still. */
  async another(change) {
    const before = await this.page.evaluate(() => document.body.dataset.frame);
    await change();
    await this.wait((before) => document.body.dataset.frame !== before, before);
  }

  /** Until there are more samples than this. */
  moreThan(n) {
    return this.wait((n) => Number(document.getElementById("f-samples").textContent.replace(/,/g, "").replace(/\D.*$/, "")) > n, n);
  }

  shot(name) { return this.page.screenshot({ path: join(out, `${name}.png`) }); }

  /** Waits until no frame has come for a while. */
  async rest() {
    const frame = () => this.page.evaluate(() => document.body.dataset.frame);
    for (let last = null, now = await frame(); last !== now;) {
      await this.page.waitForTimeout(700);
      [last, now] = [now, await frame()];
    }
  }

  async pause() {
    await this.page.click("#pause");
    await this.says("pause", "Go on");
    await this.rest();
  }

  async goOn() {
    await this.page.click("#pause");
    await this.says("pause", "Pause");
  }

  /** The picture on the canvas: its pixels' bytes, red, green, blue and alpha, row by row. */
  async picture() {
    const { width, height, text } = await this.page.evaluate(() => {
      const canvas = document.getElementById("picture");
      const { data, width, height } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      let text = "";
      for (let at = 0; at < data.length; at += 2 ** 15) text += String.fromCharCode(...data.subarray(at, at + 2 ** 15));
      return { width, height, text: btoa(text) };
    });
    return { width, height, bytes: Buffer.from(text, "base64") };
  }

  /** Mean and spread of what is seen of it. */
  async seen() {
    const { bytes } = await this.picture();
    let [sum, squares, n] = [0, 0, 0];
    for (let i = 0; i < bytes.length; i += 4) {
      if (bytes[i + 3] === 0) continue;
      const value = (bytes[i] + bytes[i + 1] + bytes[i + 2]) / 3;
      [sum, squares, n] = [sum + value, squares + value * value, n + 1];
    }
    return { mean: sum / n, spread: Math.sqrt(Math.max(0, squares / n - (sum / n) ** 2)), n };
  }

  /** Waits until what is seen is so: figures may come before the picture that they are of. */
  async sees(condition, what) {
    for (const until = Date.now() + PICTURE; ;) {
      const seen = await this.seen();
      if (condition(seen)) return seen;
      assert.ok(Date.now() < until, `${what}: ${JSON.stringify(seen)}`);
      await this.page.waitForTimeout(100);
    }
  }

  isNotBlack() {
    return this.sees(({ mean, spread, n }) => mean > 2 && spread > 2 && n > 10_000, "black");
  }

  /** What a press saves, as a file in OUT. */
  async save(press, name) {
    const [download] = await Promise.all([this.page.waitForEvent("download"), press()]);
    const path = join(out, name);
    await download.saveAs(path);
    return { path, suggested: download.suggestedFilename() };
  }

  /** axe finds nothing. */
  async isAccessible(name) {
    if (!await this.page.evaluate(() => "axe" in window)) await this.page.evaluate(axe);
    const { violations } = await this.page.evaluate(() => window.axe.run());
    assert.deepEqual(violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target).join(" ")}`), [], name);
  }

  /** Drags files or folders of this machine over the page and lets them go, as a file manager does. */
  async drop(...files) {
    const session = await this.context.newCDPSession(this.page);
    const data = { items: [], files, dragOperationsMask: 1 };
    for (const type of ["dragEnter", "dragOver", "drop"]) {
      await session.send("Input.dispatchDragEvent", { type, x: 300, y: 300, data });
    }
    await session.detach();
  }
}

/** How far two pictures are apart, a byte of colour. */
export function distance(a, b) {
  assert.deepEqual([a.width, a.height], [b.width, b.height]);
  const n = a.width * a.height * 3;
  return a.bytes.reduce((sum, value, i) => sum + (i % 4 < 3 ? Math.abs(value - b.bytes[i]) : 0), 0) / n;
}

/** What an EXR's header says: the pixels that it has, first and last, and Midway's own samples and matrix by rows. */
export function headerOf(path) {
  const file = readFileSync(path);
  const after = (text) => {
    const at = file.indexOf(`${text}\0`, 0, "latin1");
    assert.ok(at >= 0, `${path} has no ${text}`);
    return at + text.length + 1 + 4; // its size comes first
  };
  const [samples, matrix] = [after("midway:samples\0int"), after("midway:world_from_camera\0m44f")];
  const window = after("dataWindow\0box2i");
  return {
    window: [0, 1, 2, 3].map((i) => file.readInt32LE(window + 4 * i)),
    samples: file.readInt32LE(samples),
    rows: [0, 1, 2, 3].map((row) => [0, 1, 2, 3].map((column) => file.readFloatLE(matrix + 4 * (4 * row + column)))),
  };
}
