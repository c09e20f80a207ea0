// Puts the page together: what hands do becomes requests, what the server says becomes the page.

import { Camera } from "./camera.js";
import { watchDrops } from "./drop.js";
import { watchKeys } from "./keys.js";
import { Lights } from "./lights.js";
import { Link } from "./link.js";
import { element, fillMethods, indexOf, method, put, say, showFigures, showPaused, touch } from "./panel.js";
import { plot } from "./plot.js";
import { Saved } from "./saved.js";
import { Stage } from "./stage.js";

const NOTICE_MS = 5000;
const state = { scene: null, status: null, input: 0, look: null, opened: null, readOnly: false, steers: true, picks: false,
  own: false, // whether this page has moved the view since it began to steer
  size: null, // the film that was asked for last
};
const camera = new Camera();

fillMethods();

function notice(text) {
  element("notice").textContent = text;
  element("notice").hidden = false;
  clearTimeout(notice.timer);
  notice.timer = setTimeout(() => { element("notice").hidden = true; }, NOTICE_MS);
}

const link = new Link({
  open() {
    document.body.classList.remove("offline");
    say("offline", null);
    Object.assign(state, { opened: null, own: false, picks: false, size: null });
  },
  closed({ known }) {
    document.body.classList.add("offline");
    element("scene-name").textContent = "no connection";
    say("black", null);
    say("offline", known ? "No connection to Midway, trying again …"
      : "Midway was started anew and does not know this browser any more. Open the address that it has printed.");
  },
  role({ steers, clients, read_only }) {
    const gains = steers && !state.steers;
    [state.readOnly, state.steers] = [read_only, steers];
    if (gains || !steers) state.own = state.picks = false;
    if (gains && state.scene) setCamera(state.scene.view);
    element("take").hidden = steers || read_only;
    document.querySelectorAll("#panel fieldset, #panel .buttons button, #file, #folder").forEach((one) => { one.disabled = read_only; });
    element("panel").tabIndex = read_only ? 0 : -1; // figures are scrolled by keys where no control is
    const others = clients > 1 ? `${clients} browsers` : "";
    element("role").textContent = read_only ? "read only" : steers ? others : `${others}, another steers`;
  },
  refused({ reason }) { notice(reason); },
  notice({ text }) { notice(text); },
  warnings({ lines }) { notice(lines.join(" · ")); },
  scene(scene) {
    if (!scene.view) return;
    state.scene = scene;
    // Of a scene that was changed the hand that turns it knows the view best.
    if (scene.opened !== state.opened || !state.own) setCamera(scene.view);
    if (scene.opened !== state.opened) {
      Object.assign(state, { opened: scene.opened, own: false, picks: false });
      element("cameras").replaceChildren(...scene.cameras.map((one, i) => new Option(one.name || `camera ${i}`, i)));
      saved.list(scene.name);
    }
    const triangles = scene.triangles === 1 ? "triangle" : "triangles";
    element("scene-name").textContent = `${scene.name} · ${scene.triangles.toLocaleString("en")} ${triangles}`;
    element("materials").hidden = !scene.variants.length;
    const names = JSON.stringify(scene.variants);
    if (element("variant").dataset.names !== names) {
      element("variant").dataset.names = names;
      const variants = scene.variants.map((name, i) => new Option(name || `variant ${i}`, i));
      element("variant").replaceChildren(new Option("default", ""), ...variants);
      element("variant").value = scene.variant ?? "";
    }
    lights.show(scene.groups);
    showOutputs();
  },
  picked({ point }) {
    if (!state.picks) return; // another browser's
    state.picks = false;
    if (!point) return notice("nothing is there");
    camera.focusOn(point);
    moved();
  },
  status(status) {
    if (!status.left) return;
    state.status = status;
    showFigures(status);
    put("method", indexOf(status.method));
    put("k", status.method.k);
    put("length", status.max_path_length ?? 0);
    put("compare", status.right ? indexOf(status.right.method) : "");
    put("exposure", status.shown.exposure);
    put("tone", status.shown.tone_map);
    put("layer", status.shown.layer);
    put("hold", Math.round(status.hold_ms));
    put("env-strength", status.environment.strength);
    put("env-rotation", status.environment.rotation);
    put("variant", status.variant ?? "");
    if (String(status.film) === String(state.size)) state.size = null;
    stage.reshape({ film: status.film, region: status.region });
    lights.put(status.mix);
    element("k").disabled = !status.left.integrator.includes("k-step") && !status.right?.integrator.includes("k-step");
    element("region").setAttribute("aria-pressed", !!status.region);
    plot(element("plot"), status.plot);
    element("plot-note").textContent = status.relmse == null ? "no measurement yet"
      : `${status.right ? "left: " : ""}relMSE ${status.relmse.toExponential(2)}, ` +
        (status.measured_by === "reference" ? "against the reference" : "expected, from two halves of the samples");
    showOutputs();
  },
  frame(frame) {
    const shape = state.status && { film: state.status.film, region: state.status.region };
    stage.show(frame, shape);
    document.body.dataset.frame = frame.sequence;
    document.body.dataset.input = frame.input;
  },
});

// Views are sent as they come, at most one a frame of the screen.
function look() {
  state.own = state.steers;
  if (state.look) return;
  state.look = requestAnimationFrame(() => {
    state.look = null;
    state.input = (state.input + 1) % 2 ** 31;
    link.send({ type: "look", ...camera.view(), input: state.input, opened: state.opened });
  });
}

function setCamera(view) {
  camera.set(view);
  element("fov").value = Math.round(camera.fov ?? 40);
  element("fov").disabled = camera.fov == null;
}

// What is moved by hand is no longer one of the list, so that it can be chosen again.
function moved() {
  element("cameras").selectedIndex = -1;
  saved.clear();
  look();
}

