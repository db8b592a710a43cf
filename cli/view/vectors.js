// Small vectors, [x, y] or [x, y, z], and the extremes of lists.

export const add = (a, b, s = 1) => a.length === 2 ? [a[0] + s * b[0], a[1] + s * b[1]] : [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + (a.length === 2 ? 0 : a[2] * b[2]);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const norm = a => Math.hypot(...a);
export const unit = a => a.map(x => x / norm(a));
export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

/** The largest of any number of numbers, at least `from`; numbers that are not finite are skipped. Math.max(...numbers)
 *  throws a RangeError for some hundred thousand numbers, and returns NaN if one of them is NaN. */
export function largest(numbers, from = -Infinity) {
  let most = from;
  for (const x of numbers) if (x > most && x < Infinity) most = x;
  return most;
}
export const smallest = numbers => -largest(numbers.map(x => -x));

/** Angle between two directions, degrees. */
export function angle_between(a, b) {
  const u = unit(a), v = unit(b);
  return 360 / Math.PI * Math.atan2(norm(add(u, v, -1)), norm(add(u, v)));
}
