// The line to the server: questions, orders, and the stream of its events.

export const client = [...crypto.getRandomValues(new Uint8Array(16))].map(n => n.toString(16).padStart(2, "0")).join("");

/// What the server refused: its fault and remedy, and all faults of a table.
class Refusal extends Error {
  constructor(answer, status) {
    super(answer.fault);
    Object.assign(this, {faults: [], remedy: "", where: "", ...answer, status});
  }
}

async function answerOf(request) {
  let response;
  try {
    response = await request;
  } catch {
    throw new Refusal({fault: "planar-console does not answer", remedy: "see whether it still runs"}, 0);
  }
  const answer = await response.json().catch(() => ({}));
  if (response.ok) return answer;
  if (response.status === 401)
    answer.remedy = "open the address that planar-console printed when it started";
  throw new Refusal({fault: `planar-console answers ${response.status}`, ...answer}, response.status);
}

let stops = 0;  // that the page knows of: what it ordered before another one does not begin

/// Takes what the server says of the stops of the cell.
const heedStops = answer => {
  if (answer.stops !== undefined) stops = answer.stops;
  return answer;
};

/// The console refuses a page that is not its own at the first question, not at the first order.
export const ask = path => answerOf(fetch(path, {headers: {"X-Planar-Origin": location.origin}}));

export const tell = (path, body = {}) => answerOf(fetch(path, {
  method: "POST",
  keepalive: path === "api/stop",  // outlives the page
  headers: {"Content-Type": "application/json", "X-Planar-Client": client, "X-Planar-Stops": stops},
  body: JSON.stringify(body),
})).then(heedStops);

const SILENCE_MS = 3000;  // the server sends a state every second
const RETRY_MS = 1500;

/// Follows the events for good: `handlers` by name, `lost(why)` as long as there is no word from the server. The server
/// tells its last events anew after each `begin()`.
export function follow(handlers, begin, lost) {
  let silence, stream;
  const heard = () => {
    clearTimeout(silence);
    silence = setTimeout(reopen, SILENCE_MS);
  };
  async function reopen() {
    stream.close();
    try {
      await ask("api/state");
      open();
    } catch (refusal) {
      lost(refusal);
      setTimeout(reopen, RETRY_MS);
    }
  }
  function open() {
    stream = new EventSource(`api/events?client=${client}`);
    stream.addEventListener("open", begin);
    for (const [name, handle] of Object.entries(handlers))
      stream.addEventListener(name, event => {
        heard();
        handle(heedStops(JSON.parse(event.data)));
      });
    heard();
  }
  open();
}
