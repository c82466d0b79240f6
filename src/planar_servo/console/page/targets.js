// The table of targets: written, run, resumed.

import {attempt, complain, order, setReady} from "./actions.js";
import {byId, fixed, make, minuteOf, offerFile, put, show} from "./dom.js";
import {showOnField} from "./field.js";
import {ask, tell} from "./link.js";
import {choose} from "./place.js";
import {kindOf, stateText} from "./results.js";

let targets = [], results = new Map(), job = null;

function rowOf(target) {
  const result = results.get(target.id) || null;
  const go = make("button", {type: "button", class: "plain"}, target.id);
  go.addEventListener("click", () => choose([target.x_mm, target.y_mm], target.phi_deg));
  const number = (value, decimals) => make("td", {class: "number"}, fixed(value, decimals));
  return make("tr", {class: kindOf(result)}, make("th", {scope: "row"}, go), number(target.x_mm, 3),
    number(target.y_mm, 3), number(target.phi_deg, 2), make("td", {class: "state"}, stateText(result)),
    number(result && result.before_own_view_mm, 4), number(result && result.after_own_view_mm, 4));
}

function countText() {
  if (!targets.length) return "none yet";
  const reached = targets.filter(({id}) => kindOf(results.get(id)) === "reached").length;
  return results.size ? `${reached} of ${targets.length} reached` : `${targets.length}`;
}

function showTargets() {
  byId("target-rows").replaceChildren(...targets.map(rowOf));
  byId("target-table").classList.toggle("no-phi", targets.every(({phi_deg}) => typeof phi_deg !== "number"));
  put("targets-count", countText());
  put("run", targets.length ? `Run ${targets.length}` : "Run");
  setReady("run", targets.length > 0);
  showOnField(targets, results);
}

const csvOf = list => "id,x_mm,y_mm,phi_deg\n" + list.map(({id, x_mm, y_mm, phi_deg}) =>
  [id, x_mm, y_mm, phi_deg === null || phi_deg === undefined ? "" : phi_deg].join(",") + "\n").join("");

function take(list) {
  targets = list;
  if (!byId("csv").matches(":focus")) byId("csv").value = csvOf(list);
  showTargets();
}

export async function loadTargets() {
  const [list, rows] = await Promise.all([ask("api/targets"), ask("api/results")]);
  for (const row of rows) heed(row);
  take(list);
}

/// A row of the last job, which takes the place of all of the job before.
function heed(row) {
  if (row.job !== job) results.clear();
  job = row.job;
  if (row.target) results.set(row.target, row);
}

export function addResult(row) {
  heed(row);
  const i = targets.findIndex(({id}) => id === row.target);
  if (i >= 0) byId("target-rows").children[i].replaceWith(rowOf(targets[i]));
  put("targets-count", countText());
  showOnField(targets, results);
}

async function keep(event) {
  event.preventDefault();
  const answer = await order("api/targets", {csv: byId("csv").value});
  if (!answer) return;
  results.clear();
  take(answer.targets);
  byId("edit").open = false;
}

/// A folder that holds a run is not refused but asked about.
async function run(resume) {
  const out = byId("run-name").value;
  show("run-ask", false);
  try {
    job = (await tell("api/run", {out, resume, judged: false})).job;
    if (!resume) results.clear();
    showTargets();
  } catch (refusal) {
    const holds = /holds a run already/.test(refusal.fault);
    if (!holds) return complain(refusal);
    put("run-ask-text", `${out} holds a run already.`);
    show("run-ask", true);
  }
}

function runAnew() {
  byId("run-name").value = `run_${minuteOf(new Date())}_${new Date().getSeconds()}`;
  run(false);
}

export function prepareTargets() {
  byId("run-name").value = `run_${minuteOf(new Date())}`;
  byId("run-form").addEventListener("submit", event => {
    event.preventDefault();
    run(byId("resume").checked);
  });
  byId("run-resume").addEventListener("click", () => run(true));
  byId("run-anew").addEventListener("click", runAnew);
  byId("targets-form").addEventListener("submit", keep);
  offerFile("csv-file", "csv");
  document.addEventListener("taught", () => attempt(loadTargets));
}
