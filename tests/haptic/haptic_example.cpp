#include "haptic_example.h"

#include <cmath>
#include <cstdlib>

#include "springs/energy_model_terms.h"
#include "springs/heuristic.h"

namespace tissue {

TissueModel haptic_example(const ExampleModel& e) {
    TissueModel m;
    m.study = "example";
    m.law = e.law;
    m.mesh = make_lattice(e.topology, e.cells, e.cells, 0.1, 0.1);
    m.modulus_N_m = 4524 * e.thickness_m;
    m.node_mass_kg = node_masses(m.mesh, 1040, e.thickness_m);
    m.heuristic_a = heuristic_stiffness(m.mesh, m.modulus_N_m);
    m.heuristic_b = m.heuristic_a / 6;
    m.one_set = m.heuristic_a;
    struct Push { const char* name; double x, y, px, py; };
    const Push pushes[] = {{"left", 0, 0.05, 1, 0},        {"top", 0.05, 0.1, 0, -1},        {"right", 0.1, 0.05, -1, 0},
                           {"tl-across", 0, 0.1, 1, 0},    {"tl-down", 0, 0.1, 0, -1},       {"tl-diagonal", 0, 0.1, 1, -1},
                           {"tr-across", 0.1, 0.1, -1, 0}, {"tr-down", 0.1, 0.1, 0, -1},     {"tr-diagonal", 0.1, 0.1, -1, -1}};
    const int C = 18;
    m.contact_m.resize(C, 2);
    m.direction.resize(C, 2);
    m.magnitude_m.resize(C);
    SpringSets t;
    t.optimizer = "example";
    t.theta.resize(C, m.mesh.spring_count());
    for (int c = 0; c < C; ++c) {
        const Push& p = pushes[c / 2];
        m.case_names.push_back(std::string(p.name) + (c % 2 ? "-15mm" : "-10mm"));
        m.contact_m.row(c) << p.x, p.y;
        m.direction.row(c) = Eigen::RowVector2d(p.px, p.py).normalized();
        m.magnitude_m[c] = c % 2 ? 0.015 : 0.010;
        for (int s = 0; s < m.mesh.spring_count(); ++s)
            t.theta(c, s) = e.stiffer * m.heuristic_a[s] * (1 + (c % 2 ? 0.3 : 0) + e.spread * std::sin(1.7 * s + 2.3 * c));
    }
    m.trained = {t};
    m.optimum = t.theta;
    return m;
}

TissueModel energy_model_example(const SpringMesh& mesh) {
    constexpr double thickness_m = 0.1;
    TissueModel m;
    m.study = "law";
    m.law = "axial";  // of the heuristic mesh beside it
    m.mesh = mesh;
    m.modulus_N_m = 4524 * thickness_m;
    m.node_mass_kg = node_masses(mesh, 1040, thickness_m);
    m.heuristic_a = heuristic_stiffness(mesh, m.modulus_N_m);
    m.heuristic_b = m.heuristic_a / 6;
    const EnergyModelTerms model_terms(mesh, energy_model_heuristic(mesh, m.modulus_N_m, "plane-strain", 12), {"spring.all", "spring.held", "contact.normal", "contact.tangent"});
    const Eigen::Vector4d p(-0.1, -0.7, 0.6, 0.1);
    m.energy_model = {model_terms.terms(), p, model_terms.constants(p), model_terms.patch(p), model_terms.incompressible()};
    const Outline outline(mesh);
    const int C = 10;
    m.contact_m.resize(C, 2);
    m.direction.resize(C, 2);
    m.magnitude_m.resize(C);
    for (int c = 0; c < C; ++c) {
        const double arc = (c / 2 + 0.5) / (C / 2) * outline.length();
        m.case_names.push_back("place-" + std::to_string(c / 2) + (c % 2 ? "-10mm" : "-5mm"));
        m.contact_m.row(c) = outline.position(arc).transpose();
        m.direction.row(c) = outline.inward_normal(arc).transpose();
        m.magnitude_m[c] = c % 2 ? 0.010 : 0.005;
    }
    return m;
}

TissueModel relaxing(TissueModel model) {
    Relaxation& r = model.energy_model->relaxation;
    r.tau_s = Eigen::Vector3d(0.05, 1, 10);
    r.contact_share = Eigen::Vector3d(0.30, 0.25, 0.20);
    r.share = r.contact_share.transpose().replicate(model.energy_model->constants.size(), 1);
    return model;
}

long long adversarial_ticks(long long usual) {
    const char* asked = std::getenv("TISSUE_ADVERSARIAL_TICKS");
    return asked ? std::atoll(asked) : usual;
}

DeviceSample sample_at(double x_m, double y_m) {
    DeviceSample sample;
    sample.position_m << x_m, y_m, 0;
    return sample;
}

DeviceSample sample_at(const Eigen::Vector3d& place_m) {
    DeviceSample sample;
    sample.position_m = place_m;
    return sample;
}

}  // namespace tissue
