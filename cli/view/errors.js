// The error map of a solid: the indentation error of contact force at every training contact and every drawn one. The
// errors are those of the evaluation, in equilibrium without relaxation; the present indentation does not change them.
import * as THREE from "./three.module.js";
import { shade } from "./canvas.js";
import { apart } from "./compare.js";
import { shows_learned } from "./learned.js";
import { nice } from "./scale.js";
import { LEARNED, look, model } from "./state.js";
import { add, angle_between, dot, largest } from "./vectors.js";
import { $, millimetres, percent, say } from "./words.js";

const WIDE = 13;      // pixels, size of a dot
const LISTED = 6;     // indentations that are listed of one contact

export const shows_errors = () => Boolean(model.errors) && $("errors_wanted").checked;
$("errors_wanted").addEventListener("change", () => { tell_error(null); name_scale(); look.stale = true; });
$("learned_wanted").addEventListener("change", () => name_scale());

/** Text of the legend for screen readers. */
const name_scale = () => $("space_legend").setAttribute("aria-label",
  `Colour: ${shows_errors() ? "error of contact force at each contact in per cent" : shows_learned() ? "stiffness over the trained stiffness" : "displacement in millimetres"}; arrows: force of the tool`);

const told = ({ error }) => error === null ? "no answer" : `error ${percent(error)}`;
const SETS = new Map([["trained", "training set"], ["validation", "validation set"], ["held_out", "test set"]]);
/** Role of an indentation as text: its set, and for "held_out_WORD" also the word. */
const set_of = role => SETS.get(role) ?? role.replace(/^held_out_/, "test set, ").replaceAll("_", " ");
const worse = (a, b) => (b.error ?? Infinity) - (a.error ?? Infinity);   // missing answers first

/** Sets model.spots, the errors by contact, largest first; and the label of the box. */
export function prepare_errors() {
  $("errors_row").hidden = !model.errors;
  tell_error(null);
  name_scale();
  if (!model.errors) return;
  const spots = new Map();
  for (const push of model.errors) {
    const key = push.contact_m.map(x => Math.round(1e8 * x)).join();
    if (!spots.has(key)) spots.set(key, { contact_m: push.contact_m, inward: push.inward, pushes: [] });
    spots.get(key).pushes.push(push);
  }
  model.spots = [...spots.values()];
  for (const { pushes } of model.spots) pushes.sort(worse);
  const known = model.errors.filter(push => push.error !== null), none = model.errors.length - known.length;
  model.worst_error = nice(largest(known.map(push => 100 * push.error), 1), 4).top / 100;
  say("errors_text", `Error map: error of contact force at ${model.spots.length} contacts${none ? `, ${none} of ${model.errors.length} indentations without an answer` : ""}`);
}

/** A disc with a dark rim, or a cross for a missing answer. */
function sign(cross) {
  const canvas = document.createElement("canvas"), c = canvas.getContext("2d");
  canvas.width = canvas.height = 32;
  c.lineCap = "round";
  if (cross)
    for (const [width, colour] of [[11, "#000"], [5, "#fff"]]) {
      [c.lineWidth, c.strokeStyle] = [width, colour];
      for (const up of [6, 26]) { c.beginPath(); c.moveTo(6, up); c.lineTo(26, 32 - up); c.stroke(); }
    }
  else {
    c.arc(16, 16, 13, 0, 2 * Math.PI);
    [c.fillStyle, c.strokeStyle, c.lineWidth] = ["#fff", "#000", 4];
    c.fill();
    c.stroke();
  }
  return new THREE.CanvasTexture(canvas);
}

const rgb = spot => spot.pushes[0].error === null ? [1, 1, 1] : shade(spot.pushes[0].error / model.worst_error).match(/\d+/g).map(x => x / 255);

/** The dots on the learned mesh, slightly outside its surface; the colour is that of the contact's largest error. */
export function error_dots(size) {
  const group = new THREE.Group();
  for (const cross of [false, true]) {
    const spots = model.spots.filter(({ pushes }) => (pushes[0].error === null) === cross), geometry = new THREE.BufferGeometry();
    for (const spot of spots) spot.drawn = add(add(spot.contact_m, apart(LEARNED)), spot.inward, -0.012 * size);
    const at = spots.flatMap(spot => spot.drawn);
    geometry.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(at), 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(Float32Array.from(spots.flatMap(rgb)), 3));
    const dots = new THREE.Points(geometry, new THREE.PointsMaterial({ size: WIDE, sizeAttenuation: false,
      map: sign(cross), alphaTest: 0.4, vertexColors: THREE.VertexColors }));
    dots.frustumCulled = false;
    group.add(dots);
  }
  return group;
}

/** The contact whose dot is under a pointer at x, y of the canvas; null without one. to_screen: pixels of a point;
 *  toward: direction to the eye. */
export function spot_at([x, y], to_screen, toward) {
  let best = null, least = WIDE / 2;
  for (const spot of model.spots) {
    if (dot(spot.inward, toward) > 0) continue;   // on the far side
    const [across, down] = to_screen(spot.drawn), away = Math.hypot(across - x, down - y);
    if (away <= least) [best, least] = [spot, away];
  }
  return best;
}

/** Shows the errors of a contact beside the pointer at x, y of the stage; spot null: hides them. */
export function tell_error(spot, [x, y] = [0, 0]) {
  $("error_tip").hidden = spot === null;
  if (!spot) return;
  const lines = spot.pushes.slice(0, LISTED).map(push => `${told(push)}: ${set_of(push.role)}, ${millimetres(push.depth_m)} deep, ` +
    `${Math.round(angle_between(push.direction, push.inward))}° from straight in`);
  if (spot.pushes.length > LISTED) lines.push(`and ${spot.pushes.length - LISTED} more, no larger error`);
  say("error_tip", lines.join("\n"));
  // left of the pointer, so that the text stays on the page
  const left = x > $("error_tip").parentElement.clientWidth / 2;
  $("error_tip").style.transform = left ? "translateX(calc(-100% - 28px))" : "";
  $("error_tip").style.left = `${x + 14}px`;
  $("error_tip").style.top = `${y + 14}px`;
}

/** For tests: the contacts, and the end of the scale; null if no map is drawn. */
export const error_map = () => shows_errors() ? { worst: model.worst_error,
  spots: model.spots.map(({ contact_m, inward, pushes }) => ({ contact_m: [...contact_m], inward: [...inward], errors: pushes.map(push => push.error) })) } : null;
