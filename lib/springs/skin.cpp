#include "springs/skin.h"

#include <algorithm>

namespace tissue {

const std::array<std::string, 4>& skin_terms() {
    static const std::array<std::string, 4> terms = {"skin.normal", "skin.tangent", "skin.heave", "skin.radial"};
    return terms;
}

bool is_skin_term(const std::string& term) { return std::count(skin_terms().begin(), skin_terms().end(), term) > 0; }

std::array<Eigen::Index, 4> skin_columns(const std::vector<std::string>& terms) {
    std::array<Eigen::Index, 4> column{};
    for (std::size_t k = 0; k < column.size(); ++k) {
        const auto at = std::find(terms.begin(), terms.end(), skin_terms()[k]);
        column[k] = at == terms.end() ? -1 : at - terms.begin();
    }
    return column;
}

SkinParameters skin_of(const std::vector<std::string>& terms, const Eigen::VectorXd& coefficients) {
    SkinParameters c;
    Eigen::Index k = 0;
    for (const Eigen::Index column : skin_columns(terms)) c[k++] = column < 0 ? 0 : coefficients[column];
    return c;
}

}  // namespace tissue
