// Drawing in two dimensions: colours, canvases at screen resolution, lines and arrows.
import { add, clamp, norm } from "./vectors.js";

const VIRIDIS = ["#440154", "#481567", "#482677", "#453781", "#404788", "#39568c", "#33638d", "#2d708e", "#287d8e",
                 "#238a8d", "#1f968b", "#20a387", "#29af7f", "#3cbb75", "#55c667", "#73d055", "#95d840", "#b8de29",
                 "#dce319", "#fde725"];   // van der Walt and Smith, matplotlib: even steps, for every colour vision
const SHADES = (() => {
  const rgb = VIRIDIS.map(hex => [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16)));
  return Array.from({ length: 256 }, (_, k) => {
    const x = k / 255 * (rgb.length - 1), i = Math.min(Math.floor(x), rgb.length - 2);
    return `rgb(${rgb[i].map((c, d) => Math.round(c + (rgb[i + 1][d] - c) * (x - i))).join()})`;
  });
})();
export const shade = x => SHADES[clamp(Math.round(255 * x), 0, 255)];

// blue, white, red over the logarithm of stiffness: softer to stiffer (ColorBrewer's RdBu)
const RD_BU = [[33, 102, 172], [103, 169, 207], [209, 229, 240], [247, 247, 247], [253, 219, 199], [239, 138, 98], [178, 24, 43]];
/** x from -1 to 1. */
export function warmth(x) {
  const at = (clamp(x, -1, 1) + 1) / 2 * (RD_BU.length - 1), i = Math.min(Math.floor(at), RD_BU.length - 2);
  return `rgb(${RD_BU[i].map((c, d) => Math.round(c + (RD_BU[i + 1][d] - c) * (at - i))).join()})`;
}

export const colours = {};
export function read_colours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["paper", "ink", "soft", "line", "grid", "learned", "heuristic", "fe", "nodule"])
    colours[name] = style.getPropertyValue(`--${name}`).trim();
  colours.fe_surface = style.getPropertyValue("--fe-surface").trim();
  colours.font = style.getPropertyValue("--sans");
}
export const font = (px, weight = "") => `${weight} ${px}px ${colours.font}`;

/** Prepares a canvas at screen resolution for drawing in CSS pixels. */
export function begin(canvas) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const c = canvas.getContext("2d");
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.clearRect(0, 0, width, height);
  c.lineJoin = c.lineCap = "round";
  return { c, width, height };
}

export function trace(c, points, closed = true) {
  c.beginPath();
  points.forEach((p, k) => k ? c.lineTo(p[0], p[1]) : c.moveTo(p[0], p[1]));
  if (closed) c.closePath();
}

export function arrow(c, from, to, colour) {
  const d = add(to, from, -1), length = norm(d);
  if (length < 2) return;
  const t = [d[0] / length, d[1] / length], n = [-t[1], t[0]], head = Math.min(11, 0.6 * length);
  const neck = add(to, t, -head);
  for (const [width, stroke] of [[6, colours.paper], [2.6, colour]]) {
    c.strokeStyle = c.fillStyle = stroke;
    c.lineWidth = width;
    trace(c, [from, neck], false);
    c.stroke();
    trace(c, [to, add(neck, n, head * 0.42), add(neck, n, -head * 0.42)]);
    c.fill();
    if (width > 3) { c.lineWidth = 3.4; c.stroke(); }
  }
}
