// The page of servers other than a viewer of a scene: without a scene, of a render that runs, and at an
// address where browsers need a token.

import { strict as assert } from "node:assert";
import { join } from "node:path";
import { Server, out, scenes, step } from "./support.mjs";

const CPU = ["--device", "cpu"];
const SMALL = ["--height", 96, ...CPU];

/** What is asked of a server comes from its page; the server ends with it. */
async function served(viewer, line, act) {
  const server = await Server.start(line);
  try {
    await viewer.page.goto(server.url);
    await act(server);
  } finally {
    viewer.expectsOffline = true;
    await viewer.page.goto("about:blank");
    await server.kill();
    viewer.expectsOffline = false;
  }
}

async function withoutScene(viewer) {
  const { page } = viewer;
  await served(viewer, ["view", "--no-open", "--port", 7412, ...SMALL], async () => {
    await viewer.says("black", "There is no scene. Drop a .glb");
    await viewer.says("scene-name", "0 triangles");
    await viewer.isAccessible("without a scene");
    await viewer.shot("nothing");
    await viewer.drop(join(scenes, "lamp.gltf"), join(scenes, "lamp.bin"));
    await viewer.says("scene-name", "lamp.gltf");
    await viewer.moreThan(4);
    await page.waitForSelector("#black", { state: "hidden" });
    await viewer.isNotBlack();
  });
}

async function runningRender(viewer) {
  const { page } = viewer;
  const line = ["render", join(scenes, "cornell-box.gltf"), "--serve=7413", "--time", "5m", "-o", join(out, "served.exr")];
  await served(viewer, [...line, ...SMALL], async () => {
    await viewer.says("scene-name", "cornell-box.gltf");
    await viewer.moreThan(0);
    await viewer.isNotBlack();
    await viewer.moreThan(await viewer.samples());
    await viewer.says("role", "read only");
    for (const id of ["pause", "method", "save-exr", "file", "folder"]) assert.ok(await page.isDisabled(`#${id}`), id);
    // What is left to be reached is reached, and no trap.
    const focused = () => page.evaluate(() => document.activeElement.id);
    await page.focus("#picture");
    await page.keyboard.press("Escape");
    assert.equal(await focused(), "panel");
    await page.keyboard.press("Escape");
    assert.equal(await focused(), "picture");
    await page.keyboard.press("Tab");
    assert.notEqual(await focused(), "picture");
    await viewer.isAccessible("a running render");
    await viewer.shot("served");
  });
}

async function elsewhere(viewer) {
  const { page } = viewer;
  const line = ["view", join(scenes, "cornell-box.gltf"), "--no-open", "--bind", "0.0.0.0", "--port", 7414, ...SMALL];
  await served(viewer, line, async (first) => {
    assert.ok(!first.url.includes("0.0.0.0"), `no browser opens ${first.url}`);
    await viewer.moreThan(2);
    assert.ok(!page.url().includes("token"), "the token stays in the address");
    viewer.expectsOffline = true;
    await first.kill();
    await viewer.says("offline", "No connection");
    const second = await Server.start(line);
    try {
      await viewer.says("offline", "Open the address that it has printed");
      await viewer.isAccessible("a stranger");
      await viewer.shot("stranger");
      // What this browser needs it may get in another tab: this one comes back by itself.
      const tab = await viewer.context.newPage();
      await tab.goto(second.url);
      await page.waitForSelector("#offline", { state: "hidden" });
      await tab.close();
      viewer.expectsOffline = false;
      await viewer.moreThan(2);
      await viewer.isNotBlack();
    } finally {
      viewer.expectsOffline = true;
      await second.kill();
    }
  });
}

export async function others(viewer) {
  await step("without a scene the page asks for one and takes it", () => withoutScene(viewer));
  await step("a render that runs is looked at and left alone", () => runningRender(viewer));
  await step("a server that was started anew says that it wants another address", () => elsewhere(viewer));
}
