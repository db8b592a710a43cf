// Numbers and units as text.
import { model } from "./state.js";

export const $ = id => document.getElementById(id);
export const millimetres = m => Number.isFinite(m) ? `${(1e3 * m).toFixed(1)}\u00a0mm` : "–";
export const unit_of = force => Math.abs(force) < 0.1 ? { name: "mN", scale: 1e3 } : { name: "N", scale: 1 };
/** A force in the unit that suits the model, so that the unit does not change with the value. */
export function newtons(force, like = model.strongest_N || force) {
  if (!Number.isFinite(force)) return "–";
  const unit = unit_of(like), x = unit.scale * force;
  return `${x.toFixed(Math.abs(x) >= 100 ? 0 : Math.abs(x) >= 10 ? 1 : x === 0 || Math.abs(x) >= 0.1 ? 2 : 3)}\u00a0${unit.name}`;
}
export const percent = x => `${100 * x < 9.95 ? (100 * x).toFixed(1) : Math.round(100 * x)}\u00a0%`;
/** The same with a sign, such as "+10 %" and "−37 %"; none before zero. */
export const signed_percent = x => `${Math.abs(100 * x) < 0.05 ? "" : x > 0 ? "+" : "−"}${percent(Math.abs(x))}`;
/** Relaxation of the model as text: "30 % of the force with a relaxation time of 0.05 s, 25 % with 1 s". */
export const relaxing = () => model.relaxation.tau_s.map((tau, k) => `${percent(model.relaxation.share[k])}${k ? " with" : " of the force with a relaxation time of"} ${+tau.toPrecision(3)}\u00a0s`).join(", ");
export const say = (id, text) => { if ($(id).textContent !== text) $(id).textContent = text; };
