// The mixer: a slider in stops and a colour for each group of lights. The first touch has the renderer
// keep the groups apart, which begins the picture anew; from then on mixing costs no sample.

import { element } from "./panel.js";

/** At the slider's left end a light is off. */
const OFF = -10;
/** What the server says counts again this long after a hand was on a slider. */
const SETTLED_MS = 1200;

const linear = (byte) => (byte <= 10.31475 ? byte / 3294.6 : ((byte / 255 + 0.055) / 1.055) ** 2.4);
const channels = (colour) => [1, 3, 5].map((at) => linear(parseInt(colour.slice(at, at + 2), 16)));
const byte = (value) => Math.round(value <= 0.0031308 ? 3294.6 * value : 255 * (1.055 * value ** (1 / 2.4) - 0.055));
const named = (values) => `#${values.map((value) => byte(value).toString(16).padStart(2, "0")).join("")}`;

export class Lights {
  #rows = [];
  #names = "";
  #touched = -Infinity;

  constructor(send) {
    this.send = send;
    element("reset-lights").addEventListener("click", () => this.#reset());
  }

  /** The groups of a scene, whose sliders stay where they are the same. */
  show(names) {
    if (this.#names === JSON.stringify(names)) return;
    this.#names = JSON.stringify(names);
    this.#rows = names.map((name, i) => this.#row(name, i));
    element("groups").replaceChildren(...this.#rows.map(({ row }) => row));
    element("lights").hidden = !names.length;
    this.#label();
  }

  /** What another browser may have changed. */
  put(factors) {
    if (performance.now() - this.#touched < SETTLED_MS) return;
    this.#rows.forEach(({ slider, colour }, i) => {
      const factor = factors?.[i] ?? [1, 1, 1];
      const most = Math.max(...factor);
      const own = channels(colour.value);
      const gain = most / Math.max(...own, 1e-6);
      // A darker colour of this browser's own is the same with another gain: it stays.
      const same = factor.every((value, c) => Math.abs(value - gain * own[c]) <= 0.01 * most);
      if (most > 0 && !same) colour.value = named(factor.map((value) => value / most));
      const stops = Math.log2(most / Math.max(...channels(colour.value), 1e-6));
      if (most === 0) slider.value = OFF;
      else if (factors) slider.value = stops;
      else [slider.value, colour.value] = [0, "#ffffff"];
    });
    this.#label();
  }

  #row(name, i) {
    const row = document.createElement("div");
    const [label, output, slider, colour] = ["label", "output", "input", "input"].map((tag) => document.createElement(tag));
    Object.assign(slider, { type: "range", id: `light-${i}`, min: OFF, max: 6, step: 0.25, value: 0 });
    Object.assign(colour, { type: "color", value: "#ffffff", ariaLabel: `Colour of ${name}` });
    label.htmlFor = slider.id;
    label.append(name, output);
    const both = document.createElement("div");
    both.className = "row";
    both.append(slider, colour);
    row.append(label, both);
    for (const input of [slider, colour]) input.addEventListener("input", () => this.#mix());
    return { row, slider, colour, output };
  }

  #factor({ slider, colour }) {
    const stops = Number(slider.value);
    const gain = stops <= OFF ? 0 : 2 ** stops;
    return channels(colour.value).map((value) => gain * value);
  }

  #mix() {
    this.#touched = performance.now();
    this.#label();
    this.send({ type: "mix", factors: this.#rows.map((row) => this.#factor(row)) });
  }

  #reset() {
    this.#touched = performance.now();
    for (const { slider, colour } of this.#rows) [slider.value, colour.value] = [0, "#ffffff"];
    this.#label();
    this.send({ type: "mix", factors: null });
  }

  #label() {
    for (const { slider, output } of this.#rows) {
      const stops = Number(slider.value);
      output.textContent = stops <= OFF ? "off" : `${stops > 0 ? "+" : ""}${stops.toFixed(2)}`;
    }
  }
}
