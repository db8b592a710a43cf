#include "study/viscosity.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "study/read_parts.h"

namespace tissue {
namespace {

constexpr std::size_t most_branches = 8;
constexpr double least_left = 1e-9;  // least long-term modulus over the instantaneous one

/// A list of { g, tau_s }, sorted by tau_s. without: null where every branch must have g; else set to whether there are
/// branches and none has g.
std::vector<Branch> read_branches(TomlReader& in, const Range& share, bool* without = nullptr) {
    std::vector<Branch> branches;
    double sum = 0;
    std::vector<TomlReader> listed = in.tables("viscosity");
    const bool none = without && !listed.empty() && std::none_of(listed.begin(), listed.end(), [](const TomlReader& branch) { return branch.has("g"); });
    if (without) *without = none;
    for (TomlReader& branch : listed) {
        branches.push_back({none ? 0 : branch.number("g", share), branch.number("tau_s", positive)});
        sum += branches.back().share;
        branch.refuse_the_rest();
    }
    if (branches.size() > most_branches) in.refuse("viscosity", fmt::format("has {} Maxwell branches, at most {} are allowed", branches.size(), most_branches));
    if (sum > 1 - least_left) in.refuse("viscosity", fmt::format("the sum of g is {:g}, must be less than 1: the long-term modulus must be positive", sum));
    std::sort(branches.begin(), branches.end(), [](const Branch& a, const Branch& b) { return a.tau_s < b.tau_s; });
    for (std::size_t k = 1; k < branches.size(); ++k)
        if (branches[k].tau_s == branches[k - 1].tau_s) in.refuse("viscosity", fmt::format("tau_s = {:g} is present twice", branches[k].tau_s));
    return branches;
}

std::vector<double> shares_of(const std::vector<Branch>& branches) {
    std::vector<double> shares;
    for (const Branch& b : branches) shares.push_back(b.share);
    return shares;
}

/// Converts long-term moduli to instantaneous ones: divides by 1 - sum of g.
void make_instantaneous(Study::MaterialParameters& p) {
    const double left = 1 - std::accumulate(p.share.begin(), p.share.end(), 0.0);
    p.C1_Pa /= left;
    p.C2_Pa /= left;
    for (double& mu : p.mu_Pa) mu /= left;
}

}  // namespace

void read_viscosity(TomlReader& in, Study::Material& material, bool fe) {
    if (in.is_text("viscosity")) {
        in.choice("viscosity", {"measured"});
        if (fe) in.refuse("viscosity", "can be \"measured\" only with data.histories");
        material.fits_shares = true;
    } else if (in.has("viscosity")) {
        material.viscosity = read_branches(in, positive, fe ? nullptr : &material.fits_shares);
    }
    if (!in.has("viscosity")) {
        if (in.has("moduli")) in.refuse("moduli", "needs material.viscosity");
        return;
    }
    if (!material.relaxes() && !in.has("moduli")) return;
    if (!in.has("moduli")) in.refuse("viscosity", "needs material.moduli, which states whether C1_Pa and the other moduli are \"instantaneous\" or \"long-term\"");
    material.long_term = in.choice("moduli", {"instantaneous", "long-term"}) == "long-term";
    if (fe && material.relaxes() && material.formulation == "plane-stress")
        in.refuse("viscosity", "is not supported by FE in plane stress; formulation must be \"plane-strain\"");
    if (fe && material.relaxes() && material.formulation == "incompressible" && material.law == "ogden")
        in.refuse("viscosity", "is not supported by FE of a solid with Ogden's law; law must be \"mooney-rivlin\" or \"neo-Hookean\"");
    material.share = shares_of(material.viscosity);
    if (material.long_term) make_instantaneous(material);
}

void read_own_viscosity(TomlReader& in, const Study::Material& material, Study::MaterialParameters& own) {
    own.share = material.share;
    if (in.has("viscosity")) {
        if (!material.relaxes()) in.refuse("viscosity", "needs material.viscosity, whose tau_s it has too");
        const std::vector<Branch> branches = read_branches(in, not_negative);
        const auto same = [](const Branch& a, const Branch& b) { return a.tau_s == b.tau_s; };
        if (!std::equal(branches.begin(), branches.end(), material.viscosity.begin(), material.viscosity.end(), same))
            in.refuse("viscosity", "must have the tau_s of material.viscosity, each of them once (g may be 0)");
        own.share = shares_of(branches);
    }
    if (material.long_term) make_instantaneous(own);
}

}  // namespace tissue
