#include "springs/tissue_model.h"

#include <algorithm>

#include "error.h"

namespace tissue {
namespace {

template <class Matrix>
void write_indices(Hdf5Writer& out, const std::string& name, const Matrix& m, const std::string& description) {
    std::vector<int> values;
    for (Eigen::Index i = 0; i < m.rows(); ++i)
        for (Eigen::Index j = 0; j < m.cols(); ++j) values.push_back(m(i, j));
    out.write_integers(name, {static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols())}, values,
                       description);
}

/// Reads a table of node numbers and checks that every one of them is a node.
template <int Columns>
Eigen::Matrix<int, Eigen::Dynamic, Columns> read_indices(const Hdf5Reader& in, const std::string& name, int nodes) {
    const NodeField values = in.field(name);
    if (values.cols() != Columns) in.refuse(name, "has the wrong number of columns");
    if (values.size() > 0 && (values.minCoeff() < 0 || values.maxCoeff() >= nodes))
        in.refuse(name, "names a node that does not exist");
    return values.cast<int>();
}

std::vector<int> read_node_list(const Hdf5Reader& in, const std::string& name, int nodes) {
    const std::vector<int> values = in.integers(name);
    for (int v : values)
        if (v < 0 || v >= nodes) in.refuse(name, "names a node that does not exist");
    return values;
}

void write_trained(Hdf5Writer& out, const TrainedSets& t) {
    const std::string group = "/trained/" + t.optimizer + "/";
    const auto C = static_cast<std::size_t>(t.theta.rows());
    out.write(group + "theta", t.theta, "N/m", "spring sets (C x S)");
    out.write(group + "loss", t.loss_N, "N", "L(theta), (9) (C)");
    out.write(group + "rel_loss", t.rel_loss, "1", "L / sqrt(f_fe' Q f_fe) (C)");
    out.write(group + "gap", t.gap, "1", "distance from the certified optimum (C)");
    out.write_integers(group + "iterations", {C}, t.iterations, "iterations, all restarts together (C)");
    out.write_integers(group + "evaluations", {C}, t.evaluations, "evaluations of the loss (C)");
    out.write_integers(group + "restarts", {C}, t.restarts, "restarts after a negative spring (C)");
    out.write_texts(group + "status", t.status, "why the optimiser stopped (C)");
    out.write_integers(group + "curve_iteration", {t.curve_iteration.size()}, t.curve_iteration,
                       "iterations of the learning curves (P)");
    out.write(group + "curve_loss", t.curve_loss_N, "N", "learning curves, NaN once a set has stopped (C x P)");
    out.attribute("/trained/" + t.optimizer, "seconds", t.seconds);
}

TrainedSets read_trained(const Hdf5Reader& in, const std::string& optimizer) {
    const std::string group = "/trained/" + optimizer + "/";
    TrainedSets t;
    t.optimizer = optimizer;
    t.theta = in.field(group + "theta");
    t.loss_N = in.vector(group + "loss");
    t.rel_loss = in.vector(group + "rel_loss");
    t.gap = in.vector(group + "gap");
    t.iterations = in.integers(group + "iterations");
    t.evaluations = in.integers(group + "evaluations");
    t.restarts = in.integers(group + "restarts");
    t.status = in.texts(group + "status");
    t.curve_iteration = in.integers(group + "curve_iteration");
    t.curve_loss_N = in.field(group + "curve_loss");
    t.seconds = in.number_attribute("/trained/" + optimizer, "seconds");
    return t;
}

}  // namespace

