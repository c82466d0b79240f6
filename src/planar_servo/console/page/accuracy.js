// What a cell reaches: its certificate, and experiments on a virtual one.

import {order} from "./actions.js";
import {byId, dayOf, onSubmit, put, show} from "./dom.js";
import {clearReadings} from "./recording.js";

// Five poses, then three of them from four sides, as certificate_moves() makes them.
const MOVES_IN_CYCLE = 17;

const number = id => byId(id).valueAsNumber;

function showSize() {
  const moves = number("cycles") * MOVES_IN_CYCLE + number("certified-targets");
  put("certificate-size", (moves ? `${moves} moves. ` : "") + "The same folder, cycles and targets continue one that was broken off.");
}

export const showAccuracy = cell => show("experiment", cell.virtual);

byId("certificate-name").value = `certificate_${dayOf(new Date())}`;
showSize();
byId("certificate-form").addEventListener("input", showSize);
onSubmit("certificate-form", () => {
  clearReadings();
  order("api/certificate", {out: byId("certificate-name").value, cycles: number("cycles"), targets: number("certified-targets")});
});
byId("experiment-name").value = `experiment_${dayOf(new Date())}`;
onSubmit("experiment-form", () => order("api/experiment", {out: byId("experiment-name").value}));
