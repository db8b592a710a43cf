// The connection: one WebSocket, made again when it is lost. What comes and what changes is `listener`'s:
// text(message), state(buffer), lost(), changed().
import { model } from "./state.js";

export const socket = { at: null, tries: 0, again: null, reason: "" };

const QUIET = 6;   // looks, one a second: a server that has said nothing for so long is lost, though nobody closed the connection

let listener = null;
let quiet = 0;     // looks in a row without a word; a browser that was busy itself looks once after it

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

/** The connection is none any more; after a while another one is tried. */
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

/** Who comes back to the page, or to the network, does not wait. */
const now = () => { if (listener && socket.at === null && !document.hidden) connect(); };
addEventListener("online", now);
document.addEventListener("visibilitychange", now);

/** A WebSocket that is not let in learns no reason; a plain request does. */
async function ask_why() {
  try {
    const answer = await fetch("healthz", { signal: AbortSignal.timeout(1e3 * QUIET) });
    socket.reason = answer.ok ? "no more pages may connect at the moment" : (await answer.text()).trim();
  } catch {
    // nobody there: what was said last still holds
  }
  listener.changed();
}
export const is_open = () => socket.at !== null && socket.at.readyState === WebSocket.OPEN && model !== null;
export function tell(message) {
  if (socket.at !== null && socket.at.readyState === WebSocket.OPEN) socket.at.send(JSON.stringify(message));
}
