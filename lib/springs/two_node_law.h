#pragma once

#include <string>
#include <vector>

#include "springs/spring_law.h"

namespace tissue {

/// Implements SpringLaw for two-node springs from the behaviour of one spring. Kind has:
///   name, linear, axes_apart, turns      static: properties as in SpringLaw
///   force(rest, relative)                on the first end per unit stiffness; the second gets the opposite
///   stiffness(rest, relative, convex)    d force / d relative
///   energy(rest, relative)               per unit stiffness
///   in_space                             static: whether pull() supports three dimensions
///   of                                   SpringCurve of springs that turn
///   pull(run, n)                         the same force for many springs at once
/// Vectors have two or three entries; none of these allocates.
template <class Kind>
class TwoNodeLaw final : public SpringLaw {
   public:
    explicit TwoNodeLaw(Kind kind = {}) : kind_(kind) {}

    std::string name() const override { return Kind::name; }
    bool linear_in_displacement() const override { return Kind::linear; }
    bool axes_apart() const override { return Kind::axes_apart; }
    const SpringCurve* curve() const override {
        if constexpr (Kind::turns)
            return &kind_.of;
        else
            return nullptr;
    }

    SparseMatrix force_matrix(const SpringMesh& mesh, const NodeField& u) const override {
        const int dimension = mesh.dimension();
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(static_cast<std::size_t>(2 * dimension * mesh.spring_count()));
        for (int s = 0; s < mesh.spring_count(); ++s) {
            const int i = mesh.springs(s, 0), j = mesh.springs(s, 1);
            const Vector force = kind_.force(between(mesh.nodes, i, j), between(u, i, j));
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
        entries.reserve(static_cast<std::size_t>(4 * dimension * dimension * mesh.spring_count()));
        for (int s = 0; s < mesh.spring_count(); ++s) {
            const int i = mesh.springs(s, 0), j = mesh.springs(s, 1);
            const auto k = (theta[s] * kind_.stiffness(between(mesh.nodes, i, j), between(u, i, j), false)).eval();
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

    bool plays_in_space() const override { return Kind::in_space; }
    void pull(const SpringRun& run, int n) const noexcept override { kind_.pull(run, n); }

    Eigen::Matrix2d unit_stiffness(const Eigen::Vector2d& rest, const Eigen::Vector2d& relative,
                                   bool convex) const noexcept override {
        return kind_.stiffness(rest, relative, convex);
    }
    Eigen::Matrix3d unit_stiffness(const Eigen::Vector3d& rest, const Eigen::Vector3d& relative,
                                   bool convex) const noexcept override {
        return kind_.stiffness(rest, relative, convex);
    }

    double unit_energy(const Point& rest, const Point& relative) const noexcept override {
        return kind_.energy(rest, relative);
    }

   private:
    using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3, 1>;

    Kind kind_;

    static Vector between(const NodeField& field, int i, int j) { return (field.row(i) - field.row(j)).transpose(); }
};

/// The square matrix type for a vector of two or three entries.
template <class Vector>
using SquareOf = Eigen::Matrix<double, Vector::RowsAtCompileTime, Vector::RowsAtCompileTime, Eigen::ColMajor,
                               Vector::MaxRowsAtCompileTime, Vector::MaxRowsAtCompileTime>;

}  // namespace tissue
