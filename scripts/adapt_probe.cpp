// Measures one target tissue for `make patient`: the force error of an adapted energy model at test contacts, after
// each measurement.
//   adapt_probe --model FILE --cases FILE --role ROLE [--seed N] [--method NAME] [--told] [--alone] [--place mm]
//     [--outliers part] [--pokes ROLE]
// Measurements are the cases' paths of role --pokes (default held_out_full), in an order drawn with the seed, with 2 %
// of Gaussian noise on each component of force. Methods:
//   scale terms field elements   the filter (adapt/adaptation.h) on these unknowns
//   gradient   normalised gradient steps on the field, half a step per measurement
//   spsa       ten iterations of SPSA on the field per measurement, over the last three measurements
//   refit      all measurements so far at once, with the field's prior: the best that the filter could reach
// --told: of the measurements that are left, the next is the one that rank_measurements values most; its force is not used for
// that. --alone: without one scale for all the tissue as the alternative to the field. --place: error of the contact's
// position. --outliers: fraction of the measurements with ten times the force. Prints JSON.
#include <gsl/gsl_randist.h>

#include <CLI/CLI.hpp>
#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "adapt/adaptation.h"
#include "adapt/next_measurement.h"
#include "cases/load_path.h"
#include "eval/statistics_json.h"
#include "gsl.h"
#include "parallel.h"
#include "springs/indentation_solver.h"

