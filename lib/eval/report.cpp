#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <cmath>
#include <map>

#include "eval/evaluation.h"
#include "springs/energy_model_terms.h"
#include "train/endings.h"
#include "version.h"

namespace tissue {
namespace {

/// Printed under every table: how missing answers count (eval/statistics.h).
constexpr const char* rule =
    "*n of N*: n of all N cases have an error. A model without an answer has an infinite error; a quantile that falls on it is "
    "`none`. Where the reference has no answer no error is defined: such a case is in N and in no quantile.";

std::string summary(const Statistics& s) {
    return s.n == 0 ? "none" : fmt::format("{} / {} / {}", percent(s.median), percent(s.p95), percent(s.max));
}

double loss_at(const SetDiagnostics& t, Eigen::Index set, int iteration) {
    double loss = std::nan("");
    for (std::size_t p = 0; p < t.curve_iteration.size() && t.curve_iteration[p] <= iteration; ++p)
        if (const double there = t.curve_loss_N(set, static_cast<Eigen::Index>(p)); !std::isnan(there)) loss = there;
    return loss;
}

/// Median over the sets of the loss at an iteration, over the loss at the start.
double median_progress(const SetDiagnostics& t, int iteration) {
    std::vector<double> values;
    for (Eigen::Index c = 0; c < t.loss_N.size(); ++c) values.push_back(loss_at(t, c, iteration) / loss_at(t, c, 0));
    return statistics_of(values).median;
}

/// "18 converged", "13 iterations_done, 5 restarts_exhausted".
std::string counted(const std::vector<std::string>& status) {
    std::map<std::string, int> counts;
    for (const std::string& s : status) ++counts[s];
    std::string text;
    for (const auto& [word, count] : counts) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, word);
    return text;
}

/// Warning at the head of the report where part of the training did not converge; else "".
std::string broken_markdown(const Evaluation& e) {
    const Endings endings = e.energy_model_diagnostics ? endings_of(*e.energy_model_diagnostics) : endings_of(e.problems, e.trained, e.optimum);
    if (endings.broken.empty()) return "";
    std::string out = "**Part of the training did not converge** (results/FORMATS.md defines each status):\n\n";
    for (const std::string& line : endings.broken) out += "- " + line + "\n";
    return out + "\n";
}

std::string measurement_markdown(const Evaluation& e) {
    if (!e.measurement) return "";
    const Measurement& m = *e.measurement;
    std::string out = fmt::format("## The data\n\n> {}\n\n{} rows at {} contacts. Noise of one component ({}): {} of the force",
                                  m.origin.empty() ? "The file does not state its origin." : m.origin, m.rows, m.contacts,
                                  m.noise_source == "repeats" ? fmt::format("from repeats, {} degrees of freedom", m.repeats)
                                                              : m.noise_source,
                                  m.noise_source == "unknown" ? "none known" : percent(m.force_noise));
    if (m.noise_source == "repeats") out += fmt::format(", {:.3f} mm", 1e3 * m.displacement_noise_m);
    out += ". `repeat` predicts a row by the other repeats of the same measurement: about the error of a perfect model. ";
    out += m.outliers.empty() ? "No row is an outlier.\n\n" : "Outliers, all kept:\n\n";
    for (const std::string& line : m.outliers) out += "- " + line + "\n";
    return out + (m.outliers.empty() ? "" : "\n");
}

std::string no_answer_markdown(const std::string& model, const std::string& reasons) {
    return reasons.empty() ? "" : fmt::format("\nNo answer of {}: {}.\n", model, reasons);
}

constexpr const char* shape_head = " displacement: median / p95 / max | largest node error over depth: median / p95 / max | n of N |";

std::string shape_words(bool solid) {
    return fmt::format("*Displacement*: rms over the free nodes{} of u - u_fe, over the rms of u_fe.{}", solid ? " of the surface" : "",
                       solid ? " Under the disc u is what the disc imposes, (1 - (r/R)^2 / 2) d, in FE as here, so nodes there have no error; from its rim to 2.5 R "
                               "it changes to that of the lattice, for every energy model here (lib/springs/skin.h)." : "");
}

/// Explains roles and models of a solid, before the tables that name them.
std::string solid_words(const HeldOut& h) {
    constexpr const char* roles[][2] = {{"validation", "used for choices during development, so its errors are too low"},
                                        {"held_out", "the test set: used for no choice; places, tilts and depths drawn as for `validation`"},
                                        {"held_out_near", "of the test set, nearer to a wall or a corner"},
                                        {"held_out_sideways", "of the test set, displaced along the top instead of into it"}};
    constexpr const char* models[][2] = {
        {"learned", "the trained energy model"},
        {"force_table", "a table of FE forces at the training contacts, interpolated; no springs"},
        {"untrained", "the energy model before training: every constant is its heuristic"},
        {"heuristic_a_patch", "Van Gelder's springs (7) with E, without cells that keep their volume, under the contact of the untrained model"},
        {"heuristic_b_patch", "the same with C1 + C2 in place of E"},
        {"uniform_patch", "the same springs, all of one stiffness, the best at the training contacts"}};
    std::string out = "## Contacts and models of the tables\n\n";
    for (const auto& [role, words] : roles)
        if (h.role(role)) out += fmt::format("- contacts of `{}`: {}\n", role, words);
    std::set<double> heights_m;  // a block has one height
    for (const DrawnContacts& role : h.roles)
        for (const DrawnContact& c : role.contacts) heights_m.insert(c.contact_m[2]);
    out += fmt::format("\nTools press {} of the tissue; *tilt* is the angle between tool displacement and inward normal. The models:\n\n",
                       heights_m.size() < 2 ? "the top" : "the free surface");
    for (const auto& [model, words] : models)
        if (std::find(h.models.begin(), h.models.end(), model) != h.models.end()) out += fmt::format("- model `{}`: {}\n", model, words);
    return out + "\n";
}

/// First columns of the table of the worst contacts: head, and cells of one contact.
std::string place_head(bool solid) { return solid ? " x mm | y mm | tilt deg |" : " along the surface mm | angle deg |"; }

std::string place_cells(const DrawnContact& c, bool solid) {
    return solid ? fmt::format(" {:.1f} | {:.1f} | {:.1f} |", 1e3 * c.contact_m[0], 1e3 * c.contact_m[1], c.angle_deg)
                 : fmt::format(" {:.1f} | {:.1f} |", 1e3 * c.arc_m, c.angle_deg);
}

std::string shape_cells(const ContactStatistics& s) {
    const bool force_alone = s.force.n > 0 && s.shape.n + s.shape.missing == 0;
    return fmt::format(" {} | {} | {} |", summary(s.shape), summary(s.shape_max_over_depth), force_alone ? "none" : n_of_N(s.shape));
}

/// Whether the first model has a finite force error at the contact.
bool answered(const DrawnContact& c) { return c.error[0].force && std::isfinite(*c.error[0].force); }

/// Errors of the first model in space, by disc radius and by thirds of the contacts: sorted by thickness of the tissue,
/// and by distance from the edge of the free surface. Empty for fewer than 12 contacts.
std::string by_place_markdown(const DrawnContacts& role, const std::string& model) {
    constexpr std::size_t fewest = 12;
    if (role.contacts.size() < fewest) return "";
    std::string out;
    const auto thirds = [&](const std::string& what, double DrawnContact::*place_m) {
        std::vector<DrawnContact> sorted;
        for (const DrawnContact& c : role.contacts)
            if (std::isfinite(c.*place_m)) sorted.push_back(c);
        if (sorted.size() < fewest) return;
        std::sort(sorted.begin(), sorted.end(), [&](const DrawnContact& a, const DrawnContact& b) { return a.*place_m < b.*place_m; });
        // a block has one thickness
        if (sorted.back().*place_m - sorted.front().*place_m < 0.05 * sorted.back().*place_m) return;
        for (std::size_t third = 0; third < 3; ++third) {
            const auto at = [&](std::size_t part) { return sorted.begin() + static_cast<std::ptrdiff_t>(part * sorted.size() / 3); };
            const DrawnContacts some{role.role, {at(third), at(third + 1)}, {}};
            const ContactStatistics s = some.statistics(0);
            out += fmt::format("| {}, {:.1f} to {:.1f} mm | {} | {} | {} | {} |\n", what, 1e3 * some.contacts.front().*place_m, 1e3 * some.contacts.back().*place_m,
                               summary(s.force), n_of_N(s.force), summary(s.shape), n_of_N(s.shape));
        }
    };
    for (const double radius_m : role.radii_m()) {
        const ContactStatistics s = role.of_disc(radius_m).statistics(0);
        out += fmt::format("| disc of {:g} mm | {} | {} | {} | {} |\n", 1e3 * radius_m, summary(s.force), n_of_N(s.force), summary(s.shape), n_of_N(s.shape));
    }
    thirds("thickness", &DrawnContact::thickness_m);
    thirds("distance from the free surface's edge", &DrawnContact::clearance_m);
    if (out.empty()) return "";
    const std::string lost = role.lost.empty() ? "" : fmt::format("; the {} without an FE reference are in no third", role.lost.size());
    return fmt::format("\nErrors of `{}` by radius of the disc, where there are several, and by thirds of the contacts (thickness: of the tissue along the inward normal, at rest; edge: where the free surface ends, for example at fixed parts, or turns by more than 45 degrees{}):\n\n"
                       "| contacts | force: median / p95 / max | n of N | displacement: median / p95 / max | n of N |\n|---|---|---|---|---|\n", model, lost) + out;
}

std::string held_out_markdown(const HeldOut& h, bool measured, bool solid) {
    std::string out = solid ? solid_words(h) : "";
    for (const DrawnContacts& role : h.roles) {
        out += fmt::format("## Contacts of `{}`: indentation error of force\n\n| model | median | p95 | max | n of N |", role.role);
        out += measured ? "\n|---|---|---|---|---|\n" : fmt::format("{}\n|---|---|---|---|---|---|---|---|\n", shape_head);
        for (std::size_t m = 0; m < h.models.size(); ++m) {
            const ContactStatistics s = role.statistics(m);
            out += fmt::format("| {} | {} | {} | {} | {} |", h.models[m], percent(s.force.median), percent(s.force.p95),
                               percent(s.force.max), n_of_N(s.force));
            out += (measured ? "" : shape_cells(s)) + "\n";
        }
        for (std::size_t m = 0; m < h.models.size(); ++m) out += no_answer_markdown(h.models[m], role.statistics(m).reasons);
        for (const DrawnContact& c : role.contacts)
            if (!answered(c)) out += fmt::format("\nNo answer of {} at {}.\n", h.models[0], c.name);
        int extrapolated = 0;
        for (const DrawnContact& c : role.contacts) extrapolated += c.extrapolated ? 1 : 0;
        out += fmt::format("\n{} {} were drawn, {} of them without an FE reference; {} are outside the range of the training. {}", role.drawn(),
                           measured ? "rows" : "contacts", role.lost.size(), extrapolated, rule);
        if (!measured) out += " " + shape_words(solid);
        out += measured ? "\n" : fmt::format(" Without an FE reference: {}{}\n", role.lost.size(), role.lost.empty() ? "." : ":");
        for (const std::string& lost : role.lost) out += "- " + lost + "\n";
        if (solid && !measured) out += by_place_markdown(role, h.models[0]);
        std::vector<const DrawnContact*> worst;
        for (const DrawnContact& c : role.contacts)
            if (answered(c)) worst.push_back(&c);
        std::sort(worst.begin(), worst.end(),
                  [](const auto* a, const auto* b) { return *a->error[0].force > *b->error[0].force; });
        out += fmt::format("\nThe worst ten:\n\n| contact |{} depth mm | force N | error |{}\n|{}---|---|---|---|---|---|{}\n", place_head(solid),
                           measured ? "" : " displacement error |", solid ? "---|" : "", measured ? "" : "---|");
        for (std::size_t i = 0; i < std::min<std::size_t>(10, worst.size()); ++i)
            out += fmt::format("| {} |{} {:.2f} | {:.3f} | {} |{}\n", worst[i]->name, place_cells(*worst[i], solid),
                               1e3 * worst[i]->depth_m, worst[i]->fe_force_N.norm(),
                               percent(*worst[i]->error[0].force),
                               measured ? "" : fmt::format(" {} |", percent(worst[i]->error[0].shape.value_or(std::nan("")))));
        out += "\n";
    }
    return out;
}

std::string two_tools_markdown(const TwoTools& two) {
    std::string out;
    for (const IndentationPairs& role : two.roles) {
        out += fmt::format("## Two discs at once: pairs of `{}`, force error on each disc\n\n| model | median | p95 | max | n of N |\n|---|---|---|---|---|\n", role.role);
        for (std::size_t m = 0; m < two.models.size(); ++m) {
            const Statistics s = role.statistics(m).force;
            out += fmt::format("| {} | {} | {} | {} | {} |\n", two.models[m], percent(s.median), percent(s.p95), percent(s.max), n_of_N(s));
        }
        for (std::size_t m = 0; m < two.models.size(); ++m) out += no_answer_markdown(two.models[m], role.statistics(m).reasons);
        out += fmt::format("\n`learned`: both discs press the model at once. `alone`: each disc presses it without the other. N counts two forces a pair. {} Pairs without an FE reference: {}{}\n",
                           rule, role.lost.size(), role.lost.empty() ? "." : ":");
        for (const std::string& lost : role.lost) out += "- " + lost + "\n";
        std::vector<const IndentationPair*> nearest;
        for (const IndentationPair& pair : role.pairs) nearest.push_back(&pair);
        std::sort(nearest.begin(), nearest.end(), [](const auto* a, const auto* b) { return a->apart_m() < b->apart_m(); });
        constexpr std::size_t most = 20;
        out += fmt::format("\nPairs by the distance of their centres at rest{}; of the first and of the second disc:\n\n| pair | apart mm | depth mm | FE force N |",
                           nearest.size() > most ? fmt::format(", the nearest {}", most) : "");
        for (const std::string& model : two.models) out += fmt::format(" {} |", model);
        out += "\n|---|---|---|---|";
        for (std::size_t m = 0; m < two.models.size(); ++m) out += "---|";
        out += "\n";
        for (std::size_t i = 0; i < std::min(most, nearest.size()); ++i) {
            const IndentationPair& p = *nearest[i];
            out += fmt::format("| {} | {:.1f} | {:.2f}, {:.2f} | {:.3f}, {:.3f} |", p.name, 1e3 * p.apart_m(), 1e3 * p.push_m[0].norm(), 1e3 * p.push_m[1].norm(), p.fe_force_N[0].norm(),
                               p.fe_force_N[1].norm());
            for (const auto& error : p.error) out += fmt::format(" {}, {} |", percent(error[0].force.value_or(std::nan(""))), percent(error[1].force.value_or(std::nan(""))));
            out += "\n";
        }
        out += "\n";
    }
    return out;
}

std::string discretisation_markdown(const DiscretisationCheck& discretisation) {
    if (discretisation.empty()) return "";
    std::string out = fmt::format(
        "## Discretisation error of the FE reference\n\nForces of the finite elements differ from those on the study's finer mesh by {} "
        "(median / p95 / max, {}).", summary(discretisation.difference), n_of_N(discretisation.difference, "indentations"));
    if (!discretisation.lost.empty()) out += " On the finer mesh these load paths end early:\n";
    for (const std::string& lost : discretisation.lost) out += "\n- " + lost;
    if (!discretisation.unmatched.empty()) out += "\n\nThese have no load path on the study's mesh for comparison:\n";
    for (const std::string& unmatched : discretisation.unmatched) out += "\n- " + unmatched;
    return out + "\n\n";
}

std::string map_markdown(const ForceMap& map) {
    if (map.empty()) return "";
    std::string out = fmt::format("## Force map\n\n{} straight indentations of {:g} mm over the top, none of them a load case of the training.",
                                  map.places.size() + map.lost.size(), 1e3 * map.depth_m);
    out += fmt::format(" Force error of the model: {} (median / p95 / max, {}).", summary(map.error()), n_of_N(map.error(), "places"));
    if (const auto& c = map.contrast)
        out += fmt::format(" Above the middle of the inclusion the force is {:.3f} times the force far from it in finite elements, and {} times in the model.", c->fe,
                           c->learned ? fmt::format("{:.3f}", *c->learned) : "not known");
    if (!map.lost.empty()) out += fmt::format(" Without an FE reference: {}:\n", map.lost.size());
    for (const std::string& lost : map.lost) out += "\n- " + lost;
    return out + "\n\n";
}

std::string histories_markdown(const HistoryTable& h, bool measured) {
    if (h.empty()) return "";
    const bool has_elastic = h.elastic_rms("").n + h.elastic_rms("").missing > 0;
    const std::string where =
        measured ? fmt::format("Displacement histories at contacts where no history was fitted; {} of {} are within 2 mm of a training contact", h.near_training, h.answers.size())
                 : "Displacement histories at contacts of no training path";
    std::string out = fmt::format(
        "## Force over time\n\n{}: the tool follows the history, the model advances tick by "
        "tick with the mass of its nodes, and its force is compared with {}. *rms*: of the force error over time, over that of the "
        "force. *peak*: the largest error over the largest force. Median / p95 / max.\n\n"
        "| histories | n of N | learned, rms | learned, peak |{}\n|---|---|---|---|{}\n",
        where, measured ? "the measured force, noise included" : "finite elements that relax and have mass",
        has_elastic ? " without relaxation, in model and FE: rms | n of N |" : "", has_elastic ? "---|---|" : "");
    std::vector<std::string> groups = h.groups();
    if (groups.size() > 1) groups.emplace_back();
    if (h.models.empty()) {  // no history has an FE reference
        out = fmt::format("## Force over time\n\nNone of the {} histories has an FE reference:\n", h.lost.size());
        for (const std::string& lost : h.lost) out += "\n- " + lost;
        return out + "\n\n";
    }
    for (const std::string& group : groups)
        out += fmt::format("| {} | {} | {} | {} |{}\n", group.empty() ? "all" : group, n_of_N(h.rms(0, group)), summary(h.rms(0, group)), summary(h.peak(0, group)),
                           has_elastic ? fmt::format(" {} | {} |", summary(h.elastic_rms(group)), n_of_N(h.elastic_rms(group))) : "");
    out += fmt::format(
        "\n{}\n\nBaselines, rms, median / p95 / max (n of N). `long_term` and `instantaneous`: the model without relaxation, with its long-term or instantaneous moduli; "
        "`best_factor`: {:.3g} times the latter, the best elastic model; `kelvin_voigt`: {:.3g} F + {:.3g} s dF/dt of it; `one_branch`: one Maxwell branch, "
        "relative modulus {:.3g}, relaxation time {:.3g} s. These three are fitted to {}, so their errors are too low.{}\n\n| histories |",
        rule, h.factor, h.kelvin_voigt[0], h.kelvin_voigt[1], h.branch[0], h.branch[1], h.fitted_to_all ? "these histories, all that have an answer" : "those of these histories in which mass does not matter",
        has_elastic ? " `prony`: the FE force without relaxation, through the Prony series of the material; no springs." : "");
    const std::size_t models = h.models.size() - (has_elastic ? 0 : 1);  // prony, the last one, needs an elastic FE run
    for (std::size_t m = 0; m < models; ++m) out += fmt::format(" {} |", h.models[m]);
    out += "\n|---|";
    for (std::size_t m = 0; m < models; ++m) out += "---|";
    for (const std::string& group : groups) {
        out += fmt::format("\n| {} |", group.empty() ? "all" : group);
        for (std::size_t m = 0; m < models; ++m) out += fmt::format(" {} ({}) |", summary(h.rms(m, group)), n_of_N(h.rms(m, group)));
    }
    if (!h.lost.empty()) out += fmt::format("\n\nWithout an FE reference: {}:\n", h.lost.size());
    for (const std::string& lost : h.lost) out += "\n- " + lost;
    return out + "\n\n";
}

std::string figures_markdown(const std::vector<const char*>& figures) {
    std::string out = "\n## Figures\n\n";
    for (const char* figure : figures) out += fmt::format("![{0}](figures/{0}.png)\n\n", figure);
    return out;
}

/// Ratio of a constant to its heuristic where this term is 1 and all others are 0. For cells whose heuristic is far
/// below the cap, as in plane stress, it depends on the cap, which is not in the model: "none".
std::string factor_of(const std::string& term, double p, bool starts_below_cap) {
    if (term.rfind("skin.", 0) == 0) return "none";
    if (term.rfind("cell.", 0) != 0) return fmt::format("{:.3g}", std::exp(p));
    return starts_below_cap ? fmt::format("{:.3g}", bent_factor(p)) : "none";
}

std::string energy_model_markdown(const EnergyModel& energy_model, const EnergyModelDiagnostics& diagnostics, bool measured) {
    const std::string errors = measured ? "force errors, in their scale" : "force and displacement errors, each in its scale";
    std::string over;
    if (measured) over = fmt::format(", with {:.3g} times the study's E2, fitted to the forces,", diagnostics.factor);
    std::string out = fmt::format(
        "\n## The energy model\n\n{} parameters from {} {} paths, {} load cases, in {:.1f} s. Objective {:.4g}: the mean square of {}, plus "
        "the ridge. Every constant is its heuristic{} times exp(sum of coefficient x term); constants of cells stay below their "
        "cap; the {} constants are in model.h5. Terms of the skin, where there are any, change no constant (lib/springs/skin.h).\n\n| term | coefficient | factor where the term is 1 |\n|---|---|---|\n",
        energy_model.terms.size(), diagnostics.paths, measured ? "measured" : "FE", diagnostics.records, diagnostics.seconds, diagnostics.objective, errors,
        over, energy_model.constants.size());
    for (std::size_t t = 0; t < energy_model.terms.size(); ++t) {
        const double p = energy_model.coefficients[static_cast<Eigen::Index>(t)];
        out += fmt::format("| {} | {:.3f} | {} |\n", energy_model.terms[t], p, factor_of(energy_model.terms[t], p, energy_model.incompressible || energy_model.disc_radius_m > 0));
    }
    if (diagnostics.at_rest) out += "\nThe measurements are of tissue at rest: they are compared with the long-term force of the model.\n";
    out += "\n| start | ended | objective | largest derivative | iterations | evaluations |\n|---|---|---|---|---|---|\n";
    for (std::size_t s = 0; s < diagnostics.status.size(); ++s) {
        const auto i = static_cast<Eigen::Index>(s);
        out += fmt::format("| {}{} | {} | {:.4g} | {:.1e} | {} | {} |\n", s == 0 ? "the heuristic" : fmt::format("drawn {}", s),
                           static_cast<int>(s) == diagnostics.kept ? ", kept" : "", diagnostics.status[s], diagnostics.start_objective[i],
                           diagnostics.gradient[i], diagnostics.iterations[s], diagnostics.evaluations[s]);
    }
    if (diagnostics.shares) {
        const EnergyModelDiagnostics::Shares& s = *diagnostics.shares;
        out += fmt::format("\nMaxwell branches fitted to {} measured histories, {}: force residual {} rms, noise included; KKT residual {:.1e}.{}\n", s.histories, s.status,
                           percent(s.misfit), s.kkt_residual, s.grown > 1 ? fmt::format(" The training forces are of tissue at rest; the instantaneous force is {:.3g} times the force at rest.", s.grown) : "");
        out += "\n| relative modulus g | relaxation time |\n|---|---|\n";
        for (int k = 0; k < energy_model.relaxation.branches(); ++k) out += fmt::format("| {:.3f} | {:.3g} s |\n", energy_model.relaxation.contact_share[k], energy_model.relaxation.tau_s[k]);
    }
    if (!diagnostics.lost.empty()) out += "\nTraining load cases without an equilibrium:\n\n";
    for (const std::string& lost : diagnostics.lost) out += "- " + lost + "\n";
    return out;
}

/// Figures of a study with an energy model, as planned in cases/plan.cpp.
std::string energy_model_figures(const Evaluation& e, bool solid) {
    std::vector<const char*> figures;
    if (e.measurement) figures = {"held_out"};
    else if (!e.held_out.empty()) figures = {"held_out", "held_out_force", "shape", solid ? "solid" : "contours"};
    else if (!solid) figures = {"contours"};
    if (!e.map.empty()) figures.push_back("map");
    if (!e.histories.empty()) figures.push_back("histories");
    return figures.empty() ? "" : figures_markdown(figures);
}

}  // namespace

