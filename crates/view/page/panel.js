// The controls, and the figures beside them.

export const METHODS = [
  ["path-naive", { integrator: "path-naive" }],
  ["path", { integrator: "path" }],
  ["light", { integrator: "light" }],
  ["bdpt, full join", { integrator: "bdpt" }],
  ["bdpt, K joins", { integrator: "bdpt", join: "k-step" }],
  ["bdpt, K by importance", { integrator: "bdpt", join: "k-step", importance: true }],
  ["bdpt, K of a pool", { integrator: "bdpt", join: "k-step", pool: true }],
  ["bdpt, K of a pool by importance", { integrator: "bdpt", join: "k-step", pool: true, importance: true }],
  ["bdpt, single-step join", { integrator: "bdpt", join: "single-step" }],
];

export const element = (id) => document.getElementById(id);

export function fillMethods() {
  METHODS.forEach(([name], i) => {
    element("method").append(new Option(`${i + 1}  ${name}`, i));
    element("compare").append(new Option(name, i));
  });
  element("method").value = 1;
}

/** A method of the list as the server takes it. */
export const method = (index, k) => ({ ...METHODS[index][1], k });

/** Which of the list a server's method is. */
export function indexOf(told) {
  const same = (one) => one.integrator === told.integrator &&
    (told.integrator !== "bdpt" || ((one.join ?? "full") === told.join &&
      !!one.importance === told.importance && !!one.pool === told.pool));
  return METHODS.findIndex(([, one]) => same(one));
}

const bytes = (n) => (n < 1e9 ? `${(n / 2 ** 20).toFixed(1)} MiB` : `${(n / 2 ** 30).toFixed(2)} GiB`);
const count = (n) => n.toLocaleString("en");

export function showFigures(status) {
  const { left, right } = status;
  const both = (of) => (right ? `${of(left)} | ${of(right)}` : of(left));
  const text = {
    "f-samples": both((half) => count(half.samples)),
    "f-mrays": both((half) => half.mrays.toFixed(1)),
    "f-ms": status.frame_ms.toFixed(1),
    "f-noise": status.relmse == null ? "–" : `${(100 * Math.sqrt(status.relmse)).toFixed(2)} %${right ? " (left)" : ""}`,
    "f-memory": bytes(left.memory + (right?.memory ?? 0)),
    "f-rejected": both((half) => count(half.rejected)),
    "f-size": left.size.join(" × "),
    "f-bias": left.bias.join("; ") || "none",
    "f-device": `${status.device} (${status.backend})`,
    "f-integrator": both((half) => half.integrator),
  };
  for (const [id, value] of Object.entries(text)) element(id).textContent = value;
  element("left-name").hidden = element("right-name").hidden = !right;
  const pane = (half) => `${half.integrator} · ${half.samples} samples · ${half.seconds.toFixed(1)} s`;
  if (right) {
    element("left-name").textContent = pane(left);
    element("right-name").textContent = pane(right);
  }
  say("black", status.failure ? `The renderer stopped: ${status.failure}` : status.black);
  if (isSettled("pause")) showPaused(status.paused);
}

export function showPaused(paused) {
  element("pause").setAttribute("aria-pressed", paused);
  element("pause").textContent = paused ? "Go on" : "Pause";
}

/** Shows an alert, or none. It is read out each time it is written. */
export function say(id, text) {
  element(id).hidden = !text;
  if (element(id).textContent !== (text ?? "")) element(id).textContent = text ?? "";
}

/** What the server says of a control counts again this long after a hand was on it. */
const SETTLED_MS = 1200;

/** Notes that a hand was on a control: figures under way to the page are older. */
export function touch(id) {
  element(id).touched = performance.now();
}

function isSettled(id) {
  const control = element(id);
  return !control.matches(":active") && performance.now() - (control.touched ?? -Infinity) >= SETTLED_MS;
}

/** Sets a control to what the server says. */
export function put(id, value) {
  if (isSettled(id)) element(id).value = value;
}
