#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/outline.h"
#include "springs/contact_kernel.h"

namespace tissue {

/// A contact on the free surface, spread over four of its nodes by a uniform cubic B-spline: contact and weights move
/// smoothly along the surface and round its corners. Weights sum to 1; held nodes may be among them.
struct ContactPatch {
    static constexpr int size = 4;
    int node[size];         ///< one may stand twice at the surface's ends, where there is nothing beyond
    double weight[size];    ///< w
    double slope[size];     ///< dw / d place, place counted in nodes: spacing * dw / ds
    double place;           ///< along the surface, in nodes; its fraction says where between them
    double corner;          ///< 0 where the surface is straight, 1 at a right angle
    double edge;            ///< exp(-distance / spacing) from the nearer held end of the surface, counted in nodes
    double log_scale;       ///< of its stiffnesses (ContactKernel::scale)
    Eigen::Vector2d normal, tangent;  ///< of the spline at rest, unit vectors: into the tissue, and along increasing arc
};

/// The free surface as that spline, X(p) = sum_i w_i(p) X_i. A contact at arc length s is where sum_i w_i s_i = s, s_i the
/// nodes' arc lengths: weights reproduce the arc whatever the spacing of the nodes. Two dimensions.
class ContactSurface final : public ContactKernel {
   public:
    /// Throws MismatchError as Outline does.
    explicit ContactSurface(const SpringMesh& mesh);

    std::unique_ptr<ContactKernel> clone() const override { return std::make_unique<ContactSurface>(*this); }
    ContactRows rows_at(const Point& contact_m) const override;  ///< at the surface's point nearest to that
    void tool_at(int facet, const Eigen::Vector3d& weight, double radius_m, const PatchLaw& law, ToolSpring& tool) const noexcept override;
    std::vector<std::pair<int, int>> coupled() const override;   ///< four nodes that follow each other
    double spacing_m() const override { return outline_.length() / static_cast<double>(outline_.nodes().size() - 1); }

    const Outline& outline() const { return outline_; }

    /// The patch at an arc length [m], clamped to the surface. Allocates nothing, a few dozen operations: the tick's too.
    ContactPatch at(double arc_m) const noexcept;

   private:
    double arc_at(int segment, double fraction) const noexcept;

    struct Segment {
        double first, last;  ///< arcs of its ends; equal where it is held
        int node[2];
        Eigen::Vector2d tangent;
    };

    Outline outline_;
    std::vector<Segment> segment_;  ///< of the boundary, which is closed and begins anywhere (B)
    // with one more at either end, mirrored in the last node: where the spline ends at rest
    std::vector<int> node_;
    std::vector<double> arc_;
    std::vector<Eigen::Vector2d> rest_m_;
    std::vector<double> knot_;  ///< arc of the spline at each node
};

/// What the tool meets in a contact [N/m], beside the tissue: the compliance of what lies between two nodes, under the
/// patch. The patch does not turn with the tissue, as the rigid FE patch does not.
struct PatchStiffness {
    double normal, tangent;    ///< of d - sum w u, what is left between tool and spline
    double rotation, stretch;  ///< of sum slope u, along normal and tangent: the surface under the patch keeps its line
};

/// How those depend on the contact's place: log k_m = sum_f log_N_m(m, f) factor_f, with factors
///   1, phase = cos(2 pi place): 1 at a node, -1 half way between two, corner, edge.
/// In space, of a disc (springs/disc_contact.h): `curved` takes the place of phase, and `ground` that of corner, what under it is of other stiffness; its last rows are what is not linear of it (springs/contact_spring.h): hardening
/// and saturation [log(1/J)], coupling [log(N/m2)].
struct PatchLaw {
    static constexpr int factors = 4, curved_factor = 1, ground_factor = 2, hardening_row = 4, saturation_row = 5, coupling_row = 6, disc_rows = 7;
    /// K x factors: normal, tangent, rotation, stretch; of a disc normal, tangent, imprint_normal, imprint_tangent, hardening,
    /// saturation, coupling
    using Logs = Eigen::Matrix<double, Eigen::Dynamic, factors, 0, disc_rows, factors>;  ///< no allocation
    using Start = Eigen::Matrix<double, disc_rows, 1>;  ///< of a disc, the first column
    Logs log_N_m = Logs::Zero(4, factors);
    bool softens = false;  ///< of a disc: row hardening is softening, and row saturation means nothing

    bool hardens() const { return log_N_m.rows() > hardening_row; }
    Eigen::VectorXd values_at(const ContactFactors& factors, double log_scale = 0) const;  ///< of every row, exp(log_scale) times as stiff (K)
    /// What the row m is of a contact whose tissue is `scale` times as stiff, over what it is of this: energies scale, and what is counted
    /// in them goes the other way.
    static double scaled(Eigen::Index m, double scale) noexcept { return m == hardening_row || m == saturation_row ? 1 / scale : scale; }

    static Eigen::Vector4d factors_at(const ContactPatch& patch) noexcept;
    PatchStiffness at(const ContactPatch& patch) const noexcept;  ///< In the plane, scaled. No allocation.
};

/// One contact's energy in the plane:
///   gap = d - sum w_i u_i,  turn = sum slope_i u_i
///   E = (k_n (n.gap)^2 + k_t (t.gap)^2 + k_r (n.turn)^2 + k_s (t.turn)^2) / 2
struct PatchSpring {
    ContactPatch patch;
    PatchStiffness stiffness;
    Eigen::Matrix2d gap_N_m, turn_N_m;  ///< k_n n n' + k_t t t', k_r n n' + k_s t t'

    PatchSpring(const ContactPatch& where, const PatchStiffness& k) noexcept;
    void lay_out(ToolSpring& tool) const noexcept;  ///< as the tick holds it

    struct Load {
        double energy_J;
        Eigen::Vector2d hand_N;                     ///< dE/dd: force of the tool on the tissue
        Eigen::Vector2d node_N[ContactPatch::size]; ///< dE/du_i: what the contact asks of the rest to hold u_i
    };
    /// u(i): displacement of patch.node[i] [m]. No allocation.
    Load load(const Eigen::Vector2d& push_m, const Eigen::Vector2d (&u)[ContactPatch::size]) const noexcept;

    /// d node_N[i] / d u_j.
    Eigen::Matrix2d tangent(int i, int j) const noexcept {
        return patch.weight[i] * patch.weight[j] * gap_N_m + patch.slope[i] * patch.slope[j] * turn_N_m;
    }
};

/// Displacements of a patch's nodes out of a field (N x 2).
template <class Field>
void gather(const ContactPatch& patch, const Field& u, Eigen::Vector2d (&out)[ContactPatch::size]) {
    for (int i = 0; i < ContactPatch::size; ++i) out[i] << u(patch.node[i], 0), u(patch.node[i], 1);
}

}  // namespace tissue
