#include "cases/measured_csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "error.h"
#include "io/csv_lines.h"

namespace tissue {
namespace {

const std::map<std::string, double> lengths = {{"m", 1}, {"mm", 1e-3}}, forces = {{"N", 1}, {"mN", 1e-3}};

/// A column this project knows.
struct Column {
    const char* name;
    const std::map<std::string, double>* units;  ///< none: a text
    bool required;
};
const std::vector<Column> known = {{"contact_x", &lengths, true},      {"contact_y", &lengths, true},
                                   {"displacement_x", &lengths, true}, {"displacement_y", &lengths, true},
                                   {"force_x", &forces, true},         {"force_y", &forces, true},
                                   {"push", nullptr, false},           {"repeat", nullptr, false},
                                   {"role", nullptr, false}};

std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

/// Where each known column stands, and what one of its unit is in SI.
struct Header {
    std::map<std::string, std::size_t> place;
    std::map<std::string, double> unit;
    std::size_t columns = 0;
};

Header read_header(const CsvLines& line) {
    Header header;
    header.columns = line.size();
    for (std::size_t i = 0; i < line.size(); ++i) {
        const std::string field = trimmed(line.field(i));
        const std::size_t open = field.find('[');
        const std::string name = trimmed(field.substr(0, open));
        const auto column = std::find_if(known.begin(), known.end(), [&](const Column& c) { return name == c.name; });
        if (column == known.end()) {
            std::vector<std::string> names;
            for (const Column& c : known) names.push_back(c.name);
            line.refuse(fmt::format("column '{}' is not known; allowed: {}", name, fmt::join(names, ", ")));
        }
        if (!header.place.emplace(name, i).second) line.refuse(fmt::format("column '{}' stands twice", name));
        std::vector<std::string> units;
        if (column->units)
            for (const auto& unit : *column->units) units.push_back(unit.first);
        if (open == std::string::npos) {
            if (column->units)
                line.refuse(fmt::format("column '{}' has no unit; write '{} [UNIT]' with UNIT one of {}", name, name,
                                        fmt::join(units, ", ")));
            continue;
        }
        const std::string unit = field.back() == ']' ? trimmed(field.substr(open + 1, field.size() - open - 2)) : field;
        if (!column->units) line.refuse(fmt::format("column '{}' is a text and has no unit", name));
        const auto found = column->units->find(unit);
        if (found == column->units->end())
            line.refuse(fmt::format("column '{}': unit '{}' is not known; allowed: {}", name, unit, fmt::join(units, ", ")));
        header.unit[name] = found->second;
    }
    for (const Column& c : known)
        if (c.required && !header.place.count(c.name)) line.refuse(fmt::format("column '{}' is missing", c.name));
    return header;
}

}  // namespace

MeasuredTable read_measured_csv(const std::string& file) {
    CsvLines line(file);
    MeasuredTable table{file, "", {}};
    Header header;
    std::map<std::vector<std::string>, int> seen;
    while (line.next()) {
        if (trimmed(line.text()).empty()) continue;
        if (line.text()[0] == '#') {
            if (header.columns == 0) table.origin += (table.origin.empty() ? "" : " ") + trimmed(line.text().substr(1));
            continue;
        }
        if (header.columns == 0) {
            header = read_header(line);
            continue;
        }
        if (line.size() != header.columns)
            line.refuse(fmt::format("has {} fields, the header {} columns", line.size(), header.columns));
        const auto text = [&](const char* name) {
            const auto there = header.place.find(name);
            return there == header.place.end() ? std::string() : trimmed(line.field(there->second));
        };
        const auto vector = [&](const std::string& x, const std::string& y) {
            return Eigen::Vector2d(line.number(header.place.at(x), x) * header.unit.at(x),
                                   line.number(header.place.at(y), y) * header.unit.at(y));
        };
        MeasuredRow row{line.number(), vector("contact_x", "contact_y"), vector("displacement_x", "displacement_y"),
                        vector("force_x", "force_y"), text("push"), text("role")};
        if (!(row.displacement_m.norm() > 0)) line.refuse("columns 'displacement_x', 'displacement_y': both are zero");
        if (!(row.force_N.norm() > 0)) line.refuse("columns 'force_x', 'force_y': both are zero");
        if (header.place.count("push") && row.push.empty()) line.refuse("column 'push' is empty");
        if (header.place.count("role") && row.role != "train" && row.role != "validation" && row.role != "held_out")
            line.refuse(fmt::format("column 'role' is '{}'; allowed: train, validation, held_out", row.role));
        std::vector<std::string> fields;
        for (std::size_t i = 0; i < line.size(); ++i) fields.push_back(trimmed(line.field(i)));
        const auto [twin, fresh] = seen.emplace(fields, line.number());
        if (!fresh)
            line.refuse(fmt::format("is the same as line {} in every column; tell repeats that read alike apart in a "
                                    "column 'repeat'", twin->second));
        table.rows.push_back(row);
    }
    if (header.columns == 0) throw FileError(fmt::format("{}: has no header", file));
    if (table.rows.empty()) throw FileError(fmt::format("{}: has no rows", file));
    return table;
}

}  // namespace tissue
