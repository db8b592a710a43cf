#include "export/sofa.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "error.h"
#include "springs/spring_law.h"
#include "../example.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

TissueModel model_of(const std::string& topology, const std::string& law) {
    TissueModel model;
    model.study = "example";
    model.law = law;
    model.mesh = make_lattice(topology, 4, 3, 0.1, 0.06);
    model.node_mass_kg = Eigen::VectorXd::LinSpaced(model.mesh.node_count(), 1e-3, 2e-3);
    return model;
}

/// Values of a scene, read as SOFA reads them.
class Scene {
   public:
    explicit Scene(const std::string& text) : text_(text) {}

    std::vector<double> numbers(const std::string& element, const std::string& key) const {
        const std::size_t tag = text_.find("<" + element + " ");
        REQUIRE(tag != std::string::npos);
        const std::size_t from = text_.find(" " + key + "=\"", tag) + key.size() + 3;
        std::istringstream in(text_.substr(from, text_.find('"', from) - from));
        std::vector<double> values;
        for (double v; in >> v;) values.push_back(v);
        return values;
    }
    bool has(const std::string& element) const { return text_.find("<" + element + " ") != std::string::npos; }

    /// Forces F (3 N) on the nodes by SOFA's springs and constant forces at positions x (3 N), and their tangent dF/dx.
    /// SOFA's documented spring: F = ks (l - L0) U, dF = ((ks - F/l) U U' + F/l) dx.
    void force(const Eigen::VectorXd& x, Eigen::VectorXd& F, Eigen::MatrixXd& dF) const {
        F = Eigen::VectorXd::Zero(x.size());
        dF = Eigen::MatrixXd::Zero(x.size(), x.size());
        const std::vector<double> s = numbers("SpringForceField", "spring");
        REQUIRE(s.size() % 5 == 0);
        for (std::size_t k = 0; k < s.size(); k += 5) {
            const auto i = 3 * static_cast<Eigen::Index>(s[k]), j = 3 * static_cast<Eigen::Index>(s[k + 1]);
            CHECK(s[k + 3] == 0);
            const Eigen::Vector3d span = x.segment<3>(j) - x.segment<3>(i), U = span.normalized();
            const double pull = s[k + 2] * (span.norm() - s[k + 4]), turn = pull / span.norm();
            const Eigen::Matrix3d m = (s[k + 2] - turn) * U * U.transpose() + turn * Eigen::Matrix3d::Identity();
            F.segment<3>(i) += pull * U;
            F.segment<3>(j) -= pull * U;
            dF.block<3, 3>(i, i) -= m;
            dF.block<3, 3>(j, j) -= m;
            dF.block<3, 3>(i, j) += m;
            dF.block<3, 3>(j, i) += m;
        }
        if (!has("ConstantForceField")) return;
        const std::vector<double> held = numbers("ConstantForceField", "forces");
        REQUIRE(static_cast<Eigen::Index>(held.size()) == F.size());
        F += Eigen::Map<const Eigen::VectorXd>(held.data(), F.size());
    }

   private:
    std::string text_;
};

Eigen::VectorXd in_space(const NodeField& field) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * field.rows());
    for (Eigen::Index i = 0; i < field.rows(); ++i) x.segment<2>(3 * i) = field.row(i).transpose();
    return x;
}

Eigen::VectorXd in_plane(const Eigen::VectorXd& x) {
    Eigen::VectorXd u(x.size() / 3 * 2);
    for (Eigen::Index i = 0; i < x.size() / 3; ++i) u.segment<2>(2 * i) = x.segment<2>(3 * i);
    return u;
}

}  // namespace

TEST_CASE("a SOFA scene has the stiffness matrix K of every spring law at rest", "[export]") {
    for (const std::string& law : spring_laws().names())
        for (const std::string topology : {"grid4", "grid8"}) {
            INFO(law << " " << topology);
            const TissueModel model = model_of(topology, law);
            const NamedSet set{"left-10mm", -1, example_theta(model.mesh)};
            const Scene scene(sofa_scene(model, set));
            const NodeField rest = NodeField::Zero(model.mesh.node_count(), 2);
            const Eigen::MatrixXd K = make_spring_law(law)->stiffness(model.mesh, set.theta, rest);

            const std::vector<double> positions = scene.numbers("MeshTopology", "position");
            const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(positions.data(), 3 * model.mesh.node_count());
            CHECK(x == in_space(model.mesh.nodes));
            Eigen::VectorXd F;
            Eigen::MatrixXd dF;
            scene.force(x, F, dF);
            CHECK(F.norm() <= tolerance::rounding * K.norm() * 0.1);  // at rest
            Eigen::MatrixXd in_K(K.rows(), K.cols());
            for (Eigen::Index r = 0; r < K.rows(); ++r)
                for (Eigen::Index c = 0; c < K.cols(); ++c) in_K(r, c) = -dF(3 * (r / 2) + r % 2, 3 * (c / 2) + c % 2);
            CHECK((in_K - K).norm() <= tolerance::rounding * K.norm());
        }
}

TEST_CASE("a SOFA scene has the same forces far from rest for isotropic and geometric springs only",
          "[export]") {
    for (const std::string& law : spring_laws().names()) {
        INFO(law);
        const TissueModel model = model_of("grid8", law);
        const NamedSet set{"left-10mm", -1, example_theta(model.mesh)};
        const NodeField u = scattered(model.mesh, 0.006);
        Eigen::VectorXd F;
        Eigen::MatrixXd dF;
        Scene(sofa_scene(model, set)).force(in_space(model.mesh.nodes + u), F, dF);
        const Eigen::VectorXd f = make_spring_law(law)->force_matrix(model.mesh, u) * set.theta;
        const double off = (in_plane(F) + f).norm() / f.norm();
        if (law == "axial")
            CHECK(off > 0.01);
        else
            CHECK(off <= tolerance::rounding);
    }
}

TEST_CASE("a SOFA scene has masses and triangles and fixed nodes and keeps nodes in their plane", "[export]") {
    const TissueModel model = model_of("grid4", "axial");
    const Scene scene(sofa_scene(model, {"one_set", -1, example_theta(model.mesh)}));
    const std::vector<double> triangles = scene.numbers("MeshTopology", "triangles");
    REQUIRE(static_cast<Eigen::Index>(triangles.size()) == 3 * model.mesh.simplices.rows());
    for (Eigen::Index t = 0; t < model.mesh.simplices.rows(); ++t)
        for (Eigen::Index k = 0; k < 3; ++k) CHECK(triangles[static_cast<std::size_t>(3 * t + k)] == model.mesh.simplices(t, k));
    const std::vector<double> masses = scene.numbers("DiagonalMass", "vertexMass");
    CHECK(masses == std::vector<double>(model.node_mass_kg.begin(), model.node_mass_kg.end()));
    const std::vector<double> fixed = scene.numbers("FixedProjectiveConstraint", "indices");
    CHECK(fixed == std::vector<double>(model.mesh.fixed.begin(), model.mesh.fixed.end()));
    CHECK(scene.numbers("PartialFixedProjectiveConstraint", "fixedDirections") == std::vector<double>{0, 0, 1});
    CHECK(scene.numbers("PartialFixedProjectiveConstraint", "indices").size() ==
          static_cast<std::size_t>(model.mesh.node_count()));
}
