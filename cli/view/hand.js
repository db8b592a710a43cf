// Holding the tissue, with one tool or two: whoever leads a hand, it is told to the server at most once a frame.
import { control, hands, look, model, state, vector_of } from "./state.js";
import { is_open, tell } from "./transport.js";
import { add, norm } from "./vectors.js";
import { $ } from "./words.js";

const ALIVE = 500;                  // ms, between words while the hand rests
const LONGEST = 60e3;               // ms that a tool stays in the tissue by itself: others wait for it

function say_where(hand, down) {
  const [x, y, z] = hand.at, tool = hand.tool > 0 ? { tool: hand.tool } : {};
  tell({ type: "pointer", x, y, ...z === undefined ? {} : { z }, down, ...tool });
}

/** The hands that there are tools for. */
export const own_hands = () => hands.slice(0, model ? model.tools : 1);
/** The hand that a pointer or the keyboard leads now; undefined where there is none. */
export const led_by = by => own_hands().find(hand => hand.down && hand.by === by);
/** Whether it was left in the tissue, and nobody leads it. */
export const stays = hand => hand.down && hand.by === "box";
/** Whether a pointer or the keyboard leads one. */
export const leading = () => own_hands().some(hand => hand.down && !stays(hand));
const is_others = hand => control.holders[hand.tool] === "other";

/** The next hand to press with, at a point if it is given: the nearest that nobody holds, else the one that has stayed in the tissue longest; undefined where there is none. */
export function next_hand(p) {
  const free = own_hands().filter(hand => !hand.down && !is_others(hand)), away = hand => norm(add(vector_of(hand.tool, "master"), p, -1));
  if (p && state && control.holders.every(holder => holder === "nobody")) free.sort((a, b) => away(a) - away(b));
  return free[0] || own_hands().filter(hand => stays(hand) && !is_others(hand)).sort((a, b) => a.left - b.left)[0];
}

/** The hand that has taken hold at a point; undefined where it may not. */
export function take_hold(p, by, hand = next_hand(p)) {
  if (!is_open() || !hand || is_others(hand) || hand.down && !stays(hand)) return undefined;
  let_go(hand);
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
  if (hand && hand.down && hand.press && model.tools > 1 && $("stays").checked) Object.assign(hand, { by: "box", left: performance.now() });
  else let_go(hand);
}
$("stays").addEventListener("change", () => {
  if (!$("stays").checked) for (const hand of hands) if (stays(hand)) let_go(hand);
  look.stale = true;
});

export function move_hands(now) {
  for (const hand of own_hands()) {
    if (stays(hand) && now - hand.left > LONGEST) let_go(hand);
    if (!hand.down || now - hand.told < (hand.said === hand.at ? ALIVE : 16)) continue;
    hand.told = now;
    hand.said = hand.at;
    say_where(hand, true);
  }
}

addEventListener("blur", () => let_all_go());
addEventListener("keydown", event => { if (event.key === "Escape") let_all_go(); });
document.addEventListener("visibilitychange", () => { if (document.hidden) let_all_go(); });
