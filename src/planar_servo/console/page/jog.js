// Moving by hand. A motion lasts while a button or key is held: the server stops it when this page falls silent.

import {command, order, stop} from "./actions.js";
import {byId, put, show, sentence} from "./dom.js";
import {tell} from "./link.js";

const KEEP_MS = 80;  // the server waits for 200
const TAP_MS = 250;  // a shorter press is a tap, which moves one whole step
const TAP_LASTS_MS = 3000;
const KEYS = {arrowright: "x +", arrowleft: "x -", arrowup: "y +", arrowdown: "y -", q: "joint 1 +", a: "joint 1 -",
  w: "joint 2 +", s: "joint 2 -", e: "joint 3 +", d: "joint 3 -"};

let held = null;  // {motion, source, since, down, kept}
let endStep = () => {};

const step = () => document.querySelector("input[name=step]:checked").value;
const lineOf = motion => motion.replace(/([+-])$/, (_, sign) => (sign === "-" ? "-" : "") + step());

/// Moves one step, and keeps it alive until it has ended or is let go.
async function moveStep(hold) {
  const ended = new Promise(resolve => { endStep = resolve; });
  const begun = await order("/api/jog", {line: lineOf(hold.motion)});
  if (!begun) return false;
  hold.seq = begun.seq;
  hold.moving = true;
  const keep = () => hold.kept && tell("/api/jog/keep").catch(() => {});
  keep();
  const beat = setInterval(keep, KEEP_MS);
  const good = await ended;
  clearInterval(beat);
  hold.moving = false;
  return good;
}

async function press(motion, source) {
  if (held) return;
  const hold = {motion, source, since: performance.now(), down: true, kept: true};
  held = hold;
  while (hold.down && hold.kept) if (!await moveStep(hold)) break;
  if (held === hold) held = null;
}

function letGo() {
  if (!held || !held.down) return;
  held.down = false;
  if (performance.now() - held.since < TAP_MS) setTimeout(drop, TAP_LASTS_MS, held);
  else drop(held);
}

/// Ends the motion now.
function drop(hold = held) {
  if (!hold || !hold.kept || hold !== held) return;
  hold.down = hold.kept = false;
  if (hold.moving) stop();
}

/// Ends a step that the state no longer shows, and tells what the arm needs first.
export function showJog(state) {
  if (held && held.moving && state.doing !== "moving" && (held.seq === undefined || state.seq > held.seq)) endStep(true);
  const needs = state.arm ? state.arm.to_do : "";
  put("to-do", needs ? sentence(needs) : "");
  show("to-do", Boolean(needs));
}

/// The line to the server is lost: it stops the arm by itself.
export function dropJog() {
  drop();
  endStep(false);
}

function prepareButton(button) {
  button.addEventListener("pointerdown", event => {
    if (event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    press(button.dataset.jog, button);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) button.addEventListener(end, letGo);
  button.addEventListener("contextmenu", event => event.preventDefault());  // of a long touch
  button.addEventListener("click", event => event.detail === 0 && command(lineOf(button.dataset.jog)));
}

function changeStep(by) {
  const steps = [...document.querySelectorAll("input[name=step]")];
  const next = steps[steps.findIndex(one => one.checked) + by];
  if (next) next.checked = true;
}

function keyDown(event) {
  if (event.target.matches("input,textarea,select") || event.ctrlKey || event.altKey || event.metaKey) return;
  const key = event.key.toLowerCase(), motion = KEYS[key];
  if (key === "+" || key === "-") changeStep(key === "+" ? 1 : -1);
  if (!motion) return;
  event.preventDefault();
  if (!event.repeat && !byId("jog").querySelector("[data-jog]").disabled) press(motion, key);
}

export function prepareJog() {
  const panel = byId("jog");
  panel.querySelectorAll("[data-jog]").forEach(prepareButton);
  panel.addEventListener("keydown", keyDown);
  panel.addEventListener("keyup", event => held && held.source === event.key.toLowerCase() && letGo());
  panel.addEventListener("focusin", () => put("keys-on", "Keys move the arm"));
  panel.addEventListener("focusout", event => {
    if (panel.contains(event.relatedTarget)) return;
    put("keys-on", "Click here to use keys");
    drop();
  });
  byId("steps").addEventListener("click", event => event.detail > 0 && panel.focus());  // else arrows change the step
  byId("teach-form").addEventListener("submit", async event => {
    event.preventDefault();
    const id = byId("teach-id").value.trim();
    if (id && await command(`teach ${id}`)) document.dispatchEvent(new Event("taught"));
  });
  addEventListener("blur", () => drop());
  addEventListener("pagehide", () => drop());
  document.addEventListener("visibilitychange", () => document.hidden && drop());
}
