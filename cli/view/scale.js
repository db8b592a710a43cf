// Round numbers for axes and legends.

/** About n round steps up to at least `most`. */
export function nice(most, n = 4) {
  const raw = Math.max(most, 1e-12) / n, ten = 10 ** Math.floor(Math.log10(raw));
  const step = ten * [1, 2, 2.5, 5, 10].find(s => s * ten >= 0.999 * raw);
  return { step, top: step * Math.ceil(most / step - 1e-9), digits: Math.max(0, -Math.floor(Math.log10(step * 1.0001) - (step / ten === 2.5 ? 1 : 0) + 1e-9)) };
}
