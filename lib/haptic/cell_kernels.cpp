#include "haptic/cell_kernels.h"

#include "hot_loop.h"

namespace tissue::kernel {

TISSUE_HOT void squares(int n, const double* __restrict px, const double* __restrict py, const double* __restrict qx,
                        const double* __restrict qy, const double* __restrict gain, const double* __restrict ax,
                        const double* __restrict ay, const double* __restrict bx, const double* __restrict by,
                        const double* __restrict cx, const double* __restrict cy, const double* __restrict dx,
                        const double* __restrict dy, double* __restrict gx, double* __restrict gy, double* __restrict hx,
                        double* __restrict hy) {
    for (int k = 0; k < n; ++k) {
        const double ux = cx[k] - ax[k], uy = cy[k] - ay[k], vx = dx[k] - bx[k], vy = dy[k] - by[k];
        const double x = qx[k] + vx, y = qy[k] + vy;
        const double pull = gain[k] * ((px[k] * vy - py[k] * vx) + (ux * y - uy * x));
        gx[k] = pull * y;
        gy[k] = -pull * x;
        hx[k] = -pull * (py[k] + uy);
        hy[k] = pull * (px[k] + ux);
    }
}

TISSUE_HOT void squares_grown(int n, const double* __restrict px, const double* __restrict py, const double* __restrict qx,
                              const double* __restrict qy, const double* __restrict ax, const double* __restrict ay, const double* __restrict bx,
                              const double* __restrict by, const double* __restrict cx, const double* __restrict cy, const double* __restrict dx,
                              const double* __restrict dy, double* __restrict gx, double* __restrict gy, double* __restrict hx, double* __restrict hy,
                              double* __restrict grown) {
    for (int k = 0; k < n; ++k) {
        const double ux = cx[k] - ax[k], uy = cy[k] - ay[k], vx = dx[k] - bx[k], vy = dy[k] - by[k];
        const double x = qx[k] + vx, y = qy[k] + vy;
        grown[k] = (px[k] * vy - py[k] * vx) + (ux * y - uy * x);
        gx[k] = y;
        gy[k] = -x;
        hx[k] = -(py[k] + uy);
        hy[k] = px[k] + ux;
    }
}

TISSUE_HOT void times(int n, const double* __restrict gain, const double* __restrict y, int arrays, int apart, double* __restrict g) {
    for (int a = 0; a < arrays; ++a, g += apart)
        for (int k = 0; k < n; ++k) g[k] *= gain[k] * y[k];
}

TISSUE_HOT void add(int n, const double* __restrict g, double* __restrict f) {
    for (int k = 0; k < n; ++k) f[k] += g[k];
}

TISSUE_HOT void add_pair(int n, const double* __restrict g, double* f_i, double* f_j) {
    for (int k = 0; k < n; ++k) f_i[k] -= g[k];
    for (int k = 0; k < n; ++k) f_j[k] += g[k];
}

namespace {

struct Vector {
    double x, y, z;
};
TISSUE_INLINE Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
TISSUE_INLINE double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
TISSUE_INLINE Vector cross(const Vector& a, const Vector& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

/// Growth of det (A B C) when p, q, r are added to its columns, free of cancellation, and its derivatives by p, q, r.
struct Gained {
    double by;
    Vector by_p, by_q, by_r;
};
TISSUE_INLINE Gained gained(const Vector& A, const Vector& B, const Vector& C, const Vector& p, const Vector& q, const Vector& r) {
    const Vector a = A + p, b = B + q, c = C + r, before = cross(B, C), more = cross(q, C) + cross(b, r);
    return {dot(p, before) + dot(a, more), before + more, cross(c, a), cross(a, b)};
}

/// Forces at the corners of cube k, for gain (J - 1) where `pulled`, else for 1 in its place. Returns J - 1.
template <bool pulled>
TISSUE_INLINE double cube(int k, double per_m, const double* __restrict cx, const double* __restrict cy, const double* __restrict cz, double gain,
                          const double* __restrict ux, const double* __restrict uy, const double* __restrict uz, int up, int in, int far, double* __restrict g) {
    const int corner[8] = {0, 1, up, up + 1, in, in + 1, far, far + 1};
    const double x = cx[k], y = cy[k], z = cz[k], X = per_m * (1 - x), Y = per_m * (1 - y), Z = 1 - z;
    const double hx = per_m * x, hy = per_m * y;
    const double along_x[4] = {Y * Z, hy * Z, Y * z, hy * z}, along_y[4] = {X * Z, hx * Z, X * z, hx * z}, along_z[4] = {X * (1 - y), hx * (1 - y), X * y, hx * y};
    double by[3][3];  // displacement gradient: axis, component
    for (int d = 0; d < 3; ++d) {
        const double* __restrict from = d == 0 ? ux : d == 1 ? uy : uz;
        double v[8];
        for (int c = 0; c < 8; ++c) v[c] = from[corner[c] + k];
        by[0][d] = along_x[0] * (v[1] - v[0]) + along_x[1] * (v[3] - v[2]) + along_x[2] * (v[5] - v[4]) + along_x[3] * (v[7] - v[6]);
        by[1][d] = along_y[0] * (v[2] - v[0]) + along_y[1] * (v[3] - v[1]) + along_y[2] * (v[6] - v[4]) + along_y[3] * (v[7] - v[5]);
        by[2][d] = along_z[0] * (v[4] - v[0]) + along_z[1] * (v[5] - v[1]) + along_z[2] * (v[6] - v[2]) + along_z[3] * (v[7] - v[3]);
    }
    const Gained now = gained({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {by[0][0], by[0][1], by[0][2]}, {by[1][0], by[1][1], by[1][2]}, {by[2][0], by[2][1], by[2][2]});
    const double t = pulled ? gain * now.by : 1;
    const double p[3] = {t * now.by_p.x, t * now.by_p.y, t * now.by_p.z}, q[3] = {t * now.by_q.x, t * now.by_q.y, t * now.by_q.z},
                 r[3] = {t * now.by_r.x, t * now.by_r.y, t * now.by_r.z};
    for (int d = 0; d < 3; ++d)
        for (int c = 0; c < 8; ++c)
            g[(8 * d + c) * cubes_at_once + k] = ((c & 1) ? p[d] : -p[d]) * along_x[c >> 1] + ((c & 2) ? q[d] : -q[d]) * along_y[(c & 1) + (c >> 2) * 2] + ((c & 4) ? r[d] : -r[d]) * along_z[c & 3];
    return now.by;
}

}  // namespace

TISSUE_HOT void cubes(int n, double per_m, const double* __restrict cx, const double* __restrict cy, const double* __restrict cz,
                      const double* __restrict gain, const double* __restrict ux, const double* __restrict uy, const double* __restrict uz, int up, int in,
                      int far, double* __restrict g) {
    for (int k = 0; k < n; ++k) cube<true>(k, per_m, cx, cy, cz, gain[k], ux, uy, uz, up, in, far, g);
}

TISSUE_HOT void cubes_grown(int n, double per_m, const double* __restrict cx, const double* __restrict cy, const double* __restrict cz,
                            const double* __restrict ux, const double* __restrict uy, const double* __restrict uz, int up, int in, int far,
                            double* __restrict g, double* __restrict grown) {
    for (int k = 0; k < n; ++k) grown[k] = cube<false>(k, per_m, cx, cy, cz, 1, ux, uy, uz, up, in, far, g);
}

}  // namespace tissue::kernel
