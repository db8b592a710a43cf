#include "measured_example.h"

namespace tissue {

Study measured_study() {
    Study study = example_study();
    study.data = Study::Data{"data.csv", 8, 0.1, 0.2, 0.0005, {}};
    study.springs.topology = "grid8";
    study.springs.law = "axial";
    study.training.optimizer = "exact";
    study.training.also = {};
    study.training.objective = "reaction";
    study.training.ridge = 1;
    return study;
}

SpringMesh measured_mesh() {
    const Study s = measured_study();
    return make_lattice("grid8", s.cells[0], s.cells[1], s.geometry.width_m, s.geometry.height_m);
}

}  // namespace tissue