void write_model(const std::string& file, const TissueModel& model, const Provenance& provenance) {
    Hdf5Writer out(file, "model", provenance);
    out.attribute("/", "study", model.study);
    out.attribute("/", "law", model.law);
    out.attribute("/", "topology", model.mesh.topology);
    out.attribute("/", "modulus_N_m", model.modulus_N_m);
    out.write("/mesh/nodes", model.mesh.nodes, "m", "nodes at rest (N x D)");
    write_indices(out, "/mesh/springs", model.mesh.springs, "node pair of each spring (S x 2)");
    write_indices(out, "/mesh/triangles", model.mesh.triangles, "triangulation for drawing (T x 3)");
    out.write_integers("/mesh/boundary", {model.mesh.boundary.size()}, model.mesh.boundary,
                       "nodes of the outline, counter-clockwise");
    out.write_integers("/mesh/fixed", {model.mesh.fixed.size()}, model.mesh.fixed, "nodes held at rest");
    out.write("/mesh/incident_area", model.mesh.incident_area, "m2", "sum of area(T_e) in (7) (S)");
    out.write("/mesh/node_area", model.mesh.node_area, "m2", "tissue area that a node carries, (8) (N)");
    out.write("/node_mass", model.node_mass_kg, "kg", "node masses, (8) (N)");
    out.write("/heuristic_a", model.heuristic_a, "N/m", "theta of (7), E2 = E t (S)");
    out.write("/heuristic_b", model.heuristic_b, "N/m", "theta of (7), E2 = (C1 + C2) t (S)");
    out.write("/one_set", model.one_set, "N/m", "the single set that serves all cases best (S)");
    out.write_texts("/cases/names", model.case_names, "load cases trained on (C)");
    out.write("/cases/contact", model.contact_m, "m", "contact at rest (C x D)");
    out.write("/cases/direction", model.direction, "1", "unit vector of the push (C x D)");
    out.write("/cases/magnitude", model.magnitude_m, "m", "how far the contact is pushed (C)");
    if (model.contact_force_N.rows() > 0)
        out.write("/cases/contact_force", model.contact_force_N, "N", "FE force of the indenter on the tissue (C x D)");
    out.write("/cases/node_weight", model.node_weight, "1", "diagonal of Q, one entry a node (C x N)");
    out.write("/optimum/theta", model.optimum.theta, "N/m", "best spring sets inside the box (C x S)");
    out.write("/optimum/loss", model.optimum.loss_N, "N", "L of them, (9) (C)");
    out.write("/optimum/rel_loss", model.optimum.rel_loss, "1", "L / sqrt(f_fe' Q f_fe) (C)");
    out.write("/optimum/lower_bound", model.optimum.lower_bound_N, "N", "no set in the box has a smaller L (C)");
    out.write("/optimum/kkt_residual", model.optimum.kkt_residual, "1", "of the optimality conditions (C)");
    if (!model.optimum.status.empty())
        out.write_texts("/optimum/status", model.optimum.status, "why the exact solver stopped (C)");
    out.attribute("/optimum", "seconds", model.optimum.seconds);
    if (!model.problems.status.empty()) {
        out.write_texts("/problems/status", model.problems.status, "how each case's problem came about (C)");
        out.attribute("/problems", "objective", model.problems.objective);
        out.attribute("/problems", "one_set_status", model.problems.one_set_status);
    }
    std::vector<std::string> optimizers;
    for (const TrainedSets& t : model.trained) {
        write_trained(out, t);
        optimizers.push_back(t.optimizer);
    }
    out.write_texts("/optimizers", optimizers, "groups of /trained, the study's own first");
    out.commit();
}

