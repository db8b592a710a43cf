#include "haptic/law_spectrum.h"

#include <algorithm>

#include "error.h"
#include "haptic/spectrum.h"
#include "springs/press.h"

namespace tissue {
namespace {

Eigen::SparseMatrix<double> with_contact(const Eigen::SparseMatrix<double>& tissue, const PatchSpring& contact) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < ContactPatch::size; ++i)
        for (int j = 0; j < ContactPatch::size; ++j)
            for (int a = 0; a < 2; ++a)
                for (int b = 0; b < 2; ++b)
                    entries.emplace_back(2 * contact.patch.node[i] + a, 2 * contact.patch.node[j] + b, contact.tangent(i, j)(a, b));
    Eigen::SparseMatrix<double> added(tissue.rows(), tissue.cols());
    added.setFromTriplets(entries.begin(), entries.end());
    return tissue + added;
}

}  // namespace

LawSpectrum law_spectrum(const TissueModel& model, const RealtimeMesh& springs) {
    if (!model.energy_law) throw MismatchError("the model's stiffness is no law");
    constexpr int places = 8;
    constexpr double slant = 0.7853981633974483;  // 45 degrees
    const LawModel& law = *model.energy_law;
    const TissueEnergy energy(model.mesh, law.incompressible);
    const ContactSurface surface(model.mesh);
    const Eigen::SparseMatrix<double> at_rest = energy.tangent(law.constants, NodeField::Zero(model.mesh.node_count(), 2));
    LawSpectrum spectrum{smallest_eigenvalue(springs, at_rest), largest_eigenvalue(springs, at_rest)};

    std::vector<double> arcs = surface.outline().corners();
    for (int k = 0; k < places; ++k) arcs.push_back((k + 0.5) / places * surface.outline().length());
    const double depth_m = model.case_count() > 0 ? model.magnitude_m.maxCoeff() : 0;
    PressSolver solver(energy, surface);
    for (double arc : arcs)
        for (double angle : {-slant, 0.0, slant}) {
            const ContactPatch patch = surface.at(arc);
            const PatchSpring contact(patch, law.patch.at(patch));
            const PressState state = solver.press(law.constants, contact, depth_m * surface.outline().direction(arc, angle));
            if (state.status == PressStatus::lost) continue;
            const Eigen::SparseMatrix<double> pressed = with_contact(energy.tangent(law.constants, state.displacement), contact);
            spectrum.largest = std::max(spectrum.largest, largest_eigenvalue(springs, pressed));
        }
    return spectrum;
}

}  // namespace tissue
