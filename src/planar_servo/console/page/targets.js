// The table of targets: written, run, resumed.

import {attempt, complain, order, setReady} from "./actions.js";
import {byId, fixed, keepText, make, minuteOf, offerFile, offerText, onSubmit, put, show} from "./dom.js";
import {showOnField} from "./field.js";
import {ask, tell} from "./link.js";
import {choose} from "./place.js";
import {kindOf, stateText} from "./results.js";

const SAME_MM = 0.001;

let targets = [], results = new Map(), job = null, whither = "";
let usual = "";  // the tool of targets that name none

function rowOf(target) {
  const result = results.get(target.id) || null;
  const go = make("button", {type: "button", class: "plain"}, target.id);
  go.addEventListener("click", () => choose([target.x_mm, target.y_mm], target.phi_deg, target.tool || usual));
  const number = (value, decimals) => make("td", {class: "number"}, fixed(value, decimals));
  return make("tr", {class: kindOf(result)}, make("th", {scope: "row"}, go), number(target.x_mm, 3),
    number(target.y_mm, 3), number(target.phi_deg, 2), make("td", {class: "state"}, stateText(result)),
    number(result && result.before_own_view_mm, 4), number(result && result.after_own_view_mm, 4));
}

function countText() {
  if (!targets.length) return "none yet";
  const reached = targets.filter(({id}) => kindOf(results.get(id)) === "reached").length;
  return (results.size ? `${reached} of ${targets.length} reached` : `${targets.length}`) + whither;
}

function showTargets() {
  byId("target-rows").replaceChildren(...targets.map(rowOf));
  byId("target-table").classList.toggle("no-phi", targets.every(({phi_deg}) => typeof phi_deg !== "number"));
  put("targets-count", countText());
  put("run", targets.length ? `Run ${targets.length}` : "Run");
  setReady("run", targets.length > 0);
  showOnField(targets, results);
}

/// Offers these names after the first choice, which is none of them; nothing where there are none. Where somebody
/// chooses now, that choice stays, even of one that is gone.
function offer(id, names, kept = byId(id).value) {
  const list = byId(id), chosen = byId("edit").open ? list.value : kept;
  const all = [...new Set([...names, chosen])].filter(Boolean);
  list.replaceChildren(list.options[0], ...all.map(name => make("option", {value: name}, name)));
  list.value = chosen;
  show(`${id}-row`, all.length > 0);
}

export async function loadTargets() {
  const [list, table, rows] = await Promise.all([ask("api/targets"), ask("api/table"), ask("api/results")]);
  for (const row of rows) heed(row);
  targets = list;
  for (const target of targets) if (!isOf(results.get(target.id), target)) results.delete(target.id);
  offerText("csv", table.csv);
  whither = (table.work && `, on ${table.work}`) + (table.tool && `, with ${table.tool}`);
  usual = table.tool;
  offer("on-work", table.works, table.work);
  offer("with-tool", table.tools, table.tool);
  showTargets();
}

/// Whether a result is that of a target where it lies now.
const isOf = (row, {x_mm, y_mm}) => row && Math.hypot(row.x_mm - x_mm, row.y_mm - y_mm) < SAME_MM;

/// A row of the last job, which takes the place of all of the job before. Returns whether it does so now.
function heed(row) {
  const isFirst = row.job !== job;
  if (isFirst) results.clear();
  job = row.job;
  if (row.target) results.set(row.target, row);
  return isFirst;
}

export function addResult(row) {
  if (heed(row)) return showTargets();
  const i = targets.findIndex(({id}) => id === row.target);
  if (i >= 0) byId("target-rows").children[i].replaceWith(rowOf(targets[i]));
  put("targets-count", countText());
  showOnField(targets, results);
}

/// A work may have been found since the page was loaded.
async function refreshChoices() {
  const {works, tools} = await ask("api/table");
  offer("on-work", works);
  offer("with-tool", tools);
}

async function keep() {
  const answer = await order("api/targets",
    {csv: byId("csv").value, work: byId("on-work").value, tool: byId("with-tool").value});
  if (!answer) return;
  keepText("csv");
  await attempt(loadTargets);
  byId("edit").open = false;
}

/// A folder that holds a run is not refused but asked about.
async function run(resume) {
  const out = byId("run-name").value;
  show("run-ask", false);
  try {
    if (JSON.stringify(await ask("api/targets")) !== JSON.stringify(targets)) {
      await loadTargets();
      return complain({fault: "the console had other targets than this page, which shows them now", remedy: "look at them, then run"});
    }
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

byId("run-name").value = `run_${minuteOf(new Date())}`;
onSubmit("run-form", () => run(byId("resume").checked));
byId("run-resume").addEventListener("click", () => run(true));
byId("run-anew").addEventListener("click", runAnew);
onSubmit("targets-form", keep);
offerFile("csv-file", "csv");
byId("edit").addEventListener("toggle", () => byId("edit").open && attempt(refreshChoices));
document.addEventListener("taught", () => attempt(loadTargets));
