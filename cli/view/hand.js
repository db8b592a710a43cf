// Holding the tissue: whoever leads the hand, it is told to the server at most once a frame.
import { control, hand } from "./state.js";
import { is_open, tell } from "./transport.js";

const ALIVE = 500;                  // ms, between words while the hand rests

export function take_hold(p, by) {
  if (!is_open() || hand.down || control.holder === "other") return;
  Object.assign(hand, { at: p, down: true, by, said: null, told: -Infinity });
}

export function let_go(tells = true) {
  if (!hand.down) return;
  hand.down = false;
  if (tells) tell({ type: "pointer", x: hand.at[0], y: hand.at[1], down: false });
  if (hand.by !== "keys") hand.at = null;
}

export function move_hand(now) {
  if (!hand.down || now - hand.told < (hand.said === hand.at ? ALIVE : 16)) return;
  hand.told = now;
  hand.said = hand.at;
  tell({ type: "pointer", x: hand.at[0], y: hand.at[1], down: true });
}

addEventListener("blur", () => let_go());
document.addEventListener("visibilitychange", () => { if (document.hidden) let_go(); });
