#include "haptic/lattice_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "error.h"

namespace tissue {

LatticeRows::LatticeRows(const SpringMesh& mesh) : count_(mesh.node_count()) {
    constexpr double most_rows = 4;  // per node
    const int N = mesh.node_count(), own = mesh.embedding.node_count(), lattice = N - own;
    if (mesh.embedding.empty()) return;
    const NodeField place = ((mesh.nodes.bottomRows(lattice).rowwise() - mesh.nodes.bottomRows(lattice).colwise().minCoeff()) / mesh.embedding.spacing_m).array().round();
    const double width = place.col(0).maxCoeff() + 1, layer = width * (place.col(1).maxCoeff() + 1);
    if (!(layer < 1e15)) return;  // doubles hold whole numbers exactly up to here

    // The rows of a layer follow those of the layer below, so each layer has one offset to the next.
    struct Layer {
        double low, high;  // smallest and largest x + width y of its nodes
        double first = 0;  // row of x = y = 0
    };
    std::map<double, Layer> layers;
    for (int n = 0; n < lattice; ++n) {
        const double at = place(n, 0) + width * place(n, 1);
        Layer& of = layers.try_emplace(place(n, 2), Layer{layer, 0}).first->second;
        of.low = std::min(of.low, at);
        of.high = std::max(of.high, at);
    }
    double rows = 0;
    for (auto& [z, of] : layers) {
        of.first = rows - of.low;
        rows += of.high - of.low + 1;
    }
    if (!(rows <= most_rows * lattice)) return;
    std::vector<bool> taken(static_cast<std::size_t>(rows), false);
    row_.assign(static_cast<std::size_t>(N), -1);
    for (int n = 0; n < lattice; ++n) {
        const int row = static_cast<int>(layers.at(place(n, 2)).first + place(n, 0) + width * place(n, 1));
        if (taken[static_cast<std::size_t>(row)]) throw MismatchError(fmt::format("node {} of the lattice has the same place as another node", own + n));
        taken[static_cast<std::size_t>(row)] = true;
        row_[static_cast<std::size_t>(own + n)] = row;
        if (runs_.empty() || row != runs_.back().row + runs_.back().count)
            runs_.push_back({own + n, row, 1});
        else
            ++runs_.back().count;
    }
    count_ = static_cast<int>(rows);
}

void LatticeRows::scatter(const NodeColumns& by_node, NodeColumns& by_row) const noexcept {
    for (Eigen::Index d = 0; d < by_node.cols(); ++d)
        for (const Run& run : runs_) std::copy_n(by_node.col(d).data() + run.node, run.count, by_row.col(d).data() + run.row);
}

void LatticeRows::gather(const NodeColumns& by_row, NodeColumns& by_node) const noexcept {
    const Eigen::Index own = runs_.front().node;
    for (Eigen::Index d = 0; d < by_node.cols(); ++d) {
        std::fill_n(by_node.col(d).data(), own, 0.0);
        for (const Run& run : runs_) std::copy_n(by_row.col(d).data() + run.row, run.count, by_node.col(d).data() + run.node);
    }
}

}  // namespace tissue
