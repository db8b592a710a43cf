// Pointer and keyboard in the plane.
import { let_go, take_hold } from "./hand.js";
import { stage, to_plane, view } from "./plane.js";
import { hand, look, model } from "./state.js";
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
stage.addEventListener("pointermove", event => { if (hand.down && hand.by === event.pointerId) hand.at = in_plane(event); });
for (const name of ["pointerup", "pointercancel", "lostpointercapture"])
  stage.addEventListener(name, event => { if (hand.by === event.pointerId) let_go(); });

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
function ready_hand() {   // where the keyboard begins: before the contact of the demo, outside
  if (!model || hand.at) return;
  const place = model.places[Math.max(0, model.demo)];
  hand.at = place ? add(place.contact_m, place.direction, -0.008) : add(model.low_m, [-0.01, -0.01]);
}
stage.addEventListener("focus", () => { ready_hand(); look.stale = true; });
stage.addEventListener("blur", () => { if (hand.by === "keys") let_go(); look.stale = true; });
stage.addEventListener("keydown", event => {
  if (!model || event.ctrlKey || event.altKey || event.metaKey) return;
  ready_hand();
  look.stale = true;
  const arrow = ARROWS[event.key];
  if (arrow) {
    const to = add(hand.at, arrow, event.shiftKey ? LEAP : STEP);
    hand.at = [clamp(to[0], view.low[0], view.high[0]), clamp(to[1], view.low[1], view.high[1])];
  } else if (event.key === " " || event.key === "Enter") {
    if (event.repeat) { /* one press, one change */ }
    else if (hand.down) let_go();
    else take_hold(hand.at, "keys");
  } else if (event.key === "Escape") let_go();
  else return;
  event.preventDefault();
});
