// Model files: the first byte selects one of several, the other bytes edit it. A model that can be read is played; an
// adapted one continues to learn.
#include "../mesh/embedded_block.h"
#include "../haptic/haptic_example.h"
#include "../solid_model_example.h"
#include "adapt/adapted_model.h"
#include "edited_store.h"
#include "fuzz_file.h"

#include "mesh/solid_block.h"
#include "mesh/embedded_lattice.h"
using namespace tissue;

namespace {

EditedStore stored(const char* name, const TissueModel& model) {
    const std::string file = base_file(name);
    write_model(file, model, {"fuzz", 0, {}});
    return EditedStore(file);
}

EditedStore learned(const TissueModel& model) {
    Adaptation adaptation(model);
    adaptation.learn({Eigen::Vector2d(0.05, 0.1), Eigen::Vector2d(0, -0.005), Eigen::Vector2d(0, -3)});
    const std::string file = base_file("learned");
    write_adapted_model(file, adaptation, {"fuzz", 0, {}});
    return EditedStore(file);
}

TissueModel in_space() {
    TissueModel model = solid_model_example(embedded_block(Lattice{{2, 2, 2}, {0.1, 0.1, 0.05}}));
    model.contact_m = Eigen::RowVector3d(0.05, 0.05, 0.05);
    model.direction = Eigen::RowVector3d(0, 0, -1);
    return model;
}

TissueModel embedded() {
    TissueModel model = solid_model_example(embedded_lattice(solid_block(Lattice{{2, 2, 2}, {0.02, 0.02, 0.01}}), 0.006));
    model.contact_m = Eigen::RowVector3d(0.01, 0.01, 0.01);
    model.direction = Eigen::RowVector3d(0, 0, -1);
    return model;
}

const std::vector<EditedStore>& bases() {
    static const TissueModel model = energy_model_example(make_lattice("grid8", 2, 2, 0.1, 0.1));
    static const std::vector<EditedStore> all = {stored("sets", haptic_example({"grid4", "isotropic", 2})), stored("law", model), stored("relaxing", relaxing(model)),
                                                 stored("solid", in_space()), stored("embedded", embedded()), learned(model)};
    return all;
}

/// Moves the device down to the centre of the top, into the tissue, and out.
void play(const TissueModel& tissue) {
    const HapticModel model(tissue, {});
    Simulation simulation(model);
    Point above = 0.5 * (model.low_m + model.high_m);
    const Eigen::Index up = above.size() - 1;
    const double height_m = model.high_m[up] - model.low_m[up];
    for (int tick = 0; tick < 24; ++tick) {
        above[up] = model.high_m[up] + height_m * (0.1 - 0.15 * std::sin(0.125 * tick));
        const Eigen::Vector3d force_N = simulation.tick(above.size() == 3 ? sample_at(Eigen::Vector3d(above)) : sample_at(above[0], above[1]));
        must(force_N.allFinite() && force_N.norm() <= model.options.safety.force_max_N * (1 + 1e-12), "a force that is not finite or above its maximum");
    }
}

}  // namespace

FUZZ_TARGET(model)(const std::uint8_t* data, std::size_t size) {
    Choices choices(data, size);
    EditedStore store = bases()[choices.below(bases().size())];
    for (int k = 0; k < 8 && choices.more(); ++k) store.edit(choices);
    const std::string file = FuzzFile::folder() + "/model.h5";
    if (!reads([&] { store.write(file); })) return 0;
    reads([&] { Hdf5Reader(file, "").describe(); });
    reads([&] {
        const TissueModel model = read_model(file);
        if (model.mesh.node_count() < 100) play(model);
    });
    reads([&] {
        if (adapted_options(file)) read_adaptation(file, {});
    });
    reads([&] { learned_field(file); });
    return 0;
}
