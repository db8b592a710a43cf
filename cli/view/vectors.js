// Small vectors [x, y].

export const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1];
export const norm = a => Math.hypot(a[0], a[1]);
export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
