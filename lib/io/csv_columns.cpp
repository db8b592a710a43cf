#include "io/csv_columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace tissue {

const Units& length_units() {
    static const Units units = {{"m", 1}, {"mm", 1e-3}};
    return units;
}

const Units& force_units() {
    static const Units units = {{"N", 1}, {"mN", 1e-3}};
    return units;
}

const Units& time_units() {
    static const Units units = {{"s", 1}, {"ms", 1e-3}};
    return units;
}

std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

CsvColumns::CsvColumns(const CsvLines& line, const std::vector<CsvColumn>& known) : columns_(line.size()) {
    for (std::size_t i = 0; i < line.size(); ++i) {
        const std::string field = trimmed(line.field(i));
        const std::size_t open = field.find('[');
        const std::string name = trimmed(field.substr(0, open));
        const auto column = std::find_if(known.begin(), known.end(), [&](const CsvColumn& c) { return name == c.name; });
        if (column == known.end()) {
            std::vector<std::string> names;
            for (const CsvColumn& c : known) names.push_back(c.name);
            line.refuse(fmt::format("column '{}' is not known; allowed: {}", name, fmt::join(names, ", ")));
        }
        if (!place_.emplace(name, i).second) line.refuse(fmt::format("column '{}' is present twice", name));
        std::vector<std::string> units;
        if (column->units)
            for (const auto& unit : *column->units) units.push_back(unit.first);
        if (open == std::string::npos) {
            if (column->units)
                line.refuse(fmt::format("column '{}' has no unit; write '{} [UNIT]', UNIT one of {}", name, name, fmt::join(units, ", ")));
            continue;
        }
        const std::string unit = field.back() == ']' ? trimmed(field.substr(open + 1, field.size() - open - 2)) : field;
        if (!column->units) line.refuse(fmt::format("column '{}' has text and must have no unit", name));
        const auto found = column->units->find(unit);
        if (found == column->units->end())
            line.refuse(fmt::format("column '{}': unit '{}' is not known; allowed: {}", name, unit, fmt::join(units, ", ")));
        unit_[name] = found->second;
    }
    for (const CsvColumn& c : known)
        if (c.required && !has(c.name)) line.refuse(fmt::format("column '{}' is missing", c.name));
}

void CsvColumns::check(const CsvLines& line) const {
    if (line.size() != columns_)
        line.refuse(fmt::format("has {} fields, the header {} columns{}", line.size(), columns_,
                                line.size() > columns_ ? "; are there decimal commas? Write decimal points" : ""));
}

double CsvColumns::number(const CsvLines& line, const std::string& name) const { return line.number(place_.at(name), name) * unit_.at(name); }

std::string CsvColumns::text(const CsvLines& line, const std::string& name) const {
    const auto there = place_.find(name);
    return there == place_.end() ? std::string() : trimmed(line.field(there->second));
}

}  // namespace tissue
