#include "haptic/device_map.h"

#include <fmt/format.h>

#include "error.h"

namespace tissue {

Eigen::Matrix<double, 2, 3> parse_axes(const std::string& text) {
    const auto refuse = [&] {
        throw MismatchError(fmt::format("axes '{}': wanted two different ones of x, y, z with a sign, as in x,-z", text));
    };
    Eigen::Matrix<double, 2, 3> axes = Eigen::Matrix<double, 2, 3>::Zero();
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos) refuse();
    std::string words[2] = {text.substr(0, comma), text.substr(comma + 1)};
    for (int row : {0, 1}) {
        std::string& word = words[row];
        double sign = 1;
        if (!word.empty() && (word[0] == '-' || word[0] == '+')) {
            sign = word[0] == '-' ? -1 : 1;
            word.erase(0, 1);
        }
        if (word.size() != 1 || word[0] < 'x' || word[0] > 'z') refuse();
        axes(row, word[0] - 'x') = sign;
    }
    if (axes.row(0).cwiseProduct(axes.row(1)).cwiseAbs().sum() > 0) refuse();
    return axes;
}

}  // namespace tissue
