// A place that somebody chose: whether it can be reached, how well, and going there as a second step.

import {attempt, order, setReady} from "./actions.js";
import {byId, fixed, numberIn, onSubmit, placeText, put} from "./dom.js";
import {markPlace, placeAt} from "./field.js";
import {ask} from "./link.js";

let hasMap = false, tool = "";
let asked = 0;  // the number of the newest question
let examined;   // the place that Go there goes to

const placeOf = () => ({x_mm: numberIn("place-x"), y_mm: numberIn("place-y"), phi_deg: numberIn("place-phi")});
const known = place => Object.fromEntries(Object.entries(place).filter(([, value]) => value !== null));

function textOf(place, answer) {
  const parts = [placeText([place.x_mm, place.y_mm]) + (tool && ` for the tip of ${tool}`)];
  parts.push(answer.reachable ? answer.barred ? `is reached by a way round, since ${answer.barred}` : "can be reached" : `cannot be reached: ${answer.why}`);
  if (answer.sigma_mm !== null) parts.push(`expected uncertainty ${fixed(answer.sigma_mm, 4)} mm per axis`);
  if (answer.error_mm) parts.push(`vision errs by ${fixed(answer.error_mm[0], 3)}, ${fixed(answer.error_mm[1], 3)} mm`);
  if (hasMap && !answer.in_region) parts.push("outside the valid region of the map");
  return parts.join("; ");
}

async function examine() {
  const place = placeOf(), mine = ++asked;
  setReady("go", false);
  if (![place.x_mm, place.y_mm, place.phi_deg ?? 0].every(Number.isFinite)) {
    put("place", "A place needs x and y in millimetres, and φ in degrees or none");
    return;
  }
  markPlace([place.x_mm, place.y_mm]);
  const wanted = {...known(place), tool};
  const answer = await attempt(() => ask(`api/place?${new URLSearchParams(wanted)}`));
  if (!answer || mine !== asked) return;
  markPlace([place.x_mm, place.y_mm], answer.way_mm);
  put("place", textOf(place, answer));
  byId("place").classList.toggle("warning", !answer.reachable || (hasMap && !answer.in_region));
  examined = wanted;
  setReady("go", answer.reachable);
}

/// Chooses a place in mm; nothing moves.
export function choose([x, y], phi_deg = null, withTool = "") {
  tool = withTool;
  byId("place-x").value = x.toFixed(3);
  byId("place-y").value = y.toFixed(3);
  if (phi_deg !== null) byId("place-phi").value = phi_deg;
  examine();
}

export function heedMap(cell) {
  hasMap = cell.map !== null;
}

setReady("go", false);
byId("field-view").addEventListener("click", event => choose(placeAt(event)));
onSubmit("place-form", examine);
byId("place-form").addEventListener("input", () => {
  ++asked;
  setReady("go", false);
});
byId("go").addEventListener("click", () => order("api/go", examined));
