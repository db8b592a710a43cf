#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "study/toml.h"

namespace tissue {

/// Parses the text of a TOML file. Throws StudyError with file, line and cause where it is not TOML.
toml::table parse_toml(const std::string& text, const std::string& file);

/// Range of allowed numbers. Both bounds are included, the lower one unless it is open.
struct Range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool low_open = false;
};

/// Reads the keys of one TOML table, records which keys were read, and refuses all others. Every refusal is a
/// StudyError with file, line, key, and what is allowed.
class TomlReader {
   public:
    /// path: name of the table in messages ("training"), empty for the root.
    TomlReader(const toml::table& table, std::string file, std::string path);

    TomlReader table(const std::string& key);
    std::vector<TomlReader> tables(const std::string& key);

    double number(const std::string& key, Range range = {});
    std::optional<double> optional_number(const std::string& key, Range range = {});
    long integer(const std::string& key, long low, long high);
    std::optional<long> optional_integer(const std::string& key, long low, long high);
    bool flag(const std::string& key);
    std::string text(const std::string& key);
    bool is_text(const std::string& key) const;  ///< whether the key exists and is a text
    bool is_list(const std::string& key) const;  ///< whether the key exists and is a list
    std::string choice(const std::string& key, const std::vector<std::string>& allowed);
    std::vector<std::string> texts(const std::string& key);
    std::vector<double> numbers(const std::string& key, Range range = {});
    std::vector<double> numbers(const std::string& key, std::size_t count, Range range = {});
    /// A list, not empty, of lists of `count` numbers each.
    std::vector<std::vector<double>> rows(const std::string& key, std::size_t count);
    std::vector<std::string> keys() const;  ///< in alphabetical order
    bool has(const std::string& key) const { return table_->contains(key); }

    /// The file that contains a key; that of a base study where the key comes from it.
    std::string file_of(const std::string& key) const;

    /// Path of a file `name`, relative to the folder of file_of(key).
    std::string beside(const std::string& key, const std::string& name) const;

    /// Refuses a key that is neither absent nor an empty list, for instance because another key replaces it.
    void refuse_unless_empty(const std::string& key, const std::string& why);

    /// Throws for keys that were not read.
    void refuse_the_rest() const;

    [[noreturn]] void refuse(const std::string& key, const std::string& why) const;

   private:
    const toml::node& require(const std::string& key);

    const toml::table* table_;
    std::string file_, path_;
    std::set<std::string> known_;
};

}  // namespace tissue
