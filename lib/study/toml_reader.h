#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "study/toml.h"

namespace tissue {

/// The text of a TOML file. Throws StudyError with file, line and cause for whatever is not TOML.
toml::table parse_toml(const std::string& text, const std::string& file);

/// Inclusive range of allowed numbers, unless a bound is said to be open.
struct Range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool low_open = false;
};

/// Reads keys of one TOML table, remembers which were asked for, and refuses what is left over. Every refusal is a
/// StudyError with file, line, key, and what is allowed.
class TomlReader {
   public:
    /// path: how messages name the table ("training"), empty for the root.
    TomlReader(const toml::table& table, std::string file, std::string path);

    TomlReader table(const std::string& key);
    std::vector<TomlReader> tables(const std::string& key);

    double number(const std::string& key, Range range = {});
    std::optional<double> optional_number(const std::string& key, Range range = {});
    long integer(const std::string& key, long low, long high);
    std::optional<long> optional_integer(const std::string& key, long low, long high);
    bool flag(const std::string& key);
    std::string text(const std::string& key);
    bool is_text(const std::string& key) const;  ///< whether there is such a key, and it is a text
    bool is_list(const std::string& key) const;  ///< whether there is such a key, and it is a list
    std::string choice(const std::string& key, const std::vector<std::string>& allowed);
    std::vector<std::string> texts(const std::string& key);
    std::vector<double> numbers(const std::string& key, Range range = {});
    std::vector<double> numbers(const std::string& key, std::size_t count, Range range = {});
    /// A list of lists of so many numbers, not empty.
    std::vector<std::vector<double>> rows(const std::string& key, std::size_t count);
    std::vector<std::string> keys() const;  ///< in alphabetical order
    bool has(const std::string& key) const { return table_->contains(key); }

    /// The file in which a key stands: a base study's, where it comes from there.
    std::string file_of(const std::string& key) const;

    /// A file of this name beside that one.
    std::string beside(const std::string& key, const std::string& name) const;

    /// For a list that another key stands in for.
    void refuse_unless_empty(const std::string& key, const std::string& why);

    /// Throws for keys that nobody asked for.
    void refuse_the_rest() const;

    [[noreturn]] void refuse(const std::string& key, const std::string& why) const;

   private:
    const toml::node& require(const std::string& key);

    const toml::table* table_;
    std::string file_, path_;
    std::set<std::string> known_;
};

}  // namespace tissue
