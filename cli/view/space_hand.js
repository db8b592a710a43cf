// Pointer and keyboard in space: press where a solid is touched, turn and zoom beside it.
import { SNAP, apart } from "./compare.js";
import { shows_errors, spot_at, tell_error } from "./errors.js";
import { let_go, take_hold } from "./hand.js";
import { aim, screen_axes, space_to_screen, stage, touched, view } from "./space.js";
import { IN, LEARNED, hand, look, model, state } from "./state.js";
import { is_open } from "./transport.js";
import { add, clamp, cross, dot, norm, unit } from "./vectors.js";
import { $, millimetres } from "./words.js";

const INSET = 0.0003;        // m: the tool is on the tissue, not beside it
const PRESS = 0.03;          // m/s, into the tissue
const COMING = 2000;         // ms that the tool is waited for
const STEEPEST = 60;         // degrees off the inward normal
const TILT = 0.35, TURN = 0.4;   // degrees a pixel
const NOTCH = 0.0005;        // m of depth, by wheel and keys

let press = null;            // {mesh, contact, inward, direction, depth, begun, arrived, from}
let turning = null;          // {by, x, y}
const fingers = new Map();   // on the canvas: pointerId -> [x, y]
let spread = 0;              // between two of them, pixels

const deepest = () => model.deepest_m;
const wanted = () => Number($("depth").value) / 1e3;

export function show_depth() {
  $("depth").max = 1e3 * deepest();
  $("depth").value = Math.round(600 * deepest() / 0.5) * 0.5;
  say_depth();
}
const say_depth = () => { $("depth_now").textContent = millimetres(wanted()); };
function set_depth(depth) {
  $("depth").value = clamp(1e3 * depth, 0, 1e3 * deepest());
  say_depth();
}
$("depth").addEventListener("input", say_depth);
$("fe_wanted").addEventListener("change", () => { look.stale = true; });

/** At a contact that FE have solved, when there is one so close. */
function snapped(touch) {
  let best = null, least = SNAP;
  for (const { contact_m, inward } of model.places) {
    const at = add(contact_m, apart(touch.mesh)), distance = norm(add(at, touch.at, -1));
    if (distance < least) [best, least] = [{ mesh: touch.mesh, at, inward }, distance];
  }
  return best || touch;
}

function begin_press(touch, by, direction = touch.inward, from = null) {
  if (hand.down) return false;
  const { at, mesh, inward } = touch;
  take_hold(add(at, inward, INSET), by);
  if (!hand.down) return false;
  press = { mesh, contact: at, inward, direction, depth: 0, begun: null, arrived: false, from };
  return true;
}

/** Once a frame: the tool goes on until it is as deep as it shall be. */
export function lead(now, before) {
  if (!hand.down) press = null;
  if (!press) return;
  press.begun = press.begun || now;
  press.arrived = press.arrived || state && state.v[IN.pressed] === press.mesh || now - press.begun > COMING;
  const step = PRESS * clamp((now - before) / 1e3, 0, 0.05), goal = press.arrived ? wanted() : 0;
  press.depth += clamp(goal - press.depth, -step, step);
  const at = add(add(press.contact, press.inward, INSET), press.direction, press.depth);
  if (norm(add(at, hand.at, -1)) > 1e-6) hand.at = at;
}

/** Tilts a push by so many pixels to the right and down. */
function tilted(from, dx, dy) {
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
  if (!model || event.button !== 0) return;
  const at = in_canvas(event);
  fingers.set(event.pointerId, at);
  stage.setPointerCapture(event.pointerId);
  if (fingers.size === 2) {   // two fingers zoom, whatever the first began
    if (hand.down && hand.by !== "keys") let_go();
    turning = null;
    spread = pinch();
  }
  if (fingers.size > 1 || hand.down) return;
  const touch = touched(...at);
  if (touch) begin_press(snapped(touch), event.pointerId, undefined, { at, direction: null });
  else turning = { by: event.pointerId, at };
});
stage.addEventListener("pointermove", event => {
  if (!model) return;
  const at = in_canvas(event);
  if (fingers.has(event.pointerId)) fingers.set(event.pointerId, at);
  if (fingers.size === 2) {
    const now = pinch();
    if (spread > 0 && now > 0) zoom(now / spread);
    spread = now;
  } else if (press && hand.down && hand.by === event.pointerId) {
    press.from.direction = press.from.direction || press.direction;
    press.direction = tilted(press.from.direction, at[0] - press.from.at[0], at[1] - press.from.at[1]);
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
    if (hand.by === event.pointerId) let_go();
    if (turning && turning.by === event.pointerId) turning = null;
  });
stage.addEventListener("pointerleave", () => { tell_error(null); if (document.activeElement !== stage) point_at(null); });
stage.addEventListener("wheel", event => {
  event.preventDefault();
  if (hand.down) set_depth(wanted() - Math.sign(event.deltaY) * NOTCH);
  else zoom(Math.exp(-0.0015 * clamp(event.deltaY, -200, 200)));
}, { passive: false });

/** Where the keyboard presses: at the contact and with the push that the lists name, or where the demo begins. */
function chosen() {
  const k = Number($("way").value), place = model.places[k >= 0 ? k : Math.max(0, model.demo)];
  return place && { mesh: LEARNED, at: place.contact_m, inward: place.inward, direction: place.direction };
}
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
stage.addEventListener("focus", () => { if (model && chosen() && stage.matches(":focus-visible")) Object.assign(aim, chosen()); look.stale = true; });
stage.addEventListener("blur", () => { if (hand.by === "keys") let_go(); look.stale = true; });
stage.addEventListener("keydown", event => {
  if (!model || event.ctrlKey || event.altKey || event.metaKey) return;
  const arrow = ARROWS[event.key];
  look.stale = true;
  if (arrow && event.shiftKey) {
    if (press && hand.down) press.direction = tilted(press.direction, 5 / TILT * arrow[0], 5 / TILT * arrow[1]);
  } else if (arrow) turn(5 * arrow[0], 5 * arrow[1]);
  else if (event.key === "+" || event.key === "=") zoom(1.15);
  else if (event.key === "-") zoom(1 / 1.15);
  else if (event.key === "Home") Object.assign(view, { azimuth: -62, elevation: 30, zoom: 1 });
  else if (event.key === "PageUp") set_depth(wanted() - NOTCH);
  else if (event.key === "PageDown") set_depth(wanted() + NOTCH);
  else if (event.key === " " || event.key === "Enter") {
    if (event.repeat) { /* one press, one change */ }
    else if (hand.down) let_go();
    else {
      const touch = chosen();
      if (touch) {
        Object.assign(aim, touch);
        begin_press(touch, "keys", touch.direction);
      }
    }
  } else if (event.key === "Escape") let_go();
  else return;
  event.preventDefault();
});

/** The push as it stands: for those who look on. */
export const pressing = () => press && hand.down && { contact_m: [...press.contact], direction: [...press.direction], inward: [...press.inward], depth_m: press.depth };