TissueModel read_model(const std::string& file) {
    const Hdf5Reader in(file, "model");
    TissueModel model;
    model.study = in.text_attribute("/", "study");
    model.law = in.text_attribute("/", "law");
    model.seed = static_cast<unsigned long>(in.number_attribute("/", "seed"));
    model.modulus_N_m = in.number_attribute("/", "modulus_N_m");
    model.mesh.topology = in.text_attribute("/", "topology");
    model.mesh.nodes = in.field("/mesh/nodes");
    const int N = model.mesh.node_count();
    model.mesh.springs = read_indices<2>(in, "/mesh/springs", N);
    model.mesh.triangles = read_indices<3>(in, "/mesh/triangles", N);
    model.mesh.boundary = read_node_list(in, "/mesh/boundary", N);
    model.mesh.fixed = read_node_list(in, "/mesh/fixed", N);
    model.mesh.incident_area = in.vector("/mesh/incident_area");
    model.mesh.node_area = in.vector("/mesh/node_area");
    model.node_mass_kg = in.vector("/node_mass");
    model.heuristic_a = in.vector("/heuristic_a");
    model.heuristic_b = in.vector("/heuristic_b");
    model.one_set = in.vector("/one_set");
    model.case_names = in.texts("/cases/names");
    model.contact_m = in.field("/cases/contact");
    model.direction = in.field("/cases/direction");
    model.magnitude_m = in.vector("/cases/magnitude");
    if (in.has("/cases/contact_force")) model.contact_force_N = in.field("/cases/contact_force");
    model.node_weight = in.field("/cases/node_weight");
    const int C = model.case_count(), S = model.mesh.spring_count();
    if (model.mesh.node_area.size() != N || model.node_mass_kg.size() != N || model.node_weight.cols() != N)
        in.refuse("/mesh", "its datasets do not have the same number of nodes");
    if (model.mesh.incident_area.size() != S || model.heuristic_a.size() != S || model.heuristic_b.size() != S)
        in.refuse("/mesh", "its datasets do not have the same number of springs");
    if (model.contact_m.rows() != C || model.direction.rows() != C || model.magnitude_m.size() != C ||
        model.node_weight.rows() != C)
        in.refuse("/cases", "its datasets do not have the same number of cases");
    if (model.contact_force_N.rows() > 0 &&
        (model.contact_force_N.rows() != C || model.contact_force_N.cols() != model.mesh.dimension()))
        in.refuse("/cases/contact_force", "does not have one force a case");
    model.optimum = {in.field("/optimum/theta"),         in.vector("/optimum/loss"),
                     in.vector("/optimum/rel_loss"),     in.vector("/optimum/lower_bound"),
                     in.vector("/optimum/kkt_residual"), {}, in.number_attribute("/optimum", "seconds")};
    if (in.has("/optimum/status")) {
        model.optimum.status = in.texts("/optimum/status");
        if (model.optimum.status.size() != static_cast<std::size_t>(C)) in.refuse("/optimum/status", "does not have one row a case");
    }
    if (in.has("/problems/status")) {
        model.problems = {in.text_attribute("/problems", "objective"), in.texts("/problems/status"),
                          in.text_attribute("/problems", "one_set_status")};
        if (model.problems.status.size() != static_cast<std::size_t>(C)) in.refuse("/problems/status", "does not have one row a case");
    }
    if (model.optimum.theta.rows() != C || model.optimum.theta.cols() != S || model.optimum.loss_N.size() != C ||
        model.optimum.rel_loss.size() != C || model.optimum.lower_bound_N.size() != C ||
        model.optimum.kkt_residual.size() != C)
        in.refuse("/optimum", "does not have one row a case");
    for (const std::string& optimizer : in.texts("/optimizers")) {
        model.trained.push_back(read_trained(in, optimizer));
        const TrainedSets& t = model.trained.back();
        const auto one_a_case = [C](const auto& list) { return list.size() == static_cast<std::size_t>(C); };
        if (t.theta.rows() != C || t.theta.cols() != S || t.loss_N.size() != C || t.rel_loss.size() != C ||
            t.gap.size() != C || t.curve_loss_N.rows() != C || !one_a_case(t.iterations) ||
            !one_a_case(t.evaluations) || !one_a_case(t.restarts) || !one_a_case(t.status))
            in.refuse("/trained/" + optimizer, "does not have one row a case");
        if (t.curve_loss_N.cols() != static_cast<Eigen::Index>(t.curve_iteration.size()))
            in.refuse("/trained/" + optimizer, "does not have one column of the learning curves an iteration");
    }
    if (model.trained.empty()) in.refuse("/optimizers", "is empty");
    return model;
}

}  // namespace tissue
