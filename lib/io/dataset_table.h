#pragma once

#include <map>
#include <string>
#include <vector>

#include "io/hdf5_store.h"

namespace tissue {

/// Allowed values of a dataset. They are finite, unless `nan` is set. By default they are within 1e12, so that squares
/// and sums stay finite; no quantity of tissue reaches 1e12 in SI units.
struct Values {
    DatasetKind kind = DatasetKind::numbers;
    double low = -1e12, high = 1e12;
    bool low_open = false;
    bool nan = false;           ///< NaN is allowed and means a missing value
    std::string index_of = {};  ///< for integers: 0 to this length - 1
    bool name = false;          ///< for texts: valid names (can_name_a_dataset), all different

    static Values finite() { return {}; }
    /// A position or displacement [m]. The tick treats positions beyond 1 km as faults.
    static Values place() {
        Values v;
        v.low = -1e3;
        v.high = 1e3;
        return v;
    }
    static Values positive() { return Values{}.above(0, true); }
    /// A logarithm whose exponential, and products of a few of these, stay finite.
    static Values logarithm() {
        Values v;
        v.low = -50;
        v.high = 50;
        return v;
    }
    static Values not_negative() { return Values{}.above(0, false); }
    static Values count() { return Values{DatasetKind::integers}.above(0, false); }
    static Values index(const std::string& length) {
        Values v = count();
        v.index_of = length;
        return v;
    }
    static Values text() { return {DatasetKind::texts}; }
    static Values names() {
        Values v = text();
        v.name = true;
        return v;
    }
    Values or_nan() const {
        Values v = *this;
        v.nan = true;
        return v;
    }

   private:
    Values above(double bound, bool open) const {
        Values v = *this;
        v.low = bound;
        v.low_open = open;
        return v;
    }
};

/// Conditions between the rows of a dataset.
enum class Rows {
    any,
    distinct,   ///< no two rows have the same entries (integers: in any order, and none twice in a row)
    ascending,  ///< each value larger than the one before
    unit        ///< rows of unit length
};

/// One dataset of a kind of file, and its conditions. "NAME" in its name matches any one group. The shape is as in
/// results/FORMATS.md, such as "S x 2". A letter is a length that is the same in every dataset of the file (of the
/// group, where the name has a NAME). "C*" may be 0; other lengths may not.
struct DatasetRule {
    std::string name, shape;
    Values values;
    std::string units, description;
    Rows rows = Rows::any;
    bool optional = false;  ///< missing in files of earlier programs
};

using DatasetTable = std::vector<DatasetRule>;

DatasetTable joined(DatasetTable table, const DatasetTable& more);

/// The rule of a dataset. Throws std::logic_error when the table has none, which is an error in the program.
const DatasetRule& rule_of(const DatasetTable& table, const std::string& name);

/// Writes datasets with the units and the description of their rules.
class TableWriter {
   public:
    TableWriter(Hdf5Writer& out, const DatasetTable& table) : out_(out), table_(table) {}

    /// values: an Array, vector or field.
    template <class Numbers>
    void write(const std::string& name, const Numbers& values) {
        const DatasetRule& rule = rule_of(table_, name);
        out_.write(name, values, rule.units, rule.description + shape_words(rule));
    }
    void write_integers(const std::string& name, const std::vector<std::size_t>& shape, const std::vector<int>& values);
    /// Any matrix of integers, in row-major order.
    template <class Matrix>
    void write_table(const std::string& name, const Matrix& m) {
        std::vector<int> values;
        for (Eigen::Index i = 0; i < m.rows(); ++i)
            for (Eigen::Index j = 0; j < m.cols(); ++j) values.push_back(m(i, j));
        write_integers(name, {static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols())}, values);
    }
    void write_texts(const std::string& name, const std::vector<std::string>& values);

   private:
    static std::string shape_words(const DatasetRule& rule);

    Hdf5Writer& out_;
    const DatasetTable& table_;
};

/// Reads datasets and checks each against its rule. Throws FileError, "FILE: DATASET: WHY", for a dataset that is
/// missing, of another type or shape, or with a value or rows that its rule does not allow. A copy starts with the
/// lengths met so far and continues independently: use one per group.
class TableReader {
   public:
    TableReader(const Hdf5Reader& in, const DatasetTable& table, std::map<std::string, std::size_t> lengths = {})
        : in_(&in), table_(&table), length_(std::move(lengths)) {}

    /// Continues with another table and the lengths met so far.
    void use(const DatasetTable& table) { table_ = &table; }

    bool has(const std::string& name) const { return in_->has(name); }
    Array array(const std::string& name);
    Eigen::VectorXd vector(const std::string& name);
    NodeField field(const std::string& name);
    std::vector<int> integers(const std::string& name);
    /// Integers (R x Columns).
    template <int Columns>
    Eigen::Matrix<int, Eigen::Dynamic, Columns> table_of(const std::string& name) {
        return field(name).template cast<int>();
    }
    std::vector<std::string> texts(const std::string& name);
    int length(const std::string& letter) const { return static_cast<int>(length_.at(letter)); }

    [[noreturn]] void refuse(const std::string& place, const std::string& why) const { in_->refuse(place, why); }

   private:
    const DatasetRule& check_shape(const std::string& name);

    const Hdf5Reader* in_;
    const DatasetTable* table_;
    std::map<std::string, std::size_t> length_;
};

}  // namespace tissue
