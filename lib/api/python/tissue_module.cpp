// The door for Python: `import tissue`. help(tissue) is the documentation.
#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <thread>

#include "adapt/adapted_model.h"
#include "adapt/next_poke.h"
#include "api/api_session.h"
#include "api/session_counts.h"
#include "cases/load_path.h"
#include "error.h"
#include "eval/closed_loop.h"
#include "haptic/session_options.h"
#include "io/atomic_file.h"
#include "io/one_line.h"
#include "parallel.h"
#include "springs/law_at_radius.h"
#include "springs/law_press.h"
#include "springs/push_refusal.h"
#include "springs/set_grid.h"
#include "version.h"

namespace py = pybind11;
using namespace tissue;

namespace {

/// Rows of points, as numpy gives them: any layout, any number type.
using Rows = Eigen::Ref<const NodeField, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;

using File = std::filesystem::path;  // a str, bytes, or anything with __fspath__

std::shared_ptr<TissueModel> open_model(const File& file) {
    const py::gil_scoped_release others_may;
    return std::make_shared<TissueModel>(read_model(file.string()));
}

/// In work that takes long, without the interpreter: looks now and then whether Ctrl-C, or another signal that Python handles, has come; what
/// its handler raises ends the work. In threads that are not Python's main one nothing ever has.
class Signals {
   public:
    void heed() {
        constexpr std::chrono::milliseconds apart(50);  // others hold the interpreter for 5 ms at a time
        const auto now = std::chrono::steady_clock::now();
        if (now - last_ < apart) return;
        last_ = now;
        const py::gil_scoped_acquire interpreter;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }

   private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Does something with an object while other Python threads run, one of them at a time with the object. Nobody waits for it holding the
/// interpreter; a signal's handler, which runs amid heed(), may come again.
template <class Object, class Act>
auto alone(Object& object, Act&& act) {
    const py::gil_scoped_release others_may;
    const std::lock_guard<std::recursive_mutex> one_at_a_time(object.guard);
    return act();
}

/// An object of which __new__ was called and __init__ was not: pybind11 would give methods storage in which nothing has been built.
void* never_initialised(std::size_t) { throw py::type_error("the object was never initialised: its __init__ has not run"); }

/// Of the class of T. What is built by __init__ does not go through here.
template <class T>
void needs_init() {
    py::detail::get_type_info(typeid(T), true)->operator_new = &never_initialised;
}

using Options = std::vector<std::pair<std::string, std::string>>;

/// A bool of Python's or of numpy's, which any comparison of its values gives.
bool is_bool(py::handle value) {
    const std::string type = Py_TYPE(value.ptr())->tp_name;
    return py::isinstance<py::bool_>(value) || type == "numpy.bool" || type == "numpy.bool_";
}

Options options_of(const py::kwargs& given) {
    Options options;
    for (const auto& [key, value] : given) {
        std::string name = py::str(key);
        std::replace(name.begin(), name.end(), '_', '-');
        std::string text;
        if (is_bool(value))
            text = value.cast<bool>() ? "yes" : "no";
        else if (py::isinstance<py::sequence>(value) && !py::isinstance<py::str>(value))
            for (const auto& part : value) text += std::string(py::str(part)) + " ";
        else
            text = py::str(value);
        options.emplace_back(name, text);
    }
    return options;
}

HapticOptions with(HapticOptions options, const Options& given, unsigned changeable = everywhere) {
    for (const auto& [name, value] : given) set_option(options, name, value, changeable);
    return options;
}

/// For help(tissue.Simulation).
std::string options_text() {
    std::string text = "options, each by name:";
    for (const SessionOption& option : session_options()) {
        std::string name = option.name;
        std::replace(name.begin(), name.end(), '-', '_');
        text += "\n    " + name + " [" + option.unit + "]: " + option.meaning;
        if (option.where & live) text += "; may change while it runs";
        if (option.where & limits) text += "; may change until the first tick";
        if (const std::string values = option.values(); !values.empty()) text += "; " + values;
        if (const std::string initial = option.initial(interfaces); !initial.empty()) text += "; default " + initial;
    }
    return text + "\nA yes|no is a bool, an offset a sequence.";
}

/// A session, with the model that it plays.
struct Session : ApiSession {
    std::shared_ptr<const TissueModel> tissue;
    std::recursive_mutex guard;
    Session(std::shared_ptr<const TissueModel> t, std::shared_ptr<const HapticModel> m, NamedSurfaces s) : ApiSession(std::move(m), std::move(s)), tissue(std::move(t)) {}
    Session(const Session& other) : ApiSession(other), tissue(other.tissue) {}

