// Elements and numbers. Whatever comes from the server goes into text nodes and attributes, never into markup.

const SVG = "http://www.w3.org/2000/svg";

export const byId = id => document.getElementById(id);

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

export const make = (tag, attributes = {}, ...children) => filled(document.createElement(tag), attributes, children);
export const draw = (tag, attributes = {}, ...children) =>
  filled(document.createElementNS(SVG, tag), attributes, children);

/// Sets a text where it differs, so that a screen reader is not told what it knows.
export function put(id, text) {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
}

export function show(id, shown) {
  byId(id).hidden = !shown;
}

/// A number with a fixed count of decimals and a real minus sign; a dash for what is unknown.
export function fixed(value, decimals) {
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

/// "x 402.605  y −281.908 mm"
export const placeText = (at, decimals = 3) =>
  at ? `x ${fixed(at[0], decimals)}  y ${fixed(at[1], decimals)} mm` : "–";

const ON_PAGE = {"--resume": "“resume what is there”", "--out": "“Folder”", "--grid": "“Board”", "--cycles": "“Cycles”",
  "--targets": "“Targets”", "--at-marks": "“At its mark”"};

/// A program's text as it is said here: without the gauge that it draws, and without options but those of whole commands.
export const plain = text => text.replace(/\[[= ]+\] /g, "")
  .replace(/(?<!planar-[^;,)]*)--[a-z-]+/g, option => ON_PAGE[option] || option);

/// "40 s", "3 min", "1 h 20 min"
export function duration(seconds) {
  if (seconds < 90) return `${Math.round(seconds)} s`;
  const minutes = Math.round(seconds / 60);
  return minutes < 90 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

const two = n => String(n).padStart(2, "0");

/// "20261126", for names of folders
export const dayOf = time => `${time.getFullYear()}${two(time.getMonth() + 1)}${two(time.getDate())}`;

/// "20261126_1430"
export const minuteOf = time => `${dayOf(time)}_${two(time.getHours())}${two(time.getMinutes())}`;

/// The number in an input, written with a point or a comma; null for none, NaN for what is no number.
export function numberIn(id) {
  const text = byId(id).value.trim().replace(",", ".").replace("−", "-");
  return text === "" ? null : Number(text);
}

/// Puts a text into a text area, unless somebody has written there.
export function offerText(id, text) {
  const area = byId(id);
  if (area.value !== area.defaultValue) return;
  area.value = text;
  keepText(id);
}

/// Says that what somebody has written there is kept.
export function keepText(id) {
  byId(id).defaultValue = byId(id).value;
}

/// Does this where a form is sent.
export const onSubmit = (id, act) => byId(id).addEventListener("submit", event => {
  event.preventDefault();
  act();
});

/// Puts the text of a file that is chosen into a text area, of the same file, too, which has changed since.
export function offerFile(id, text) {
  byId(id).addEventListener("click", event => { event.target.value = ""; });
  byId(id).addEventListener("change", async event => {
    const [file] = event.target.files;
    if (file) byId(text).value = await file.text();
  });
}

/// A sentence, as plain() has it, begins with a capital, but for the name of a program, a file or a place.
export const sentence = text => plain(text).replace(/^(?!planar-|\S*[./_\d])./, first => first.toUpperCase());
