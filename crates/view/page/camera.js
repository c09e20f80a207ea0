// The camera under the hand: where from, where to. Vectors are arrays of three numbers.

const add = (a, b) => a.map((x, i) => x + b[i]);
const sub = (a, b) => a.map((x, i) => x - b[i]);
const scale = (a, s) => a.map((x) => x * s);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const normalize = (a) => scale(a, 1 / (length(a) || 1));

/** Closest to the pole that an orbit comes, in radians. */
const POLE = 0.02;

export class Camera {
  constructor() {
    this.set({ eye: [0, 0, 5], target: [0, 0, 0], up: [0, 1, 0], fov: 40, height: null, lens: 0, focus: null });
  }

  set(view) {
    this.eye = view.eye.slice();
    this.target = view.target.slice();
    this.fov = view.fov;
    this.height = view.height ?? null; // of parallel rays
    this.lens = view.lens ?? 0;
    this.focus = view.focus ?? null;
    // Orbits keep what is up in the world up, unless the camera lies on its side.
    const up = view.up ?? [0, 1, 0];
    this.up = Math.abs(up[1]) > 0.3 ? [0, Math.sign(up[1]), 0] : up.slice();
  }

  view() {
    const { eye, target, up, fov, height, lens, focus } = this;
    return { eye, target, up, fov, height, lens, focus };
  }

  distance() { return length(sub(this.eye, this.target)); }

  axes() {
    const back = normalize(sub(this.eye, this.target));
    const right = normalize(cross(this.up, back));
    return { back, right, above: cross(back, right) };
  }

  /** Turns about the target, angles in radians. */
  orbit(yaw, pitch) {
    const offset = sub(this.eye, this.target);
    const distance = length(offset);
    const { right } = this.axes();
    const out = cross(right, this.up); // level, towards the eye
    const height = Math.asin(Math.max(-1, Math.min(1, dot(offset, this.up) / distance)));
    const turned = Math.max(POLE - Math.PI / 2, Math.min(Math.PI / 2 - POLE, height + pitch));
    const flat = add(scale(out, Math.cos(yaw)), scale(right, Math.sin(yaw)));
    this.eye = add(this.target, scale(add(scale(flat, Math.cos(turned)), scale(this.up, Math.sin(turned))), distance));
  }

  /** Moves across the view; x right and y up in heights of the picture. */
  pan(x, y) {
    const { right, above } = this.axes();
    const height = this.height ?? 2 * this.distance() * Math.tan(((this.fov ?? 40) * Math.PI) / 360);
    this.shift(add(scale(right, x * height), scale(above, y * height)));
  }

  zoom(factor) {
    const by = Math.min(10, Math.max(0.1, factor));
    if (this.height != null) this.height *= by;
    else this.eye = add(this.target, scale(sub(this.eye, this.target), by));
  }

  /** Flies: right, up, forward, in distances to the target. */
  fly(right, up, forward) {
    const axes = this.axes();
    const way = add(add(scale(axes.right, right), scale(axes.above, up)), scale(axes.back, -forward));
    this.shift(scale(way, this.distance()));
  }

  shift(by) {
    this.eye = add(this.eye, by);
    this.target = add(this.target, by);
  }

  /** Turns about a point from now on, and has it sharp. */
  focusOn(point) {
    this.target = point.slice();
    this.focus = null;
  }

  /** Sees all of a box, from the same side, on a film of this width by height. */
  frame([least, most], aspect = 1) {
    const centre = scale(add(least, most), 0.5);
    const radius = Math.max(length(sub(most, least)) / 2, 1e-3);
    const above = ((this.fov ?? 40) * Math.PI) / 360;
    const narrower = Math.min(above, Math.atan(Math.tan(above) * aspect));
    const distance = (1.05 * radius) / Math.sin(narrower);
    const { back } = this.axes();
    if (this.height != null) this.height = (2.1 * radius) / Math.min(1, aspect);
    this.target = centre;
    this.eye = add(centre, scale(back, distance));
  }
}