    /// Of every tool (T x 3).
    NodeField tick_tools(const NodeField& positions_m, double elapsed_s, const std::vector<double>& age_s) {
        const int tools = simulation.tool_count();
        if (positions_m.rows() != tools || positions_m.cols() != 3 || (!age_s.empty() && age_s.size() != static_cast<std::size_t>(tools)))
            throw MismatchError(tools == 1 ? "a tick takes one position, of three numbers" : "a tick takes two positions, of three numbers each, and as many ages: tick_tools()");
        const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> at_m = positions_m;
        Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> force_N(tools, 3);
        tick(at_m.data(), age_s.empty() ? nullptr : age_s.data(), elapsed_s, force_N.data());
        return force_N;
    }

    void one_tool_only(const char* what) const {
        if (simulation.tool_count() > 1) throw MismatchError(std::string(what) + " is of a session of one tool; of two: tick_tools()");
    }
};

NodeField ticks(Session& session, const Rows& positions_m, double elapsed_s) {
    session.one_tool_only("ticks()");
    if (positions_m.cols() != 3) throw MismatchError("positions are of the device: three numbers each");
    if (!(elapsed_s >= 0 && std::isfinite(elapsed_s))) throw MismatchError("elapsed_s must be 0 or more and finite: ticks() keeps no clock that could tell how long ago the last one was");
    NodeField forces(positions_m.rows(), 3);
    Signals signals;
    return alone(session, [&] {
        for (Eigen::Index k = 0; k < forces.rows(); ++k) {
            if (k % 16 == 0) signals.heed();
            DeviceSample sample;
            sample.position_m = positions_m.row(k);
            forces.row(k) = session.simulation.tick(sample, elapsed_s);  // of no clock
        }
        session.forget_clock();  // the time that these took is none between two ticks
        return std::move(forces);
    });
}

py::dict contact_of(Session& session) {
    const TickRecord tick = alone(session, [&] { return session.simulation.record(session.tool()); });
    py::dict contact;
    contact["mesh"] = tick.mesh;
    contact["facet"] = tick.facet;
    contact["weight"] = tick.weight;
    contact["displacement_m"] = Eigen::VectorXd(tick.contact_displacement_m);
    contact["force_N"] = Eigen::VectorXd(Point::Zero(tick.coupling_N.size()) - tick.coupling_N);
    contact["slipping"] = tick.slipping;
    contact["fault"] = tick.fault();
    constexpr const char* statuses[] = {"done", "refused", "not armed", "folded", "diverged"};
    contact["status"] = tick.status != TickStatus::done ? statuses[static_cast<int>(tick.status)] : tick.late ? "late" : tick.overrun ? "overrun" : "done";
    return contact;
}

py::dict limits_of(Session& session) {
    const auto [c, lost_s] = alone(session, [&] { return std::pair(session.simulation.safety(session.tool()).counters(), session.simulation.counters().lost_s); });
    py::dict limits;
    limits["clamped"] = c.clamped;
    limits["slewed"] = c.slewed;
    limits["damped"] = c.damped;
    limits["capped"] = c.capped;
    limits["late"] = c.late;
    limits["lost_s"] = lost_s;
    return limits;
}

py::dict energies_of(Session& session) {
    std::array<double, session_energies.size()> now{};
    alone(session, [&] {
        for (std::size_t i = 0; i < now.size(); ++i) now[i] = session_energies[i].of(session.simulation, session.tool());
    });
    py::dict energies;
    for (std::size_t i = 0; i < now.size(); ++i) energies[session_energies[i].name] = now[i];
    return energies;
}

py::bytes state_of(Session& session) {
    std::string bytes;
    alone(session, [&] {
        bytes.resize(session.simulation.state_size());
        session.simulation.save(reinterpret_cast<std::byte*>(bytes.data()));
    });
    return bytes;
}

void restore(Session& session, const std::string& state) {
    alone(session, [&] {
        session.restore(reinterpret_cast<const std::byte*>(state.data()), state.size());
    });
}

py::dict counts_of(Session& session) {
    std::array<long long, session_counts.size()> now{};
    alone(session, [&] {
        for (std::size_t i = 0; i < now.size(); ++i) now[i] = session_counts[i].of(session.simulation, session.tool());
    });
    py::dict counts;
    for (std::size_t i = 0; i < now.size(); ++i) counts[session_counts[i].name] = now[i];
    return counts;
}

/// A law that learns.
struct Patient {
    std::unique_ptr<Adaptation> adaptation;
    std::recursive_mutex guard;

