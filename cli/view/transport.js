// The connection: one WebSocket, which is opened again after it is lost. It calls text(message), state(buffer), lost()
// and changed() of `listener`.
import { model } from "./state.js";

export const socket = { at: null, tries: 0, again: null, reason: "" };

const QUIET = 6;   // checks, one a second: after this many without a message the connection counts as lost

let listener = null;
let quiet = 0;     // successive checks without a message; a browser that was busy checks only once afterwards

export function connect(to = listener) {
  listener = to;
  clearTimeout(socket.again);
  const ws = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}${location.pathname}ws`);
  ws.binaryType = "arraybuffer";
  socket.at = ws;
  quiet = 0;
  let opened = false;
  ws.onopen = () => {
    if (socket.at !== ws) return;
    opened = true;
    quiet = 0;
    socket.reason = "";
  };
  ws.onmessage = ({ data }) => {
    if (socket.at !== ws) return;
    quiet = 0;
    if (typeof data === "string") listener.text(JSON.parse(data));
    else listener.state(data);
  };
  ws.onclose = ({ reason }) => {
    if (socket.at !== ws) return;
    if (reason) socket.reason = reason;
    if (!opened) ask_why();
    lose();
  };
}

/** Drops the connection, and opens another one after a delay. */
function lose() {
  socket.at = null;
  const wait = Math.min(0.5 * 2 ** socket.tries++, 8);   // s
  socket.again = setTimeout(() => connect(), 1e3 * wait);
  listener.lost();
  listener.changed();
}

setInterval(() => {
  if (socket.at === null || ++quiet < QUIET) return;
  const silent = socket.at;
  lose();
  silent.close();
}, 1000);

/** Reconnects at once when the page becomes visible or the network returns. */
const now = () => { if (listener && socket.at === null && !document.hidden) connect(); };
addEventListener("online", now);
document.addEventListener("visibilitychange", now);

/** Asks for the reason of a refusal by a plain request: a refused WebSocket gets none. */
async function ask_why() {
  try {
    const answer = await fetch("healthz", { signal: AbortSignal.timeout(1e3 * QUIET) });
    socket.reason = answer.ok ? "no more pages may connect at the moment" : (await answer.text()).trim();
  } catch {
    // no server: the last reason stays
  }
  listener.changed();
}
export const is_open = () => socket.at !== null && socket.at.readyState === WebSocket.OPEN && model !== null;
export function tell(message) {
  if (socket.at !== null && socket.at.readyState === WebSocket.OPEN) socket.at.send(JSON.stringify(message));
}
