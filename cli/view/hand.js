// Holding the tissue with one tool or two. The position of a hand is sent to the server at most once a frame.
import { control, hands, look, model, pressed_by, state, vector_of } from "./state.js";
import { is_open, tell } from "./transport.js";
import { add, norm } from "./vectors.js";
import { $ } from "./words.js";

const ALIVE = 500;                  // ms between messages while the hand rests
const LONGEST = 60e3;               // ms that a tool may stay in the tissue without a lead, because others wait for it

function say_where(hand, down) {
  const [x, y, z] = hand.at, tool = hand.tool > 0 ? { tool: hand.tool } : {};
  tell({ type: "pointer", x, y, ...z === undefined ? {} : { z }, down, ...tool, ...down && grasps(hand) ? { grasp: true } : {} });
}

/** Whether its tool is to grasp: once it touches the tissue. */
const grasps = hand => $("grasp").checked && pressed_by(hand.tool) >= 0 && (!hand.press || hand.press.arrived || hand.press.out);
$("grasp").addEventListener("change", () => { for (const hand of hands) hand.told = -Infinity; });

/** The hands of the model's tools. */
export const own_hands = () => hands.slice(0, model ? model.tools : 1);
/** The hand that a pointer or the keyboard leads; undefined without one. */
export const led_by = by => own_hands().find(hand => hand.down && hand.by === by);
/** Whether a hand was left in the tissue and is not led. */
export const stays = hand => hand.down && hand.by === "box";
/** Whether a pointer or the keyboard leads any hand. */
export const leading = () => own_hands().some(hand => hand.down && !stays(hand));
const is_others = hand => control.holders[hand.tool] === "other";

/** The hand for the next indentation, at point p if given: a free one, the nearest to p if no tool is held; else the
 *  one that has stayed in the tissue longest; undefined without one. */
export function next_hand(p) {
  const free = own_hands().filter(hand => !hand.down && !is_others(hand)), away = hand => norm(add(vector_of(hand.tool, "master"), p, -1));
  if (p && state && control.holders.every(holder => holder === "nobody")) free.sort((a, b) => away(a) - away(b));
  return free[0] || own_hands().filter(hand => stays(hand) && !is_others(hand)).sort((a, b) => a.left - b.left)[0];
}

/** Takes hold at a point and returns the hand; undefined if that is not possible. */
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

/** Ends the lead of a hand. It leaves the tissue, or with two tools and the box checked stays there. */
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
