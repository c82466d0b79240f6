// Moving by hand. A motion lasts while a button or key is held: the server stops it when this page falls silent.

import {command, complain, order, stop} from "./actions.js";
import {byId, onSubmit, put, show, sentence} from "./dom.js";
import {stops, tell} from "./link.js";

const KEEP_MS = 80;  // the server waits for 200
const MOST_UNANSWERED = 2;  // behind more of them a stop would have to wait
const TAP_MS = 250;  // a shorter press is a tap, which moves one whole step
const TAP_LASTS_MS = 3000;
const REPEAT_MS = 1200;  // a keyboard repeats a held key after a second at the latest
const MODIFIERS = ["Shift", "Control", "Alt", "AltGraph", "Meta"];
const FARTHEST_TURN_DEG = 15;  // of one command
const KEYS = {arrowright: "x +", arrowleft: "x -", arrowup: "y +", arrowdown: "y -", q: "joint 1 +", a: "joint 1 -",
  w: "joint 2 +", s: "joint 2 -", e: "joint 3 +", d: "joint 3 -"};

let pressed = null;  // the newest press: {motion, code, known, heard, since, down, kept, begun, over}
let moving = null;   // the step under way: {hold, seq, end}
let before = Promise.resolve();  // the end of all presses before
let dropped = before;  // the answer to the last stop by drop(), which stops nothing that is pressed later

const step = () => document.querySelector("input[name=step]:checked").value;
const lineOf = motion => motion.slice(0, -1) + (motion.endsWith("-") ? "-" : "") +
  (motion.startsWith("joint") ? Math.min(step(), FARTHEST_TURN_DEG) : step());

/// A key is held as long as it repeats, once it is no tap; a button has no code.
function isHeld(hold) {
  if (hold.down && hold.code && performance.now() - hold.heard > REPEAT_MS) drop();
  return hold.kept;
}

/// Moves one step, and keeps it alive until it has ended or is let go. Returns whether another may follow. After a stop,
/// whoever orders it, no step of a press from before it begins.
async function moveStep(hold) {
  const begun = await order("api/jog", {line: lineOf(hold.motion)}, await hold.known);
  if (!begun) return false;
  let unanswered = 0;
  const keep = async () => {
    if (!isHeld(hold) || unanswered === MOST_UNANSWERED) return;
    ++unanswered;
    await tell("api/jog/keep").catch(() => {});
    --unanswered;
  };
  const beat = setInterval(keep, KEEP_MS);
  keep();
  const good = await new Promise(end => { moving = {hold, seq: begun.seq, end}; });
  clearInterval(beat);
  moving = null;
  return good;
}

async function follow(hold) {
  hold.begun = true;
  while (hold.kept && await moveStep(hold) && hold.down);
  hold.over = true;
}

/// One press may wait for the step before to end, so that fast taps are not lost.
function press(motion, code) {
  if (pressed && !pressed.over && (pressed.down || !pressed.begun)) return;
  const now = performance.now();
  const known = dropped.then(() => stops);
  const hold = {motion, code, known, heard: now, since: now, down: true, kept: true, begun: false, over: false};
  pressed = hold;
  put("cut-short", "");
  before = before.then(() => follow(hold));
}

/// Ends the motion now.
function drop() {
  for (const hold of [moving && moving.hold, pressed]) if (hold) hold.down = hold.kept = false;
  if (moving) dropped = stop();
}

function letGo() {
  if (!pressed || !pressed.down) return;
  const hold = pressed;
  hold.down = false;
  if (performance.now() - hold.since >= TAP_MS) drop();
  else setTimeout(() => hold.over || drop(), TAP_LASTS_MS);
}

/// Ends a step that the state no longer shows, and tells what the arm needs first.
export function showJog(state) {
  if (moving && state.doing !== "moving" && (moving.seq === undefined || state.seq > moving.seq)) moving.end(true);
  const needs = state.arm ? state.arm.to_do : "";
  put("to-do", needs ? sentence(needs) : "");
  show("to-do", Boolean(needs));
}

/// A step that is refused is told, and none follows it.
export function heedLine({level, text}) {
  if (level === "info" || !pressed || pressed.over) return;
  put("cut-short", sentence(text));
  if (pressed.kept) complain({fault: text});
  pressed.down = false;
}

/// The line to the server is lost, which stops the arm by itself.
export function loseJog() {
  drop();
  if (moving) moving.end(false);
}

function prepareButton(button) {
  button.addEventListener("pointerdown", event => {
    if (event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    press(button.dataset.jog);
  });
  for (const end of ["pointerup", "lostpointercapture"]) button.addEventListener(end, letGo);
  button.addEventListener("pointercancel", drop);  // the browser took the touch for another gesture
  button.addEventListener("contextmenu", event => event.preventDefault());  // of a long touch
  button.addEventListener("click", event => {
    if (event.detail > 0) return;
    press(button.dataset.jog);  // by keyboard: a tap
    letGo();
  });
}

function changeStep(by) {
  const steps = [...document.querySelectorAll("input[name=step]")];
  const next = steps[steps.findIndex(one => one.checked) + by];
  if (next) next.checked = true;
}

/// Letters change with modifiers and layouts while a key is held; its code does not.
function keyDown(event) {
  if (pressed && pressed.down && pressed.code) {
    if (event.repeat && event.code === pressed.code) pressed.heard = performance.now();
    else if (event.code !== pressed.code || MODIFIERS.includes(event.key)) drop();
  }
  if (event.target.matches("input,textarea,select") || event.ctrlKey || event.altKey || event.metaKey) return;
  const key = event.key.toLowerCase(), motion = KEYS[key];
  if (key === "+" || key === "-") changeStep(key === "+" ? 1 : -1);
  if (!motion) return;
  event.preventDefault();
  if (!event.repeat && !byId("jog").querySelector("[data-jog]").disabled) press(motion, event.code);
}

function keyUp(event) {
  if (!pressed || !pressed.down || !pressed.code) return;
  if (event.code === pressed.code) letGo();
  else drop();
}

const panel = byId("jog");
panel.querySelectorAll("[data-jog]").forEach(prepareButton);
panel.addEventListener("keydown", keyDown);
panel.addEventListener("keyup", keyUp);
panel.addEventListener("focusin", () => put("keys-on", "Keys move the arm"));
panel.addEventListener("focusout", event => {
  if (panel.contains(event.relatedTarget)) return;
  put("keys-on", "Click here to use keys");
  drop();
});
byId("steps").addEventListener("click", event => event.detail > 0 && panel.focus());  // else arrows change the step
onSubmit("teach-form", async () => {
  const id = byId("teach-id").value.trim();
  if (id && await command(`teach ${id}`)) document.dispatchEvent(new Event("taught"));
});
addEventListener("blur", drop);
addEventListener("pagehide", drop);
document.addEventListener("visibilitychange", () => document.hidden && drop());
