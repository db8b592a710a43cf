#include "mutations.h"

#include <hdf5.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "error.h"
#include "example.h"

namespace tissue {
namespace {

/// One alteration of one dataset of a file.
struct Mutation {
    std::string name;                                ///< "one row added"
    std::function<void(const std::string&)> apply;   ///< alters the file with this name
    bool must_be_refused = true;                     ///< false: the altered file may be valid
};

void put(const std::string& file, const std::string& dataset, const Array* array) {
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    REQUIRE(H5Ldelete(id, dataset.c_str(), H5P_DEFAULT) >= 0);
    if (array) {
        const std::vector<hsize_t> shape(array->shape.begin(), array->shape.end());
        const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
        const hid_t made = H5Dcreate2(id, dataset.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        if (!array->values.empty()) H5Dwrite(made, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array->values.data());
        H5Dclose(made);
        H5Sclose(space);
    }
    H5Fclose(id);
}

void put_texts(const std::string& file, const std::string& dataset, const std::vector<std::string>& texts) {
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    REQUIRE(H5Ldelete(id, dataset.c_str(), H5P_DEFAULT) >= 0);
    std::size_t length = 1;
    for (const std::string& text : texts) length = std::max(length, text.size());
    std::string raw(texts.size() * length, '\0');
    for (std::size_t i = 0; i < texts.size(); ++i) texts[i].copy(raw.data() + i * length, length);
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, length);
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    H5Tset_cset(type, H5T_CSET_UTF8);
    const hsize_t count = texts.size();
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t made = H5Dcreate2(id, dataset.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (count > 0) H5Dwrite(made, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, raw.data());
    H5Dclose(made);
    H5Sclose(space);
    H5Tclose(type);
    H5Fclose(id);
}

/// Adds a copy of the last row, or removes the last row. A dataset without rows gets a row of zeros.
Array with_rows(Array a, int change) {
    const std::size_t rows = a.shape[0];
    std::size_t columns = 1;
    for (std::size_t d = 1; d < a.shape.size(); ++d) columns *= a.shape[d];
    a.shape[0] = static_cast<std::size_t>(static_cast<int>(rows) + change);
    const std::vector<double> last(a.values.end() - static_cast<std::ptrdiff_t>(rows > 0 ? columns : 0), a.values.end());
    a.values.insert(a.values.end(), last.begin(), last.end());
    a.values.resize(a.shape[0] * columns);
    return a;
}

/// Extends the last dimension by one (with zeros), or shortens it by one.
Array with_columns(const Array& a, int change) {
    const std::size_t columns = a.shape.back(), rows = a.values.size() / columns,
                      changed = static_cast<std::size_t>(static_cast<int>(columns) + change);
    Array b{a.shape, {}};
    b.shape.back() = changed;
    for (std::size_t r = 0; r < rows; ++r)
        for (std::size_t c = 0; c < changed; ++c) b.values.push_back(c < columns ? a.values[r * columns + c] : 0);
    return b;
}

}  // namespace

std::vector<std::pair<std::string, const DatasetRule*>> datasets_of(const std::string& file, const DatasetTable& table) {
    std::vector<std::pair<std::string, const DatasetRule*>> found;
    for (const std::string& name : Hdf5Reader(file, "").datasets()) try {
            found.emplace_back(name, &rule_of(table, name));
        } catch (const std::logic_error&) {  // the table has no rule for this dataset
        }
    return found;
}

namespace {

std::vector<Mutation> mutations(const std::string& file, const std::string& dataset, const DatasetTable& table) {
    const Hdf5Reader in(file, "");
    const DatasetRule& rule = rule_of(table, dataset);
    std::vector<Mutation> all;
    const auto add = [&](const std::string& name, const Array& a, bool must_be_refused = true) {
        all.push_back({name, [=](const std::string& f) { put(f, dataset, &a); }, must_be_refused});
    };
    all.push_back({"missing", [=](const std::string& f) { put(f, dataset, nullptr); }, !rule.optional});
    // if no other dataset has the same length, another length gives another valid file
    const std::string first = rule.shape.substr(0, rule.shape.find(' '));
    std::set<const DatasetRule*> sharing;
    for (const auto& [name, other] : datasets_of(file, table))
        if ((" " + other->shape + " ").find(" " + first + " ") != std::string::npos) sharing.insert(other);
    const bool shared = sharing.size() > 1 || std::isdigit(static_cast<unsigned char>(first[0]));
    if (rule.values.kind == DatasetKind::texts) {
        const std::vector<std::string> texts = in.texts(dataset);
        const auto add_texts = [&](const std::string& name, const std::vector<std::string>& changed, bool must_be_refused) {
            all.push_back({name, [=](const std::string& f) { put_texts(f, dataset, changed); }, must_be_refused});
        };
        std::vector<std::string> more = texts, fewer = texts, twice = texts, nameless = texts, outside = texts;
        more.push_back("one more");
        if (!texts.empty()) {
            fewer.pop_back();
            twice.back() = twice.front();
            nameless.back() = "";
            outside.back() = "../x";
            add_texts("one text removed", fewer, shared);
            add_texts("first text repeated as the last", twice, rule.values.name && texts.size() > 1);
            add_texts("last text empty", nameless, rule.values.name);
            add_texts("last text is a path", outside, rule.values.name);
        }
        add_texts("one text added", more, shared || rule.values.name);  // the group with the added name is missing
        add_texts("no texts", {}, first.back() != '*');
        add("changed to numbers", {{texts.size() + 1}, std::vector<double>(texts.size() + 1, 1.0)});
        return all;
    }
    const Array a = in.array(dataset);
    const bool rows = !a.values.empty();
    all.push_back({"changed to texts", [=](const std::string& f) { put_texts(f, dataset, {"a", "b", "c"}); }, true});
    add("one row added", with_rows(a, 1), shared || (rows && rule.rows != Rows::any));
    if (rows) add("one row removed", with_rows(a, -1), shared);
    if (rows && a.shape.size() > 1) {
        add("one column added", with_columns(a, 1));
        add("one column removed", with_columns(a, -1));
        Array turned = a;
        std::reverse(turned.shape.begin(), turned.shape.end());
        if (turned.shape != a.shape) add("transposed", turned);
    }
    Array deeper = a;
    deeper.shape.push_back(1);
    add("one dimension added", deeper);
    Array empty = a;
    empty.shape[0] = 0;
    empty.values.clear();
    if (rows) add("no rows", empty, first.back() != '*' || first == "R*");
    if (!rows) return all;
    for (const std::size_t at : {std::size_t{0}, a.values.size() / 2, a.values.size() - 1}) {
        const auto value = [&](const std::string& name, double v, bool must_be_refused) {
            Array changed = a;
            changed.values[at] = v;
            add(name + " at " + std::to_string(at), changed, must_be_refused);
        };
        const Values& v = rule.values;
        value("NaN", std::nan(""), !v.nan);
        value("inf", std::numeric_limits<double>::infinity(), true);
        value("-inf", -std::numeric_limits<double>::infinity(), true);
        value("negative", -1, v.low >= 0);
        value("zero", 0, v.low_open);
        value("huge", 1e300, true);
        if (v.kind == DatasetKind::integers) value("one half", 0.5, true);
        if (!v.index_of.empty()) value("index out of range", 4096, true);
    }
    if (a.shape[0] > 1 && rule.rows != Rows::any) {
        const std::size_t columns = a.values.size() / a.shape[0];
        Array twice = a;
        std::copy_n(a.values.begin(), columns, twice.values.end() - static_cast<std::ptrdiff_t>(columns));
        add("first row repeated as the last", twice, rule.rows == Rows::distinct || rule.rows == Rows::ascending);
        Array backwards = a;
        for (std::size_t r = 0; r < a.shape[0]; ++r)
            std::copy_n(a.values.begin() + static_cast<std::ptrdiff_t>(r * columns), columns,
                        backwards.values.begin() + static_cast<std::ptrdiff_t>((a.shape[0] - 1 - r) * columns));
        add("rows in reverse order", backwards, rule.rows == Rows::ascending);
        if (columns > 1 && rule.values.kind == DatasetKind::integers) {
            Array same = a;
            same.values[1] = same.values[0];
            add("one index twice in a row", same);
        }
    }
    return all;
}

}  // namespace

int refused_mutations(const std::string& file, const DatasetTable& table, const std::function<void(const std::string&)>& read,
                      const std::string& place, const std::function<bool(const std::string&)>& wanted) {
    const TemporaryFolder folder;
    const std::string copy = folder.file("altered.h5");
    int refused = 0;
    for (const auto& [dataset, rule] : datasets_of(file, table)) {
        if (wanted && !wanted(dataset)) continue;
        for (const Mutation& mutation : mutations(file, dataset, table)) {
            INFO(dataset << ": " << mutation.name);
            std::filesystem::copy_file(file, copy, std::filesystem::copy_options::overwrite_existing);
            mutation.apply(copy);
            try {
                read(copy);
                CHECK_FALSE(mutation.must_be_refused);
            } catch (const FileError& e) {
                ++refused;
                CHECK_THAT(e.what(), Catch::Matchers::StartsWith(copy + ": " + place));
                CHECK(std::string(e.what()).find('\n') == std::string::npos);
            }
        }
    }
    return refused;
}

}  // namespace tissue