std::string to_markdown(const Evaluation& e) {
    const ModelErrors& learned = e.models.front();
    const bool solid = e.energy_model && e.energy_model->disc_radius_m > 0;
    std::string out = fmt::format("# Study `{}`\n\n", e.study);
    if (const DrawnContacts* held_out = e.held_out.role("held_out")) {
        const ContactStatistics s = held_out->statistics(0);
        out += fmt::format(
            "**On the test set the force error of the trained model is {} (median), {} (95th percentile) and {} (largest); {}{}.**\n\nWritten by `tissuectl eval` {}.\n\n",
            percent(s.force.median), percent(s.force.p95), percent(s.force.max), n_of_N(s.force, e.measurement ? "rows" : "contacts"), e.measurement ? "" : "; displacement error " + summary(s.shape), version);
    } else if (e.energy_model_diagnostics) {
        out += fmt::format("**At the training contacts the force error of the model is {} and its displacement error {} (median / "
                           "p95 / max, {}).**\n\nWritten by `tissuectl eval` {}.\n\n",
                           summary(learned.closed_loop().force), summary(learned.closed_loop().shape), n_of_N(learned.closed_loop().force, "load cases"),
                           version);
    } else {
        const ModelErrors& heuristic = e.model("heuristic_a");
        const double loss_ratio = heuristic.rel_loss().median / learned.rel_loss().median;
        const double force_ratio = heuristic.resolved_error().median / learned.resolved_error().median;
        out += fmt::format(
        "**The nodal-force error of the trained springs is {} in the median of {}; that of Van Gelder's heuristic is {}, "
        "{:.1f} times as much.** Of the resolved force at the loaded node the median errors are {} and {}, a factor of {:.1f}.\n\n"
        "Written by `tissuectl eval` {}.\n\n",
        percent(learned.rel_loss().median), n_of_N(learned.rel_loss(), "load cases"), percent(heuristic.rel_loss().median),
        loss_ratio, percent(learned.resolved_error().median), percent(heuristic.resolved_error().median), force_ratio,
        version);
    }

    out += broken_markdown(e) + measurement_markdown(e) + held_out_markdown(e.held_out, e.measurement.has_value(), solid) + two_tools_markdown(e.two_tools) + map_markdown(e.map) + histories_markdown(e.histories, e.measurement.has_value()) + discretisation_markdown(e.discretisation);
    out += "## Errors at the training contacts: median / p95 / max\n\n";
    if (!e.open_loop()) {
        out += "| model | indentation error of force | n of N |\n|---|---|---|\n";
        for (const ModelErrors& m : e.models)
            out += fmt::format("| {} | {} | {} |\n", m.name, summary(m.closed_loop().force), n_of_N(m.closed_loop().force));
    } else {
        out += "| model | rel_loss (9) | resolved force | n of N | indentation error of force | n of N |\n|---|---|---|---|---|---|\n";
        for (const ModelErrors& m : e.models)
            out += fmt::format("| {} | {} | {} | {} | {} | {} |\n", m.name, summary(m.rel_loss()),
                               summary(m.resolved_error()), n_of_N(m.rel_loss()), summary(m.closed_loop().force), n_of_N(m.closed_loop().force));
    }
    out += fmt::format("\n{} N is the number of load cases. ", rule);
    if (e.open_loop())
        out += "*rel_loss*: L(theta) over the weighted FE force, with every node at its FE position. *Resolved force*: along "
               "the tool displacement, at the loaded node. ";
    out += "*Indentation error*: the contact is displaced as in FE, the rest of the mesh is in equilibrium.";
    if (!e.lost.empty()) {
        out += fmt::format(" {} of the training paths end early in FE; the training uses the part before:\n\n", e.lost.size());
        for (const std::string& lost : e.lost) out += "- " + lost + "\n";
        out += "\n";
    }
    if (!e.uniform_chosen_on.empty())
        out += fmt::format("{}uniform is {:.4g} N/m, chosen on {}.", e.lost.empty() ? " " : "", e.uniform_N_m,
                           e.uniform_chosen_on == "closed_loop" ? "the indentation error of force"
                           : e.uniform_chosen_on == "modulus"   ? "the study's modulus: springs of one stiffness have no equilibrium at half of the load cases"
                                                                : "rel_loss");
    out += "\n";
    for (const ModelErrors& m : e.models) out += no_answer_markdown(m.name, m.closed_loop().reasons);
    if (!e.measurement) {
        out += fmt::format("\n## Displacement error at the training contacts\n\n| model |{}\n|---|---|---|---|\n", shape_head);
        for (const ModelErrors& m : e.models) out += fmt::format("| {} |{}\n", m.name, shape_cells(m.closed_loop()));
        out += "\n" + shape_words(solid) + "\n";
    }

    if (e.energy_model_diagnostics)
        return out + energy_model_markdown(*e.energy_model, *e.energy_model_diagnostics, e.measurement.has_value()) + energy_model_figures(e, solid);
    out +=
        "\n## Training\n\n| optimiser | sets | iterations | restarts (sets that restarted) | ended | median loss over start at "
        "1,000 | at 5,000 | at the end | gap median / max | seconds |\n|---|---|---|---|---|---|---|---|---|---|\n";
    for (const SetDiagnostics& t : e.trained) {
        int iterations = 0, restarts = 0, restarted = 0;
        for (int i : t.iterations) iterations += i;
        for (int r : t.restarts) {
            restarts += r;
            restarted += r > 0 ? 1 : 0;
        }
        const auto progress = [&t](int at) {  // "" for an optimiser without a learning curve
            const double part = median_progress(t, at);
            return std::isnan(part) ? std::string() : fmt::format("{:.3f}", part);
        };
        out += fmt::format("| {} | {} | {} | {} ({}) | {} | {} | {} | {} | {} / {} | {:.2f} |\n", t.optimizer,
                           t.status.size(), iterations, restarts, restarted, counted(t.status), progress(1000), progress(5000), progress(1 << 30),
                           percent(statistics_of({t.gap.begin(), t.gap.end()}).median), percent(t.gap.maxCoeff()),
                           t.seconds);
    }
    out += fmt::format(
        "\nThe paper restarted three of its eighteen sets. *Gap*: loss of a set above its certified optimum in the box, "
        "in units of max(L_lb, 5 % of the FE force). The certificate is the exact solution of every set ({:.3f} s "
        "for all), whose optimality conditions hold to {:.1e}{}.\n",
        e.optimum.seconds, e.optimum.kkt_residual.maxCoeff(),
        e.optimum.status.empty() ? "" : " (" + counted(e.optimum.status) + ")");

    if (!e.listed) return out + figures_markdown({"held_out", "held_out_force", "shape", "contours", "springs"});
    if (std::any_of(e.lower_bound_rel.begin(), e.lower_bound_rel.end(), [](double bound) { return std::isnan(bound); }))
        out += "\n*L_lb* is a bound on the minimised function, which includes a ridge or the reaction of the contact; *L relative* is of (9) alone. The bound is given "
               "relative to the FE force only where both are the same.\n";
    out += "\n| set | L_lb N | L_lb relative |";
    for (const SetDiagnostics& t : e.trained) out += fmt::format(" {}: L relative / gap / restarts / status |", t.optimizer);
    out += "\n|---|---|---|";
    for (std::size_t t = 0; t < e.trained.size(); ++t) out += "---|";
    out += "\n";
    for (std::size_t c = 0; c < e.case_names.size(); ++c) {
        const auto i = static_cast<Eigen::Index>(c);
        out += fmt::format("| {} | {:.4g} | {} |", e.case_names[c], e.optimum.lower_bound_N[i], percent(e.lower_bound_rel[c]));
        for (const SetDiagnostics& t : e.trained)
            out += fmt::format(" {} / {} / {} / {} |", percent(t.rel_loss[i]), percent(t.gap[i]), t.restarts[c],
                               t.status[c]);
        out += "\n";
    }

    out +=
        "\n## Spring stiffnesses\n\nSec. 3 of the paper expects springs that differ little from the heuristic near the contact, "
        "change little between neighbouring sets, and a force that grows with the displacement.\n\n"
        "| model | distance from heuristic, near / far | step between magnitudes | step between angles | force falls "
        "where FE rises | smallest eigenvalue | sets with zero-energy modes |\n|---|---|---|---|---|---|---|\n";
    for (const ModelErrors& m : e.models) {
        const SpringCharacter& s = m.springs;
        out += fmt::format("| {} | {:.2f} / {:.2f} | {:.2f} | {:.2f} | {} of {} | {:.2g} | {} |\n", m.name,
                           statistics_of(s.near).median, statistics_of(s.far).median,
                           statistics_of(s.magnitude_step).median, statistics_of(s.angle_step).median, s.force_falls,
                           s.force_steps, s.smallest_eigenvalue, s.singular_sets);
    }
    out +=
        "\nMedians of root mean squares over springs, in units of E2. The eigenvalue is that of K under its supports. Loss of "
        "springs that stay near the heuristic (exact solutions of L^2 + ridge |theta - theta0|^2):\n\n"
        "| ridge | rel_loss | distance | force falls | smallest eigenvalue |\n|---|---|---|---|---|\n";
    for (const FrontPoint& p : e.front)
        out += fmt::format("| {:g} | {} | {:.2f} | {} | {:.2g} |\n", p.ridge, percent(p.rel_loss), p.distance,
                           p.force_falls, p.smallest_eigenvalue);
    int not_converged = 0;
    for (const FrontPoint& p : e.front) not_converged += p.not_converged;
    if (not_converged > 0) out += fmt::format("\nOf these exact solutions {} did not converge.\n", not_converged);

    out += "\n## Every case\n\n| case | FE force N |";
    for (const ModelErrors& m : e.models) out += fmt::format(" {} rel_loss / force N / indentation error |", m.name);
    out += "\n|---|---|";
    for (std::size_t m = 0; m < e.models.size(); ++m) out += "---|";
    out += "\n";
    for (std::size_t c = 0; c < e.case_names.size(); ++c) {
        out += fmt::format("| {} | {:.4g} |", e.case_names[c], e.fe_resolved_N[c]);
        for (const ModelErrors& m : e.models) {
            const CaseError& error = m.cases[c];
            out += fmt::format(" {} / {:.4g} / {} |", percent(error.open_loop.rel_loss),
                               error.open_loop.resolved_force_N,
                               percent(error.closed_loop.force.value_or(std::nan(""))));
        }
        out += "\n";
    }
    return out + figures_markdown({"contours", "force", "learning", "springs", "errors", "character"});
}

}  // namespace tissue
