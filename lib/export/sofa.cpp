#include "export/sofa.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numeric>

#include "error.h"
#include "springs/spring_law.h"

namespace tissue {
namespace {

/// A field (N x D), D at most 3, as "x y z x y z ..."; in the plane z = 0.
std::string vectors(const NodeField& field) {
    std::string text;
    for (Eigen::Index i = 0; i < field.rows(); ++i)
        for (Eigen::Index d = 0; d < 3; ++d) text += fmt::format("{} ", d < field.cols() ? field(i, d) : 0.0);
    text.pop_back();
    return text;
}

/// Breaks up "--", which is not allowed in an XML comment.
std::string in_comment(std::string text) {
    for (std::size_t at; (at = text.find("--")) != std::string::npos;) text.replace(at, 2, "- -");
    return text;
}

}  // namespace

std::string sofa_fidelity(const std::string& law_name) {
    const std::unique_ptr<SpringLaw> law = make_spring_law(law_name);
    if (law->axes_apart()) return "exact in SOFA, by springs of zero length and a constant force";
    if (law->linear_in_displacement())
        return "SOFA's springs rotate with the tissue: equal stiffness at rest, different forces after rotation";
    return "exact in SOFA";
}

std::string sofa_scene(const TissueModel& model, const NamedSet& set) {
    const SpringMesh& mesh = model.mesh;
    const std::string fidelity = sofa_fidelity(model.law);
    const bool no_length = make_spring_law(model.law)->axes_apart();
    std::string springs;
    for (int s = 0; s < mesh.spring_count(); ++s)
        springs += fmt::format("{} {} {} 0 {}\n", mesh.springs(s, 0), mesh.springs(s, 1), set.theta[s],
                               no_length ? 0.0 : mesh.rest_length(s));
    std::string preload;
    if (no_length) {
        // f = K x pulls the springs together at rest; the constant force K X balances it
        NodeField hold(mesh.node_count(), mesh.dimension());
        Eigen::Map<Eigen::VectorXd>(hold.data(), hold.size()) =
            make_spring_law(model.law)->force_matrix(mesh, mesh.nodes) * set.theta;
        preload = fmt::format("        <ConstantForceField name=\"rest\" forces=\"{}\"/>\n", vectors(hold));
    }
    std::vector<int> triangles, all(static_cast<std::size_t>(mesh.node_count()));
    for (Eigen::Index t = 0; t < mesh.simplices.rows(); ++t)
        for (int k = 0; k < 3; ++k) triangles.push_back(mesh.simplices(t, k));
    std::iota(all.begin(), all.end(), 0);

    return fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<!-- Spring mesh of study '{}', spring set '{}', law {}: {}. SI units. SOFA 24.06 or later. -->\n"
        "<Node name=\"root\" dt=\"0.001\" gravity=\"0 0 0\">\n"
        "    <RequiredPlugin name=\"Sofa.Component.Constraint.Projective\"/>\n"
        "    <RequiredPlugin name=\"Sofa.Component.LinearSolver.Direct\"/>\n"
        "    <RequiredPlugin name=\"Sofa.Component.Mass\"/>\n"
        "    <RequiredPlugin name=\"Sofa.Component.MechanicalLoad\"/>\n"
        "    <RequiredPlugin name=\"Sofa.Component.ODESolver.Backward\"/>\n"
        "    <RequiredPlugin name=\"Sofa.Component.SolidMechanics.Spring\"/>\n"
        "    <RequiredPlugin name=\"Sofa.Component.StateContainer\"/>\n"
        "    <RequiredPlugin name=\"Sofa.Component.Topology.Container.Constant\"/>\n"
        "    <RequiredPlugin name=\"Sofa.Component.Visual\"/>\n"
        "    <VisualStyle displayFlags=\"showBehaviorModels showForceFields\"/>\n"
        "    <DefaultAnimationLoop/>\n"
        "    <DefaultVisualManagerLoop/>\n"
        "    <Node name=\"tissue\">\n"
        "        <EulerImplicitSolver rayleighMass=\"0\" rayleighStiffness=\"0\"/>\n"
        "        <SparseLDLSolver template=\"CompressedRowSparseMatrixMat3x3\"/>\n"
        "        <MeshTopology name=\"mesh\" position=\"{}\" triangles=\"{}\"/>\n"
        "        <MechanicalObject name=\"state\" template=\"Vec3\" position=\"@mesh.position\"/>\n"
        "        <DiagonalMass template=\"Vec3\" vertexMass=\"{}\"/>\n"
        "        <SpringForceField name=\"springs\" template=\"Vec3\" spring=\"{}\"/>\n"
        "{}"
        "        <FixedProjectiveConstraint name=\"support\" indices=\"{}\"/>\n"
        "        <PartialFixedProjectiveConstraint name=\"plane\" indices=\"{}\" fixedDirections=\"0 0 1\"/>\n"
        "    </Node>\n"
        "</Node>\n",
        in_comment(model.study), in_comment(set.name), model.law, fidelity, vectors(mesh.nodes),
        fmt::join(triangles, " "), fmt::join(model.node_mass_kg, " "), springs, preload, fmt::join(mesh.fixed, " "),
        fmt::join(all, " "));
}

}  // namespace tissue
