#include "measured_example.h"

namespace tissue {

const std::string& measured_study_text() {
    static const std::string text = [] {
        const std::string& fe = example_study_text();
        return fe.substr(0, fe.find("[mesh]")) + R"([data]
file = "../data/d.csv"
seed = 8
validation_part = 0.1
held_out_part = 0.2

[springs]
topology = "grid8"
stiffness = "law"
terms = ["spring.all", "spring.surface", "cell.all", "contact.normal", "contact.tangent", "contact.rotation", "contact.stretch"]

[training]
ridge = 1e-6
seed = 11
)";
    }();
    return text;
}

Study measured_study() { return example_study(measured_study_text()); }

SpringMesh measured_mesh() {
    const Study s = measured_study();
    return make_lattice(s.springs.topology, s.cells[0], s.cells[1], s.geometry.width_m, s.geometry.height_m);
}

}  // namespace tissue
