// Where a model can be pressed, in words.
import { turn } from "./compare.js";
import { model } from "./state.js";
import { add, clamp, dot, norm } from "./vectors.js";

/** "top, x 50 mm" and the like: where a place is, on which side of the learned mesh. */
export function where(place) {
  const { low, high } = model.box, [x, y] = place.contact_m, close = 1e-6, mm = v => `${+(1e3 * v).toFixed(1)} mm`;
  const [left, right, top] = [x < low[0] + close, x > high[0] - close, y > high[1] - close];
  if (top && (left || right)) return { side: "top", text: left ? "left corner" : "right corner", order: x };
  if (top) return { side: "top", text: `x ${mm(x - low[0])}`, order: x };
  if (left || right) return { side: left ? "left side" : "right side", text: `y ${mm(y - low[1])}`, order: y };
  return { side: "elsewhere", text: `x ${mm(x - low[0])}, y ${mm(y - low[1])}`, order: x };
}

/** "down" or "right, 20° up": a push in words. */
export function way_of([x, y]) {
  const words = { right: [1, 0], up: [0, 1], left: [-1, 0], down: [0, -1] };
  const by_size = Object.keys(words).sort((a, b) => dot([x, y], words[b]) - dot([x, y], words[a]));
  const tilt = Math.round(180 / Math.PI * Math.acos(clamp(dot([x, y], words[by_size[0]]), -1, 1)));
  return by_size[0] + (tilt ? `, ${tilt}° ${by_size[1]}` : "");
}
export const title = k => `${where(model.places[k]).side}, ${where(model.places[k]).text}, pushed ${way_of(model.places[k].direction)}`;

/** What shares a contact: model.contacts, [{side, text, order, places}] in order; model.fans, by place the pushes at its
 *  contact by angle; model.apart_m, how close two contacts come. */
export function group_places() {
  const contacts = new Map();   // label -> {side, order, places}
  model.places.forEach((place, k) => {
    const at = where(place), key = `${at.side}, ${at.text}`;
    if (!contacts.has(key)) contacts.set(key, { ...at, places: [] });
    contacts.get(key).places.push(k);
  });
  model.contacts = [...contacts.values()].sort((a, b) => a.order - b.order);
  const at = model.contacts.map(contact => model.places[contact.places[0]].contact_m);
  model.fans = new Map();   // by place: the pushes at its contact, by angle
  for (const { places } of model.contacts) {
    const sum = places.reduce((all, k) => add(all, model.places[k].direction), [0, 0]);
    const from = norm(sum) > 1e-3 ? sum : model.places[places[0]].direction;
    const pushes = places.map(place => ({ place, angle: turn(from, model.places[place].direction) })).sort((a, b) => a.angle - b.angle);
    for (const k of places) model.fans.set(k, { from, pushes });
  }
  model.apart_m = Math.min(...at.flatMap((p, i) => at.slice(i + 1).map(q => norm(add(p, q, -1)))));   // Infinity for one
}
