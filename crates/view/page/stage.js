// The picture on its canvas, and what the hand does to it.

import { Aim, between, frame } from "./aim.js";

const ORBIT = 3.2; // radians for a drag across the picture's height
const KEY_ORBIT = 0.08;
const KEY_FLY = 0.03; // distances to the target in a step of 30 ms
const ZOOM = 1.0015;

export class Stage {
  /** camera: moved in place, then told by `moved()`; picked(x, y), marked([x, y, w, h]) in 0..1; say(text). */
  constructor({ canvas, divider, box, cross }, camera, { moved, picked, marked, say }) {
    Object.assign(this, { canvas, divider, box, camera, moved, picked, marked });
    this.aim = new Aim({ cross, box, say, film: () => this.filmOnPage() });
    this.context = canvas.getContext("2d");
    this.frame = null;
    this.pointers = new Map();
    this.held = new Set();
    new ResizeObserver(() => this.resize()).observe(canvas);
    divider.addEventListener("input", () => this.draw());
    this.listen();
  }

  resize() {
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(this.canvas.clientWidth * ratio);
    this.canvas.height = Math.round(this.canvas.clientHeight * ratio);
    this.draw();
  }

  show(frame, shape) {
    this.frame?.bitmaps.forEach((bitmap) => bitmap.close());
    this.frame = frame;
    this.shape = shape;
    this.draw();
  }

  /** Draws the frame where it lies in a film that has changed, unless it is of the one before. */
  reshape(shape) {
    if (!this.frame || JSON.stringify(shape) === JSON.stringify(this.shape)) return;
    const [width, height] = shape.region?.slice(2) ?? shape.film;
    const apart = Math.abs(this.frame.width * height - this.frame.height * width);
    if (apart > Math.max(width, height)) return;
    this.shape = shape;
    this.draw();
  }

  /** Where the whole film lies on the canvas, and the frame's part of it. */
  place() {
    const { width, height } = this.canvas;
    const film = this.shape?.film ?? [this.frame.width, this.frame.height];
    const fit = Math.min(width / film[0], height / film[1]);
    const whole = [(width - film[0] * fit) / 2, (height - film[1] * fit) / 2, film[0] * fit, film[1] * fit];
    const region = this.shape?.region;
    if (!region) return { whole, part: whole };
    const part = [whole[0] + region[0] * fit, whole[1] + region[1] * fit, region[2] * fit, region[3] * fit];
    return { whole, part };
  }

  draw() {
    const { context, canvas } = this;
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (!this.frame?.bitmaps.length) return;
    this.aim.draw();
    const { part } = this.place();
    context.imageSmoothingQuality = "high";
    const [left, right] = this.frame.bitmaps;
    context.drawImage(left, ...part);
    this.divider.hidden = !right;
    if (!right) return;
    const x = (canvas.width * this.divider.value) / 100;
    context.save();
    context.beginPath();
    context.rect(x, 0, canvas.width - x, canvas.height);
    context.clip();
    context.drawImage(right, ...part);
    context.restore();
    context.fillStyle = "#fff";
    context.fillRect(x - 1, 0, 2, canvas.height);
  }

  /** Where the whole film lies over the canvas, in the page's pixels. */
  filmOnPage() {
    const ratio = this.canvas.width / this.canvas.clientWidth;
    return this.place().whole.map((v) => v / ratio);
  }

  /** A pointer's place in the film, from 0 to 1. */
  inFilm(event) {
    const ratio = this.canvas.width / this.canvas.clientWidth;
    const bounds = this.canvas.getBoundingClientRect();
    const { whole } = this.place();
    const clamp = (v) => Math.min(1, Math.max(0, v));
    const at = [(event.clientX - bounds.left) * ratio, (event.clientY - bounds.top) * ratio];
    return [clamp((at[0] - whole[0]) / whole[2]), clamp((at[1] - whole[1]) / whole[3])];
  }

  get marking() { return this.canvas.classList.contains("marking"); }

