#include "adapt/adapted_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "error.h"

namespace tissue {
namespace {

constexpr const char* group = "/adaptation";

/// Calls visit(name, value) for the numbers of AdaptOptions that are stored in a file.
template <class Options, class Visit>
void each_number(Options& o, Visit&& visit) {
    visit("prior_common", o.prior.common);
    visit("prior_local", o.prior.local);
    visit("prior_length_m", o.prior.length_m);
    visit("prior_term", o.prior.term);
    visit("force_noise", o.force_noise);
    visit("model_error", o.model_error);
    visit("place_error_m", o.place_error_m);
    visit("gate", o.gate);
    visit("off_surface_m", o.off_surface_m);
    visit("least_push_m", o.least_push_m);
    visit("largest", o.largest);
}

template <class State, class Visit>
void each_count(State& s, Visit&& visit) {
    visit("learned", s.learned);
    visit("gated", s.gated);
    visit("refused", s.refused);
    visit("gated_in_a_row", s.gated_in_a_row);
}

AdaptOptions read_options(const Hdf5Reader& file) {
    AdaptOptions options;
    options.unknowns = file.text_attribute(group, "unknowns");
    each_number(options, [&](const char* name, double& value) {
        value = file.number_attribute(group, name);
        if (!(value >= 0 && value < 1e3)) file.refuse(group, fmt::format("attribute '{}' is {}, must be a number from 0 to 1000", name, value));
    });
    options.rival = file.number_attribute(group, "rival") != 0;
    options.at_rest = file.number_attribute(group, "at_rest") != 0;
    const double rounds = file.number_attribute(group, "rounds");
    if (!(rounds >= 1 && rounds <= 100 && rounds == std::floor(rounds))) file.refuse(group, fmt::format("attribute 'rounds' is {}, must be a count", rounds));
    options.rounds = static_cast<int>(rounds);
    if (!(options.gate < 1)) file.refuse(group, "attribute 'gate' is not below 1");
    try {
        check(options);
    } catch (const MismatchError& e) {
        file.refuse(group, e.what());
    }
    return options;
}

}  // namespace

const DatasetTable& adaptation_table() {
    static const DatasetTable table = {
        {"/adaptation/constants", "E", Values::positive(), "N/m", "constants of the energy model before the first measurement; in space Pa"},
        {"/adaptation/patch_log", "K x F", Values::logarithm(), "log(N/m)", "contact stiffness before the first measurement"},
        {"/adaptation/contact_log_scale", "N", Values::logarithm(), "1", "log factor of the contact by node, before the first measurement", Rows::any, true},
        {"/adaptation/heuristic_a", "S", Values::positive(), "N/m", "heuristic_a before the first measurement"},
        {"/adaptation/heuristic_b", "S", Values::positive(), "N/m", "heuristic_b before the first measurement"},
        {"/adaptation/x", "P", Values::logarithm(), "1", "adapted unknowns, each the log of a stiffness factor"},
        {"/adaptation/covariance", "P x P", Values::finite(), "1", "posterior covariance of the unknowns"},
        {"/adaptation/recent", "R", Values::not_negative(), "1", "chi2 over the number of axes, of the measurements learned last", Rows::any, true},
        {"/adaptation/last", "3 x D", Values::finite(), "m, N", "the last measurement: contact, tool displacement, force", Rows::any, true},
    };
    return table;
}

void write_adapted_model(const std::string& file, const Adaptation& adaptation, const Provenance& provenance) {
    const TissueModel model = adaptation.model();
    Hdf5Writer out(file, "model", provenance, format_of(model));
    write_tissue(out, model);
    TableWriter table(out, adaptation_table());
    const EnergyModel& base = *adaptation.base().energy_model;
    const Adaptation::State& state = adaptation.state();
    table.write("/adaptation/constants", base.constants);
    table.write("/adaptation/patch_log", NodeField(base.patch.log_N_m));
    if (base.contact_log_scale.size() > 0) table.write("/adaptation/contact_log_scale", base.contact_log_scale);
    table.write("/adaptation/heuristic_a", adaptation.base().heuristic_a);
    table.write("/adaptation/heuristic_b", adaptation.base().heuristic_b);
    table.write("/adaptation/x", state.x);
    table.write("/adaptation/covariance", NodeField(state.P));
    if (!state.recent.empty()) table.write("/adaptation/recent", Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(state.recent.data(), static_cast<Eigen::Index>(state.recent.size()))));
    if (state.last.push_m.size() > 0 && state.last.contact_m.allFinite() && state.last.push_m.allFinite() && state.last.force_N.allFinite()) {
        NodeField last(3, state.last.push_m.size());
        last << state.last.contact_m.transpose(), state.last.push_m.transpose(), state.last.force_N.transpose();
        table.write("/adaptation/last", last);
    }
    out.attribute(group, "unknowns", adaptation.options().unknowns);
    each_number(adaptation.options(), [&](const char* name, double value) { out.attribute(group, name, value); });
    out.attribute(group, "rival", adaptation.options().rival ? 1.0 : 0.0);
    out.attribute(group, "scale", state.scale);
    out.attribute(group, "scale_variance", state.scale_variance);
    out.attribute(group, "evidence", state.evidence);
    out.attribute(group, "at_rest", adaptation.options().at_rest ? 1.0 : 0.0);
    out.attribute(group, "rounds", static_cast<double>(adaptation.options().rounds));
    each_count(state, [&](const char* name, int count) { out.attribute(group, name, static_cast<double>(count)); });
    out.commit();
}

