#include "io/dataset_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>
#include <set>
#include <sstream>
#include <stdexcept>

#include "io/dataset_name.h"

namespace tissue {
namespace {

std::vector<std::string> split(const std::string& text, char by) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, by);) parts.push_back(part);
    return parts;
}

bool matches(const std::string& pattern, const std::string& name) {
    if (pattern.find("NAME") == std::string::npos) return pattern == name;
    const std::vector<std::string> a = split(pattern, '/'), b = split(name, '/');
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) { return x == "NAME" || x == y; });
}

/// "S x 2" as {"S", "2"}; empty for "".
std::vector<std::string> lengths_of(const std::string& shape) {
    std::vector<std::string> lengths;
    std::istringstream in(shape);
    for (std::string word; in >> word;)
        if (word != "x") lengths.push_back(word);
    return lengths;
}

std::string words(const Values& v) {
    return fmt::format("{} {} {} and <= {:g}", v.kind == DatasetKind::integers ? "a whole number" : "a number",
                       v.low_open ? ">" : ">=", v.low, v.high);
}

bool allowed(double value, const Values& v) {
    if (std::isnan(value)) return v.nan;
    if (v.kind == DatasetKind::integers && (value != std::floor(value) || std::abs(value) > 2147483647.0)) return false;
    return std::isfinite(value) && value <= v.high && (v.low_open ? value > v.low : value >= v.low);
}

/// Why the rows violate the rule; empty when they do not.
std::string wrong_rows(const Array& a, const DatasetRule& rule) {
    const std::size_t rows = a.shape.empty() ? 0 : a.shape[0], columns = rows > 0 ? a.values.size() / rows : 0;
    std::set<std::vector<double>> seen;
    if (rule.rows == Rows::unit && a.shape.size() == 1) {  // one vector
        const double square = std::inner_product(a.values.begin(), a.values.end(), a.values.begin(), 0.0);
        return std::abs(std::sqrt(square) - 1) > 1e-6 ? "must have length 1" : "";
    }
    for (std::size_t r = 0; r < rows; ++r) {
        std::vector<double> row(a.values.begin() + static_cast<std::ptrdiff_t>(r * columns),
                                a.values.begin() + static_cast<std::ptrdiff_t>((r + 1) * columns));
        switch (rule.rows) {
            case Rows::any: return "";
            case Rows::unit:
                if (std::abs(std::sqrt(std::inner_product(row.begin(), row.end(), row.begin(), 0.0)) - 1) > 1e-6)
                    return fmt::format("row {} must have length 1", r);
                break;
            case Rows::ascending:
                if (r > 0 && !(a.values[r] > a.values[r - 1])) return fmt::format("row {} must be larger than the one before", r);
                break;
            case Rows::distinct:
                if (rule.values.kind == DatasetKind::integers) {
                    std::sort(row.begin(), row.end());
                    if (const auto twice = std::adjacent_find(row.begin(), row.end()); twice != row.end())
                        return fmt::format("row {} names {} twice", r, *twice);
                }
                if (!seen.insert(row).second) return fmt::format("row {} is present twice", r);
        }
    }
    return "";
}

}  // namespace

DatasetTable joined(DatasetTable table, const DatasetTable& more) {
    table.insert(table.end(), more.begin(), more.end());
    return table;
}

const DatasetRule& rule_of(const DatasetTable& table, const std::string& name) {
    const auto rule = std::find_if(table.begin(), table.end(), [&](const DatasetRule& r) { return matches(r.name, name); });
    if (rule == table.end()) throw std::logic_error("no rule for the dataset " + name);
    return *rule;
}

// ---- writing

