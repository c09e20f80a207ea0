// Keys, wherever the focus is: what a focused control needs of the keyboard it keeps.

import { kept } from "./kept.js";
import { element } from "./panel.js";

/** What moves the focus, or what a control does with it. */
const ANY_CONTROL = /^(Tab|Enter| |Escape|Arrow.*|Home|End|PageUp|PageDown)$/;
/** A list is searched by what is typed. */
const LIST = /^[\p{L}\p{N}]$/u;
/** What speech and stray hands type: by choice it acts in the picture alone (WCAG 2.1.4). */
const SIGN = /^\S$/u;
const CHOICE = "keys in the picture alone";

/** acts: keys, by their lower case; digit(n); save(); restart(), where no control takes Space; layer(), in the
 * picture, and whether there is another. */
export function watchKeys(stage, acts) {
  const picture = element("picture");
  const alone = element("keys-alone");
  alone.checked = kept.get(CHOICE) === true;
  alone.addEventListener("change", () => kept.set(CHOICE, alone.checked));
  addEventListener("keydown", (event) => {
    const modified = event.ctrlKey || event.metaKey || event.altKey;
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "s") acts.save();
    else if (modified || element("help").open || !press(event)) return;
    event.preventDefault();
  });
  addEventListener("keyup", (event) => stage.lift(event));
  addEventListener("blur", () => stage.letGo());

  /** Whether the key meant something. */
  function press(event) {
    const focused = document.activeElement ?? document.body;
    const inPicture = focused === picture || focused === document.body;
    if (event.key === "Escape") return escape(focused);
    if (alone.checked && focused !== picture && SIGN.test(event.key)) return false;
    if (!inPicture && keeps(focused, event.key)) return false;
    if (stage.press(event)) return true;
    if (focused === picture && event.key === "Tab" && !event.shiftKey) return acts.layer();
    const act = event.key === " " ? acts.restart : acts.keys[event.key] ?? acts.keys[event.key.toLowerCase()];
    if (/^[1-9]$/.test(event.key)) acts.digit(Number(event.key));
    else if (act) act();
    else return false;
    return true;
  }

  function keeps(control, key) {
    return ANY_CONTROL.test(key) || (control.tagName === "SELECT" && LIST.test(key));
  }

  /** Out of the picture, and from everywhere else into it. */
  function escape(focused) {
    if (stage.cancel()) return true;
    const control = document.querySelector("#panel :is(button, select, input):enabled") ?? element("panel");
    (focused === picture ? control : picture).focus();
    return true;
  }
}