  /** Has a part of the film marked, by pointer or keys. */
  mark() {
    if (!this.frame) return;
    this.canvas.focus();
    this.canvas.classList.add("marking");
    this.aim.part((part) => this.endMark(part));
  }

  /** Has a place of the film picked by keys. */
  pick() {
    if (!this.frame) return;
    this.cancel();
    this.canvas.focus();
    this.aim.place(([x, y]) => this.picked(x, y));
  }

  /** Ends marking and picking; whether there was any. */
  cancel() {
    const was = this.aim.active;
    this.aim.stop();
    this.canvas.classList.remove("marking");
    return was;
  }

  listen() {
    const { canvas, pointers } = this;
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => {
      canvas.focus();
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, button: event.button, from: event });
      canvas.classList.add("dragging");
      if (event.button === 1) event.preventDefault();
    });
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    const release = (event) => {
      const start = pointers.get(event.pointerId);
      pointers.delete(event.pointerId);
      canvas.classList.remove("dragging");
      if (start && this.marking) this.endMark(between(this.inFilm(start.from), this.inFilm(event)));
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", (event) => pointers.delete(event.pointerId));
    canvas.addEventListener("dblclick", (event) => {
      if (this.frame) this.picked(...this.inFilm(event));
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.camera.zoom(ZOOM ** (event.deltaY * (event.deltaMode ? 30 : 1)));
      this.moved();
    }, { passive: false });
    setInterval(() => this.fly(), 30);
  }

  drag(event) {
    const last = this.pointers.get(event.pointerId);
    if (!last) return;
    if (this.marking) return this.drawMark(last.from, event);
    const height = this.canvas.clientHeight || 1;
    const [dx, dy] = [(event.clientX - last.x) / height, (event.clientY - last.y) / height];
    if (this.pointers.size === 2) {
      const [one, two] = [...this.pointers.values()];
      const before = Math.hypot(one.x - two.x, one.y - two.y);
      Object.assign(last, { x: event.clientX, y: event.clientY });
      const after = Math.hypot(one.x - two.x, one.y - two.y);
      this.camera.zoom(before / Math.max(after, 1));
      this.camera.pan(-dx / 2, dy / 2);
    } else {
      Object.assign(last, { x: event.clientX, y: event.clientY });
      if (last.button === 0 && !event.shiftKey) this.camera.orbit(-dx * ORBIT, dy * ORBIT);
      else this.camera.pan(-dx, dy);
    }
    this.moved();
  }

  drawMark(from, to) {
    const bounds = this.canvas.getBoundingClientRect();
    const [a, b] = [from, to].map((event) => [event.clientX - bounds.left, event.clientY - bounds.top]);
    frame(this.box, between(a, b));
  }

  endMark(part) {
    this.cancel();
    this.marked(part);
  }

  /** A key that no control needs; whether it meant something here. */
  press(event) {
    if (this.aim.press(event)) return true;
    const key = event.key.toLowerCase();
    const arrows = { arrowleft: [-1, 0], arrowright: [1, 0], arrowup: [0, 1], arrowdown: [0, -1] };
    if (arrows[key]) {
      const [x, y] = arrows[key];
      if (event.shiftKey) this.camera.pan(x * 0.04, y * 0.04);
      else this.camera.orbit(x * KEY_ORBIT, y * KEY_ORBIT);
      this.moved();
    } else if (key === "+" || key === "=" || key === "-") {
      this.camera.zoom(key === "-" ? 1.1 : 1 / 1.1);
      this.moved();
    } else if (/^[wasdqe]$/.test(key)) {
      this.held.add(key);
    } else {
      return false;
    }
    return true;
  }

  lift(event) { this.held.delete(event.key.toLowerCase()); }

  letGo() { this.held.clear(); }

  fly() {
    if (!this.held.size) return;
    const axis = (plus, minus) => (this.held.has(plus) ? KEY_FLY : 0) - (this.held.has(minus) ? KEY_FLY : 0);
    this.camera.fly(axis("d", "a"), axis("e", "q"), axis("w", "s"));
    this.moved();
  }
}
