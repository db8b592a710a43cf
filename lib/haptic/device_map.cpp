#include "haptic/device_map.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <sstream>
#include <vector>

#include "error.h"

namespace tissue {

void DeviceMap::fit(int dimension) {
    if (axes.rows() == 0) axes = Eigen::Matrix3d::Identity().topRows(dimension);
    if (offset_m.size() == 0) offset_m = Point::Zero(dimension);
    if (axes.rows() != dimension) throw MismatchError(fmt::format("axes: {} device axes for a tissue of {} axes", axes.rows(), dimension));
    if (offset_m.size() != dimension) throw MismatchError(fmt::format("offset: {} numbers for a tissue of {} axes", offset_m.size(), dimension));
    if (rotation_rad.size() != 0 && rotation_rad.size() != 3) throw MismatchError(fmt::format("rotation: needs three numbers, also in the plane, not {}", rotation_rad.size()));
    if (rotation_rad.size() != 0 && !(rotation_rad.cwiseAbs().maxCoeff() <= 100)) throw MismatchError("rotation: numbers are in radians, at most 100");
    turn_ = axes;
    if (const double angle = rotation_rad.size() == 0 ? 0 : rotation_rad.norm(); angle > 0) turn_ = axes * Eigen::AngleAxisd(angle, Eigen::Vector3d(rotation_rad / angle)).toRotationMatrix();
}

Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> parse_axes(const std::string& text) {
    const auto refuse = [&] {
        throw MismatchError(fmt::format("axes '{}': must be two or three different axes of x, y, z, each with or without a sign, as in x,-z", text));
    };
    std::vector<std::string> words;
    std::stringstream in(text);
    for (std::string word; std::getline(in, word, ',');) words.push_back(word);
    if (words.size() < 2 || words.size() > 3) refuse();
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> axes;
    axes.setZero(static_cast<Eigen::Index>(words.size()), 3);
    for (std::size_t row = 0; row < words.size(); ++row) {
        std::string& word = words[row];
        double sign = 1;
        if (!word.empty() && (word[0] == '-' || word[0] == '+')) {
            sign = word[0] == '-' ? -1 : 1;
            word.erase(0, 1);
        }
        if (word.size() != 1 || word[0] < 'x' || word[0] > 'z') refuse();
        axes(static_cast<Eigen::Index>(row), word[0] - 'x') = sign;
    }
    if (axes.cwiseAbs().colwise().sum().maxCoeff() > 1) refuse();
    return axes;
}

}  // namespace tissue
