// The page of planar-console: asks for the cell once, then follows its state.

import {prepareAccuracy, showAccuracy} from "./accuracy.js";
import {attempt, gate, mayAct, mayOperate, prepareActions} from "./actions.js";
import {addLine, clearLines, prepareBar, showBar, showLost} from "./bar.js";
import {loadCell, prepareCell} from "./cell.js";
import {put, show} from "./dom.js";
import {prepareField, showField, showGround} from "./field.js";
import {heedLine, loseJog, prepareJog, showJog} from "./jog.js";
import {ask, follow} from "./link.js";
import {addPass, loadPath, preparePath} from "./path.js";
import {preparePicture, showCamera, showPictures} from "./picture.js";
import {choose, heedMap, preparePlace} from "./place.js";
import {clearReadings, heedReading, prepareRecording, showRecording} from "./recording.js";
import {addResult, loadTargets, prepareTargets} from "./targets.js";

let cell, opened = null, endedJob = null;

function showCell() {
  put("cell-name", cell.name);
  document.title = `${cell.name} – planar-console`;
  showCamera(cell);
  showGround(cell);
  heedMap(cell);
  showAccuracy(cell);
}

/// The console has read the cell's files anew, `count` times by now.
async function heedFiles(count) {
  if (count === opened) return;
  const first = opened === null;
  opened = count;
  if (first) return;
  cell = await attempt(() => ask("api/cell")) || cell;
  showCell();
  attempt(loadCell);
  attempt(loadTargets);  // what was loaded is forgotten with the files
  attempt(loadPath);
}

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
  heedFiles(state.opened);
  gate(mayAct(cell, state));
  document.body.classList.toggle("watching", !mayOperate(cell, state));
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

const showResult = row => (row.target ? addResult : addPass)(row);

function lose(refusal) {
  document.body.classList.add("lost");
  loseJog();
  gate(false);
  showLost(refusal);
}

async function begin() {
  show("old-browser", false);
  show("console", true);
  cell = await attempt(() => ask("api/cell"));
  if (!cell) return setTimeout(begin, 2000);
  prepareActions();
  prepareBar();
  preparePicture();
  prepareField(choose);
  preparePlace();
  showCell();
  prepareJog();
  prepareTargets();
  preparePath();
  prepareCell();
  prepareRecording();
  prepareAccuracy();
  gate(false);
  follow({state: showState, line: showLine, result: showResult}, clear, lose);
  attempt(loadTargets);
  attempt(loadPath);
  attempt(loadCell);
}

begin();
