// The field seen from above, drawn in millimetres: x to the right, y up.

import {byId, draw, fixed, placeText, put} from "./dom.js";
import {kindOf} from "./results.js";

const LONGEST_ARROW_PX = 26;
const LEAST_GRID_PX = 44;
const LABEL_PX = 20;    // of the field's width for each target, where targets have names
const TRAIL = 200;  // places of the end point that are remembered
const svg = byId("field-view");
const layers = {};
const trail = [];
let cell, state = null, targets = [], path = [], results = new Map(), chosen = null, chosenWay = [], px = 1;  // px: one pixel in mm

const at = ([x, y]) => `${x.toFixed(3)} ${(-y).toFixed(3)}`;
const line = (points, attributes) => draw("path", {d: `M${points.map(at).join("L")}`, ...attributes});

/// An angle from -180 degrees on, below 180.
const turned = deg => deg - 360 * Math.floor((deg + 180) / 360);

/// 1, 2 or 5 times a power of ten: the smallest that is not below, at most 2.5 times the value.
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 2, 5, 10].find(n => n * power >= value);
}

function ground() {
  const {radius_min_mm: least, radius_max_mm: most, keep_out, obstacles} = cell.workspace;
  const edge = most * 1.1, step = roundUp(LEAST_GRID_PX * px), marks = [];
  marks.push(draw("circle", {r: most, class: "reach"}), draw("circle", {r: least, class: "hole"}));
  for (let v = -Math.floor(edge / step) * step; v <= edge; v += step) {
    const name = Math.abs(v) < step / 2 ? "axis" : "grid";
    marks.push(line([[v, -edge], [v, edge]], {class: name}), line([[-edge, v], [edge, v]], {class: name}));
    if (name === "axis" || edge + v < 24 * px) continue;  // the corner
    marks.push(draw("text", {x: v, y: edge - 4 * px, class: "tick middle"}, fixed(v, 0)),
      draw("text", {x: -edge + 4 * px, y: -v + 4 * px, class: "tick"}, fixed(v, 0)));
  }
  marks.push(draw("text", {x: edge - 4 * px, y: -6 * px, class: "name end"}, "x"),
    draw("text", {x: 6 * px, y: -edge + 14 * px, class: "name"}, "y"));
  for (const {x_mm, y_mm, radius_mm} of keep_out)
    marks.push(draw("circle", {cx: x_mm, cy: -y_mm, r: radius_mm, class: "keep-out"}));
  for (const {name, outline_mm} of obstacles)
    marks.push(draw("path", {d: `M${outline_mm.map(at).join("L")}Z`, class: "obstacle"}),
      draw("text", {x: outline_mm[0][0] + 3 * px, y: -outline_mm[0][1], class: "label"}, name));
  if (cell.map && cell.map.region_mm.length) marks.push(draw("path", {
    d: `M${cell.map.region_mm.map(at).join("L")}Z`, class: "region"}));
  layers.ground.replaceChildren(...marks);
}

function glyph(kind, [x, y]) {
  const r = 4 * px, place = {cx: x, cy: -y, r, class: `target ${kind}`};
  if (kind === "failed")
    return draw("path", {d: `M${x - r} ${-y - r}l${2 * r} ${2 * r}m0 ${-2 * r}l${-2 * r} ${2 * r}`, class: "target failed"});
  if (kind === "outside")
    return draw("path", {d: `M${x} ${-y - r * 1.3}l${r * 1.3} ${r * 1.3}l${-r * 1.3} ${r * 1.3}l${-r * 1.3} ${-r * 1.3}Z`,
      class: "target outside"});
  return draw("circle", place);
}

const recording = () => state && state.doing === "recording" ? state.recording : null;
const RECORDED = {done: "reached", left_out: "failed"};

