// A cross on the picture that arrow keys move: places and parts of the film are chosen without a mouse.

const STEP = 1 / 40; // of the film's sides
const FINE = 1 / 400;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const percent = (place) => place.map((v) => `${Math.round(100 * v)} %`).join(", ");

/** What lies between two places, as left, top, width and height. */
export const between = (a, b) =>
  [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.abs(a[0] - b[0]), Math.abs(a[1] - b[1])];

export class Aim {
  #done = null;
  #corners = 1;
  #first = null;
  #at = [0.5, 0.5];

  /** cross, box: elements over the picture; film(): where the film lies there; say(text). */
  constructor({ cross, box, film, say }) {
    Object.assign(this, { cross, box, film, say });
  }

  get active() { return this.#done !== null; }

  /** Has a place chosen: done([x, y]), from 0 to 1. */
  place(done) {
    this.#start(1, done);
    this.say("arrows move the cross, Shift finely; Enter focuses there, Escape leaves it");
  }

  /** Has a part chosen by two corners: done([x, y, width, height]). */
  part(done) {
    this.#start(2, done);
    this.say("drag across the part to render; or move the cross by arrows, Enter sets a corner");
  }

  stop() {
    if (!this.active) return;
    this.#done = this.#first = null;
    this.cross.hidden = this.box.hidden = true;
  }

  /** A key that is pressed meanwhile; whether it meant something here. */
  press(event) {
    if (!this.active) return false;
    if (event.key === "Enter") this.#enter();
    else if (ARROWS[event.key]) this.#move(ARROWS[event.key], event.shiftKey ? FINE : STEP);
    else return false;
    return true;
  }

  draw() {
    if (!this.active) return;
    const [left, top, width, height] = this.film();
    const onPage = ([x, y]) => [left + x * width, top + y * height];
    const [x, y] = onPage(this.#at);
    Object.assign(this.cross.style, { left: `${x}px`, top: `${y}px` });
    this.cross.hidden = false;
    if (this.#first) frame(this.box, between(onPage(this.#first), [x, y]));
  }

  #start(corners, done) {
    this.stop();
    [this.#corners, this.#done, this.#at] = [corners, done, [0.5, 0.5]];
    this.draw();
  }

  #move([x, y], step) {
    const within = (v) => Math.min(1, Math.max(0, v));
    this.#at = [within(this.#at[0] + x * step), within(this.#at[1] + y * step)];
    this.draw();
    this.say(percent(this.#at));
  }

  #enter() {
    if (this.#corners === 2 && !this.#first) {
      this.#first = this.#at;
      this.draw();
      return this.say(`a corner at ${percent(this.#at)}; arrows to the opposite one, Enter renders what is between`);
    }
    const [done, chosen] = [this.#done, this.#first ? between(this.#first, this.#at) : this.#at];
    this.stop();
    done(chosen);
  }
}

/** Puts a box where it is to be seen. */
export function frame(box, [left, top, width, height]) {
  Object.assign(box.style, { left: `${left}px`, top: `${top}px`, width: `${width}px`, height: `${height}px` });
  box.hidden = false;
}
