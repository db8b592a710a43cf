// Force over depth, and over time.
import { begin, colours, font, trace } from "./canvas.js";
import { fe_curve, pushed } from "./compare.js";
import { nice } from "./scale.js";
import { IN, LEARNED, WINDOW, model, relaxes, samples, state } from "./state.js";
import { largest } from "./vectors.js";
import { $, unit_of } from "./words.js";

/** Draws frame, grid, ticks and labels; returns the map of a plot's units to pixels. */
function axes(c, width, height, x, y) {
  const box = { left: 46, top: 20, right: width - 12, bottom: height - 36 };
  const X = v => box.left + (box.right - box.left) * (v - x.low) / (x.high - x.low);
  const Y = v => box.bottom - (box.bottom - box.top) * v / y.high;
  c.font = font(12);
  c.lineWidth = 1;
  c.textBaseline = "middle";
  for (let v = 0; v <= y.high * 1.0001; v += y.step) {
    const at = Math.round(Y(v)) + 0.5;
    c.strokeStyle = v === 0 ? colours.soft : colours.grid;
    trace(c, [[box.left, at], [box.right, at]], false);
    c.stroke();
    c.fillStyle = colours.soft;
    c.textAlign = "right";
    c.fillText((v * y.scale).toFixed(y.digits), box.left - 7, at);
  }
  c.textAlign = "center";
  c.textBaseline = "top";
  for (let v = x.low; v <= x.high * 1.0001 + 1e-12; v += x.step) {
    const at = Math.round(X(v)) + 0.5;
    c.strokeStyle = v === x.low ? colours.soft : colours.grid;
    trace(c, [[at, box.top], [at, box.bottom]], false);
    c.stroke();
    c.fillStyle = colours.soft;
    c.fillText(String(+(v * x.scale).toFixed(2)).replace("-", "−"), at, box.bottom + 5);
  }
  c.textAlign = "right";
  c.fillText(x.label, box.right, box.bottom + 20);
  c.textAlign = "left";
  c.textBaseline = "alphabetic";
  c.fillText(y.label, 2, box.top - 8);
  return { X, Y, box };
}

const force_axis = most => {
  const unit = unit_of(most), ticks = nice(most * unit.scale);
  return { high: ticks.top / unit.scale, step: ticks.step / unit.scale, scale: unit.scale, digits: ticks.digits, label: unit.name };
};

export function line(c, points) {
  c.beginPath();
  let pen = false;
  for (const [x, y] of points) {
    if (!Number.isFinite(x) || !Number.isFinite(y)) pen = false;
    else if (pen) c.lineTo(x, y);
    else { c.moveTo(x, y); pen = true; }
  }
  c.stroke();
}

/** The samples of the present indentation, or of the last one. */
function last_press() {
  let to = samples.length;
  while (to > 0 && !samples[to - 1].pressed) to--;
  let from = to;
  while (from > 0 && samples[from - 1].pressed) from--;
  return samples.slice(from, to);
}

