// Pointer and keyboard in space: indentation on a solid, turning and zooming beside it.
import { SNAP, apart } from "./compare.js";
import { shows_errors, spot_at, tell_error } from "./errors.js";
import { end_hold, leading, led_by, let_all_go, let_go, next_hand, own_hands, stays, take_hold } from "./hand.js";
import { aim, screen_axes, space_to_screen, stage, touched, view } from "./space.js";
import { LEARNED, look, model, pressed_by } from "./state.js";
import { is_open } from "./transport.js";
import { add, clamp, cross, dot, norm, unit } from "./vectors.js";
import { $, millimetres } from "./words.js";

const INSET = 0.0003;        // m below the surface, so that the tool touches the tissue
const PRESS = 0.03;          // m/s, into the tissue
const COMING = 2000;         // ms, longest wait for the tool
const STEEPEST = 60;         // degrees, largest angle from the inward normal
const TILT = 0.35, TURN = 0.4;   // degrees per pixel
const NOTCH = 0.0005;        // m, step of depth by wheel and keys

// press of a hand: {mesh, contact, inward, direction, depth: present, wanted: by the slider, begun, arrived, from}
let turning = null;          // {by, at}
const fingers = new Map();   // on the canvas: pointerId -> [x, y]
let pinching = false, spread = 0;   // whether two of them zoom; their distance in pixels, 0: not known yet

const deepest = () => model.deepest_m;
const wanted = () => Number($("depth").value) / 1e3;

export function show_depth() {
  $("depth").max = 1e3 * deepest();
  set_lowest();
  $("depth").value = Math.round(600 * deepest() / 0.5) * 0.5;
  say_depth();
}
/** A tool that grasps lifts too: its depth may be below zero. */
function set_lowest() {
  $("depth").min = $("grasp").checked ? -1e3 * deepest() : 0;
  say_depth();
}
$("grasp").addEventListener("change", () => { if (model) set_lowest(); });
const say_depth = () => { $("depth_now").textContent = millimetres(wanted()); };
function set_depth(depth) {
  $("depth").value = clamp(1e3 * depth, Number($("depth").min), 1e3 * deepest());
  say_depth();
}
$("depth").addEventListener("input", say_depth);
$("fe_wanted").addEventListener("change", () => { look.stale = true; });

/** The nearest known contact within SNAP of a touch, else the touch. */
function snapped(touch) {
  let best = null, least = SNAP;
  for (const { contact_m, inward } of model.places) {
    const at = add(contact_m, apart(touch.mesh)), distance = norm(add(at, touch.at, -1));
    if (distance < least) [best, least] = [{ mesh: touch.mesh, at, inward }, distance];
  }
  return best || touch;
}

function begin_press(touch, by, direction = touch.inward, from = null) {
  const { at, mesh, inward } = touch, hand = take_hold(add(at, inward, INSET), by);
  if (!hand) return false;
  hand.press = { mesh, contact: at, inward, direction, depth: 0, wanted: null, begun: null, out: false, arrived: false, from };
  return true;
}

/** Once a frame: moves each tool towards its depth. A tool that stays in the tissue keeps its depth. */
export function lead(now, before) {
  for (const hand of own_hands()) if (hand.press) go_on(hand, now, before);
}

function go_on(hand, now, before) {
  const { press } = hand;
  press.begun = press.begun || now;
  press.out = press.out || pressed_by(hand.tool) < 0;   // until then it is in its previous indentation
  press.arrived = press.arrived || press.out && pressed_by(hand.tool) === press.mesh || now - press.begun > COMING;
  if (!stays(hand) || press.wanted === null) press.wanted = wanted();
  const step = PRESS * clamp((now - before) / 1e3, 0, 0.05), goal = press.arrived ? press.wanted : 0;
  press.depth += clamp(goal - press.depth, -step, step);
  const at = add(add(press.contact, press.inward, INSET), press.direction, press.depth);
  if (norm(add(at, hand.at, -1)) > 1e-6) hand.at = at;
}

/** Tilts a direction of an indentation by a drag of dx pixels to the right and dy down. */
function tilted(press, from, dx, dy) {
  const [right, up] = screen_axes(), aside = [0, 1, 2].map(k => right[k] * dx - up[k] * dy), { inward } = press;
  const along = add(aside, inward, -dot(aside, inward));
  if (norm(along) < 1e-9) return from;
  const off = add(from, unit(along), Math.tan(clamp(TILT * Math.hypot(dx, dy), 0, 80) * Math.PI / 180)), straight = dot(off, inward);
  const side = add(off, inward, -straight), most = Math.tan(STEEPEST * Math.PI / 180) * Math.max(straight, 1e-3);
  return unit(add(inward.map(x => x * Math.max(straight, 1e-3)), side, Math.min(1, most / Math.max(norm(side), 1e-12))));
}

const turn = (dx, dy) => {
  view.azimuth -= dx;
  view.elevation = clamp(view.elevation + dy, -25, 89);
  tell_error(null);   // its dot moves away
  look.stale = true;
};
const zoom = by => {
  view.zoom = clamp(view.zoom * by, 0.4, 8);
  tell_error(null);
  look.stale = true;
};
const in_canvas = event => {
  const box = stage.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
};
const pinch = () => {
  const [a, b] = [...fingers.values()];
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
};