/// The places and monuments of a recording, which stand in the place of targets.
function showPlaces({places, monuments, here_mm: here}) {
  const marks = places.map(({x_mm, y_mm, mark}) => glyph(RECORDED[mark] || "planned", [x_mm, y_mm]));
  for (const {id, x_mm: x, y_mm: y} of monuments) marks.push(
    draw("path", {d: `M${x} ${-y - 6 * px}l${6 * px} ${10 * px}h${-12 * px}Z`, class: "monument"}),
    draw("text", {x: x + 9 * px, y: -y + 4 * px, class: "label"}, id));
  if (here) marks.push(draw("circle", {cx: here[0], cy: -here[1], r: 9 * px, class: "chosen"}));
  layers.targets.replaceChildren(...marks);
}

function showTargets() {
  if (recording()) return showPlaces(recording());
  const checked = (state && state.checking_mm || []).map(([x, y]) => draw("circle", {cx: x, cy: -y, r: 9 * px, class: "chosen"}));
  const marks = targets.map(({id, x_mm, y_mm}) => glyph(kindOf(results.get(id)), [x_mm, y_mm]));
  if (targets.length * LABEL_PX <= svg.clientWidth) for (const {id, x_mm, y_mm} of targets)
    marks.push(draw("text", {x: x_mm + 7 * px, y: -y_mm - 5 * px, class: "label"}, id));
  layers.targets.replaceChildren(...marks, ...checked);
}

/// Where an arrow begins and how long it is, in mm.
function arrowsOf(kind) {
  if (kind === "map") return (cell.map ? cell.map.arrows : []).map(a => [a.x_mm, a.y_mm, a.dx_mm, a.dy_mm]);
  return [...results.values()].map(r =>
    [r.x_mm, r.y_mm, r[`${kind}_own_view_dx_mm`], r[`${kind}_own_view_dy_mm`]]).filter(a => Number.isFinite(a[2]));
}

function arrow([x, y, dx, dy], scale) {
  const [ex, ey] = [x + dx * scale, y + dy * scale], length = Math.hypot(dx, dy) * scale;
  const head = Math.min(5 * px, length * 0.6), along = Math.atan2(dy, dx);
  const wing = turn => [ex - head * Math.cos(along + turn), ey - head * Math.sin(along + turn)];
  return draw("path", {d: `M${at([x, y])}L${at([ex, ey])}M${at(wing(0.45))}L${at([ex, ey])}L${at(wing(-0.45))}`, class: "arrow"});
}

function showArrows() {
  const all = arrowsOf(byId("arrows").value).filter(a => Math.hypot(a[2], a[3]) > 0);
  const longest = Math.max(...all.map(a => Math.hypot(a[2], a[3])));
  if (!all.length) {
    layers.arrows.replaceChildren();
    put("legend", byId("arrows").value === "none" ? "" : "No arrows yet");
    return;
  }
  const unit_mm = roundUp(longest / 2.5), scale = LONGEST_ARROW_PX * px / longest, edge = cell.workspace.radius_max_mm * 1.1;
  const sample = arrow([-edge + 34 * px, edge - 14 * px, unit_mm, 0], scale);
  layers.arrows.replaceChildren(...all.map(a => arrow(a, scale)), sample, draw("text", {
    x: -edge + 34 * px, y: -edge + 30 * px, class: "name"}, `${unit_mm.toPrecision(1)} mm`));
  put("legend", `${all.length} arrows, the longest ${fixed(longest, 4)} mm, drawn ${Math.round(scale)} times as long`);
}

