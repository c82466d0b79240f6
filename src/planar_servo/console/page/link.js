// The line to the server: questions, orders, and the stream of its events.

export const client = [...crypto.getRandomValues(new Uint8Array(16))].map(n => n.toString(16).padStart(2, "0")).join("");

/// What the server refused: its fault and remedy, and all faults of a table.
class Refusal extends Error {
  constructor(answer, status) {
    super(answer.fault);
    Object.assign(this, {faults: [], remedy: "", where: "", ...answer, status});
  }
}

const SILENT = {fault: "planar-console does not answer", remedy: "see whether it still runs, and close other windows of it"};

async function answerOf(request) {
  let response;
  try {
    response = await request;
  } catch {
    throw new Refusal(SILENT, 0);
  }
  const answer = await response.json().catch(() => null);
  if (response.ok && answer) return answer;
  const remedy = response.status === 401 ? {remedy: "open the address that planar-console printed when it started"} : {};
  throw new Refusal({fault: `planar-console answers ${response.status} and nothing that can be read`, ...answer, ...remedy}, response.status);
}

export let stops = 0;  // that the page knows of: what it ordered before another one does not begin

/// Takes what the server says of the stops of the cell.
const heedStops = answer => {
  if (answer.stops !== undefined) stops = answer.stops;
  return answer;
};

/// The console refuses a page that is not its own at the first question, not at the first order.
export const ask = (path, patience_ms) => answerOf(fetch(path, {
  headers: {"X-Planar-Origin": location.origin},
  signal: patience_ms ? AbortSignal.timeout(patience_ms) : null,
}));

let line = new AbortController();  // of the orders that are not answered yet

/// `known` are the stops that whoever orders this knew of. A stop outlives the page and the line.
export const tell = (path, body = {}, known = stops) => answerOf(fetch(path, {
  method: "POST",
  keepalive: path === "api/stop",
  signal: path === "api/stop" ? null : line.signal,
  headers: {"Content-Type": "application/json", "X-Planar-Client": client, "X-Planar-Stops": known},
  body: JSON.stringify(body),
})).then(heedStops);

const SILENCE_MS = 3000;  // the server sends a state every second
const RETRY_MS = 1500;
const CONNECTING = {fault: "connecting"};

/// Gives the stream up for a moment, so that what waits for a free connection goes out.
export let hangUp = () => {};

/// Follows the events for good: `handlers` by name, `lost(why)` as long as there is no word from the server. The server
/// tells its last events anew after each `begin(cell)`, and may have read the cell's files anew. A browser has six
/// connections to a host, and a stream keeps one: a page that nobody sees gives its own up, unless it moves the cell.
export function follow(handlers, begin, lost) {
  let stream = null, timer, turn = 0, moves = false;
  const later = (wait_ms, why) => {
    clearTimeout(timer);
    timer = setTimeout(open, wait_ms, why);
  };
  function heed(name, data) {
    later(SILENCE_MS, SILENT);
    handlers[name](heedStops(data));
    if (name === "state") moves = data.operator === client;
    if (document.hidden && !moves) open(CONNECTING);
  }
  function listen(cell) {
    stream = new EventSource(`api/events?client=${client}`);
    stream.addEventListener("open", () => begin(cell));
    stream.addEventListener("error", () => {
      stream.close();
      later(RETRY_MS, SILENT);
    });
    for (const name of Object.keys(handlers))
      stream.addEventListener(name, event => heed(name, JSON.parse(event.data)));
    later(SILENCE_MS, SILENT);
  }
  async function open(why) {
    const mine = ++turn;
    line.abort();  // what has not gone out must not go out much later
    line = new AbortController();
    clearTimeout(timer);
    if (stream) stream.close();
    stream = null;
    if (why) lost(why);
    if (document.hidden && !moves) return;
    try {
      const cell = await ask("api/cell", SILENCE_MS);
      if (mine === turn) listen(cell);
    } catch (refusal) {
      if (mine !== turn) return;
      lost(refusal);
      later(RETRY_MS);
    }
  }
  hangUp = () => open(SILENT);
  document.addEventListener("visibilitychange", () => {
    if (document.hidden ? stream && !moves : !stream) open(CONNECTING);
  });
  open(CONNECTING);
}
