#include "springs/tissue_energy.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

#include "error.h"
#include "mesh/topology.h"
#include "springs/region_area.h"
#include "springs/turning_springs.h"

namespace tissue {

TissueEnergy::TissueEnergy(const SpringMesh& mesh, bool incompressible, const SpringCurve& curve)
    : first_{0}, embedding_(mesh.embedding), nodes_(mesh.node_count()), dimension_(mesh.dimension()), dependent_(mesh.fixed) {
    if (!embedding_.empty()) {
        dependent_.resize(static_cast<std::size_t>(embedding_.node_count()));
        std::iota(dependent_.begin(), dependent_.end(), 0);
    }
    kinds_.push_back(std::make_unique<TurningSprings>(mesh, curve));
    if (mesh.is_solid()) {
        auto volumes = std::make_unique<CellVolumes>(mesh);
        volumes_ = volumes.get();
        kinds_.push_back(std::move(volumes));
        kinds_.push_back(std::make_unique<Supports>(mesh));
        for (const auto& kind : kinds_) first_.push_back(first_.back() + kind->count());
        return;
    }
    areas_ = std::make_unique<CellAreas>(mesh);
    const Cells& cells = areas_->nodes();
    if (!on_lattice(mesh)) {
        for (const std::vector<int>& star : node_stars(mesh, cells))
            kinds_.push_back(std::make_unique<RegionArea>(mesh, cells, star));
    } else {
        kinds_.push_back(std::make_unique<CellAreas>(mesh));
    }
    if (incompressible) {
        for (const std::vector<int>& region : cell_regions(mesh, cells))
            kinds_.push_back(std::make_unique<RegionArea>(mesh, cells, region));
    }
    for (const auto& kind : kinds_) first_.push_back(first_.back() + kind->count());
}

TissueEnergy::TissueEnergy(const SpringMesh& mesh, const EnergyModel& energy_model) : TissueEnergy(mesh, energy_model.incompressible, energy_model.curve) {
    if (energy_model.constants.size() != constant_count()) throw MismatchError(fmt::format("the energy model has {} constants, must have {} for this mesh", energy_model.constants.size(), constant_count()));
}

double TissueEnergy::energy(const Eigen::VectorXd& constants, const NodeField& u) const {
    double sum = 0;
    for (std::size_t k = 0; k < kinds_.size(); ++k)
        for (int e = 0; e < kinds_[k]->count(); ++e) sum += constants[first_[k] + e] * kinds_[k]->energy(e, u);
    return sum;
}

NodeField TissueEnergy::force(const Eigen::VectorXd& constants, const NodeField& u) const {
    NodeField f = NodeField::Zero(nodes_, dimension_);
    ElementVector unit;
    for (std::size_t k = 0; k < kinds_.size(); ++k) {
        const Cells& nodes = kinds_[k]->nodes();
        for (int e = 0; e < kinds_[k]->count(); ++e) {
            kinds_[k]->force(e, u, unit);
            for (Eigen::Index i = 0; i < nodes.cols(); ++i)
                f.row(nodes(e, i)) += constants[first_[k] + e] * unit.segment(i * dimension_, dimension_).transpose();
        }
    }
    return f;
}

Eigen::SparseMatrix<double> TissueEnergy::tangent(const Eigen::VectorXd& constants, const NodeField& u) const {
    std::vector<Eigen::Triplet<double>> entries;
    ElementMatrix unit;
    for (std::size_t k = 0; k < kinds_.size(); ++k) {
        const Cells& nodes = kinds_[k]->nodes();
        for (int e = 0; e < kinds_[k]->count(); ++e) {
            kinds_[k]->tangent(e, u, unit);
            for (Eigen::Index a = 0; a < unit.rows(); ++a)
                for (Eigen::Index b = 0; b < unit.cols(); ++b)
                    entries.emplace_back(nodes(e, a / dimension_) * dimension_ + a % dimension_,
                                         nodes(e, b / dimension_) * dimension_ + b % dimension_,
                                         constants[first_[k] + e] * unit(a, b));
        }
    }
    Eigen::SparseMatrix<double> K(u.size(), u.size());
    K.setFromTriplets(entries.begin(), entries.end());
    return K;
}

double TissueEnergy::smallest_ratio(const NodeField& u) const {
    double smallest = std::numeric_limits<double>::infinity();
    for (int e = 0; areas_ && e < areas_->count(); ++e) smallest = std::min(smallest, areas_->area_ratio(e, u));
    for (int e = 0; volumes_ && e < volumes_->count(); ++e) smallest = std::min(smallest, volumes_->volume_ratio(e, u));
    return smallest;
}

}  // namespace tissue
