// Recording a plan: what a person is to do, in large letters, and how far it has come.

import {attempt, mayOperate, order} from "./actions.js";
import {byId, make, onSubmit, put, sentence, show} from "./dom.js";
import {tell} from "./link.js";

// What a question offers beside Enter, in its own words, and the answer.
const OFFERS = [[/\bs skips\b/, "Skip", "s"], [/\br repeats\b/, "Repeat", "r"], [/\btype k to keep\b/, "Keep", "k"]];
const TYPED = /\btype x/;  // a reading

let asked = null, advised = "";

/// Answers the question that is shown; what is only advice is confirmed as it is read.
async function answer(text) {
  const question = asked, advice = advised;
  await attempt(() => question ? tell("api/answer", {id: question.id, text}) : tell("api/confirm", {advice}));
  byId("reading").value = "";
}

function offer([, words, text]) {
  const button = make("button", {type: "button"}, words);
  button.addEventListener("click", () => answer(text));
  return button;
}

function showQuestion(question, advice) {
  const text = question ? question.text.replace(/[:\s]+$/, "") : advice || "";
  show("person", text !== "");
  document.body.classList.toggle("guided", !question && text !== "");
  put("person-text", sentence(text));
  advised = advice || "";
  if (asked && question && asked.id === question.id) return;
  asked = question;
  show("reading-label", Boolean(question) && TYPED.test(text));
  byId("offers").replaceChildren(...OFFERS.filter(([words]) => question && words.test(text)).map(offer));
}

function showProgress(recording) {
  show("recorded", Boolean(recording));
  if (!recording) return;
  put("recorded-title", recording.title);
  put("recorded-now", recording.now);
  byId("recorded-counts").replaceChildren(...recording.counts.map(count => make("li", {}, count)));
}

export function showRecording(cell, state) {
  showQuestion(state.question || null, state.advice);
  showProgress(state.recording);
  for (const control of byId("person").querySelectorAll("button, input")) control.disabled = !mayOperate(cell, state);
}

/// Each reading of a monument stays beside the question about the next.
export function heedReading({text}) {
  if (text.startsWith("monument '")) byId("monuments").prepend(make("li", {}, sentence(text)));
}

export const clearReadings = () => byId("monuments").replaceChildren();

onSubmit("person-form", () => answer(byId("reading").value.trim()));
byId("board").addEventListener("change", () => {  // it is one board
  byId("step-board").value = byId("board").value;
  byId("step-board").dispatchEvent(new Event("change"));
});
onSubmit("record-form", () => {
  clearReadings();
  order("api/record", {plan: byId("plan").value, out: byId("recording-name").value, board: byId("board").value || null,
    on_bad_reading: byId("bad-reading").value});
});