export function draw_depth_plot(comparable) {
  const { c, width, height } = begin($("depth_plot"));
  if (!model) return;
  const press = last_press(), now = state && state.v[IN.pressed] >= 0;
  const k = press.length ? press[press.length - 1].place : -1, place = model.places[k];
  const curve = place ? place.curve.length && fe_curve(k, press[press.length - 1].moved[LEARNED]) || place.curve : [];
  const meshes = model.meshes.map((_, m) => press.map(s => pushed(s, m)));
  const deepest = largest(meshes.flat().map(p => p[0]), model.deepest_m);
  const most = largest([...curve, ...meshes[LEARNED]].map(p => p[1]), curve.length ? 1e-4 : Math.max(1e-4, model.strongest_N));
  const mm = nice(1e3 * deepest, 5);
  const { X, Y, box } = axes(c, width, height, { low: 0, high: mm.top * 1e-3, step: mm.step * 1e-3, scale: 1e3, label: "depth along the displacement (mm)" },
                             force_axis(most * 1.04));
  c.save();
  c.beginPath();
  c.rect(box.left - 5, box.top - 5, box.right - box.left + 10, box.bottom - box.top + 10);
  c.clip();
  // FE curve with dots at the FE depths; faint while it is not comparable
  c.globalAlpha = comparable ? 1 : 0.3;
  c.strokeStyle = c.fillStyle = colours.fe;
  c.lineWidth = 3;
  line(c, curve.map(([d, f]) => [X(d), Y(f)]));
  for (const [d, f] of curve) {
    c.beginPath();
    c.arc(X(d), Y(f), 3.4, 0, 2 * Math.PI);
    c.fill();
  }
  c.globalAlpha = 1;
  const mark = (m, x, y, size) => {
    c.fillStyle = m === LEARNED ? colours.learned : colours.heuristic;
    c.beginPath();
    if (m === LEARNED) c.arc(x, y, size, 0, 2 * Math.PI);
    else c.rect(x - 0.86 * size, y - 0.86 * size, 1.72 * size, 1.72 * size);
    c.fill();
  };
  c.globalAlpha = 0.7;   // the history of this indentation, with oscillations
  meshes.forEach((points, m) => {
    c.strokeStyle = m === LEARNED ? colours.learned : colours.heuristic;
    c.lineWidth = 1.4;
    line(c, points.map(([d, f]) => [X(d), Y(f)]));
  });
  c.globalAlpha = 1;
  if (now && press.length) {
    const ends = meshes.map(points => points[points.length - 1]);
    c.strokeStyle = colours.soft;   // one force, two depths
    c.lineWidth = 1;
    c.setLineDash([2, 3]);
    trace(c, ends.map(([d, f]) => [X(d), Y(f)]), false);
    c.stroke();
    c.setLineDash([]);
    ends.forEach(([d, f], m) => {
      c.strokeStyle = colours.paper;
      c.lineWidth = 3;
      mark(m, X(d), Y(f), 6);
      c.stroke();
      c.fill();
    });
  }
  c.restore();
  // key
  const names = [...model.meshes.map(mesh => mesh.name), relaxes() ? "FE, instantaneous" : "FE reference"];
  c.font = font(12);
  c.textAlign = "left";
  c.textBaseline = "middle";
  let x = box.right - names.reduce((sum, name) => sum + 36 + c.measureText(name).width, -14);
  names.forEach((name, m) => {
    const is_mesh = m < model.meshes.length;
    c.strokeStyle = is_mesh ? colours[name] : colours.fe;
    c.lineWidth = is_mesh ? 1.4 : 3;
    trace(c, [[x, 8], [x + 17, 8]], false);
    c.stroke();
    if (is_mesh) mark(m, x + 8.5, 8, 4);
    c.fillStyle = colours.ink;
    c.fillText(name, x + 22, 8.5);
    x += 36 + c.measureText(name).width;
  });
}

export function draw_time_plot() {
  const { c, width, height } = begin($("time_plot"));
  if (!model) return;
  const now = state ? state.v[IN.time] : 0, shown = samples.filter(s => s.time >= now - WINDOW);
  const along = s => s.pressed ? pushed(s, LEARNED)[1] : 0;   // the displacement, as the FE force
  const most = largest(shown.flatMap(s => [along(s), s.fe_N[LEARNED]]), Math.max(0.3 * model.strongest_N, 1e-4));
  const { X, Y, box } = axes(c, width, height, { low: -WINDOW, high: 0, step: 2, scale: 1, label: "time (s)" }, force_axis(most * 1.04));
  const lines = [["FE reference", colours.fe, 3, s => s.fe_N[LEARNED]], ["learned", colours.learned, 1.8, along]];
  c.font = font(12);
  c.textAlign = "left";
  c.textBaseline = "middle";
  let x = box.right - lines.reduce((sum, [name]) => sum + 36 + c.measureText(name).width, -14);
  for (const [name, colour, width_px, force] of lines) {
    c.strokeStyle = colour;
    c.lineWidth = width_px;
    line(c, shown.map(s => [X(s.time - now), Y(force(s))]));
    trace(c, [[x, 8], [x + 17, 8]], false);
    c.stroke();
    c.fillStyle = colours.ink;
    c.fillText(name, x + 22, 8.5);
    x += 36 + c.measureText(name).width;
  }
}
