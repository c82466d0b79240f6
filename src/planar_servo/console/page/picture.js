// The live picture with what is seen in it, the lamps close up, exposure and sharpness.

import {command} from "./actions.js";
import {byId, draw, fixed, make, numberIn, onSubmit, put, show} from "./dom.js";

const STALE_S = 3;
let loading = false, size = {width_px: 1, height_px: 1};
let shown = {seq: 0};  // the picture in view: its number, and when it was taken by the clock of this page

/// Returns whether the picture is there; where it is gone, the next one follows.
function load(image, address) {
  image.src = address;
  return image.decode().then(() => true, () => false);
}

/// Shows the newest picture once the one before is there; none while nobody looks.
async function showPicture({picture, lamps}) {
  const age_s = shown.seq ? (performance.now() - shown.taken_ms) / 1000 : 0;
  show("no-picture", !shown.seq);
  put("picture-age", age_s >= STALE_S ? `${fixed(age_s, 0)} s old` : "");
  byId("frame").classList.toggle("stale", age_s >= STALE_S);
  if (loading || document.hidden || picture.seq === shown.seq) return;
  loading = true;
  const next = {seq: picture.seq, taken_ms: performance.now() - 1000 * picture.age_s};
  const all = [load(byId("whole"), `api/picture.jpg?seq=${next.seq}`)];
  if (lamps) for (const n of [1, 2]) all.push(load(byId(`lamp-${n}`), `api/lamp/${n}.jpg?seq=${next.seq}`));
  if ((await Promise.all(all))[0]) shown = next;
  loading = false;
}

/// A picture that was on its way may never come.
export function losePicture() {
  loading = false;
}

/// Right of a place, or left of it near the picture's right edge.
const besideX = (x, by) => x < size.width_px * 0.9 ? {x: x + by} : {x: x - by, "text-anchor": "end"};

function crossAt(x, y, arm, name, label) {
  const gap = arm / 3;
  const d = `M${x - arm} ${y}h${arm - gap}m${2 * gap} 0h${arm - gap}M${x} ${y - arm}v${arm - gap}m0 ${2 * gap}v${arm - gap}`;
  return [draw("path", {d, class: name}), draw("text", {x, y: y - arm * 1.3, "text-anchor": "middle", class: name}, label)];
}

function showCrosses({lamps, fixed_lamps}) {
  const arm = size.width_px / 56;
  const marks = (lamps || []).flatMap(({x_px, y_px, saturated}, i) =>
    crossAt(x_px, y_px, arm, saturated ? "saturated" : "found", `${i + 1}`));
  for (const {id, x_px, y_px} of fixed_lamps)
    marks.push(draw("circle", {cx: x_px, cy: y_px, r: arm / 2, class: "fixed"}),
      draw("text", {...besideX(x_px, arm * 0.7), y: y_px, class: "fixed"}, id));
  const svg = byId("crosses");
  svg.replaceChildren(svg.firstElementChild, ...marks);
}

function lampText(lamp, i) {
  if (!lamp) return `Lamp ${i + 1}: not seen`;
  return `Lamp ${i + 1}: ${fixed(lamp.x_px, 1)}, ${fixed(lamp.y_px, 1)} px${lamp.saturated ? ", saturated" : ""}`;
}

function showLamps({lamps, sharpness, fixed_lamps}) {
  [0, 1].forEach(i => {
    const lamp = lamps && lamps[i];
    put(`lamp-${i + 1}-text`, lampText(lamp, i));
    byId(`lamp-${i + 1}`).parentElement.classList.toggle("empty", !lamp);
    byId(`lamp-${i + 1}-text`).classList.toggle("warning", Boolean(lamp && lamp.saturated));
  });
  put("edge", sharpness ? fixed(sharpness.edge_px, 2) : "–");
  put("edge-best", sharpness ? fixed(sharpness.best_px, 2) : "–");
  byId("edge-bar").value = sharpness ? sharpness.best_px / sharpness.edge_px : 0;
  show("fixed", fixed_lamps.length > 0);
  byId("fixed-lamps").replaceChildren(...fixed_lamps.map(({id, moved_px}) =>
    make("li", {}, make("span", {}, id), make("span", {class: "number"}, fixed(moved_px, 2)), " px")));
}

/// Fills the inputs unless somebody is changing them.
function showExposure(exposure) {
  if (!exposure || "changed" in form.dataset || form.contains(document.activeElement)) return;
  byId("exposure").value = exposure.exposure_us.toFixed(0);
  byId("gain").value = exposure.gain_db.toFixed(1);
}

export function showPictures(state) {
  showPicture(state);
  showCrosses(state);
  showLamps(state);
  showExposure(state.exposure);
}

/// Takes a cell whose files were read anew.
export function showCamera(cell) {
  size = cell.camera;
  const svg = byId("crosses");
  svg.setAttribute("viewBox", `0 0 ${size.width_px} ${size.height_px}`);
  svg.setAttribute("font-size", size.width_px / 36);
  byId("frame").style.setProperty("--ratio", size.width_px / size.height_px);
}

byId("brighten").addEventListener("change", event => byId("frame").classList.toggle("bright", event.target.checked));
byId("optics").open = !matchMedia("(max-width: 560px)").matches;  // a phone shows picture and jog in one view
const form = byId("exposure-form");
form.addEventListener("input", () => { form.dataset.changed = ""; });
onSubmit("exposure-form", async () => {
  const gain = numberIn("gain");
  if (await command(`exposure ${byId("exposure").value} ${gain === null ? "" : gain}`.trim())) delete form.dataset.changed;
});
