#include "springs/spring_law.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "error.h"
#include "springs/stretch.h"

namespace tissue {
namespace {

using Row = Eigen::RowVectorXd;
using Block = Eigen::MatrixXd;

/// Every law of a two-node spring: the force on its first node (the second gets the opposite) per unit stiffness,
/// and the derivative of that force with respect to u_i - u_j. The base does the assembly.
class TwoNodeLaw : public SpringLaw {
   public:
    SparseMatrix force_matrix(const SpringMesh& mesh, const NodeField& u) const override {
        const int dimension = mesh.dimension();
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(2 * dimension * mesh.spring_count());
        for (int s = 0; s < mesh.spring_count(); ++s) {
            const int i = mesh.springs(s, 0), j = mesh.springs(s, 1);
            const Row force = unit_force(mesh.nodes.row(i) - mesh.nodes.row(j), u.row(i) - u.row(j));
            for (int d = 0; d < dimension; ++d) {
                entries.emplace_back(dimension * i + d, s, force[d]);
                entries.emplace_back(dimension * j + d, s, -force[d]);
            }
        }
        SparseMatrix A(u.size(), mesh.spring_count());
        A.setFromTriplets(entries.begin(), entries.end());
        return A;
    }

    SparseMatrix stiffness(const SpringMesh& mesh, const Eigen::VectorXd& theta, const NodeField& u) const override {
        const int dimension = mesh.dimension();
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(4 * dimension * dimension * mesh.spring_count());
        for (int s = 0; s < mesh.spring_count(); ++s) {
            const int i = mesh.springs(s, 0), j = mesh.springs(s, 1);
            const Block k =
                theta[s] * unit_stiffness(mesh.nodes.row(i) - mesh.nodes.row(j), u.row(i) - u.row(j));
            for (int a = 0; a < dimension; ++a)
                for (int b = 0; b < dimension; ++b) {
                    entries.emplace_back(dimension * i + a, dimension * i + b, k(a, b));
                    entries.emplace_back(dimension * j + a, dimension * j + b, k(a, b));
                    entries.emplace_back(dimension * i + a, dimension * j + b, -k(a, b));
                    entries.emplace_back(dimension * j + a, dimension * i + b, -k(a, b));
                }
        }
        SparseMatrix K(u.size(), u.size());
        K.setFromTriplets(entries.begin(), entries.end());
        return K;
    }

   protected:
    /// rest = X_i - X_j, relative = u_i - u_j [m] (1 x D).
    virtual Row unit_force(const Row& rest, const Row& relative) const = 0;
    virtual Block unit_stiffness(const Row& rest, const Row& relative) const = 0;
};

class IsotropicLaw final : public TwoNodeLaw {
   public:
    std::string name() const override { return "isotropic"; }
    bool linear_in_displacement() const override { return true; }

   protected:
    Row unit_force(const Row&, const Row& relative) const override { return relative; }
    Block unit_stiffness(const Row& rest, const Row&) const override {
        return Block::Identity(rest.size(), rest.size());
    }
};

class AxialLaw final : public TwoNodeLaw {
   public:
    std::string name() const override { return "axial"; }
    bool linear_in_displacement() const override { return true; }

   protected:
    Row unit_force(const Row& rest, const Row& relative) const override {
        return rest * (rest.dot(relative) / rest.squaredNorm());
    }
    Block unit_stiffness(const Row& rest, const Row&) const override {
        return rest.transpose() * rest / rest.squaredNorm();
    }
};

/// Springs along the current direction, which turns with the tissue; Stretch says how hard they pull.
template <class Stretch>
class TurningLaw final : public TwoNodeLaw {
   public:
    explicit TurningLaw(std::string name) : name_(std::move(name)) {}
    std::string name() const override { return name_; }
    bool linear_in_displacement() const override { return false; }

   protected:
    Row unit_force(const Row& rest, const Row& relative) const override {
        const Row current = rest + relative;
        const double length = current.norm();
        // two nodes on one spot have no direction to push in
        return length > 0 ? Row(current * Stretch::secant(rest.norm(), length)) : Row(Row::Zero(rest.size()));
    }
    Block unit_stiffness(const Row& rest, const Row& relative) const override {
        const Row current = rest + relative;
        const double length = current.norm();
        const Block identity = Block::Identity(rest.size(), rest.size());
        if (!(length > 0)) return identity;
        const Block along = current.transpose() * current / (length * length);
        return Stretch::tangent(rest.norm(), length) * along + Stretch::secant(rest.norm(), length) * (identity - along);
    }

   private:
    std::string name_;
};

}  // namespace

const std::vector<std::string>& spring_law_names() {
    static const std::vector<std::string> names = {"isotropic", "axial", "geometric", "rubber"};
    return names;
}

std::unique_ptr<SpringLaw> make_spring_law(const std::string& name) {
    if (name == "isotropic") return std::make_unique<IsotropicLaw>();
    if (name == "axial") return std::make_unique<AxialLaw>();
    if (name == "geometric") return std::make_unique<TurningLaw<HookeanStretch>>(name);
    if (name == "rubber") return std::make_unique<TurningLaw<RubberStretch>>(name);
    throw MismatchError(
        fmt::format("spring law '{}' is not known; allowed: {}", name, fmt::join(spring_law_names(), ", ")));
}

}  // namespace tissue
