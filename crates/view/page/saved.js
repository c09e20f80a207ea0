// Saved cameras: they stay in this browser, by the scene's name.

import { kept } from "./kept.js";
import { element } from "./panel.js";

const nameOf = (view, i) => view.name ?? `view ${i + 1}`;

export class Saved {
  #scene = "";

  /** view(): the camera as it is; choose(view); say(text). */
  constructor({ view, choose, say }) {
    Object.assign(this, { view, choose, say });
    const list = element("saved");
    element("save-camera").addEventListener("click", () => this.#add());
    element("delete-camera").addEventListener("click", () => this.#delete());
    list.addEventListener("keydown", (event) => { if (event.key === "Delete") this.#delete(); });
    list.addEventListener("change", () => {
      const view = this.#views()[list.value];
      if (view) this.choose(view);
      this.#showChosen();
    });
  }

  /** Offers those of a scene. */
  list(scene) {
    this.#scene = scene;
    this.#show("");
  }

  /** The camera is none of them any more. */
  clear() {
    element("saved").value = "";
    this.#showChosen();
  }

  #views() { return [kept.get(`cameras ${this.#scene}`)].flat().filter(Boolean).map((view, i) => ({ ...view, name: nameOf(view, i) })); }

  #store(views) { return kept.set(`cameras ${this.#scene}`, views); }

  #show(chosen) {
    const views = this.#views();
    const options = views.map(({ name }, i) => new Option(name, i));
    element("saved").replaceChildren(new Option(views.length ? "choose" : "none", ""), ...options);
    element("saved").value = chosen;
    this.#showChosen();
  }

  #showChosen() { element("delete-camera").disabled = element("saved").value === ""; }

  #add() {
    const views = this.#views();
    // Those that are left keep their names when others are deleted.
    const numbers = views.map(({ name }) => Number(name.replace("view ", "")) || 0);
    const name = `view ${Math.max(0, ...numbers) + 1}`;
    if (!this.#store([...views, { ...this.view(), name }])) return this.say("this browser keeps nothing of this page");
    this.#show(views.length);
    this.say(`saved as ${name}`);
  }

  #delete() {
    const views = this.#views();
    const [chosen] = views.splice(element("saved").value || views.length, 1);
    if (!chosen) return;
    this.#store(views);
    this.#show("");
    this.say(`${chosen.name} is deleted`);
    element("saved").focus(); // the button can be pressed no more
  }
}
