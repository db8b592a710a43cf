#include "cases/measured_csv.h"

#include <fmt/format.h>

#include <map>

#include "error.h"
#include "io/csv_columns.h"
#include "io/csv_table.h"

namespace tissue {
namespace {

const std::vector<CsvColumn> known = {
    {"contact_x", &length_units(), true},      {"contact_y", &length_units(), true},      {"displacement_x", &length_units(), true},
    {"displacement_y", &length_units(), true}, {"force_x", &force_units(), true},         {"force_y", &force_units(), true},
    {"push", nullptr, false},                  {"repeat", nullptr, false},                {"role", nullptr, false}};

}  // namespace

MeasuredTable read_measured_csv(const std::string& file) {
    CsvTable line(file);
    MeasuredTable table{file, "", {}};
    CsvColumns columns;
    std::map<std::vector<std::string>, int> seen;
    while (line.next()) {
        if (line.is_comment()) {
            if (columns.empty()) table.origin += (table.origin.empty() ? "" : " ") + trimmed(line.text().substr(1));
            continue;
        }
        if (columns.empty()) {
            columns = CsvColumns(line, known);
            continue;
        }
        columns.check(line);
        const auto text = [&](const char* name) { return columns.text(line, name); };
        const auto vector = [&](const std::string& x, const std::string& y) { return Eigen::Vector2d(columns.number(line, x), columns.number(line, y)); };
        MeasuredRow row{line.number(), vector("contact_x", "contact_y"), vector("displacement_x", "displacement_y"),
                        vector("force_x", "force_y"), text("push"), text("role")};
        if (!(row.displacement_m.norm() > 0)) line.refuse("columns 'displacement_x', 'displacement_y': both are zero");
        if (!(row.force_N.norm() > 0)) line.refuse("columns 'force_x', 'force_y': both are zero");
        if (columns.has("push") && row.push.empty()) line.refuse("column 'push' is empty");
        if (columns.has("role") && row.role != "train" && row.role != "validation" && row.role != "held_out")
            line.refuse(fmt::format("column 'role' is '{}'; allowed: train, validation, held_out", row.role));
        std::vector<std::string> fields;
        for (std::size_t i = 0; i < line.size(); ++i) fields.push_back(trimmed(line.field(i)));
        const auto [twin, fresh] = seen.emplace(fields, line.number());
        if (!fresh)
            line.refuse(fmt::format("is the same as line {} in every column; number identical repeats in a "
                                    "column 'repeat'", twin->second));
        table.rows.push_back(row);
    }
    if (columns.empty()) throw FileError(fmt::format("{}: has no header", file));
    if (table.rows.empty()) throw FileError(fmt::format("{}: has no rows", file));
    return table;
}

std::string length_text(double length_m) { return length_m < 1 ? fmt::format("{:.3g} mm", 1e3 * length_m) : fmt::format("{:.3g} m", length_m); }

}  // namespace tissue
