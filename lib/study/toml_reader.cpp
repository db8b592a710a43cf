#include "study/toml_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "error.h"
#include "io/one_line.h"

namespace tissue {
namespace {

std::string words(const Range& range) {
    if (std::isinf(range.low) && std::isinf(range.high)) return "a finite number";
    if (std::isinf(range.high)) return fmt::format("a number {} {}", range.low_open ? ">" : ">=", range.low);
    return fmt::format("a number {} {} and <= {}", range.low_open ? ">" : ">=", range.low, range.high);
}

bool inside(double value, const Range& range) {
    return std::isfinite(value) && value <= range.high && (range.low_open ? value > range.low : value >= range.low);
}

/// toml++ nests one table for each dot of a key and destroys them by recursion. A very long key would exhaust the
/// stack.
constexpr std::size_t longest_line = 10000;

/// The first line such that parsing the text up to its end fails an assertion.
int failing_line(const std::string& text, const std::string& file) {
    int line = 1;
    for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', end + 1), ++line) try {
            (void)toml::parse(text.substr(0, end + 1), file);
        } catch (const toml::parse_error&) {
        } catch (const TomlAssertion&) {
            return line;
        }
    return line;
}

}  // namespace

toml::table parse_toml(const std::string& text, const std::string& file) {
    int line = 1;
    for (std::size_t start = 0; start < text.size(); ++line) {
        const std::size_t end = std::min(text.find('\n', start), text.size());
        if (end - start > longest_line)
            throw StudyError(fmt::format("{}:{}: the line has {} characters, at most {} are allowed", file, line, end - start,
                                         longest_line));
        start = end + 1;
    }
    try {
        return toml::parse(text, file);
    } catch (const toml::parse_error& e) {
        throw StudyError(one_line(fmt::format("{}:{}: {}", file, e.source().begin.line, e.description())));
    } catch (const TomlAssertion&) {
        throw StudyError(fmt::format("{}:{}: is not TOML: a key or a value is missing or malformed", file,
                                     failing_line(text, file)));
    }
}

TomlReader::TomlReader(const toml::table& table, std::string file, std::string path)
    : table_(&table), file_(std::move(file)), path_(std::move(path)) {}

std::string TomlReader::file_of(const std::string& key) const {
    const toml::node* node = table_->get(key);
    const toml::source_region& source = node ? node->source() : table_->source();
    return source.path ? *source.path : file_;
}

std::string TomlReader::beside(const std::string& key, const std::string& name) const {
    return (std::filesystem::path(file_of(key)).parent_path() / name).lexically_normal().string();
}

/// For a key that exists, the message gives the file and line that contain it. For a missing key it names the study,
/// and the file from which the study has the rest of the table.
void TomlReader::refuse(const std::string& key, const std::string& why) const {
    const toml::node* node = table_->get(key);
    const std::string holder = file_of(key), name = path_.empty() ? key : path_ + "." + key;
    const auto line = (node ? node->source() : table_->source()).begin.line;
    if (node) {
        const std::string user = holder == file_ ? "" : fmt::format(" (base of {})", file_);
        throw StudyError(one_line(fmt::format("{}:{}: key '{}': {}{}", holder, line, name, why, user)));
    }
    const std::string rest = holder == file_ ? "" : fmt::format(" (the other keys of '{}' are from {}:{})", path_, holder, line);
    throw StudyError(one_line(fmt::format("{}:{}: key '{}': {}{}", file_, holder == file_ ? line : 1, name, why, rest)));
}

const toml::node& TomlReader::require(const std::string& key) {
    known_.insert(key);
    const toml::node* node = table_->get(key);
    if (!node) refuse(key, path_.empty() ? "is missing; give it, or base the study on one that has it (based_on)" : "is missing");
    return *node;
}

TomlReader TomlReader::table(const std::string& key) {
    const toml::node& node = require(key);
    if (!node.is_table()) refuse(key, "must be a table");
    return {*node.as_table(), file_, path_.empty() ? key : path_ + "." + key};
}

std::vector<TomlReader> TomlReader::tables(const std::string& key) {
    const toml::node& node = require(key);
    const toml::array* array = node.as_array();
    if (!array || (!array->empty() && !array->is_homogeneous<toml::table>())) refuse(key, "must be a list of tables");
    std::vector<TomlReader> readers;
    const std::string prefix = path_.empty() ? key : path_ + "." + key;
    for (std::size_t i = 0; i < array->size(); ++i)
        readers.emplace_back(*(*array)[i].as_table(), file_, fmt::format("{}[{}]", prefix, i));
    return readers;
}

