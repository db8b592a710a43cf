// Contacts and directions of a model as text.
import { turn } from "./compare.js";
import { is_solid, model } from "./state.js";
import { add, angle_between, clamp, dot, norm, unit } from "./vectors.js";

/** Position of a place on the learned mesh as text, such as "top, x 50 mm". */
export function where(place) {
  if (is_solid()) return where_in_space(place);
  const { low, high } = model.box, [x, y] = place.contact_m, close = 1e-6, mm = v => `${+(1e3 * v).toFixed(1)} mm`;
  const [left, right, top] = [x < low[0] + close, x > high[0] - close, y > high[1] - close];
  if (top && (left || right)) return { side: "top", text: left ? "left corner" : "right corner", order: x };
  if (top) return { side: "top", text: `x ${mm(x - low[0])}`, order: x };
  if (left || right) return { side: left ? "left side" : "right side", text: `y ${mm(y - low[1])}`, order: y };
  return { side: "elsewhere", text: `x ${mm(x - low[0])}, y ${mm(y - low[1])}`, order: x };
}

function where_in_space(place) {
  const { low, high } = model.box, [x, y, z] = place.contact_m, close = 1e-6;
  const mm = (...axes) => axes.map(a => `${"xyz"[a]} ${+(1e3 * (place.contact_m[a] - low[a])).toFixed(1)}`).join(", ") + " mm";
  const sides = { top: [z > high[2] - close, 0, 1], "left side": [x < low[0] + close, 1, 2], "right side": [x > high[0] - close, 1, 2],
                  front: [y < low[1] + close, 0, 2], back: [y > high[1] - close, 0, 2] };
  for (const [side, [here, ...axes]] of Object.entries(sides)) if (here) return { side, text: mm(...axes), order: place.contact_m[axes[0]] };
  return { side: "elsewhere", text: mm(0, 1, 2), order: x };
}

/** Direction of a place in space as text: "straight in" or "tilted 30° to the right". */
function way_in_space({ direction, inward }) {
  const tilt = Math.round(angle_between(direction, inward)), words = { "to the right": [1, 0, 0], "to the left": [-1, 0, 0],
    backward: [0, 1, 0], forward: [0, -1, 0], up: [0, 0, 1], down: [0, 0, -1] };
  if (tilt === 0) return "straight in";
  const aside = unit(add(direction, inward, -dot(direction, inward)));
  const by_size = Object.keys(words).filter(word => dot(words[word], aside) > 0.38).sort((a, b) => dot(aside, words[b]) - dot(aside, words[a]));
  return `tilted ${tilt}° ${by_size.join(" and ")}`;
}

/** Direction of a place as text, in the plane "down" or "right, 20° up". */
export function way_of(place) {
  if (is_solid()) return way_in_space(place);
  const [x, y] = place.direction;
  const words = { right: [1, 0], up: [0, 1], left: [-1, 0], down: [0, -1] };
  const by_size = Object.keys(words).sort((a, b) => dot([x, y], words[b]) - dot([x, y], words[a]));
  const tilt = Math.round(180 / Math.PI * Math.acos(clamp(dot([x, y], words[by_size[0]]), -1, 1)));
  return by_size[0] + (tilt ? `, ${tilt}° ${by_size[1]}` : "");
}
export const title = k => `${where(model.places[k]).side}, ${where(model.places[k]).text}, direction ${way_of(model.places[k])}`;

/** Groups places by contact: model.contacts, [{side, text, order, places}] in order; model.fans, by place the
 *  directions at its contact by angle; model.apart_m, the least distance between two contacts. */
export function group_places() {
  const contacts = new Map();   // label -> {side, order, places}
  model.places.forEach((place, k) => {
    const at = where(place), key = `${at.side}, ${at.text}`;
    if (!contacts.has(key)) contacts.set(key, { ...at, places: [] });
    contacts.get(key).places.push(k);
  });
  model.contacts = [...contacts.values()].sort((a, b) => a.order - b.order);
  const at = model.contacts.map(contact => model.places[contact.places[0]].contact_m);
  model.fans = new Map();   // by place: the directions at its contact, by angle
  for (const { places } of model.contacts) {
    if (is_solid()) break;
    const sum = places.reduce((all, k) => add(all, model.places[k].direction), [0, 0]);
    const from = norm(sum) > 1e-3 ? sum : model.places[places[0]].direction;
    const pushes = places.map(place => ({ place, angle: turn(from, model.places[place].direction) })).sort((a, b) => a.angle - b.angle);
    for (const k of places) model.fans.set(k, { from, pushes });
  }
  model.apart_m = Infinity;   // of a single contact
  at.forEach((p, i) => { for (let j = 0; j < i; j++) model.apart_m = Math.min(model.apart_m, norm(add(p, at[j], -1))); });
}
