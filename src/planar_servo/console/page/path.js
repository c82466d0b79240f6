// A path: written, drawn, followed.

import {order, setReady} from "./actions.js";
import {byId, fixed, keepText, make, minuteOf, offerFile, offerText, onSubmit, put, show} from "./dom.js";
import {showPath} from "./field.js";
import {ask} from "./link.js";
import {kindOf, stateText} from "./results.js";

const EXAMPLE = "x_mm,y_mm,via_x_mm,via_y_mm\n";
const GUIDES = {arm: "the arm alone", vision: "vision"};

let job = null;

function take({csv, length_mm, places_mm}) {
  offerText("path-csv", csv || EXAMPLE);
  put("path-length", places_mm.length ? `${fixed(length_mm, 1)} mm` : "none yet");
  setReady("follow", places_mm.length > 0);
  showPath(places_mm);
}

/// One pass over the path, as it was seen.
export function addPass(row) {
  if (row.job !== job) byId("path-rows").replaceChildren();
  job = row.job;
  const number = (value, decimals) => make("td", {class: "number"}, fixed(value, decimals));
  byId("path-rows").append(make("tr", {class: kindOf(row)}, number(row.speed_mm_s, 1),
    make("td", {}, GUIDES[row.guided_by] || row.guided_by), make("td", {class: "state"}, stateText(row)),
    number(row.deviation_mean_mm_own_view, 4), number(row.deviation_max_mm_own_view, 4)));
  show("path-results", true);
}

export async function loadPath() {
  const [path, rows] = await Promise.all([ask("api/path"), ask("api/results")]);
  take(path);
  const passes = rows.filter(({guided_by}) => guided_by);
  if (passes.length) byId("path-rows").replaceChildren();
  passes.forEach(addPass);
}

async function keep() {
  const csv = byId("path-csv").value;
  const path = await order("api/path", {csv: csv.trim() === EXAMPLE.trim() ? "" : csv});
  if (!path) return;
  keepText("path-csv");
  take(path);
  byId("path-edit").open = false;
}

function follow() {
  order("api/follow", {out: byId("path-name").value, speeds_mm_s: [byId("path-speed").valueAsNumber],
    guided_by: byId("guided-by").value.split(",")});
}

byId("path-name").value = `path_${minuteOf(new Date())}`;
setReady("follow", false);
onSubmit("follow-form", follow);
onSubmit("path-form", keep);
offerFile("path-file", "path-csv");
