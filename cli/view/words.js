// Numbers and units as people read them.
import { model } from "./state.js";

export const $ = id => document.getElementById(id);
export const millimetres = m => Number.isFinite(m) ? `${(1e3 * m).toFixed(1)}\u00a0mm` : "–";
export const unit_of = force => Math.abs(force) < 0.1 ? { name: "mN", scale: 1e3 } : { name: "N", scale: 1 };
/** In the unit that suits the model: one that does not change from reading to reading. */
export function newtons(force, like = model.strongest_N || force) {
  if (!Number.isFinite(force)) return "–";
  const unit = unit_of(like), x = unit.scale * force;
  return `${x.toFixed(Math.abs(x) >= 100 ? 0 : Math.abs(x) >= 10 ? 1 : x === 0 || Math.abs(x) >= 0.1 ? 2 : 3)}\u00a0${unit.name}`;
}
export const percent = x => `${100 * x < 9.95 ? (100 * x).toFixed(1) : Math.round(100 * x)}\u00a0%`;
/** How the model relaxes: "30 % of its force in 0.05 s, 25 % in 1 s". */
export const relaxing = () => model.relaxation.tau_s.map((tau, k) => `${percent(model.relaxation.share[k])}${k ? "" : " of the force"} with a time of ${+tau.toPrecision(3)}\u00a0s`).join(", ");
export const say = (id, text) => { if ($(id).textContent !== text) $(id).textContent = text; };