std::string TableWriter::shape_words(const DatasetRule& rule) {
    std::string shape = rule.shape;
    shape.erase(std::remove(shape.begin(), shape.end(), '*'), shape.end());
    const bool letters = std::any_of(shape.begin(), shape.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
    return letters ? " (" + shape + ")" : "";
}

void TableWriter::write_integers(const std::string& name, const std::vector<std::size_t>& shape, const std::vector<int>& values) {
    const DatasetRule& rule = rule_of(table_, name);
    out_.write_integers(name, shape, values, rule.description + shape_words(rule));
}

void TableWriter::write_texts(const std::string& name, const std::vector<std::string>& values) {
    const DatasetRule& rule = rule_of(table_, name);
    out_.write_texts(name, values, rule.description + shape_words(rule));
}

// ---- reading

const DatasetRule& TableReader::check_shape(const std::string& name) {
    const DatasetRule& rule = rule_of(*table_, name);
    const std::vector<std::size_t> shape = in_->shape(name);
    const bool texts = in_->kind(name) == DatasetKind::texts;
    if (texts != (rule.values.kind == DatasetKind::texts))
        in_->refuse(name, texts ? "has texts, must have numbers" : "has numbers, must have texts");
    const std::vector<std::string> wanted = lengths_of(rule.shape);
    bool fits = shape.size() == wanted.size();
    std::vector<std::string> said;
    for (std::size_t d = 0; d < wanted.size(); ++d) {
        std::string letter = wanted[d];
        const bool may_be_0 = letter.back() == '*';
        if (may_be_0) letter.pop_back();
        const bool fixed = std::isdigit(static_cast<unsigned char>(letter[0])) != 0;
        const auto known = length_.find(letter);
        said.push_back(fixed ? letter : known == length_.end() ? letter : fmt::format("{} = {}", letter, known->second));
        if (!fits) continue;
        if (fixed)
            fits = shape[d] == std::stoul(letter);
        else if (known != length_.end())
            fits = shape[d] == known->second;
        else if (shape[d] == 0 && !may_be_0)
            in_->refuse(name, "is empty");
        else
            length_[letter] = shape[d];
    }
    if (!fits)
        in_->refuse(name, fmt::format("is {}, must be {}", shape.empty() ? "a single value" : fmt::format("{}", fmt::join(shape, " x ")),
                                      fmt::join(said, " x ")));
    return rule;
}

Array TableReader::array(const std::string& name) {
    const DatasetRule& rule = check_shape(name);
    Array a = in_->array(name);
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        if (!allowed(a.values[i], rule.values))
            in_->refuse(name, fmt::format("value {} is {}, must be {}", i, a.values[i], words(rule.values)));
        if (!rule.values.index_of.empty() && !(a.values[i] < static_cast<double>(length_.at(rule.values.index_of))))
            in_->refuse(name, fmt::format("value {} is {}, which does not exist; there are {}", i, a.values[i],
                                          length_.at(rule.values.index_of)));
    }
    if (const std::string why = wrong_rows(a, rule); !why.empty()) in_->refuse(name, why);
    return a;
}

Eigen::VectorXd TableReader::vector(const std::string& name) {
    const Array a = array(name);
    return Eigen::Map<const Eigen::VectorXd>(a.values.data(), static_cast<Eigen::Index>(a.values.size()));
}

NodeField TableReader::field(const std::string& name) {
    const Array a = array(name);
    if (a.shape.size() != 2) in_->refuse(name, "must have two dimensions");
    return Eigen::Map<const NodeField>(a.values.data(), static_cast<Eigen::Index>(a.shape[0]), static_cast<Eigen::Index>(a.shape[1]));
}

std::vector<int> TableReader::integers(const std::string& name) {
    const Array a = array(name);
    return {a.values.begin(), a.values.end()};
}

std::vector<std::string> TableReader::texts(const std::string& name) {
    const DatasetRule& rule = check_shape(name);
    const std::vector<std::string> texts = in_->texts(name);
    std::set<std::string> seen;
    for (const std::string& text : texts) {
        if (!rule.values.name) continue;
        if (!can_name_a_dataset(text))
            in_->refuse(name, "has a name that is empty, '.' or '..', or has a '/' or a control character");
        if (!seen.insert(text).second) in_->refuse(name, fmt::format("'{}' is present twice", text));
    }
    return texts;
}

}  // namespace tissue
