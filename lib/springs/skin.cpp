#include "springs/skin.h"

#include <algorithm>

namespace tissue {

const std::array<std::string, 4>& skin_terms() {
    static const std::array<std::string, 4> terms = {"skin.normal", "skin.tangent", "skin.heave", "skin.radial"};
    return terms;
}

SkinLaw skin_of(const std::vector<std::string>& terms, const Eigen::VectorXd& coefficients) {
    SkinLaw c = SkinLaw::Zero();
    for (std::size_t k = 0; k < skin_terms().size(); ++k)
        if (const auto at = std::find(terms.begin(), terms.end(), skin_terms()[k]); at != terms.end())
            c[static_cast<Eigen::Index>(k)] = coefficients[at - terms.begin()];
    return c;
}

}  // namespace tissue
