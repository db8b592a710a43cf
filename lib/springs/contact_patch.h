#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/outline.h"
#include "springs/contact_kernel.h"

namespace tissue {

/// A contact on the free surface in the plane, spread over four of its nodes by a uniform cubic B-spline. Contact and
/// weights change smoothly along the surface and round its corners. The weights sum to 1. Fixed nodes may be among the
/// four.
struct ContactPatch {
    static constexpr int size = 4;
    int node[size];         ///< at the surface's two ends one node may occur twice
    double weight[size];    ///< w
    double slope[size];     ///< dw / d place, with place counted in nodes: spacing * dw / ds
    /// position along the surface, counted in nodes; the fraction is the position between two of them
    double place;
    double corner;          ///< 0 where the surface is straight, 1 at a right angle
    double edge;            ///< exp(-distance / spacing) from the nearer fixed end of the surface, counted in nodes
    double log_scale;       ///< log of the factor on its stiffnesses (ContactKernel::scale)
    /// unit vectors of the spline at rest: into the tissue, and along increasing arc length
    Eigen::Vector2d normal, tangent;
};

/// The free surface as this spline, X(p) = sum_i w_i(p) X_i. The contact at arc length s is where sum_i w_i s_i = s,
/// with s_i the nodes' arc lengths: the arc length is reproduced for any spacing of the nodes. Two dimensions.
class ContactSurface final : public ContactKernel {
   public:
    /// Throws MismatchError as Outline does.
    explicit ContactSurface(const SpringMesh& mesh);

    std::unique_ptr<ContactKernel> clone() const override { return std::make_unique<ContactSurface>(*this); }
    ContactRows rows_at(const Point& contact_m) const override;  ///< at the surface point nearest to contact_m
    void tool_at(int facet, const Eigen::Vector3d& weight, double radius_m, const ContactParameters& contact_parameters, ToolSpring& tool) const noexcept override;
    std::vector<std::pair<int, int>> coupled() const override;   ///< pairs within four successive nodes
    double spacing_m() const override { return outline_.length() / static_cast<double>(outline_.nodes().size() - 1); }

    const Outline& outline() const { return outline_; }

    /// The patch at an arc length [m], clamped to the surface. Allocates nothing and takes a few dozen operations, so
    /// the tick may call it.
    ContactPatch at(double arc_m) const noexcept;

   private:
    double arc_at(int segment, double fraction) const noexcept;

    struct Segment {
        double first, last;  ///< arc lengths of its ends; equal where the segment is fixed
        int node[2];
        Eigen::Vector2d tangent;
    };

    Outline outline_;
    std::vector<Segment> segment_;  ///< of the closed boundary, in the order of SpringMesh::facets (B)
    // One more entry at either end, mirrored about the end node, so that the spline ends at that node at rest.
    std::vector<int> node_;
    std::vector<double> arc_;
    std::vector<Eigen::Vector2d> rest_m_;
    std::vector<double> knot_;  ///< arc length of the spline at each node
};

/// Stiffnesses of the contact between tool and mesh [N/m], beside those of the mesh. They represent the compliance
/// under the patch that the spacing of the nodes does not resolve. The patch does not rotate with the tissue, as the
/// rigid FE patch does not.
struct PatchStiffness {
    double normal, tangent;    ///< of d - sum w u, the gap between tool and spline
    double rotation, stretch;  ///< of sum slope u, along normal and tangent: keep the surface under the patch straight
};

/// How the stiffness of a disc's contact changes with its displacement (springs/contact_spring.h).
enum class ContactCurve {
    hardens,     ///< with the energy of its mean rows, thus in every direction
    softens,     ///< with that energy, to half of its stiffness at most; row hardening is the rate, row saturation unused
    compression  ///< hardens with the energy of its normal compression only, not where the tool pulls
};

/// Dependence of the contact's stiffnesses on its place: log k_m = sum_f log_N_m(m, f) factor_f, with the factors
///   1, phase = cos(2 pi place): 1 at a node, -1 half way between two, corner, edge.
/// For a disc in space (springs/disc_contact.h) `curved` replaces phase, and `ground` replaces corner: the effect of
/// tissue of other stiffness under the disc. The last rows of a disc are the nonlinear terms
/// (springs/contact_spring.h): hardening and saturation [log(1/J)], coupling [log(N/m2)].
struct ContactParameters {
    static constexpr int factors = 4, curved_factor = 1, ground_factor = 2, hardening_row = 4, saturation_row = 5, coupling_row = 6, disc_rows = 7;
    /// K x factors. Rows in the plane: normal, tangent, rotation, stretch. Rows of a disc: normal, tangent,
    /// imprint_normal, imprint_tangent, hardening, saturation, coupling.
    /// bounded size: no allocation
    using Logs = Eigen::Matrix<double, Eigen::Dynamic, factors, 0, disc_rows, factors>;
    using Start = Eigen::Matrix<double, disc_rows, 1>;  ///< first column of a disc
    Logs log_N_m = Logs::Zero(4, factors);
    ContactCurve curve = ContactCurve::hardens;  ///< of a disc

    bool hardens() const { return log_N_m.rows() > hardening_row; }
    /// values of all rows (K) of a contact that is exp(log_scale) times as stiff
    Eigen::VectorXd values_at(const ContactFactors& factors, double log_scale = 0) const;
    /// Factor on the value of row m where the contact is `scale` times as stiff. Stiffnesses scale with `scale`.
    /// Hardening and saturation are per energy [1/J] and scale with its inverse.
    static double scaled(Eigen::Index m, double scale) noexcept { return m == hardening_row || m == saturation_row ? 1 / scale : scale; }

    static Eigen::Vector4d factors_at(const ContactPatch& patch) noexcept;
    /// in the plane, with the patch's log_scale; no allocation
    PatchStiffness at(const ContactPatch& patch) const noexcept;
};

/// Energy of one contact in the plane:
///   gap = d - sum w_i u_i,  turn = sum slope_i u_i
///   E = (k_n (n.gap)^2 + k_t (t.gap)^2 + k_r (n.turn)^2 + k_s (t.turn)^2) / 2
struct PatchSpring {
    ContactPatch patch;
    PatchStiffness stiffness;
    Eigen::Matrix2d gap_N_m, turn_N_m;  ///< k_n n n' + k_t t t', k_r n n' + k_s t t'

    PatchSpring(const ContactPatch& where, const PatchStiffness& k) noexcept;
    void lay_out(ToolSpring& tool) const noexcept;  ///< in the form of the tick

    struct Load {
        double energy_J;
        Eigen::Vector2d tool_force_N;                     ///< dE/dd: force of the tool on the tissue
        /// dE/du_i: nodal force that holds u_i against the contact
        Eigen::Vector2d node_N[ContactPatch::size];
    };
    /// push_m: tool displacement d [m]. u[i]: displacement of patch.node[i] [m]. No allocation.
    Load load(const Eigen::Vector2d& push_m, const Eigen::Vector2d (&u)[ContactPatch::size]) const noexcept;

    /// d node_N[i] / d u_j [N/m].
    Eigen::Matrix2d tangent(int i, int j) const noexcept {
        return patch.weight[i] * patch.weight[j] * gap_N_m + patch.slope[i] * patch.slope[j] * turn_N_m;
    }
};

/// Displacements of a patch's nodes from a field (N x 2).
template <class Field>
void gather(const ContactPatch& patch, const Field& u, Eigen::Vector2d (&out)[ContactPatch::size]) {
    for (int i = 0; i < ContactPatch::size; ++i) out[i] << u(patch.node[i], 0), u(patch.node[i], 1);
}

}  // namespace tissue
