// The page of planar-console: follows the state of its cell.

import {showAccuracy} from "./accuracy.js";
import {attempt, gate, mayAct, mayOperate} from "./actions.js";
import {addLine, clearLines, showBar, showLost} from "./bar.js";
import {loadCell} from "./cell.js";
import {put, show} from "./dom.js";
import {showField, showGround} from "./field.js";
import {heedLine, loseJog, showJog} from "./jog.js";
import {follow} from "./link.js";
import {addPass, loadPath} from "./path.js";
import {losePicture, showCamera, showPictures} from "./picture.js";
import {heedMap} from "./place.js";
import {clearReadings, heedReading, showRecording} from "./recording.js";
import {addResult, loadTargets} from "./targets.js";

let cell, seq = 0, endedJob = null;

function begin(ofCell) {
  cell = ofCell;
  put("cell-name", cell.name);
  document.title = `${cell.name} – planar-console`;
  showCamera(cell);
  showGround(cell);
  heedMap(cell);
  showAccuracy(cell);
  clearLines();
  clearReadings();
  for (const load of [loadTargets, loadPath, loadCell]) attempt(load);
}

/// A job that has ended may have made files and a report.
function heedJob(job) {
  if (!job || job.ended === null || job.id === endedJob) return;
  endedJob = job.id;
  attempt(loadCell);
}

function showState(state) {
  if (state.seq < seq) return location.reload();  // another console answers at this address
  seq = state.seq;
  document.body.classList.remove("lost");
  showBar(cell, state);
  showPictures(state);
  showField(state);
  showJog(state);
  showRecording(cell, state);
  heedJob(state.job);
  gate(mayAct(cell, state));
  document.body.classList.toggle("watching", !mayOperate(cell, state));
}

function showLine(line) {
  addLine(line);
  heedLine(line);
  heedReading(line);
}

const showResult = row => (row.target ? addResult : addPass)(row);

function lose(refusal) {
  document.body.classList.add("lost");
  loseJog();
  losePicture();
  gate(false);
  showLost(refusal);
}

show("old-browser", false);
show("console", true);
follow({state: showState, line: showLine, result: showResult}, begin, lose);
