#include "edited_store.h"

#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "fuzz_file.h"

namespace tissue {
namespace {

constexpr std::size_t most_values = 4096;  ///< largest size of a dataset whose shape is edited

std::size_t count(const std::vector<std::size_t>& shape) {
    std::size_t values = 1;
    for (const std::size_t side : shape) values *= side;
    return values;
}

herr_t note_group(hid_t, const char* name, const H5O_info_t* info, void* out) {
    if (info->type == H5O_TYPE_GROUP) static_cast<std::vector<std::string>*>(out)->push_back(std::strcmp(name, ".") == 0 ? "/" : std::string("/") + name);
    return 0;
}

herr_t note_name(hid_t, const char* name, const H5A_info_t*, void* out) {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
}

}  // namespace

std::string base_file(const std::string& name) {
    const char* kept = std::getenv("FUZZ_KEEP");
    return (kept ? kept : FuzzFile::folder()) + ("/" + name + ".h5");
}

std::size_t Choices::below(std::size_t n) {
    const std::size_t high = byte();
    return (n > 256 ? high * 256 + byte() : high) % n;
}

double Choices::number() {
    static const double known[] = {0, -1, 1, 2, -0.0, 0.5, 3, 1e-300, 1e300, -1e300, 1e-9, 1e9, 2147483647, 2147483648.0, -2147483648.0, 1e19,
                                   std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), std::numeric_limits<double>::denorm_min()};
    const std::size_t which = byte();
    if (which < std::size(known)) return known[which];
    if (which < 128) return static_cast<double>(byte());
    std::uint8_t raw[sizeof(double)];
    for (std::uint8_t& b : raw) b = byte();
    double value;
    std::memcpy(&value, raw, sizeof value);
    return value;
}

std::string Choices::text() {
    std::string text(below(32), ' ');
    for (char& c : text) c = static_cast<char>(byte());
    return text;
}

EditedStore::EditedStore(const std::string& file) {
    const Hdf5Reader in(file, "");
    for (const std::string& name : in.datasets()) {
        const DatasetKind kind = in.kind(name);
        datasets_.push_back({name, kind, kind == DatasetKind::texts ? Array{} : in.array(name), kind == DatasetKind::texts ? in.texts(name) : std::vector<std::string>{}});
    }
    kind_ = in.text_attribute("/", "kind");
    version_ = in.number_attribute("/", "format_version");
    read_attributes(file);
}

/// Attributes of groups, without those that Hdf5Writer writes itself.
void EditedStore::read_attributes(const std::string& file) {
    static const std::set<std::string> writers = {"program", "kind", "format_version", "version", "command", "seed"};
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    std::vector<std::string> groups;
    H5Ovisit(id, H5_INDEX_NAME, H5_ITER_INC, note_group, &groups);
    for (const std::string& group : groups) {
        const hid_t object = H5Oopen(id, group.c_str(), H5P_DEFAULT);
        std::vector<std::string> names;
        H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, note_name, &names);
        for (const std::string& name : names) {
            if (group == "/" && writers.count(name)) continue;
            const hid_t attribute = H5Aopen(object, name.c_str(), H5P_DEFAULT), type = H5Aget_type(attribute);
            const bool is_text = H5Tget_class(type) == H5T_STRING;
            H5Tclose(type);
            H5Aclose(attribute);
            const Hdf5Reader in(file, "");
            if (is_text) attributes_.push_back({group, name, in.text_attribute(group, name)});
            else attributes_.push_back({group, name, in.number_attribute(group, name)});
        }
        H5Oclose(object);
    }
    H5Fclose(id);
}

void EditedStore::edit(Choices& choices) {
    const std::uint8_t how = choices.byte();
    if (how % 16 == 15 && !attributes_.empty()) {
        Attribute& a = attributes_[choices.below(attributes_.size())];
        switch (choices.byte() % 3) {
            case 0: a.value = choices.number(); break;
            case 1: a.value = choices.text(); break;
            default: a.key += "x"; break;
        }
        return;
    }
    if (datasets_.empty()) return;
    const std::size_t which = choices.below(datasets_.size());
    Dataset& d = datasets_[which];
    std::vector<double>& values = d.array.values;
    switch (how % 16) {
        case 0: datasets_.erase(datasets_.begin() + static_cast<std::ptrdiff_t>(which)); return;
        case 1: d.kind = static_cast<DatasetKind>(choices.byte() % 3); break;
        case 2: {  // the content of another dataset
            const Dataset& other = datasets_[choices.below(datasets_.size())];
            d = {d.name, other.kind, other.array, other.texts};
            break;
        }
        case 3:
        case 4: {  // another length along one axis, or one axis more or less
            std::vector<std::size_t> shape = d.array.shape;
            const std::size_t axis = choices.below(shape.size() + 2);
            if (axis < shape.size()) shape[axis] = choices.byte() % 2 ? shape[axis] + 1 - 2 * (choices.byte() % 2) : choices.byte();
            else if (axis == shape.size()) shape.push_back(choices.byte() % 4);
            else if (!shape.empty()) shape.pop_back();
            if (std::any_of(shape.begin(), shape.end(), [](std::size_t side) { return side > most_values; }) || count(shape) > most_values) break;
            const double last = values.empty() ? 0 : values.back();
            d.array.shape = shape;
            values.resize(count(shape), last);
            break;
        }
        case 5:
        case 6: {  // one of the texts
            if (d.texts.empty() || choices.byte() % 8 == 0) d.texts.emplace_back();
            d.texts[choices.below(d.texts.size())] = choices.text();
            break;
        }
        case 7: {  // all values
            const double by = choices.number();
            for (double& value : values) value = choices.byte() % 2 ? value * by : by;
            break;
        }
        case 8:  // two values are exchanged
            if (!values.empty()) std::swap(values[choices.below(values.size())], values[choices.below(values.size())]);
            break;
        default:
            if (!values.empty()) values[choices.below(values.size())] = choices.number();
    }
}

void EditedStore::write(const std::string& file) const {
    Hdf5Writer out(file, kind_, {"fuzz", 0, {}}, static_cast<int>(version_));
    for (const Dataset& d : datasets_) {
        if (d.kind == DatasetKind::texts) out.write_texts(d.name, d.texts, "");
        else if (d.kind == DatasetKind::numbers) out.write(d.name, d.array, "1", "");
        else {
            std::vector<int> integers;
            for (const double value : d.array.values) integers.push_back(std::abs(value) <= 2147483647.0 ? static_cast<int>(value) : 0);
            out.write_integers(d.name, d.array.shape, integers, "");
        }
    }
    for (const Attribute& a : attributes_)
        std::visit([&](const auto& value) { out.attribute(a.object, a.key, value); }, a.value);
    out.commit();
}

}  // namespace tissue
