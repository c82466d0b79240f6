// The page of planar-console: asks for the cell once, then follows its state.

import {attempt, gate, mayAct, prepareActions} from "./actions.js";
import {addLine, clearLines, prepareBar, showBar, showLost} from "./bar.js";
import {loadCell, prepareCell} from "./cell.js";
import {byId, put, show} from "./dom.js";
import {prepareField, showField} from "./field.js";
import {heedLine, loseJog, prepareJog, showJog} from "./jog.js";
import {ask, follow} from "./link.js";
import {preparePicture, showPictures} from "./picture.js";
import {choose, preparePlace} from "./place.js";
import {clearReadings, heedReading, prepareRecording, showRecording} from "./recording.js";
import {addResult, loadTargets, prepareTargets} from "./targets.js";

let cell, endedJob = null;

/// A job that has ended may have made files and a report.
function heedJob(job) {
  if (!job || job.ended === null || job.id === endedJob) return;
  endedJob = job.id;
  attempt(loadCell);
}

function showState(state) {
  document.body.classList.remove("lost");
  showBar(cell, state);
  showPictures(state);
  showField(state);
  showJog(state);
  showRecording(cell, state);
  heedJob(state.job);
  gate(mayAct(cell, state));
}

function clear() {
  clearLines();
  clearReadings();
}

function showLine(line) {
  addLine(line);
  heedLine(line);
  heedReading(line);
}

function lose(refusal) {
  document.body.classList.add("lost");
  loseJog();
  gate(false);
  showLost(refusal);
}

async function begin() {
  show("old-browser", false);
  show("console", true);
  cell = await attempt(() => ask("/api/cell"));
  if (!cell) return setTimeout(begin, 2000);
  put("cell-name", cell.name);
  document.title = `${cell.name} – planar-console`;
  prepareActions();
  prepareBar();
  preparePicture(cell);
  prepareField(cell, choose);
  preparePlace(cell);
  prepareJog();
  prepareTargets();
  prepareCell();
  prepareRecording();
  gate(false);
  follow({state: showState, line: showLine, result: addResult}, clear, lose);
  attempt(loadTargets);
  attempt(loadCell);
}

begin();
