// Pointer and keyboard in the plane.
import { let_go, take_hold } from "./hand.js";
import { aimed, stage, to_plane, view } from "./plane.js";
import { would_press } from "./snap.js";
import { hand, look, model } from "./state.js";
import { is_open } from "./transport.js";
import { add, clamp } from "./vectors.js";

const STEP = 0.001, LEAP = 0.005;   // m, of the arrow keys

const in_plane = event => {
  const box = stage.getBoundingClientRect();
  return to_plane([event.clientX - box.left, event.clientY - box.top]);
};
stage.addEventListener("pointerdown", event => {
  if (!model || event.button !== 0 || hand.down) return;
  stage.setPointerCapture(event.pointerId);
  take_hold(in_plane(event), event.pointerId);
});
stage.addEventListener("pointermove", event => {
  if (!model) return;
  if (hand.down && hand.by === event.pointerId) hand.pointer = in_plane(event);
  aim_at(!hand.down && is_open() && event.pointerType !== "touch" ? would_press(null, in_plane(event)) : null);
});
stage.addEventListener("pointerleave", () => aim_at(null));
/** Marks the contact at which a press would be. */
function aim_at(press) {
  const at = press && press.known ? press.contact : null;
  if (!at && !aimed.at) return;
  aimed.at = at;
  look.stale = true;
}
for (const name of ["pointerup", "pointercancel", "lostpointercapture"])
  stage.addEventListener(name, event => { if (hand.by === event.pointerId) let_go(); });

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
function ready_hand() {   // where the keyboard begins: before the contact of the demo, outside
  if (!model || hand.at) return;
  const place = model.places[Math.max(0, model.demo)];
  hand.at = hand.pointer = place ? add(place.contact_m, place.direction, -0.008) : add(model.low_m, [-0.01, -0.01]);
}
stage.addEventListener("focus", () => { ready_hand(); look.stale = true; });
stage.addEventListener("blur", () => { if (hand.by === "keys") let_go(); look.stale = true; });
stage.addEventListener("keydown", event => {
  if (!model || event.ctrlKey || event.altKey || event.metaKey) return;
  ready_hand();
  look.stale = true;
  const arrow = ARROWS[event.key];
  if (arrow) {
    const to = add(hand.pointer, arrow, event.shiftKey ? LEAP : STEP);
    hand.pointer = [clamp(to[0], view.low[0], view.high[0]), clamp(to[1], view.low[1], view.high[1])];
    if (!hand.down) hand.at = hand.pointer;
  } else if (event.key === " " || event.key === "Enter") {
    if (event.repeat) { /* one press, one change */ }
    else if (hand.down) let_go();
    else take_hold(hand.pointer, "keys");
  } else if (event.key === "Escape") let_go();
  else return;
  event.preventDefault();
});