    Point point(const Eigen::VectorXd& p, const char* what) const {
        if (p.size() != adaptation->base().mesh.dimension()) throw MismatchError(std::string(what) + " is of another number of axes than the tissue");
        return p;
    }
};

/// Answers of the model pressed at each contact from rest. ball_m: by a rigid ball of that radius [m] in place of its disc.
py::tuple press(const TissueModel& model, const Rows& contacts_m, const Rows& pushes_m, int threads, std::optional<double> ball_m) {
    const int D = model.mesh.dimension(), n = static_cast<int>(contacts_m.rows());
    if (contacts_m.cols() != D || pushes_m.cols() != D || pushes_m.rows() != n)
        throw MismatchError("contacts and pushes are as many, of as many numbers as the tissue has axes");
    std::vector<ContactAnswer> answers(static_cast<std::size_t>(n));
    {
        const py::gil_scoped_release others_may;
        std::optional<LawPress> law;
        std::optional<SetGrid> sets;
        std::unique_ptr<SpringLaw> springs;
        std::optional<BallPress> ball;
        if (ball_m && !model.energy_law) throw MismatchError("a ball needs a law in space");
        if (ball_m)
            ball.emplace(model.mesh, *model.energy_law, *ball_m);
        else if (model.energy_law)
            law.emplace(model);
        else
            sets.emplace(model), springs = make_spring_law(model.law);
        Signals signals;
        const FreeSurface surface(model.mesh);
        for (int k = 0; k < n; ++k) {
            signals.heed();
            if (const std::string why = push_refusal(model.mesh, surface, contacts_m.row(k).transpose(), pushes_m.row(k).transpose()); !why.empty())
                throw MismatchError("contact " + std::to_string(k) + " " + why);
        }
        const auto caller = std::this_thread::get_id();
        parallel_for(n, threads, [&](int k) {
            if (std::this_thread::get_id() == caller) signals.heed();
            const Point contact = contacts_m.row(k), push = pushes_m.row(k);
            ContactAnswer& answer = answers[static_cast<std::size_t>(k)];
            if (ball || law) {
                answer = ball ? answer_of(*ball, contact, push) : answer_of(*law, contact, push);
                return;
            }
            if (push.norm() == 0) {
                answer.force_N = Eigen::VectorXd::Zero(D), answer.displacement_m = NodeField::Zero(model.mesh.node_count(), D);
                return;
            }
            const int set = sets->nearest(sets->outline().arc_of(contact), push / push.norm(), push.norm());
            answer = answer_of(model.mesh, *springs, model.trained.front().theta.row(set).transpose(),
                               {locate_on_surface(model.mesh, surface.nearest(contact).point_m), push, Eigen::VectorXd::Zero(D)});
        });
    }
    NodeField force = NodeField::Constant(n, D, std::nan(""));
    py::array_t<double> displacement({n, model.mesh.node_count(), D});
    std::fill_n(displacement.mutable_data(), displacement.size(), std::nan(""));
    std::vector<std::string> reasons;
    for (int k = 0; k < n; ++k) {
        const ContactAnswer& answer = answers[static_cast<std::size_t>(k)];
        if (answer.force_N) {
            force.row(k) = *answer.force_N;
            std::copy_n(answer.displacement_m.data(), answer.displacement_m.size(), displacement.mutable_data(k, 0, 0));
        }
        reasons.push_back(answer.reason);
    }
    return py::make_tuple(std::move(force), std::move(displacement), reasons);
}

py::list paths_of(const File& file) {
    const Cases cases = [&] {
        const py::gil_scoped_release others_may;
        return read_cases(file.string());
    }();
    py::list paths;
    for (const LoadPath& path : cases.paths) {
        const auto R = static_cast<Eigen::Index>(path.records.size());
        const Eigen::Index D = path.contact_m.size(), N = cases.nodes.rows();
        Eigen::VectorXd magnitude(R);
        NodeField force(R, D);
        const bool seen = R > 0 && path.records.front().displacement.rows() == N;
        py::array_t<double> displacement({seen ? R : 0, N, D});
        for (Eigen::Index r = 0; r < R; ++r) {
            const PathRecord& record = path.records[static_cast<std::size_t>(r)];
            magnitude[r] = record.magnitude_m;
            force.row(r) = record.contact_force_N;
            if (seen) std::copy_n(record.displacement.data(), record.displacement.size(), displacement.mutable_data(r, 0, 0));
        }
        py::dict p;
        p["name"] = path.name;
        p["role"] = path.role;
        p["contact_m"] = Eigen::VectorXd(path.contact_m);
        p["direction"] = Eigen::VectorXd(path.direction);
        if (D == 3) p["radius_m"] = path.radius_m;
        p["lost"] = path.lost;
        p["magnitude_m"] = std::move(magnitude);
        p["force_N"] = std::move(force);
        p["displacement_m"] = std::move(displacement);
        if (path.second) {  // a second disc, pushed in proportion with the first
            NodeField second_force(R, D);
            for (Eigen::Index r = 0; r < R; ++r) second_force.row(r) = path.records[static_cast<std::size_t>(r)].second_force_N;
            p["second_contact_m"] = Eigen::VectorXd(path.second->contact_m);
            p["second_direction"] = Eigen::VectorXd(path.second->direction);
            p["second_depth_m"] = path.second->depth_m;
            p["second_force_N"] = std::move(second_force);
        }
        paths.append(std::move(p));
    }
    return paths;
}

py::dict read_study(const File& folder) {
    py::dict study;
    study["model"] = open_model(folder / "model.h5");
    study["paths"] = paths_of(folder / "cases.h5");
    study["eval"] = py::none();
    if (!std::filesystem::exists(folder / "eval.json")) return study;
    const std::string file = (folder / "eval.json").string(), text = read_file(file);
    try {
        study["eval"] = py::module_::import("json").attr("loads")(py::bytes(text));
    } catch (const py::error_already_set& e) {
        if (!e.matches(PyExc_ValueError)) throw;
        throw FileError(fmt::format("{}: is no JSON: {}", file, one_line(py::str(e.value()))));
    }
    return study;
}

py::dict learn(Patient& patient, const Eigen::VectorXd& contact_m, const Eigen::VectorXd& push_m, const Eigen::VectorXd& force_N) {
    const PokeAnswer answer =
        alone(patient, [&] { return patient.adaptation->learn({patient.point(contact_m, "contact_m"), patient.point(push_m, "push_m"), patient.point(force_N, "force_N")}); });
    py::dict said;
    said["status"] = to_string(answer.status);
    said["why"] = answer.why;
    said["expected_N"] = Eigen::VectorXd(answer.expected_N);
    said["expected_sd"] = answer.expected_sd;
    said["chi2"] = answer.chi2;
    said["gate"] = answer.gate;
    said["error_before"] = answer.error_before;
    said["error_after"] = answer.error_after;
    said["warning"] = answer.warning;
    return said;
}

py::tuple expect(Patient& patient, const Eigen::VectorXd& contact_m, const Eigen::VectorXd& push_m) {
    Eigen::MatrixXd covariance;
    const Expected expected = alone(patient, [&] {
        Expected there = patient.adaptation->expect(patient.point(contact_m, "contact_m"), patient.point(push_m, "push_m"));
        covariance = patient.adaptation->covariance(there);
        return there;
    });
    return py::make_tuple(Eigen::VectorXd(expected.force_N), std::sqrt(covariance.trace() / static_cast<double>(covariance.rows())), to_string(expected.status));
}

py::list next(Patient& patient, double depth_m, std::size_t count) {
    std::vector<Push> pushes;
    Signals signals;
    const std::vector<PokeWorth> worth = alone(patient, [&] {
        Adaptation& a = *patient.adaptation;
        pushes = pushes_over(a.surface(), a.base().mesh, depth_m, a.surface().spacing_m());
        return rank_pokes(a, pushes, pushes, [&] { signals.heed(); });
    });
    py::list told;
    for (std::size_t i = 0; i < std::min(count, worth.size()); ++i) {
        const Push& push = pushes[worth[i].push];
        told.append(py::make_tuple(Eigen::VectorXd(push.contact_m), Eigen::VectorXd(push.push_m), worth[i].gain));
    }
    return told;
}

}  // namespace

PYBIND11_MODULE(tissue, m) {
    m.doc() = R"(Soft tissue for haptics: models learned from finite elements (tissuectl).

    import tissue
    study = tissue.read_study("results/surface")          # model, FE's load paths, eval.json
    model = study["model"]
    force, displacement, why = model.press(contacts, pushes)   # closed loop, many contacts at once
    session = tissue.Simulation(model, friction=0.3)           # the tick of tissue-haptic
    force = session.tick([0.05, 0.098, 0])
    patient = tissue.Adaptation("results/surface/model.h5")    # learns from pokes
    patient.learn(contact, push, force)

SI units. A model has D = 2 or 3 axes, N nodes. Errors are tissue.Error, one line that names file, place and cause; an argument of another
type is a TypeError. Other Python threads run while something here takes long; those that want the same object wait for one another. Ctrl-C ends
ticks() between two ticks, press() between two contacts and next() between two presses.)";
    // numpy now: two threads that had their first arrays at once would wait for each other, one for the import and one for the interpreter
    py::detail::npy_api::get();
    m.attr("__version__") = version;
    static const py::handle error = py::exception<Error>(m, "Error", PyExc_ValueError).release();  // never freed: the interpreter ends before statics do
    error.attr("__doc__") = "What the caller got wrong, or the disk did: one line.";
    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            std::rethrow_exception(thrown);
        } catch (const Error& e) {
            PyErr_SetString(error.ptr(), one_line(e.what()).c_str());
        }
    });

    py::class_<TissueModel, std::shared_ptr<TissueModel>>(m, "Model", "What plays: a model.h5 of tissuectl train or adapt. Arrays are the model's own, to be read, without copies.")
        .def(py::init(&open_model), py::arg("file"), "file: a str or a path")
        .def_readonly("study", &TissueModel::study, "its name")
        .def_property_readonly("dimension", [](const TissueModel& t) { return t.mesh.dimension(); }, "D")
        .def_property_readonly("is_law", [](const TissueModel& t) { return t.energy_law.has_value(); }, "one energy; else spring sets")
        .def_property_readonly("nodes", [](const TissueModel& t) -> const NodeField& { return t.mesh.nodes; }, "at rest [m] (N, D); of a solid in an embedded lattice its own, then the lattice's")
        .def_property_readonly("springs", [](const TissueModel& t) -> const auto& { return t.mesh.springs; }, "node numbers (S, 2)")
        .def_property_readonly("facets", [](const TissueModel& t) -> const auto& { return t.mesh.facets; }, "node numbers of the surface (F, D)")
        .def_property_readonly("fixed", [](const TissueModel& t) { return t.mesh.fixed; }, "nodes that are held")
        .def_readonly("node_mass_kg", &TissueModel::node_mass_kg, "(N)")
        .def_readonly("modulus", &TissueModel::modulus_N_m, "in the plane E t [N/m], in space E [Pa]")
        .def("with_tool", [](const TissueModel& t, double radius_m) { return with_tool(t, {ToolChoice::Shape::disc, radius_m}); }, py::arg("radius_m"),
             "The model under a disc of another radius [m], between the smallest and the largest that it was trained under (disc_radii_m).")
        .def_property_readonly("case_radius_m", [](const TissueModel& t) { return t.case_radius_m; }, "of each case's disc, where a law in space was trained under several (C); else empty")
        .def_property_readonly("disc_radii_m", [](const TissueModel& t) { return t.energy_law ? t.energy_law->sizes.radii_m : Eigen::VectorXd(); },
                               "of a law in space that knows discs of several radii, ascending; else empty")
        .def_property_readonly("disc_radius_m", [](const TissueModel& t) { return t.energy_law ? t.energy_law->disc_radius_m : 0.0; }, "of a law in space; else 0")
        .def_readonly("case_names", &TissueModel::case_names, "of the load cases trained on (C)")
        .def_readonly("contact_m", &TissueModel::contact_m, "of each load case (C, D)")
        .def_readonly("direction", &TissueModel::direction, "of each load case (C, D)")
        .def_readonly("magnitude_m", &TissueModel::magnitude_m, "of each load case (C)")
        .def_readonly("fe_force_N", &TissueModel::contact_force_N, "FE's, of each load case (C, D); no rows where the file has none")
        .def_property_readonly("terms", [](const TissueModel& t) { return t.energy_law ? t.energy_law->terms : std::vector<std::string>{}; }, "of a law (P)")
        .def_property_readonly("coefficients", [](const TissueModel& t) { return t.energy_law ? t.energy_law->coefficients : Eigen::VectorXd(); }, "of those terms (P)")
        .def_property_readonly("constants", [](const TissueModel& t) { return t.energy_law ? t.energy_law->constants : Eigen::VectorXd(); },
                               "of a law's springs, cells and an embedded solid's supports [N/m] (E)")
        .def("press", &press, py::arg("contacts_m"), py::arg("pushes_m"), py::arg("threads") = std::max(1u, std::thread::hardware_concurrency()), py::arg("ball_m") = py::none(),
             "The tissue at rest with the tool held: contacts (K, D) on the free surface or within 2 mm of it, pushes from there (K, D), none out of the tissue.\n"
             "ball_m: radius of a rigid ball [m], of a law in space, in place of its disc; its contact may be as large as the largest disc that the model was trained under.\n"
             "Returns force of the tool on the tissue [N] (K, D), displacement [m] (K, N, D), in space with the surface beside the tool as it is seen, and why there is no answer, "
             "\"\" where there is one (K); without an answer both are NaN. Of spring sets the nearest serves, as in tissuectl eval.")
        .def("__repr__", [](const TissueModel& t) {
            return "<tissue.Model '" + t.study + "', " + std::to_string(t.mesh.node_count()) + " nodes in " + (t.mesh.is_solid() ? "space" : "the plane") +
                   (t.energy_law ? ", a law>" : ", " + std::to_string(t.case_count()) + " spring sets>");
        });

    py::class_<Session>(m, "Simulation", "The running tissue: the tick of tissue-haptic, with its safety. To make one of a law in space takes seconds, in which its spectrum is worked out; Ctrl-C comes after that.")
        .def(py::init([](std::shared_ptr<TissueModel> model, const py::kwargs& given) {
                 const HapticOptions options = with(interface_options(), options_of(given));
                 const py::gil_scoped_release others_may;
                 check_options(options);  // before the model knows of one
                 if (!options.tool.is_default()) model = std::make_shared<TissueModel>(with_tool(*model, options.tool));
                 return std::make_unique<Session>(model, std::make_shared<HapticModel>(*model, options), NamedSurfaces(*model));
             }),
             py::arg("model").none(false),
             options_text().c_str())
        .def("tick", [](Session& s, const Eigen::Vector3d& position_m, double elapsed_s, double age_s) {
                 s.one_tool_only("tick()");
                 return alone(s, [&] { return Eigen::Vector3d(s.tick_tools(NodeField(position_m.transpose()), elapsed_s, {age_s}).row(0)); });
             },
             py::arg("position_m"), py::arg("elapsed_s") = 0.0, py::arg("age_s") = 0.0,
             "One step: the device's position [m] (3); returns the force on the hand [N] (3), finite and within force_max whatever comes in. elapsed_s: since the last tick; 0: dt; negative or not finite: "
             "unknown, and the library's own clock tells. age_s: since the position was measured, where positions come less often than ticks.")
        .def("ticks", &ticks, py::arg("positions_m"), py::arg("elapsed_s") = 0.0,
             "A tick for each position (T, 3), one after the other, each elapsed_s after the one before (0: dt); returns forces [N] (T, 3). After Ctrl-C the session is where it came to.")
        .def("tick_tools", [](Session& s, const NodeField& positions_m, double elapsed_s, const std::optional<std::vector<double>>& age_s) { return alone(s, [&] { return s.tick_tools(positions_m, elapsed_s, age_s.value_or(std::vector<double>())); }); },
             py::arg("positions_m"), py::arg("elapsed_s") = 0.0, py::arg("age_s") = py::none(),
             "One step of every tool at once (option tools): the devices' positions [m] (tools, 3), an age each [s] (tools), or None; returns the forces on the hands [N] (tools, 3).")
        .def("use_tool", [](Session& s, int tool) { alone(s, [&] { s.use_tool(tool); }); }, py::arg("tool"), "Which tool, 0 at the start, set(), clutch(), contact, counts, limits and energies_J act on. Shared by both: the counts ticks, folded, unstable and lost_ms, the energies kinetic, stored and dissipated.")
        .def_property_readonly("tools", [](const Session& s) { return s.simulation.tool_count(); }, "how many press the tissue")
        .def("reset", [](Session& s) { alone(s, [&] { s.simulation.reset(); }); }, "The tissue to rest; the tool must be outside once before there is force again.")
        .def("set", [](Session& s, const py::kwargs& given) {
                 const Options options = options_of(given);
                 alone(s, [&] { s.simulation.change(with(s.simulation.options(s.tool()), options, changeable(s.simulation)), s.tool()); });
             },
             "Options that may change while it runs, by name, and before the first tick limits of the device (force_max, ..). A change that moves the tool by more than a hand does in a tick is a new start: it must be outside once.")
        .def("clutch", [](Session& s, bool on) { alone(s, [&] { s.simulation.clutch(on, s.tool()); }); }, py::arg("on").noconvert(), "On: the hand moves and the tool stays, without force. Off: the tool goes on from there.")
        .def_property("state", &state_of, &restore, "All that changes while it runs, as bytes; a session of the same model and options to which they are given goes on from them bit for bit.")
        .def("begin", [](Session& s) { return alone(s, [&] { return std::make_unique<Session>(s.tissue, s.model, s.surfaces); }); },
             "Another session of the same model, at rest, with the options that this one was made with, and its surfaces; it costs a thousandth of a new Simulation.")
        .def("copy", [](Session& s) { return alone(s, [&] { return std::make_unique<Session>(s); }); }, "Another session that goes on as this one does.")
        .def("follow", [](Session& s, Session& leader) {
                 const Simulation other = alone(leader, [&] { return Simulation(leader.simulation); });
                 alone(s, [&] { s.simulation.follow(other); });
             }, py::arg("session"), "Of a session that has not ticked: its tool is led to where that one's is. Takes some hundred ticks' time.")
        .def("take_over", [](Session& s, Session& from) {
                 if (&s == &from) throw MismatchError("take_over: the same session");
                 const Session other = alone(from, [&] { return Session(from); });
                 alone(s, [&] { s.take_over(other); });
             }, py::arg("session"), "After follow(): goes on at the hand where that one was. Force, limits, what is known of the device, energy given and counts are that one's; what forces differ by fades within some tenths of a second.")
        .def_property_readonly("displacement_m", [](const Session& s) -> const NodeColumns& { return s.simulation.state(0).displacement; },
                               "of the lattice's nodes now [m] (N, D): a view that the next tick changes")
        .def_property_readonly("seen_m", [](Session& s) {
                 return alone(s, [&] {
                     NodeColumns seen;
                     s.simulation.seen(0, seen);
                     return NodeField(seen);
                 });
             }, "of the nodes now as they are drawn and compared with FE [m] (N, D): in space, beside the tool, the surface that it presses (lib/springs/skin.h)")
        .def("add_surface", [](Session& s, const std::string& name, const File& file, double unit_m) { alone(s, [&] { s.surfaces.add(name, file, unit_m); }); }, py::arg("name"), py::arg("file"), py::arg("unit_m"),
             "A surface that moves with the tissue from now on: of a file (.stl, .obj, .ply, ..), whose numbers are in this unit [m].")
        .def_property_readonly("surfaces", [](Session& s) { return alone(s, [&] { return s.surfaces.names(); }); }, "names of those there are, in space: boundary, nodule where the model has one, and what was added")
        .def("surface", [](Session& s, const std::string& name) {
                 return alone(s, [&] {
                     const NamedSurfaces::Surface* of = s.surfaces.find(name);
                     if (!of) throw MismatchError("there is no surface '" + name + "'");
                     NodeColumns seen;
                     s.simulation.seen(0, seen);
                     Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> places(of->rest_m.rows(), 3);
                     of->places(seen, places.data());
                     return std::pair(places, of->triangles);
                 });
             }, py::arg("name"), "Where its points are now [m] (V, 3), and its triangles, normals out (W, 3). Point v stays point v.")
        .def_property_readonly("contact", &contact_of, "as the last tick left it: mesh (-1: nothing is pressed), facet, weight, displacement_m, force_N (on the tissue, before safety), slipping, fault, status (done; late: the device had let go, and the force begins at zero; overrun: time was lost; without force: refused, not armed, folded, diverged)")
        .def_property_readonly("counts", &counts_of, "of the session")
        .def_property_readonly("limits", &limits_of, "what limits have done to the force, in ticks: clamped, slewed, damped, capped, late (the device had let go); and lost_s, time that passed and that the tissue did not go through")
        .def_property_readonly("energies_J", &energies_of, "the energy log: given (to the hand since the start; below 0: the hand gave), observed and bound (of the passivity observer), kinetic (of the tissue), friction (dissipated), "
                               "and with energy_book=True stored and dissipated in the branches of a tissue that relaxes")
        .def_property_readonly("model", [](const Session& s) { return std::const_pointer_cast<TissueModel>(s.tissue); }, "that it plays");

    py::class_<Patient>(m, "Adaptation", "A law that learns from pokes of a tissue that is not the one it was trained on, as tissuectl adapt does.")
        .def(py::init([](const File& file, const std::string& unknowns, double force_noise, double model_error, double place_error_m, bool rival) {
                 AdaptOptions options;
                 options.unknowns = unknowns;
                 options.force_noise = force_noise;
                 options.model_error = model_error;
                 options.place_error_m = place_error_m;
                 options.rival = rival;
                 auto patient = std::make_unique<Patient>();
                 const py::gil_scoped_release others_may;
                 patient->adaptation = read_adaptation(file.string(), options);
                 return patient;
             }),
             py::arg("model_file"), py::arg("unknowns") = "field", py::arg("force_noise") = 0.02, py::arg("model_error") = 0.03, py::arg("place_error_m") = 0.0,
             py::arg("rival") = true, "Goes on where the file has learned already, with its own options then.")
        .def("learn", &learn, py::arg("contact_m"), py::arg("push_m"), py::arg("force_N"),
             "One poke: where the tool touched at rest, how far it went [m], its force on the tissue [N] (D each). Returns what became of it: status (learned, gated, refused), why, ...")
        .def("expect", &expect, py::arg("contact_m"), py::arg("push_m"), "Force of a push [N] (D; NaN unless the status is held), its standard deviation over its size, and the status of the rest.")
        .def("next", &next, py::arg("depth_m") = usual_depth_m, py::arg("count") = 3, "Pushes that would tell most: contact, push, and what part of the mean variance of all forces each would take away.")
        .def("model", [](Patient& p) { return alone(p, [&] { return std::make_shared<TissueModel>(p.adaptation->model()); }); }, "The model as it is now.")
        .def("write", [](Patient& p, const File& file) { alone(p, [&] { write_adapted_model(file.string(), *p.adaptation, {"python tissue.Adaptation.write", 0, {}}); }); },
             py::arg("file"), "A model.h5 that plays as it has learned to, and that learning can go on from.")
        .def("forget", [](Patient& p) { alone(p, [&] { p.adaptation->forget(); }); }, "As before the first poke.")
        .def_property_readonly("learned", [](Patient& p) { return alone(p, [&] { return p.adaptation->state().learned; }); }, "pokes")
        .def_property_readonly("factor", [](Patient& p) { return alone(p, [&] { return Eigen::VectorXd(p.adaptation->x().array().exp()); }); },
                               "exp of each unknown: of a field, how many times as stiff each node is as trained (P)")
        .def_property_readonly("sd", [](Patient& p) { return alone(p, [&] { return Eigen::VectorXd(p.adaptation->state().P.diagonal().cwiseMax(0).cwiseSqrt()); }); },
                               "standard deviation of that one's logarithm (P)");

    needs_init<TissueModel>();
    needs_init<Session>();
    needs_init<Patient>();

    m.def("read_study", &read_study, py::arg("folder"), "results/STUDY: a dict of model, paths (as read_cases) and eval (eval.json; None where there is none yet).");
    m.def("read_cases", &paths_of, py::arg("file"),
          "FE's load paths of a cases.h5: a list of dicts of name, role, contact_m, direction, lost, magnitude_m (R), in space radius_m of its disc (0: the study's own), force_N (R, D), displacement_m (R, N, D; no rows where nobody saw inside). Of two discs at once also second_contact_m, second_direction, second_depth_m (reached with the largest magnitude_m), second_force_N (R, D).");
}
