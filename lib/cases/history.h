#pragma once

#include <optional>
#include <string>
#include <vector>

#include "field.h"

namespace tissue {

struct History {
    std::string name, group, kind, role;
    Point contact_m, direction;
    std::optional<Point> second_contact_m;
    Eigen::VectorXd time_s;
    NodeField push_m, force_N, elastic_N;
    std::vector<int> contact;
    std::string lost;
};

}  // namespace tissue
