// The connection: one WebSocket, made again when it is lost. What comes and what changes is `listener`'s:
// text(message), state(buffer), lost(), changed().
import { model } from "./state.js";

export const socket = { at: null, tries: 0, again: null, reason: "" };

let listener = null;

export function connect(to = listener) {
  listener = to;
  clearTimeout(socket.again);
  const ws = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws`);
  ws.binaryType = "arraybuffer";
  socket.at = ws;
  let opened = false;
  ws.onopen = () => {
    opened = true;
    socket.reason = "";
  };
  ws.onmessage = ({ data }) => typeof data === "string" ? listener.text(JSON.parse(data)) : listener.state(data);
  ws.onclose = ({ reason }) => {
    if (socket.at !== ws) return;
    if (reason) socket.reason = reason;
    listener.lost();
    const wait = Math.min(0.5 * 2 ** socket.tries++, 8);   // s
    socket.again = setTimeout(() => connect(), 1e3 * wait);
    socket.at = null;
    if (!opened) ask_why();
    listener.changed();
  };
}

/** A WebSocket that is not let in learns no reason; a plain request does. */
async function ask_why() {
  try {
    const answer = await fetch("healthz");
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