namespace {

using namespace tissue;
using json = nlohmann::ordered_json;

struct Options {
    std::string model, cases, role = "held_out", pokes = "held_out_full", method = "field";
    unsigned long seed = 1;
    bool told = false, alone = false;
    double place_mm = 0, outliers = 0, factor = 1;
    int most = 60;
};

struct Stream {
    std::unique_ptr<gsl_rng, void (*)(gsl_rng*)> rng{gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free};
    explicit Stream(unsigned long seed) { gsl_rng_set(rng.get(), seed); }
    double normal() { return gsl_ran_gaussian(rng.get(), 1); }
    double uniform() { return gsl_rng_uniform(rng.get()); }
};

std::vector<ForceMeasurement> pokes_of(const Cases& cases, const std::string& role, double factor) {
    std::vector<ForceMeasurement> pokes;
    for (const LoadPath& path : cases.paths)
        if (path.role == role && path.lost.empty() && path.records.size() > 1)
            pokes.push_back({path.contact_m, path.push_m(path.records.back()), factor * path.records.back().contact_force_N});
    return pokes;
}

/// Number of paths of a role without an FE reference. They are in no quantile but count in N (eval/statistics.h).
int lost_of(const Cases& cases, const std::string& role) {
    return static_cast<int>(std::count_if(cases.paths.begin(), cases.paths.end(), [&](const LoadPath& path) { return path.role == role && !path.lost.empty(); }));
}

/// Residual r and its derivative H by the unknowns for one measurement, as in the filter (Adaptation).
struct Row {
    Point r;
    Eigen::MatrixXd H;
};
Row row_of(Adaptation& a, const ForceMeasurement& poke) {
    const Expected e = a.expect(poke.contact_m, poke.push_m);
    const double size = e.force_N.norm(), ratio = std::log(poke.force_N.norm() / size);
    const Point f = e.force_N / size, g = poke.force_N.normalized();
    return {f * ratio + (g - f.dot(g) * f), e.by_x};
}

void put(Adaptation& a, const Eigen::VectorXd& x) {
    Adaptation::State state = a.state();
    state.x = x.cwiseMax(-a.options().largest).cwiseMin(a.options().largest);
    a.restore(std::move(state));
}

void gradient(Adaptation& a, const ForceMeasurement& poke) {
    const Row row = row_of(a, poke);
    put(a, a.state().x + 0.5 * row.H.transpose() * (row.H * row.H.transpose()).ldlt().solve(row.r));
}

void spsa(Adaptation& a, const std::vector<ForceMeasurement>& known, Stream& draw) {
    const std::size_t first = known.size() > 3 ? known.size() - 3 : 0;
    const auto loss = [&](const Eigen::VectorXd& x) {
        put(a, x);
        double sum = 0;
        for (std::size_t i = first; i < known.size(); ++i) {
            const Expected e = a.expect(known[i].contact_m, known[i].push_m);
            sum += std::pow(std::log(known[i].force_N.norm() / e.force_N.norm()), 2);
        }
        return sum;
    };
    Eigen::VectorXd x = a.state().x;
    for (int k = 1; k <= 10; ++k) {
        const double c = 0.1 / std::pow(k, 0.101), step = 0.5 / std::pow(k, 0.602);
        Eigen::VectorXd side(x.size());
        for (double& s : side) s = draw.uniform() < 0.5 ? -1 : 1;
        x -= step * (loss(x + c * side) - loss(x - c * side)) / (2 * c) * side;
        x = x.cwiseMax(-a.options().largest).cwiseMin(a.options().largest);
    }
    put(a, x);
}

void refit(Adaptation& a, const std::vector<ForceMeasurement>& known) {
    const Eigen::Index D = a.base().mesh.dimension(), P = a.unknowns().size(), n = D * static_cast<Eigen::Index>(known.size());
    const AdaptOptions& o = a.options();
    put(a, Eigen::VectorXd::Zero(P));
    for (int round = 0; round < 4; ++round) {
        Eigen::MatrixXd H(n, P);
        Eigen::VectorXd r(n);
        for (std::size_t i = 0; i < known.size(); ++i) {
            const Row row = row_of(a, known[i]);
            H.middleRows(D * static_cast<Eigen::Index>(i), D) = row.H;
            r.segment(D * static_cast<Eigen::Index>(i), D) = row.r;
        }
        const Eigen::MatrixXd PH = a.unknowns().prior * H.transpose();
        Eigen::MatrixXd S = H * PH;
        S.diagonal().array() += o.force_noise * o.force_noise + o.model_error * o.model_error;
        put(a, PH * S.ldlt().solve(r + H * a.state().x));
    }
}

void run(const Options& o) {
    const TissueModel model = read_model(o.model);
    const Cases cases = read_cases(o.cases);
    std::vector<ForceMeasurement> left = pokes_of(cases, o.pokes, o.factor);
    const std::vector<ForceMeasurement> held_out = pokes_of(cases, o.role, o.factor);
    Stream draw(o.seed);
    for (std::size_t i = left.size(); i > 1; --i) std::swap(left[i - 1], left[gsl_rng_uniform_int(draw.rng.get(), i)]);

    const bool filter = o.method != "gradient" && o.method != "spsa" && o.method != "refit";
    AdaptOptions options;
    options.unknowns = filter ? o.method : "field";
    options.place_error_m = o.place_mm / 1e3;
    options.rival = filter && !o.alone;
    Adaptation adaptation(model, options);
    const std::vector<Push> judged = pushes_over(adaptation.surface(), model.mesh, 0.006, adaptation.surface().spacing_m());

    json curve = json::array();
    std::vector<double> update_ms, rank_ms;
    const auto seconds = [] { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); };
    const auto judge = [&](int n) {
        const IndentationSolver solver(adaptation.model());
        std::vector<double> error(held_out.size());
        parallel_for(static_cast<int>(held_out.size()), 2, [&](int i) {
            const ForceMeasurement& poke = held_out[static_cast<std::size_t>(i)];
            const Equilibrium answer = solver.at(poke.contact_m, poke.push_m);
            error[static_cast<std::size_t>(i)] = answer ? (answer.contact_force - poke.force_N).norm() / poke.force_N.norm() : std::numeric_limits<double>::infinity();
        });
        // Test forces within the filter's 68 % and 95 % regions: chi-squared quantiles for two or three degrees of
        // freedom.
        int one = 0, two = 0;
        for (const ForceMeasurement& poke : held_out) {
            const Expected e = adaptation.expect(poke.contact_m, poke.push_m);
            if (e.status != SolverStatus::converged) continue;
            const Point off = (poke.force_N - e.force_N) / e.force_N.norm();
            const double chi2 = off.dot(adaptation.covariance(e).ldlt().solve(off));
            one += chi2 < (off.size() == 2 ? 2.279 : 3.506);
            two += chi2 < (off.size() == 2 ? 5.991 : 7.815);
        }
        const Statistics s = statistics_of(error, lost_of(cases, o.role));
        const double all = static_cast<double>(held_out.size());
        json row = to_value(s);
        row.update({{"pokes", n}, {"inside68", one / all}, {"inside95", two / all}});
        curve.push_back(row);
    };
    judge(0);
    std::vector<ForceMeasurement> known;
    const std::vector<int> looked_at = {1, 2, 3, 5, 10, 20, 40, 60};
    for (int n = 1; n <= o.most && !left.empty(); ++n) {
        std::size_t next = 0;
        if (o.told) {
            std::vector<Push> may_be;
            for (const ForceMeasurement& poke : left) may_be.push_back({poke.contact_m, poke.push_m});
            const double began = seconds();
            next = rank_measurements(adaptation, may_be, judged).front().push;
            rank_ms.push_back(1e3 * (seconds() - began));
        }
        ForceMeasurement poke = left[next];
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(next));
        const double size = poke.force_N.norm();
        for (double& f : poke.force_N) f += 0.02 * size * draw.normal();
        if (draw.uniform() < o.outliers) poke.force_N *= 10;
        if (o.place_mm > 0) {
            const FreeSurface::Place at = adaptation.surface().nearest(poke.contact_m);
            Point way(poke.contact_m.size());
            for (double& w : way) w = draw.normal();
            way -= way.dot(at.inward) * at.inward;
            if (way.size() == 2) way *= std::abs(draw.normal()) / way.norm();
            poke.contact_m = adaptation.surface().nearest(poke.contact_m + 1e-3 * o.place_mm * way).point_m;
        }
        known.push_back(poke);
        const double began = seconds();
        if (filter)
            adaptation.learn(poke);
        else if (o.method == "gradient")
            gradient(adaptation, poke);
        else if (o.method == "spsa")
            spsa(adaptation, known, draw);
        else if (std::find(looked_at.begin(), looked_at.end(), n) != looked_at.end())
            refit(adaptation, known);
        update_ms.push_back(1e3 * (seconds() - began));
        if (std::find(looked_at.begin(), looked_at.end(), n) != looked_at.end() || left.empty()) judge(n);
    }
    const Statistics update = statistics_of(update_ms), rank = statistics_of(rank_ms);
    json out = {{"method", o.method}, {"told", o.told}, {"seed", o.seed}, {"unknowns", adaptation.unknowns().size()}, {"gated", adaptation.state().gated},
                {"refused", adaptation.state().refused}, {"update_ms", {{"median", update.median}, {"p95", update.p95}, {"n", update.n}}}, {"curve", curve}};
    if (o.told) out["rank_ms"] = {{"median", rank.median}, {"p95", rank.p95}, {"n", rank.n}};
    std::cout << out.dump() << '\n';
}

}  // namespace

int main(int argc, char** argv) {
    Options o;
    CLI::App app("Error of an energy model after each measurement that it learns from.", "adapt_probe");
    app.add_option("--model", o.model)->required();
    app.add_option("--cases", o.cases)->required();
    app.add_option("--role", o.role, "role of the test contacts");
    app.add_option("--pokes", o.pokes, "role of the contacts that are measured");
    app.add_option("--method", o.method)->check(CLI::IsMember({"scale", "terms", "field", "elements", "gradient", "spsa", "refit"}));
    app.add_option("--seed", o.seed);
    app.add_flag("--told", o.told);
    app.add_flag("--alone", o.alone, "without the single scale as alternative to the field");
    app.add_option("--place", o.place_mm, "mm");
    app.add_option("--outliers", o.outliers, "part");
    app.add_option("--factor", o.factor, "factor of all forces, for a tissue that is stiffer by this factor");
    app.add_option("--most", o.most, "largest number of measurements");
    CLI11_PARSE(app, argc, argv);
    try {
        run(o);
    } catch (const std::exception& e) {
        std::cerr << "adapt_probe: " << e.what() << '\n';
        return 1;
    }
}
