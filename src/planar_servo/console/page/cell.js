// The cell's files and what they were made from, what is next, its health, and the reports of earlier runs.

import {attempt, order} from "./actions.js";
import {byId, make, onSubmit, put, show} from "./dom.js";
import {ask} from "./link.js";

const day = made => made ? made.replace("T", " ").replace(/(:\d\d)(:\d\d)?(\.\d+)?Z?$/, "$1") : "–";

function fileRow({role, path, exists, made, program, fault}) {
  const state = !exists ? "missing" : fault ? [fault.fault, fault.remedy].filter(Boolean).join("; ") : program || "–";
  return make("tr", {class: fault ? "failed" : exists ? "" : "missing"},
    make("th", {scope: "row"}, path, make("span", {class: "soft"}, ` ${role.replace("_", " ")}`)),
    make("td", {class: "number"}, exists ? day(made) : "–"), make("td", {}, state));
}

export async function loadCell() {
  const board = encodeURIComponent(byId("step-board").value);
  const [{files, next}, reports] = await Promise.all([ask(`api/files?board=${board}`), ask("api/reports")]);
  show("next", Boolean(next));
  put("next-text", next ? next.text : "");
  put("next-command", next && next.command ? next.command : "");
  show("next-command", Boolean(next && next.command));
  show("step-form", Boolean(next && next.is_calculated));
  byId("file-rows").replaceChildren(...files.map(fileRow));
  byId("reports").replaceChildren(...reports.map(({name, path, made}) => make("li", {},
    make("a", {href: path.split("/").map(encodeURIComponent).join("/"), target: "_blank", rel: "noopener"}, name), " ", make("span", {class: "soft"}, day(made)))),
    ...(reports.length ? [] : [make("li", {class: "soft"}, "None yet")]));
}

onSubmit("step-form", () => order("api/step", {board: byId("step-board").value || null}));
byId("step-board").addEventListener("change", () => attempt(loadCell));
byId("check").addEventListener("click", () => order("api/check"));
