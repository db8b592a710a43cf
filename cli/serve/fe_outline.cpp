#include "fe_outline.h"

#include <filesystem>
#include <map>

#include "cases/load_path.h"
#include "error.h"

namespace tissue::serve {
namespace {

constexpr double same = 1e-9;  // relative; both files contain what one program computed

bool alike(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
    return a.rows() == b.rows() && a.cols() == b.cols() && (a - b).norm() <= same * a.norm();
}

/// Whether load case c of the model is this load case.
bool is_case(const TissueModel& tissue, int c, const LoadCase& load) {
    return alike(tissue.contact_m.row(c), load.path->contact_m.transpose()) &&
           alike(tissue.direction.row(c), load.path->direction.transpose()) &&
           std::abs(tissue.magnitude_m[c] - load.record->magnitude_m) <= same * tissue.magnitude_m[c] &&
           (tissue.contact_force_N.rows() == 0 ||
            alike(tissue.contact_force_N.row(c), load.record->contact_force_N.transpose()));
}

/// FE displacements at the load cases of the model. Throws FileError, MismatchError.
std::vector<NodeField> displacements(const std::string& file, const TissueModel& tissue) {
    const Cases cases = read_cases(file);
    if (cases.study != tissue.study) throw MismatchError("it is of the study '" + cases.study + "'");
    if (!has_nodes(tissue.mesh, cases.nodes)) throw MismatchError("it has other nodes");
    if (cases.measurement) return {};
    std::map<std::string, LoadCase> by_name;
    for (const LoadCase& load : load_cases(cases)) by_name.emplace(load.name, load);
    std::vector<NodeField> all;
    for (int c = 0; c < tissue.case_count(); ++c) {
        const std::string& name = tissue.case_names[static_cast<std::size_t>(c)];
        const auto found = by_name.find(name);
        if (found == by_name.end()) throw MismatchError("it has no load case '" + name + "'");
        if (!is_case(tissue, c, found->second)) throw MismatchError("its load case '" + name + "' is another");
        all.push_back(found->second.record->displacement);
    }
    return all;
}

}  // namespace

FeCases read_fe_cases(const std::string& model_file, const TissueModel& tissue) {
    const std::filesystem::path file = std::filesystem::path(model_file).replace_filename("cases.h5");
    std::error_code unseen;
    if (!std::filesystem::exists(file, unseen)) return {};
    try {
        return {displacements(file.string(), tissue), ""};
    } catch (const MismatchError& e) {
        return {{}, file.string() + " is not used: it does not belong to " + model_file + ": " + e.what()};
    } catch (const Error& e) {
        return {{}, file.string() + " is not used: " + e.what()};
    }
}

}  // namespace tissue::serve
