#include <algorithm>
#include <nlohmann/json.hpp>

#include "eval/evaluation.h"
#include "eval/statistics_json.h"
#include "version.h"

namespace tissue {
namespace {

using Json = nlohmann::ordered_json;

Json or_null(const std::optional<double>& value) { return value && std::isfinite(*value) ? Json(*value) : Json(); }

int total(const std::vector<int>& values) {
    int sum = 0;
    for (int v : values) sum += v;
    return sum;
}

int restarted_sets(const SetDiagnostics& t) {
    int count = 0;
    for (int r : t.restarts) count += r > 0 ? 1 : 0;
    return count;
}

/// {"status": count}.
Json counts(const std::vector<std::string>& status) {
    Json found = Json::object();
    for (const std::string& s : status) found[s] = found.value(s, 0) + 1;
    return found;
}

bool all_are(const std::string& word, const std::vector<std::string>& status) {
    return std::all_of(status.begin(), status.end(), [&](const std::string& s) { return s == word; });
}

Json training(const SetDiagnostics& t) {
    return {{"optimizer", t.optimizer},       {"sets", t.status.size()},
            {"restarts", total(t.restarts)},  {"restarted_sets", restarted_sets(t)},
            {"iterations", total(t.iterations)}, {"evaluations", total(t.evaluations)},
            {"gap", {{"median", statistics_of({t.gap.begin(), t.gap.end()}).median}, {"max", t.gap.maxCoeff()}}},
            {"status", counts(t.status)},             {"seconds", t.seconds}};
}

Json training(const EnergyModel& energy_model, const EnergyModelDiagnostics& diagnostics) {
    Json j = {{"objective", diagnostics.objective}, {"paths", diagnostics.paths}, {"records", diagnostics.records}, {"seconds", diagnostics.seconds},
              {"factor", diagnostics.factor}, {"kept", diagnostics.kept}, {"lost", diagnostics.lost}};
    for (std::size_t t = 0; t < energy_model.terms.size(); ++t) j["terms"][energy_model.terms[t]] = energy_model.coefficients[static_cast<Eigen::Index>(t)];
    if (const auto& s = diagnostics.shares) {
        j["shares"] = {{"histories", s->histories}, {"status", s->status}, {"kkt_residual", s->kkt_residual}, {"misfit", s->misfit}, {"grown", s->grown}};
        for (int k = 0; k < energy_model.relaxation.branches(); ++k)
            j["shares"]["branches"].push_back({{"g", energy_model.relaxation.contact_share[k]}, {"tau_s", energy_model.relaxation.tau_s[k]}});
    }
    for (std::size_t s = 0; s < diagnostics.status.size(); ++s) {
        const auto i = static_cast<Eigen::Index>(s);
        j["starts"].push_back({{"status", diagnostics.status[s]}, {"objective", diagnostics.start_objective[i]}, {"gradient", diagnostics.gradient[i]},
                               {"iterations", diagnostics.iterations[s]}, {"evaluations", diagnostics.evaluations[s]}});
    }
    return j;
}

Json histories(const HistoryTable& h, bool measured) {
    Json j = {{"lost", h.lost},
              {"fitted", {{"best_factor", h.factor}, {"kelvin_voigt", {{"factor", h.kelvin_voigt[0]}, {"damper_s", h.kelvin_voigt[1]}}}, {"one_branch", {{"g", h.branch[0]}, {"tau_s", h.branch[1]}}}}}};
    if (measured) j["near_training"] = h.near_training;
    std::vector<std::string> groups = h.groups();
    groups.push_back("");
    for (const std::string& group : groups) {
        Json& entry = j["groups"][group.empty() ? "all" : group];
        entry["elastic"] = to_value(h.elastic_rms(group));
        for (std::size_t m = 0; m < h.models.size(); ++m) entry[h.models[m]] = {{"rms", to_value(h.rms(m, group))}, {"peak", to_value(h.peak(m, group))}};
    }
    for (const HistoryAnswer& a : h.answers) {
        Json row = {{"name", a.name}, {"group", a.group}, {"kind", a.kind}, {"elastic", or_null(a.elastic.rms)}};
        for (std::size_t m = 0; m < h.models.size(); ++m) row["error"][h.models[m]] = {{"rms", or_null(a.error[m].rms)}, {"peak", or_null(a.error[m].peak)}};
        row["time_s"] = a.time_s;
        row["fe_N"] = a.fe_N;
        row["learned_N"] = a.learned_N;
        row["best_factor_N"] = a.elastic_N;
        j["each"].push_back(std::move(row));
    }
    return j;
}

Json two_tools(const IndentationPairs& role, const std::vector<std::string>& models) {
    Json j;
    for (std::size_t m = 0; m < models.size(); ++m) {
        const ContactStatistics s = role.statistics(m);
        j[models[m]] = to_value(s.force);
        if (!s.reasons.empty()) j[models[m]]["reason"] = s.reasons;
    }
    j["lost"] = role.lost;
    j["pairs"] = Json::array();
    for (const IndentationPair& pair : role.pairs) {
        Json row = {{"name", pair.name}, {"apart_m", pair.apart_m()}, {"radius_m", pair.radius_m}};
        for (std::size_t t = 0; t < 2; ++t) {
            Json tool = {{"contact_m", pair.contact_m[t]}, {"push_m", pair.push_m[t]}, {"fe_force_N", pair.fe_force_N[t]}};
            for (std::size_t m = 0; m < models.size(); ++m) tool["error"][models[m]] = or_null(pair.error[m][t].force);
            row["tools"].push_back(std::move(tool));
        }
        j["pairs"].push_back(std::move(row));
    }
    return j;
}

}  // namespace

std::string to_json(const Evaluation& evaluation, unsigned long seed, const EvaluatedFiles& files) {
    Json j;
    j["study"] = evaluation.study;
    j["version"] = version;
    j["format_version"] = format_version;
    j["seed"] = seed;
    if (!files.model_hash.empty()) j["model_hash"] = files.model_hash;
    if (!files.cases_hash.empty()) j["cases_hash"] = files.cases_hash;
    if (const auto& m = evaluation.measurement)
        j["measurement"] = {{"origin", m->origin},
                            {"rows", m->rows},
                            {"contacts", m->contacts},
                            {"noise_source", m->noise_source},
                            {"force_noise", m->force_noise},
                            {"displacement_noise_m", m->displacement_noise_m},
                            {"repeats", m->repeats},
                            {"outliers", m->outliers}};
    for (const ModelErrors& m : evaluation.models)
        if (evaluation.open_loop()) j["open_loop"][m.name] = {{"rel_loss", to_value(m.rel_loss())},
                                  {"resolved_force_error", to_value(m.resolved_error())},
                                  {"n", m.rel_loss().n}, {"of", m.rel_loss().of()}};
    const bool seen_inside = !evaluation.measurement;
    for (const ModelErrors& m : evaluation.models)
        j["closed_loop"]["trained"][m.name] = to_value(m.closed_loop(), seen_inside);
    if (!evaluation.uniform_chosen_on.empty()) j["uniform"] = {{"stiffness_N_m", evaluation.uniform_N_m}, {"chosen_on", evaluation.uniform_chosen_on}};
    j["training"] = evaluation.energy_model_diagnostics ? training(*evaluation.energy_model, *evaluation.energy_model_diagnostics) : training(evaluation.trained.front());
    for (std::size_t t = 1; t < evaluation.trained.size(); ++t)
        j["training_also"].push_back(training(evaluation.trained[t]));
    if (!evaluation.energy_model_diagnostics) j["optimum"] = {{"kkt_residual_max", evaluation.optimum.kkt_residual.maxCoeff()},
                    {"seconds", evaluation.optimum.seconds}};
    if (!evaluation.energy_model_diagnostics && !all_are("converged", evaluation.optimum.status)) j["optimum"]["status"] = counts(evaluation.optimum.status);
    if (const ProblemRecord& p = evaluation.problems; !all_are("posed", p.status) || p.one_set_status != "posed")
        if (!p.status.empty())
            j["problems"] = {{"objective", p.objective}, {"status", counts(p.status)}, {"one_set_status", p.one_set_status}};
    if (!evaluation.lost.empty()) j["lost"]["train"] = evaluation.lost;
    const HeldOut& held_out = evaluation.held_out;
    for (const DrawnContacts& role : held_out.roles) {
        Json& entry = j["closed_loop"][role.role];
        for (std::size_t m = 0; m < held_out.models.size(); ++m)
            entry[held_out.models[m]] = to_value(role.statistics(m), seen_inside);
        j["lost"][role.role] = role.lost;
        for (const double radius_m : role.radii_m()) {
            Json of_disc = {{"radius_m", radius_m}};
            for (std::size_t m = 0; m < held_out.models.size(); ++m) of_disc[held_out.models[m]] = to_value(role.of_disc(radius_m).statistics(m), seen_inside);
            j["by_radius"][role.role].push_back(std::move(of_disc));
        }
        for (const DrawnContact& c : role.contacts) {
            Json row = {{"name", c.name}};
            if (c.contact_m.size() == 2) {
                row["arc_m"] = c.arc_m;
            } else {
                row["contact_m"] = c.contact_m;
                row["direction"] = c.direction;
                row["clearance_m"] = or_null(c.clearance_m);
                row["thickness_m"] = or_null(c.thickness_m);
                row["radius_m"] = c.radius_m;
            }
            row.update({{"angle_deg", c.angle_deg}, {"depth_m", c.depth_m}, {"fe_force_N", c.fe_force_N}, {"extrapolated", c.extrapolated}});
            for (std::size_t m = 0; m < held_out.models.size(); ++m) {
                row["error"][held_out.models[m]] = or_null(c.error[m].force);
                if (seen_inside) row["shape"][held_out.models[m]] = or_null(c.error[m].shape);
            }
            j["drawn"][role.role].push_back(std::move(row));
        }
    }
    for (const IndentationPairs& role : evaluation.two_tools.roles) j["two_tools"][role.role] = two_tools(role, evaluation.two_tools.models);
    for (const DrawnCurve& c : held_out.curves)
        j["drawn_curves"].push_back({{"name", c.name},
                                     {"magnitude_m", c.magnitude_m},
                                     {"fe_N", c.fe_N},
                                     {"models_N", {{"learned", c.learned_N}, {"uniform", c.uniform_N}}}});
    for (const DrawnShape& s : held_out.shapes) {
        Json row = {{"name", s.name}, {"which", s.which}};
        for (Eigen::Index i = 0; i < s.displacement_m.rows(); ++i)
            row["displacement_m"].push_back(s.displacement_m.row(i));
        j["drawn_shapes"].push_back(std::move(row));
    }
    if (const ForceMap& map = evaluation.map; !map.empty()) {
        j["map"] = {{"depth_m", map.depth_m}, {"error", to_value(map.error())}, {"lost", map.lost}};
        for (const ForceMap::Place& p : map.places)
            j["map"]["places"].push_back({{"name", p.name}, {"contact_m", p.contact_m}, {"fe_N", p.fe_N}, {"learned_N", or_null(p.learned_N)}});
        if (const auto& c = map.contrast)
            j["map"]["contrast"] = {{"over_m", c->over_m}, {"far_m", c->far_m}, {"fe", c->fe}, {"learned", or_null(c->learned)}};
    }
    if (const HistoryTable& h = evaluation.histories; !h.empty()) j["histories"] = histories(h, evaluation.measurement.has_value());
    if (!evaluation.discretisation.empty()) {
        j["truth_check"] = to_value(evaluation.discretisation.difference);
        j["truth_check"]["lost"] = evaluation.discretisation.lost;
        j["truth_check"]["unmatched"] = evaluation.discretisation.unmatched;
    }
    if (evaluation.energy_model_diagnostics)  // for spring sets these errors are in `cases`
        for (std::size_t c = 0; c < evaluation.case_names.size(); ++c)
            j["trained_errors"].push_back({{"name", evaluation.case_names[c]}, {"error", or_null(evaluation.models.front().cases[c].closed_loop.force)}});
    if (!evaluation.listed) return j.dump(1) + "\n";
    for (const ModelErrors& m : evaluation.models) {
        const SpringCharacter& s = m.springs;
        j["springs"][m.name] = {{"distance_near_E2", to_value(statistics_of(s.near))},
                                {"distance_far_E2", to_value(statistics_of(s.far))},
                                {"magnitude_step_E2", to_value(statistics_of(s.magnitude_step))},
                                {"angle_step_E2", to_value(statistics_of(s.angle_step))},
                                {"force_steps", s.force_steps},
                                {"force_falls", s.force_falls},
                                {"smallest_eigenvalue_E2", s.smallest_eigenvalue},
                                {"floppy_sets", s.singular_sets}};
    }
    for (const FrontPoint& p : evaluation.front)
        j["ridge_front"].push_back({{"ridge", p.ridge},
                                    {"rel_loss", p.rel_loss},
                                    {"distance_E2", p.distance},
                                    {"force_falls", p.force_falls},
                                    {"smallest_eigenvalue_E2", p.smallest_eigenvalue}});
    for (std::size_t c = 0; c < evaluation.case_names.size(); ++c) {
        const auto i = static_cast<Eigen::Index>(c);
        Json row = {{"name", evaluation.case_names[c]},
                    {"magnitude_m", evaluation.magnitude_m[c]},
                    {"fe_resolved_force_N", evaluation.fe_resolved_N[c]},
                    {"fe_smallest_J", evaluation.smallest_J[c]},
                    {"loss_lower_bound_N", evaluation.optimum.lower_bound_N[i]},
                    {"kkt_residual", evaluation.optimum.kkt_residual[i]},
                    {"gap", evaluation.trained.front().gap[i]},
                    {"status", evaluation.trained.front().status[c]}};
        for (const ModelErrors& m : evaluation.models) {
            const CaseError& e = m.cases[c];
            row["models"][m.name] = {{"rel_loss", e.open_loop.rel_loss},
                                     {"resolved_force_N", e.open_loop.resolved_force_N},
                                     {"resolved_force_error", e.open_loop.resolved_error},
                                     {"closed_loop_error", or_null(e.closed_loop.force)},
                                     {"closed_loop_shape", or_null(e.closed_loop.shape)}};
        }
        j["cases"].push_back(std::move(row));
    }
    for (const ForceCurve& curve : evaluation.curves) {
        Json row = {{"path", curve.path},
                    {"magnitude_m", curve.magnitude_m},
                    {"serving_set", curve.serving_set},
                    {"fe_N", curve.fe_N}};
        for (std::size_t m = 0; m < evaluation.models.size(); ++m)
            row["models_N"][evaluation.models[m].name] = curve.model_force_N[m];
        j["curves"].push_back(std::move(row));
    }
    return j.dump(1) + "\n";
}

}  // namespace tissue
