// Orders to the server, and who may give them.

import {byId, make, onSubmit, plain, put, sentence, show} from "./dom.js";
import {client, hangUp, tell} from "./link.js";

const LATE_MS = 300;

/// Returns the answer to a question; null after a refusal, which is shown until it is closed or an order succeeds.
export async function attempt(question) {
  try {
    return await question();
  } catch (refusal) {
    if (refusal.fault === undefined) throw refusal;
    complain(refusal);
    return null;
  }
}

export function complain({fault, remedy, where, faults = []}) {
  const many = faults.length > 1;
  put("notice-fault", many ? `${faults.length} faults:` : sentence(where ? `${where}: ${fault}.` : `${fault}.`));
  put("notice-remedy", remedy && !many ? `${sentence(remedy)}.` : "");
  byId("notice-faults").replaceChildren(...(many ? faults : []).map(one =>
    make("li", {}, [one.where, [one.fault, one.remedy].filter(Boolean).join("; ")].filter(Boolean).join(": "))));
  show("notice", true);
}

/// Gives an order and returns its answer; null after a refusal. `known` is as in tell().
export async function order(path, body, known) {
  const answer = await attempt(() => tell(path, body, known));
  put("answer", "");
  if (answer) show("notice", false);
  return answer;
}

/// Gives a command as planar-jog takes it and shows its answer.
export async function command(line) {
  const answer = await order("api/command", {line});
  if (!answer) return false;
  if (answer.done) put("answer", plain(answer.text).replace(/\n/g, "; "));
  else complain({fault: answer.text});
  return answer.done;
}

/// Stops the cell. Where streams of other pages keep all of the browser's connections, this page's own gives way.
export function stop() {
  const late = setTimeout(() => hangUp(), LATE_MS);
  return attempt(() => tell("api/stop")).finally(() => clearTimeout(late));
}

/// Whether this page has the right to operate and nobody else moves the cell.
export const mayOperate = (cell, state) => cell.right === "operate" && (!state.operator || state.operator === client);

/// Whether it may begin something.
export const mayAct = (cell, state) => mayOperate(cell, state) && !(state.job && state.job.ended === null);

let allowed = false;

/// Sets each control that gives an order; `data-unready` on one that lacks what it needs.
export function gate(mayBegin = allowed) {
  allowed = mayBegin;
  for (const control of document.querySelectorAll(".act")) {
    const off = !allowed || control.hasAttribute("data-unready");
    if (control.disabled !== off) control.disabled = off;
  }
}

export function setReady(id, ready) {
  byId(id).toggleAttribute("data-unready", !ready);
  gate();
}

for (const button of document.querySelectorAll("[data-line]"))
  button.addEventListener("click", () => command(button.dataset.line));
onSubmit("line-form", async () => {
  if (byId("line").value.trim() && await command(byId("line").value)) byId("line").select();
});
byId("notice-close").addEventListener("click", () => show("notice", false));
byId("stop").addEventListener("pointerdown", stop);
byId("stop").addEventListener("click", event => event.detail === 0 && stop());  // by keyboard
addEventListener("keydown", event => event.key === "Escape" && stop(), {capture: true});