function showArm() {
  const {arm, seen_mm: seen} = state, marks = [];
  if (trail.length > 1) marks.push(line(trail, {class: "trail"}));
  if (arm && arm.homed) {
    const {elbow_mm: elbow, tip_mm: tip, phi_deg: phi} = arm;
    const along = [Math.cos(phi * Math.PI / 180), Math.sin(phi * Math.PI / 180)];
    marks.push(line([[0, 0], elbow, tip], {class: "link under"}), line([[0, 0], elbow, tip], {class: "link"}),
      line([tip, [tip[0] + along[0] * 22 * px, tip[1] + along[1] * 22 * px]], {class: "tool"}),
      draw("circle", {r: 7 * px, class: "base"}), draw("circle", {cx: elbow[0], cy: -elbow[1], r: 4 * px, class: "base"}),
      draw("circle", {cx: tip[0], cy: -tip[1], r: 4 * px, class: "tip"}));
  }
  if (seen) marks.push(draw("circle", {cx: seen[0], cy: -seen[1], r: 9 * px, class: "seen"}));
  layers.arm.replaceChildren(...marks);
}

function showChosen() {
  if (!chosen) return layers.chosen.replaceChildren();
  const [x, y] = chosen, r = 12 * px, gap = 4 * px;
  layers.chosen.replaceChildren(draw("path", {class: "chosen", d: `M${x - r} ${-y}h${r - gap}m${2 * gap} 0h${r - gap}` +
    `M${x} ${-y - r}v${r - gap}m0 ${2 * gap}v${r - gap}`}),
    ...chosenWay.length ? [line(chosenWay, {class: "way"})] : []);
}

function redraw() {
  if (!cell) return;
  px = cell.workspace.radius_max_mm * 2.2 / Math.max(svg.clientWidth, 1);
  svg.style.fontSize = `${11 * px}px`;
  ground();
  showArrows();
  showPath();
  showTargets();
  if (state) showArm();
  showChosen();
}

export function showField(next) {
  const before = recording() || state && state.checking_mm;
  state = next;
  if (before || recording() || state.checking_mm) showTargets();
  put("glyph-good", recording() ? "● done" : "● reached");
  put("glyph-bad", recording() ? "✕ left out" : "✕ not reached");
  const {arm, seen_mm: seen} = state;
  const tip = arm && arm.homed ? arm.tip_mm : null, last = trail[trail.length - 1];
  if (tip && (!last || Math.hypot(tip[0] - last[0], tip[1] - last[1]) > px)) trail.push(tip);
  if (trail.length > TRAIL) trail.shift();
  put("tip", tip ? `${placeText(tip)}  φ ${fixed(turned(arm.phi_deg), 2)}°` : arm ? "unknown until homed" : "–");
  put("seen", placeText(seen));
  put("joints", tip ? `${arm.joints_deg.map(angle => fixed(angle, 3)).join("  ")}°` : "–");
  showArm();
}

export function showOnField(list, found) {
  targets = list;
  results = found;
  showTargets();
  showArrows();
}

/// Draws a path that begins at a ring, by its places; nothing for none.
export function showPath(places = path) {
  path = places;
  layers.path.replaceChildren(...(path.length ? [line(path, {class: "path"}),
    draw("circle", {cx: path[0][0], cy: -path[0][1], r: 5 * px, class: "path"})] : []));
}

/// Marks a chosen place, and the end point's way there where it is known.
export function markPlace(place, way = []) {
  chosen = place;
  chosenWay = way;
  showChosen();
}

/// Takes a cell whose files were read anew.
export function showGround(ofCell) {
  cell = ofCell;
  const edge = cell.workspace.radius_max_mm * 1.1, box = {x: -edge, y: -edge, width: 2 * edge, height: 2 * edge};
  svg.setAttribute("viewBox", Object.values(box).join(" "));
  for (const [name, value] of Object.entries(box)) svg.querySelector(".paper").setAttribute(name, value);
  redraw();
}

/// The place of a click, in mm.
export function placeAt(event) {
  const {x, y} = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  return [x, -y];
}

svg.append(draw("rect", {class: "paper"}));
for (const name of ["ground", "path", "arrows", "targets", "arm", "chosen"]) {
  layers[name] = draw("g");
  svg.append(layers[name]);
}
byId("arrows").addEventListener("change", showArrows);
new ResizeObserver(redraw).observe(svg);
