// What is always in view: the state, progress, who moves the cell; and the doubts and messages.

import {order} from "./actions.js";
import {byId, duration, make, plain, put, sentence, show} from "./dom.js";
import {client} from "./link.js";

const LONG_S = 2;  // a state younger than this needs no age
const MOST_LINES = 200;
const SURE_MS = 5000;  // in which taking over is confirmed

/// The doubts, and what holds the cell where none of them says so.
function doubtsOf({doubts, held_by: holder}) {
  if (!holder || doubts.some(({fault}) => holder.includes(fault))) return doubts;
  return [{fault: holder, remedy: "", where: ""}, ...doubts];
}

function showWork(state) {
  const long = state.doing !== "idle" && state.since_s >= LONG_S ? duration(state.since_s) : "";
  const checks = state.checking_mm !== null && state.doing === "running";
  byId("lamp").dataset.doing = state.held_by ? "doubt" : state.doing;
  put("state-text", state.held_by && state.doing === "idle" ? "Held by a doubt" :
    checks ? "Checking the cell" : sentence(state.text || state.doing));
  put("state-age", long);
}

function progressText(job) {
  const name = job.name || job.kind;
  if (job.ended !== null) return `${name}: ${plain(job.ended)}`;
  const left = job.left_s === null ? "" : `, ${duration(job.left_s)} left`;
  const unit = job.kind === "path" ? " mm" : "";
  return job.all ? `${job.done} of ${job.all}${unit}${left}` : `${name}${left}`;
}

function showProgress(job) {
  show("progress", job !== null);
  if (!job) return;
  const bar = byId("progress-bar");
  bar.hidden = job.ended !== null;
  bar.max = job.all || 1;
  if (job.all) bar.value = job.done;
  else bar.removeAttribute("value");
  put("progress-text", progressText(job));
  byId("progress-text").title = progressText(job);  // where it is cut
}

function operatorText(cell, state) {
  if (cell.right !== "operate") return "You read; the other address moves";
  if (!state.operator) return "Nobody moves this cell";
  return state.operator === client ? "You move this cell" : "Another page moves this cell";
}

function showOperator(cell, state) {
  const button = byId("take");
  const mine = state.operator === client;
  put("operator-text", operatorText(cell, state));
  show("take", cell.right === "operate" && state.operator !== null);
  if (!("sure" in button.dataset)) put("take", mine ? "Release" : "Take over");
  button.dataset.mine = mine;
}

/// Taking over from another page takes a second press.
async function takeOver() {
  const button = byId("take");
  if (button.dataset.mine === "true") return order("api/operator", {take: false});
  if ("sure" in button.dataset) {
    delete button.dataset.sure;
    return order("api/operator", {take: true});
  }
  button.dataset.sure = "";
  put("take", "Stop and take over?");
  setTimeout(() => delete button.dataset.sure, SURE_MS);
}

function showDoubts(doubts) {
  show("doubts", doubts.length > 0);
  const list = byId("doubt-list");
  const seen = JSON.stringify(doubts);
  if (list.dataset.seen === seen) return;
  list.dataset.seen = seen;
  list.replaceChildren(...doubts.map(({fault, remedy, where}) =>
    make("li", {}, make("p", {class: "fault"}, sentence(fault), ...(where ? [" ", make("code", {}, where)] : [])),
      ...(remedy ? [make("p", {class: "remedy"}, sentence(remedy))] : []))));
}

export function showBar(cell, state) {
  showWork(state);
  showProgress(state.job);
  showOperator(cell, state);
  showDoubts(doubtsOf(state));
}

export function showLost({fault, remedy}) {
  byId("lamp").dataset.doing = "lost";
  put("state-age", "");
  put("state-text", sentence([fault, remedy].filter(Boolean).join("; ")));
}

export function addLine({t, level, text}) {
  const list = byId("lines");
  const time = new Date(t).toLocaleTimeString([], {hour12: false});
  list.prepend(make("li", {class: level}, make("time", {}, time), " ",
    make("span", {}, (level === "info" ? "" : `${sentence(level)}: `) + plain(text))));
  while (list.children.length > MOST_LINES) list.lastChild.remove();
}

export const clearLines = () => byId("lines").replaceChildren();

byId("take").addEventListener("click", takeOver);