std::optional<AdaptOptions> adapted_options(const std::string& file) {
    const Hdf5Reader in(file, "model");
    if (!in.has(group)) return std::nullopt;
    return read_options(in);
}

std::optional<LearnedField> learned_field(const std::string& file) {
    const std::optional<AdaptOptions> options = adapted_options(file);
    if (!options || options->unknowns != "field") return std::nullopt;
    return learned_field(*read_adaptation(file, {}));
}

std::optional<LearnedField> learned_field(const Adaptation& adaptation) {
    if (adaptation.options().unknowns != "field") return std::nullopt;
    const Adaptation::State& state = adaptation.state();
    const Unknowns::Rows& by_node = adaptation.unknowns().by_node;
    Eigen::VectorXd sd = Eigen::VectorXd::Constant(by_node.rows(), std::sqrt(state.scale_variance));
    if (!adaptation.single_scale_in_use())
        for (Eigen::Index node = 0; node < sd.size(); ++node) {
            double variance = 0;
            for (Unknowns::Rows::InnerIterator a(by_node, node); a; ++a)
                for (Unknowns::Rows::InnerIterator b(by_node, node); b; ++b) variance += a.value() * state.P(a.col(), b.col()) * b.value();
            sd[node] = std::sqrt(std::max(0.0, variance));
        }
    return LearnedField{(by_node * adaptation.x()).array().exp(), sd, state.learned};
}

std::unique_ptr<Adaptation> read_adaptation(const std::string& file, const AdaptOptions& fresh) {
    const Hdf5Reader in(file, "model");
    TissueModel model = read_model(in);
    if (!in.has(group)) return std::make_unique<Adaptation>(model, fresh);
    if (!model.energy_model) in.refuse(group, "the model has no energy model, which adaptation needs");
    TableReader table(in, adaptation_table(), {{"D", static_cast<std::size_t>(model.mesh.dimension())},
                                               {"N", static_cast<std::size_t>(model.mesh.node_count())},
                                               {"S", static_cast<std::size_t>(model.mesh.spring_count())},
                                               {"E", static_cast<std::size_t>(model.energy_model->constants.size())}});
    EnergyModel& energy_model = *model.energy_model;
    const Eigen::VectorXd constants = table.vector("/adaptation/constants");
    const NodeField patch = table.field("/adaptation/patch_log");
    if (patch.rows() != energy_model.patch.log_N_m.rows() || patch.cols() != energy_model.patch.log_N_m.cols()) table.refuse("/adaptation/patch_log", "must have the dimensions of /law/patch_log");
    energy_model.constants = constants;
    energy_model.patch.log_N_m = patch;
    energy_model.contact_log_scale = table.has("/adaptation/contact_log_scale") ? table.vector("/adaptation/contact_log_scale") : Eigen::VectorXd();
    model.heuristic_a = table.vector("/adaptation/heuristic_a");
    model.heuristic_b = table.vector("/adaptation/heuristic_b");
    Adaptation::State state;
    state.x = table.vector("/adaptation/x");
    state.P = table.field("/adaptation/covariance");
    if (table.has("/adaptation/recent")) {
        const Eigen::VectorXd recent = table.vector("/adaptation/recent");
        state.recent.assign(recent.begin(), recent.end());
    }
    if (table.has("/adaptation/last")) {
        const NodeField last = table.field("/adaptation/last");
        state.last = {last.row(0).transpose(), last.row(1).transpose(), last.row(2).transpose()};
    }
    for (const auto& [name, value] : {std::pair<const char*, double*>{"scale", &state.scale}, {"scale_variance", &state.scale_variance}, {"evidence", &state.evidence}}) {
        *value = in.number_attribute(group, name);
        if (!std::isfinite(*value)) in.refuse(group, fmt::format("attribute '{}' is not a finite number", name));
    }
    each_count(state, [&](const char* name, int& count) {
        const double value = in.number_attribute(group, name);
        if (!(value >= 0 && value < 1e9 && value == std::floor(value))) in.refuse(group, fmt::format("attribute '{}' is {}, must be a count", name, value));
        count = static_cast<int>(value);
    });
    try {
        auto adaptation = std::make_unique<Adaptation>(model, read_options(in));
        adaptation->restore(std::move(state));
        return adaptation;
    } catch (const MismatchError& e) {
        in.refuse(group, e.what());
    }
}

}  // namespace tissue