const over = { canvas: element("picture"), divider: element("divider"), box: element("region-box"), cross: element("cross") };
const stage = new Stage(over, camera, {
  moved,
  say: notice,
  picked: (x, y) => {
    state.picks = state.steers;
    link.send({ type: "pick", x, y });
  },
  // All pixels of which a part is marked.
  marked: ([left, top, across, down]) => {
    const [width, height] = state.status?.film ?? [0, 0];
    const [x, y] = [Math.floor(left * width), Math.floor(top * height)];
    const size = [Math.ceil((left + across) * width) - x, Math.ceil((top + down) * height) - y];
    if (size[0] < 4 || size[1] < 4) return;
    link.send({ type: "region", window: [x, y, Math.min(size[0], width - x), Math.min(size[1], height - y)] });
  },
});

watchDrops(link, notice);
const saved = new Saved({ view: () => camera.view(), choose: (view) => { setCamera(view); look(); }, say: notice });
const lights = new Lights((request) => link.send(request));

function showOutputs() {
  const value = (id) => element(id).value;
  element("k-out").textContent = value("k");
  element("exposure-out").textContent = Number(value("exposure")).toFixed(2);
  element("hold-out").textContent = `${value("hold")} ms`;
  element("env-strength-out").textContent = value("env-strength");
  element("env-rotation-out").textContent = `${value("env-rotation")}°`;
  element("fov-out").textContent = `${value("fov")}°`;
}

// Requests by the controls.

const number = (id) => Number(element(id).value);

function sendMethod() {
  link.send({ type: "render", method: method(number("method"), number("k")) });
}

function sendShown() {
  const [exposure, tone_map, layer] = [number("exposure"), element("tone").value, element("layer").value];
  link.send({ type: "show", exposure, tone_map, layer });
}

function sendSplit() {
  const index = element("compare").value;
  link.send({ type: "split", right: index === "" ? null : method(Number(index), number("k")) });
}

function sendSize() {
  const wanted = element("size").value;
  if (!wanted || !state.status) return;
  const picture = element("picture");
  const shape = state.status.film[0] / state.status.film[1];
  const height = Number(wanted);
  const size = wanted === "window" ? [picture.clientWidth, picture.clientHeight] : [Math.round(height * shape), height];
  if (String(size) === String(state.size ?? state.status.film)) return; // it would begin anew
  state.size = size;
  link.send({ type: "render", size });
}

const sendEnvironment = () => link.send({
  type: "environment", strength: number("env-strength"), rotation: number("env-rotation"),
});

const on = (id, event, act) => element(id).addEventListener(event, () => { touch(id); showOutputs(); act(); });
on("method", "change", sendMethod);
on("k", "input", () => { sendMethod(); if (element("compare").value !== "") sendSplit(); });
on("length", "change", () => link.send({ type: "render", max_path_length: number("length") }));
on("compare", "change", sendSplit);
on("size", "change", sendSize);
on("hold", "input", () => link.send({ type: "render", hold_ms: number("hold") }));
on("exposure", "input", sendShown);
on("tone", "change", sendShown);
on("layer", "change", sendShown);
on("variant", "change", () => {
  const index = element("variant").value;
  link.send({ type: "variant", index: index === "" ? null : Number(index) });
});
for (const id of ["env-strength", "env-rotation"]) {
  on(id, "input", () => {}); // under the hand
  on(id, "change", sendEnvironment);
}
on("fov", "input", () => { camera.fov = number("fov"); moved(); });
on("take", "click", () => link.send({ type: "take" }));
on("restart", "click", () => link.send({ type: "restart" }));
on("frame-all", "click", frameAll);
on("save-exr", "click", () => save("exr"));
on("save-png", "click", () => save("png"));
on("pause", "click", togglePause);
on("help-open", "click", () => element("help").showModal());
on("region", "click", toggleRegion);
on("cameras", "change", () => { setCamera(state.scene.cameras[number("cameras")]); look(); });

function toggleRegion() {
  if (state.status?.region) link.send({ type: "region", window: null });
  else if (stage.marking) stage.cancel();
  else stage.mark();
}

function togglePause() {
  if (!state.steers || document.body.classList.contains("offline")) return;
  const paused = element("pause").getAttribute("aria-pressed") !== "true";
  touch("pause");
  showPaused(paused);
  link.send({ type: "pause", paused });
}

function frameAll() {
  if (!state.scene) return;
  const [width, height] = state.status?.film ?? [1, 1];
  camera.frame(state.scene.bounds, width / height);
  moved();
}

async function save(format) {
  try {
    await link.save(format, (state.scene?.name ?? "midway").replace(/\.[^.]*$/, ""));
    if (state.status?.right) notice("what is saved is the left picture");
  } catch (error) {
    notice(String(error.message ?? error));
  }
}

// Keys.

function cycle(id, step) {
  const select = element(id);
  select.selectedIndex = (select.selectedIndex + step + select.options.length) % select.options.length;
  select.dispatchEvent(new Event("change"));
}

function nudge(id, step) {
  element(id).value = number(id) + step;
  element(id).dispatchEvent(new Event("input"));
}

watchKeys(stage, {
  save: () => save("exr"),
  restart: () => link.send({ type: "restart" }),
  layer: () => !state.readOnly && (cycle("layer", 1), true),
  digit(n) {
    element("method").value = n - 1;
    touch("method");
    sendMethod();
  },
  keys: {
    f: frameAll,
    x: () => stage.pick(),
    c: toggleRegion,
    t: () => cycle("tone", 1),
    p: togglePause,
    "[": () => nudge("exposure", -0.5),
    "]": () => nudge("exposure", 0.5),
    "?": () => element("help").showModal(),
  },
});
