#include "haptic/contact_stiffness.h"

#include <algorithm>
#include <map>

#include "haptic/band_cholesky.h"

namespace tissue {

ContactStiffness::ContactStiffness(const RealtimeMesh& mesh, const std::vector<int>& first_set,
                                   const Eigen::MatrixXd& theta_of_set) {
    const std::vector<int>& outline = mesh.outline();
    const std::size_t M = outline.size();
    const FreeNumbering numbering(mesh);
    const int D = numbering.per_node;
    const NodeColumns rest = NodeColumns::Zero(mesh.node_count(), 2);
    const bool factorable = BandCholesky::bytes(numbering.order, numbering.half_bandwidth) < 256e6;

    // segments by their set, so that each set is factored once
    std::map<int, std::vector<std::size_t>> segments_of_set;
    for (std::size_t b = 0; b < M; ++b) segments_of_set[first_set[b]].push_back(b);

    first_.assign(M, 0);
    second_.assign(M, 0);
    mixed_.assign(M, 0);
    BandCholesky K(factorable ? numbering.order : 0, factorable ? numbering.half_bandwidth : 0);
    Eigen::VectorXd z(numbering.order);
    for (const auto& [set, segments] : segments_of_set) {
        const Eigen::VectorXd theta = theta_of_set.col(set);
        K.set_zero();
        if (factorable) add_stiffness(mesh, numbering, theta, rest, 1, false, K);
        const bool definite = factorable && K.factor();
        const double stand_in = mesh.spring_count() / theta.sum();  // compliance of a mean spring
        for (std::size_t b : segments) {
            const int nodes[2] = {outline[b], outline[(b + 1) % M]};
            if (!definite) {
                first_[b] = mesh.fixed(nodes[0]) ? 0 : stand_in;
                second_[b] = mesh.fixed(nodes[1]) ? 0 : stand_in;
                ++without_stiffness_;
                continue;
            }
            for (int end : {0, 1}) {
                const int n = numbering.number[static_cast<std::size_t>(nodes[end])];
                const int other = numbering.number[static_cast<std::size_t>(nodes[1 - end])];
                for (int d = 0; n >= 0 && d < D; ++d) {
                    z.setZero();
                    z[D * n + d] = 1;
                    K.solve(z.data());
                    (end == 0 ? first_ : second_)[b] += z[D * n + d] / D;
                    if (end == 0 && other >= 0) mixed_[b] += 2 * z[D * other + d] / D;
                }
            }
        }
    }
    for (std::size_t b = 0; b < M; ++b)
        for (double compliance : {first_[b], second_[b]})
            if (compliance > 0) largest_ = std::max(largest_, 1 / compliance);
}

double ContactStiffness::at(int segment, double w) const noexcept {
    const auto b = static_cast<std::size_t>(segment);
    const double v = 1 - w, compliance = v * v * first_[b] + w * w * second_[b] + v * w * mixed_[b];
    return compliance * largest_ > 1 ? 1 / compliance : largest_;
}

}  // namespace tissue
