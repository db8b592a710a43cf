// The legend of colours, arrows and lines.
import { arrow, colours, font, shade, trace, warmth } from "./canvas.js";
import { nice } from "./scale.js";
import { is_solid, model, samples } from "./state.js";
import { largest, norm } from "./vectors.js";
import { unit_of } from "./words.js";

/** Force per metre of arrow [N/m]. The arrow of the strongest known force is 0.25 of the tissue's height long, in
 *  space 0.7. */
export function arrow_scale() {
  const most = model.strongest_N || largest(samples.map(s => norm(s.force)), 1e-3);
  const height = model.high_m[model.dimension - 1] - model.low_m[model.dimension - 1];
  return most / ((is_solid() ? 0.7 : 0.25) * height);   // seen from above, arrows in space appear shorter
}

export function draw_fe_outline(c, points, closed = true) {
  c.setLineDash([5, 5]);
  c.strokeStyle = colours.fe;
  c.lineWidth = 1.6;
  trace(c, points, closed);
  c.stroke();
  c.setLineDash([]);
}

/** Draws the legend along the lower edge of a canvas with pixels_m pixels per metre: colours of displacement, a round
 * force as an arrow, and the FE parts that are shown, {surface, force}. With worst > 0 the colours mean errors of force
 * from 0 to worst; else with stiffest > 0 stiffness from 1 / stiffest to stiffest. */
export function draw_legend(c, width, height, pixels_m, fe, { stiffest = 0, worst = 0 } = {}) {
  if (worst) stiffest = 0;
  const narrow = width < 520;
  const y = height - 34, bar = Math.min(narrow ? 150 : 240, 0.42 * width), x = width - bar - (narrow ? 22 : 24), most = worst ? 100 * worst : 1e3 * model.deepest_m;
  for (let k = 0; k < bar; k++) {
    c.fillStyle = stiffest ? warmth(2 * k / (bar - 1) - 1) : shade(k / (bar - 1));
    c.fillRect(x + k, y, 1.5, 10);
  }
  c.font = font(12);
  c.fillStyle = colours.soft;
  c.textBaseline = "alphabetic";
  const { step } = nice(most, narrow ? 3 : 5);
  c.textAlign = "center";
  if (stiffest)
    for (const [part, text] of [[0, (1 / stiffest).toFixed(2)], [0.5, "1"], [1, stiffest.toFixed(2)]]) {
      c.fillRect(x + bar * part - 0.5, y + 10, 1, 4);
      c.fillText(text, x + bar * part, y + 27);
    }
  else for (let value = 0; value <= most + 1e-9; value += step) {
    const at = x + bar * value / most, unit = worst ? " %" : " mm";
    c.fillRect(at - 0.5, y + 10, 1, 4);
    c.fillText(`${+value.toFixed(1)}${value + step > most + 1e-9 ? unit : ""}`, at, y + 27);
  }
  c.textAlign = "right";
  c.fillText(worst ? (narrow ? "error" : "force error") : stiffest ? (narrow ? "stiffness" : "stiffness ratio") : narrow ? "displaced" : "displacement", x - 8, y + 10);

  // a round force of the tool as an arrow for each mesh, in the mesh's colour; black is for FE
  const per_m = arrow_scale(), round = nice(per_m * 0.02, 1), length = round.top / per_m * pixels_m;
  const left = narrow ? 12 : 20, middle = (model.meshes.length - 1) / 2;
  model.meshes.forEach(({ name }, m) => arrow(c, [left, y + 5 + 9 * (m - middle)], [left + length, y + 5 + 9 * (m - middle)], colours[name] || colours.ink));
  c.textAlign = "left";
  c.fillStyle = colours.soft;
  const unit = unit_of(round.top);
  c.fillText(`${+(round.top * unit.scale).toPrecision(2)} ${unit.name}${narrow ? "" : ", force of the tool"}`, left + length + 9, y + 10);
  draw_fe_key(c, left, y, narrow, fe);
}

/** Draws the key of FE below: the surface, and in space the force. */
function draw_fe_key(c, left, y, narrow, { surface, force = false }) {
  let at = left;
  if (surface && is_solid()) {   // a wire frame
    c.strokeStyle = colours.fe_surface;
    c.lineWidth = 1.4;
    trace(c, [[at, y + 27], [at + 8, y + 19], [at + 16, y + 27], [at + 24, y + 19]], false);
    c.stroke();
    trace(c, [[at, y + 27], [at + 24, y + 27]], false);
    c.stroke();
  } else if (surface) draw_fe_outline(c, [[at, y + 23], [at + 25, y + 23]], false);
  if (surface) at += 34;
  if (force) {
    arrow(c, [at, y + 23], [at + 26, y + 23], colours.fe);
    at += 34;
  }
  if (at === left) return;
  c.fillStyle = colours.soft;
  const what = [surface ? "surface" : "", force ? "force" : ""].filter(Boolean).join(" and ");
  c.fillText(narrow || !is_solid() ? "FE" : `FE ${what} at the learned mesh's depth`, at, y + 27);
}