stage.addEventListener("pointerdown", event => {
  if (!model || event.button !== 0 || led_by(event.pointerId)) return;
  const at = in_canvas(event);
  fingers.set(event.pointerId, at);
  stage.setPointerCapture(event.pointerId);
  const touch = touched(...at), first = own_hands().find(hand => hand.down && fingers.has(hand.by));
  if (fingers.size === 2 && !(touch && first && next_hand())) {   // two fingers zoom, unless each leads a tool
    let_go(first);
    turning = null;
    pinching = true;
    spread = pinch();
  }
  if (pinching || fingers.size > (first ? 2 : 1)) return;
  if (touch && next_hand()) begin_press(snapped(touch), event.pointerId, undefined, { at, direction: null });
  else if (!touch && !first) turning = { by: event.pointerId, at };
});
stage.addEventListener("pointermove", event => {
  if (!model) return;
  const at = in_canvas(event), hand = led_by(event.pointerId);
  if (fingers.has(event.pointerId)) fingers.set(event.pointerId, at);
  if (pinching && fingers.size === 2) {
    const now = pinch();
    if (spread > 0 && now > 0) zoom(now / spread);
    spread = now;
  } else if (hand && hand.press) {
    const { press } = hand;
    press.from.direction = press.from.direction || press.direction;
    press.direction = tilted(press, press.from.direction, at[0] - press.from.at[0], at[1] - press.from.at[1]);
  } else if (turning && turning.by === event.pointerId) {
    turn(TURN * (at[0] - turning.at[0]), TURN * (at[1] - turning.at[1]));
    turning.at = at;
  } else if (fingers.size === 0 && event.pointerType !== "touch") point_at(is_open() ? touched(...at) : null, at);
});
function point_at(touch, place) {
  tell_error(place && shows_errors() ? spot_at(place, space_to_screen, cross(...screen_axes())) : null, place);
  stage.style.cursor = touch ? "crosshair" : "grab";
  const at = touch && snapped(touch);
  if (!at && !aim.at) return;
  Object.assign(aim, at || { at: null });
  look.stale = true;
}
for (const name of ["pointerup", "pointercancel", "lostpointercapture"])
  stage.addEventListener(name, event => {
    fingers.delete(event.pointerId);
    spread = 0;
    if (fingers.size < 2) pinching = false;
    end_hold(led_by(event.pointerId));
    if (turning && turning.by === event.pointerId) turning = null;
  });
stage.addEventListener("pointerleave", () => { tell_error(null); if (document.activeElement !== stage) point_at(null); });
stage.addEventListener("wheel", event => {
  event.preventDefault();
  if (leading()) set_depth(wanted() - Math.sign(event.deltaY) * NOTCH);
  else zoom(Math.exp(-0.0015 * clamp(event.deltaY, -200, 200)));
}, { passive: false });

/** Contact and direction for the keyboard: those chosen in the lists, or those where the demo starts. */
function chosen() {
  const k = Number($("way").value), place = model.places[k >= 0 ? k : Math.max(0, model.demo)];
  return place && { mesh: LEARNED, at: place.contact_m, inward: place.inward, direction: place.direction };
}
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
stage.addEventListener("focus", () => { if (model && chosen() && stage.matches(":focus-visible")) Object.assign(aim, chosen()); look.stale = true; });
stage.addEventListener("blur", () => { end_hold(led_by("keys")); look.stale = true; });
stage.addEventListener("keydown", event => {
  if (!model || event.ctrlKey || event.altKey || event.metaKey) return;
  const arrow = ARROWS[event.key], hand = led_by("keys") || own_hands().find(one => one.press && !stays(one));
  look.stale = true;
  if (arrow && event.shiftKey) {
    if (hand) hand.press.direction = tilted(hand.press, hand.press.direction, 5 / TILT * arrow[0], 5 / TILT * arrow[1]);
  } else if (arrow) turn(5 * arrow[0], 5 * arrow[1]);
  else if (event.key === "+" || event.key === "=") zoom(1.15);
  else if (event.key === "-") zoom(1 / 1.15);
  else if (event.key === "Home") Object.assign(view, { azimuth: -62, elevation: 30, zoom: 1 });
  else if (event.key === "PageUp") set_depth(wanted() - NOTCH);
  else if (event.key === "PageDown") set_depth(wanted() + NOTCH);
  else if (event.key === " " || event.key === "Enter") {
    if (event.repeat) { /* one change per key press */ }
    else if (led_by("keys")) end_hold(led_by("keys"));
    else if (model.tools < 2 && leading()) let_all_go();
    else if (next_hand()) {
      const touch = chosen();
      if (touch) {
        Object.assign(aim, touch);
        begin_press(touch, "keys", touch.direction);
      }
    }
  } else return;
  event.preventDefault();
});

/** The present indentation of the first tool that has one, for window.tissue. */
export function pressing() {
  const hand = own_hands().find(one => one.press);
  return hand && { contact_m: [...hand.press.contact], direction: [...hand.press.direction], inward: [...hand.press.inward], depth_m: hand.press.depth };
}
