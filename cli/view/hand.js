// Holding the tissue: whoever leads the hand, it is told to the server at most once a frame.
import { control, hand } from "./state.js";
import { is_open, tell } from "./transport.js";

const ALIVE = 500;                  // ms, between words while the hand rests

function say_where(down) {
  const [x, y, z] = hand.at;
  tell(z === undefined ? { type: "pointer", x, y, down } : { type: "pointer", x, y, z, down });
}

export function take_hold(p, by) {
  if (!is_open() || hand.down || control.holder === "other") return;
  Object.assign(hand, { at: p, pointer: p, down: true, by, said: null, told: -Infinity });
}

export function let_go(tells = true) {
  if (!hand.down) return;
  hand.down = false;
  if (tells) say_where(false);
  if (hand.by !== "keys") hand.at = hand.pointer = null;
  else hand.at = hand.pointer;
}

export function move_hand(now) {
  if (!hand.down || now - hand.told < (hand.said === hand.at ? ALIVE : 16)) return;
  hand.told = now;
  hand.said = hand.at;
  say_where(true);
}

addEventListener("blur", () => let_go());
document.addEventListener("visibilitychange", () => { if (document.hidden) let_go(); });
