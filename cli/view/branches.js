// Relaxation of a force: of the instantaneous force F0 a part 1 - sum g_k is permanent, and a part g_k is in each
// Maxwell branch,
//   F = (1 - sum g_k) F0 + sum Q_k,   Q_k' + Q_k / tau_k = g_k F0',
// exact if F0 is linear between two samples. `relaxation` is the model's {tau_s, share}, often without branches.

/** The initial state {at_once, parts}: F0 and Q, N. */
export const nothing_felt = ({ tau_s }) => ({ at_once: 0, parts: tau_s.map(() => 0) });

/** The state dt seconds later, after F0 has changed linearly to at_once. */
export const later = ({ tau_s, share }, felt, dt, at_once) => ({
  at_once,
  parts: felt.parts.map((part, k) => {
    const left = Math.exp(-dt / tau_s[k]);
    return left * part + (dt > 0 ? share[k] * (1 - left) * tau_s[k] / dt : share[k]) * (at_once - felt.at_once);
  }),
});

export const sum = numbers => numbers.reduce((a, b) => a + b, 0);

/** The force F, N. */
export const force_of = ({ share }, felt) => (1 - sum(share)) * felt.at_once + sum(felt.parts);