double TomlReader::number(const std::string& key, Range range) {
    const std::optional<double> value = require(key).value<double>();
    if (!value || !inside(*value, range)) refuse(key, "must be " + words(range));
    return *value;
}

std::optional<double> TomlReader::optional_number(const std::string& key, Range range) {
    known_.insert(key);
    if (!has(key)) return std::nullopt;
    return number(key, range);
}

long TomlReader::integer(const std::string& key, long low, long high) {
    const toml::node& node = require(key);
    const std::optional<std::int64_t> value = node.is_integer() ? node.value<std::int64_t>() : std::nullopt;
    if (!value || *value < low || *value > high) refuse(key, fmt::format("must be an integer from {} to {}", low, high));
    return static_cast<long>(*value);
}

std::optional<long> TomlReader::optional_integer(const std::string& key, long low, long high) {
    known_.insert(key);
    if (!has(key)) return std::nullopt;
    return integer(key, low, high);
}

bool TomlReader::flag(const std::string& key) {
    const toml::node& node = require(key);
    if (!node.is_boolean()) refuse(key, "must be true or false");
    return node.as_boolean()->get();
}

bool TomlReader::is_text(const std::string& key) const {
    const toml::node* node = table_->get(key);
    return node && node->is_string();
}

bool TomlReader::is_list(const std::string& key) const {
    const toml::node* node = table_->get(key);
    return node && node->is_array();
}

std::string TomlReader::text(const std::string& key) {
    const toml::node& node = require(key);
    if (!node.is_string()) refuse(key, "must be a text");
    return node.as_string()->get();
}

std::string TomlReader::choice(const std::string& key, const std::vector<std::string>& allowed) {
    const std::string value = text(key);
    if (std::find(allowed.begin(), allowed.end(), value) == allowed.end())
        refuse(key, fmt::format("'{}' is not allowed; allowed: {}", value, fmt::join(allowed, ", ")));
    return value;
}

std::vector<std::string> TomlReader::texts(const std::string& key) {
    known_.insert(key);
    std::vector<std::string> values;
    if (!has(key)) return values;
    const toml::array* array = table_->get(key)->as_array();
    if (!array) refuse(key, "must be a list of texts");
    for (const toml::node& node : *array) {
        if (!node.is_string()) refuse(key, "must be a list of texts");
        values.push_back(node.as_string()->get());
    }
    return values;
}

std::vector<double> TomlReader::numbers(const std::string& key, Range range) {
    const toml::array* array = require(key).as_array();
    if (!array || array->empty()) refuse(key, "must be a list of numbers");
    std::vector<double> values;
    for (const toml::node& node : *array) {
        const std::optional<double> value = node.value<double>();
        if (!value || !inside(*value, range)) refuse(key, "every entry must be " + words(range));
        values.push_back(*value);
    }
    return values;
}

std::vector<double> TomlReader::numbers(const std::string& key, std::size_t count, Range range) {
    std::vector<double> values = numbers(key, range);
    if (values.size() != count) refuse(key, fmt::format("must be a list of {} numbers", count));
    return values;
}

std::vector<std::vector<double>> TomlReader::rows(const std::string& key, std::size_t count) {
    const std::string wanted = fmt::format("must be a list of lists of {} finite numbers", count);
    const toml::array* array = require(key).as_array();
    if (!array || array->empty()) refuse(key, wanted);
    std::vector<std::vector<double>> rows;
    for (const toml::node& node : *array) {
        const toml::array* row = node.as_array();
        if (!row || row->size() != count) refuse(key, wanted);
        std::vector<double>& values = rows.emplace_back();
        for (const toml::node& number : *row) {
            const std::optional<double> value = number.value<double>();
            if (!value || !std::isfinite(*value)) refuse(key, wanted);
            values.push_back(*value);
        }
    }
    return rows;
}

std::vector<std::string> TomlReader::keys() const {
    std::vector<std::string> names;
    for (const auto& [key, node] : *table_) names.emplace_back(key.str());
    return names;
}

void TomlReader::refuse_unless_empty(const std::string& key, const std::string& why) {
    known_.insert(key);
    if (has(key) && !(table_->get(key)->is_array() && table_->get(key)->as_array()->empty())) refuse(key, why);
}

void TomlReader::refuse_the_rest() const {
    for (const auto& [key, node] : *table_)
        if (!known_.count(std::string(key.str())))
            refuse(std::string(key.str()), fmt::format("is not known; allowed: {}", fmt::join(known_, ", ")));
}

}  // namespace tissue
