#include "known_errors.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "error.h"
#include "io/atomic_file.h"
#include "io/one_line.h"

namespace tissue::serve {
namespace {

using Json = nlohmann::json;

constexpr std::size_t most = 2000;             // contacts: more than any study draws, and few enough for one message
constexpr std::uintmax_t most_bytes = 1 << 24;  // size limit of the file
constexpr std::size_t most_words = 400;         // length limit of the warning, which quotes the file

/// Value of a key, of the given type. Throws MismatchError that names the key.
const Json& value_of(const Json& object, const char* key, const std::string& where, bool (Json::*is)() const noexcept) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (!object.is_object() || found == object.end()) throw MismatchError(fmt::format("{} has no '{}'", where, key));
    if (!((*found).*is)()) throw MismatchError(fmt::format("{}: '{}' is of another type", where, key));
    return *found;
}

double number(const Json& value, double low, double high, const std::string& where) {
    const double x = value.is_number() ? value.get<double>() : std::nan("");
    if (!(x >= low && x <= high)) throw MismatchError(fmt::format("{} is no number from {:g} to {:g}", where, low, high));
    return x;
}

Point vector(const Json& row, const char* key, const std::string& where) {
    const Json& list = value_of(row, key, where, &Json::is_array);
    if (list.size() != 3) throw MismatchError(fmt::format("{}: '{}' has {} entries, wanted 3", where, key, list.size()));
    Point v(3);
    for (int axis = 0; axis < 3; ++axis) v[axis] = number(list[static_cast<std::size_t>(axis)], -1e3, 1e3, fmt::format("{}: '{}'", where, key));
    return v;
}

/// nullopt for null, a missing answer.
std::optional<double> error(const Json& object, const char* key, const std::string& where) {
    if (object.is_object() && object.contains(key) && object[key].is_null()) return {};
    return number(value_of(object, key, where, &Json::is_number), 0, 1e12, fmt::format("{}: '{}'", where, key));
}

/// Rows of training contacts, found by name among the model's load cases.
void add_trained(const Json& rows, const TissueModel& tissue, std::vector<ReferenceError>& all) {
    std::map<std::string, int> cases;
    for (int c = 0; c < tissue.case_count(); ++c) cases.emplace(tissue.case_names[static_cast<std::size_t>(c)], c);
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const std::string where = fmt::format("row {} of 'trained_errors'", k), name = value_of(rows[k], "name", where, &Json::is_string).get<std::string>();
        const auto found = cases.find(name);
        if (found == cases.end()) throw MismatchError(fmt::format("{}: the model has no other load case '{}'", where, name));
        const int c = found->second;
        cases.erase(found);
        if (!tissue.is_own_case(c)) continue;  // of another disc than the one in use
        all.push_back({"trained", tissue.contact_m.row(c).transpose(), tissue.direction.row(c).transpose(), tissue.magnitude_m[c], error(rows[k], "error", where)});
    }
}

void add_drawn(const std::string& role, const Json& rows, const TissueModel& tissue, std::vector<ReferenceError>& all) {
    if (role == "trained" || role.empty() || role.size() > 64 || role.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") != std::string::npos)
        throw MismatchError("'drawn' has a role '" + role.substr(0, 64) + "'");
    if (!rows.is_array()) throw MismatchError("'drawn." + role + "' is no list");
    for (std::size_t k = 0; k < rows.size() && all.size() <= most; ++k) {
        const std::string where = fmt::format("row {} of 'drawn.{}'", k, role);
        if (rows[k].is_object() && rows[k].contains("radius_m") && tissue.energy_model &&
            value_of(rows[k], "radius_m", where, &Json::is_number).get<double>() != tissue.energy_model->disc_radius_m)
            continue;  // of another disc than the one in use
        ReferenceError known{role, vector(rows[k], "contact_m", where), vector(rows[k], "direction", where), 0, {}};
        if (!(std::abs(known.direction.norm() - 1) < 1e-6)) throw MismatchError(where + ": 'direction' is no unit vector");
        known.depth_m = number(value_of(rows[k], "depth_m", where, &Json::is_number), 1e-9, tissue.mesh.size_m(), where + ": 'depth_m'");
        known.force = error(value_of(rows[k], "error", where, &Json::is_object), "learned", where);
        try {
            check_on_surface(tissue.mesh, known.contact_m);
        } catch (const MismatchError& e) {
            throw MismatchError(where + ": 'contact_m' " + e.what());
        }
        all.push_back(std::move(known));
    }
}

/// Throws FileError, MismatchError, and the exceptions of the JSON parser.
std::vector<ReferenceError> errors_in(const std::string& file, const std::string& model_file, const TissueModel& tissue) {
    const Json j = Json::parse(read_file(file));
    if (!j.is_object() || !j.contains("model_hash")) throw MismatchError("it does not say which model it is of; `tissuectl eval` of now does");
    if (value_of(j, "model_hash", "it", &Json::is_string) != file_hash(model_file)) throw MismatchError("it is of another model than " + model_file + "; evaluate this one");
    std::vector<ReferenceError> all;
    if (j.contains("trained_errors")) add_trained(value_of(j, "trained_errors", "it", &Json::is_array), tissue, all);
    if (j.contains("drawn"))
        for (const auto& [role, rows] : value_of(j, "drawn", "it", &Json::is_object).items()) add_drawn(role, rows, tissue, all);
    if (all.size() > most) throw MismatchError(fmt::format("it has more than {} contacts", most));
    return all;
}

}  // namespace

KnownErrors read_reference_errors(const std::string& model_file, const TissueModel& tissue) {
    if (!tissue.mesh.is_solid()) return {};
    const std::string file = std::filesystem::path(model_file).replace_filename("eval.json").string();
    std::error_code unseen;
    if (!std::filesystem::exists(file, unseen)) return {};
    const auto refused = [&file](const std::string& why) { return KnownErrors{{}, one_line((file + " is not used: " + why).substr(0, file.size() + most_words))}; };
    if (!std::filesystem::is_regular_file(file, unseen)) return refused("it is no file");
    if (std::filesystem::file_size(file, unseen) > most_bytes) return refused("it has more than 16 MB");
    try {
        return {errors_in(file, model_file, tissue), ""};
    } catch (const std::exception& e) {  // of the parser, of this program, or out of memory
        return refused(e.what());
    }
}

}  // namespace tissue::serve
