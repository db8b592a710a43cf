// Pointers and keyboard in the plane.
import { end_hold, leading, led_by, let_go, next_hand, stays, take_hold } from "./hand.js";
import { aimed, stage, to_plane, view } from "./plane.js";
import { would_press } from "./snap.js";
import { hands, look, model } from "./state.js";
import { is_open } from "./transport.js";
import { add, clamp } from "./vectors.js";

const STEP = 0.001, LEAP = 0.005;   // m, of the arrow keys

const in_plane = event => {
  const box = stage.getBoundingClientRect();
  return to_plane([event.clientX - box.left, event.clientY - box.top]);
};
stage.addEventListener("pointerdown", event => {
  if (!model || event.button !== 0 || led_by(event.pointerId)) return;
  if (take_hold(in_plane(event), event.pointerId)) stage.setPointerCapture(event.pointerId);
});
stage.addEventListener("pointermove", event => {
  if (!model) return;
  const hand = led_by(event.pointerId);
  if (hand) hand.pointer = in_plane(event);
  aim_at(!leading() && is_open() && event.pointerType !== "touch" ? would_press(null, in_plane(event)) : null);
});
stage.addEventListener("pointerleave", () => aim_at(null));
/** Marks the known contact that an indentation would have. */
function aim_at(press) {
  const at = press && press.known ? press.contact : null;
  if (!at && !aimed.at) return;
  aimed.at = at;
  look.stale = true;
}
for (const name of ["pointerup", "pointercancel", "lostpointercapture"])
  stage.addEventListener(name, event => end_hold(led_by(event.pointerId)));

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
/** The hand that the keyboard leads or would lead. Its diamond starts outside, 8 mm before the demo's first contact. */
function keyed_hand() {
  const hand = led_by("keys") || next_hand() || hands[0];
  if (model && !hand.at) {
    const place = model.places[Math.max(0, model.demo)];
    hand.at = hand.pointer = place ? add(place.contact_m, place.direction, -0.008) : add(model.low_m, [-0.01, -0.01]);
  }
  return hand;
}
stage.addEventListener("focus", () => { keyed_hand(); look.stale = true; });
stage.addEventListener("blur", () => { end_hold(led_by("keys")); look.stale = true; });
stage.addEventListener("keydown", event => {
  if (!model || event.ctrlKey || event.altKey || event.metaKey) return;
  const hand = keyed_hand(), arrow = ARROWS[event.key];
  look.stale = true;
  if (arrow && (!hand.down || hand.by === "keys")) {
    const to = add(hand.pointer, arrow, event.shiftKey ? LEAP : STEP);
    hand.pointer = [clamp(to[0], view.low[0], view.high[0]), clamp(to[1], view.low[1], view.high[1])];
    if (!hand.down) hand.at = hand.pointer;
  } else if (event.key === " " || event.key === "Enter") {
    if (event.repeat) { /* one change per key press */ }
    else if (led_by("keys")) end_hold(hand);
    else if (stays(hand)) hand.by = "keys";   // led again from its position
    else if (hand.down) let_go(hand);
    else take_hold(hand.pointer, "keys", hand);
  } else if (!arrow) return;
  event.preventDefault();
});
