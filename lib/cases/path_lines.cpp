#include "cases/path_lines.h"

#include <fmt/format.h>

#include "io/one_line.h"

namespace tissue {

const std::string& PathLines::kind() const {
    static const std::string none;
    return size() == 0 ? none : field(0);
}

void PathLines::want(std::size_t count) const {
    if (size() != count) refuse(fmt::format("has {} fields, a '{}' row must have {}", size(), kind(), count));
}

void PathLines::want_at_least(std::size_t count) const {
    if (size() < count) refuse("has too few fields");
}

Point PathLines::point(std::size_t from, std::size_t D) const {
    Point p(static_cast<Eigen::Index>(D));
    for (std::size_t d = 0; d < D; ++d) p[static_cast<Eigen::Index>(d)] = number(from + d);
    return p;
}

std::string PathLines::text_from(std::size_t i) const {
    std::size_t start = 0;
    for (; i > 0; --i) start = text().find(',', start) + 1;
    return one_line(text().substr(start));
}

}  // namespace tissue
