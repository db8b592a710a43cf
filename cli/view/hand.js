// Holding the tissue, with one tool or two: whoever leads a hand, it is told to the server at most once a frame.
import { control, hands, look, model } from "./state.js";
import { is_open, tell } from "./transport.js";
import { $ } from "./words.js";

const ALIVE = 500;                  // ms, between words while the hand rests

function say_where(hand, down) {
  const [x, y, z] = hand.at, tool = hand.tool > 0 ? { tool: hand.tool } : {};
  tell({ type: "pointer", x, y, ...z === undefined ? {} : { z }, down, ...tool });
}

/** The hands that there are tools for. */
export const own_hands = () => hands.slice(0, model ? model.tools : 1);
/** The hand that a pointer or the keyboard leads now; undefined where there is none. */
export const led_by = by => own_hands().find(hand => hand.down && hand.by === by);
/** Whether a pointer or the keyboard leads one; not one that stays where it was left. */
export const leading = () => own_hands().some(hand => hand.down && hand.by !== STAYS);
const STAYS = "stays";              // leads a tool that was left in the tissue

/** The next hand to press with: of the first tool that nobody holds, else one that was left in the tissue; undefined where there is none. */
export function next_hand() {
  const free = own_hands().filter(hand => !hand.down && control.holders[hand.tool] !== "other");
  return free[0] || own_hands().find(hand => hand.down && hand.by === STAYS);
}

/** The hand that has taken hold at a point; undefined where it may not. */
export function take_hold(p, by, hand = next_hand()) {
  if (!is_open() || !hand) return undefined;
  if (hand.down) let_go(hand);
  return Object.assign(hand, { at: p, pointer: p, down: true, by, press: null, before: null, said: null, told: -Infinity });
}

export function let_go(hand, tells = true) {
  if (!hand || !hand.down) return;
  hand.down = false;
  hand.press = hand.before = null;
  if (tells) say_where(hand, false);
  if (hand.by !== "keys") hand.at = hand.pointer = null;
  else hand.at = hand.pointer;
}
export function let_all_go(tells = true) {
  for (const hand of hands) let_go(hand, tells);
}

/** Whoever led it does so no more: it leaves the tissue, or stays, as the box says. */
export function end_hold(hand) {
  if (hand && hand.down && model.tools > 1 && $("stays").checked) hand.by = STAYS;
  else let_go(hand);
}
$("stays").addEventListener("change", () => {
  if (!$("stays").checked) for (const hand of hands) if (hand.by === STAYS) let_go(hand);
  look.stale = true;
});

export function move_hands(now) {
  for (const hand of own_hands()) {
    if (!hand.down || now - hand.told < (hand.said === hand.at ? ALIVE : 16)) continue;
    hand.told = now;
    hand.said = hand.at;
    say_where(hand, true);
  }
}

addEventListener("blur", () => let_all_go());
document.addEventListener("visibilitychange", () => { if (document.hidden) let_all_go(); });
