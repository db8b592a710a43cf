// Python bindings: `import tissue`. help(tissue) prints the documentation.
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
#include "adapt/next_measurement.h"
#include "api/api_session.h"
#include "api/session_counts.h"
#include "cases/load_path.h"
#include "error.h"
#include "eval/closed_loop.h"
#include "haptic/session_options.h"
#include "io/atomic_file.h"
#include "io/one_line.h"
#include "parallel.h"
#include "springs/energy_model_at_radius.h"
#include "springs/indentation_solver.h"
#include "springs/push_refusal.h"
#include "springs/set_grid.h"
#include "version.h"

namespace py = pybind11;
using namespace tissue;

namespace {

/// Rows of points as a numpy array of any layout and number type.
using Rows = Eigen::Ref<const NodeField, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;

using File = std::filesystem::path;  // a str, bytes, or anything with __fspath__

std::shared_ptr<TissueModel> open_model(const File& file) {
    const py::gil_scoped_release others_may;
    return std::make_shared<TissueModel>(read_model(file.string()));
}

/// Lets Ctrl-C, and other signals that Python handles, end long work without the interpreter lock. heed() checks for
/// signals now and then, and throws what the handler raised. Only Python's main thread receives signals.
class Signals {
   public:
    void heed() {
        // another thread may hold the interpreter lock for 5 ms at a time
        constexpr std::chrono::milliseconds apart(50);
        const auto now = std::chrono::steady_clock::now();
        if (now - last_ < apart) return;
        last_ = now;
        const py::gil_scoped_acquire interpreter;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }

   private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Calls `act` under the object's mutex, without the interpreter lock, so that other Python threads run. A thread never
/// waits for the mutex while it holds the interpreter lock. The mutex is recursive: a signal handler, which runs within
/// heed(), may call again.
template <class Object, class Act>
auto alone(Object& object, Act&& act) {
    const py::gil_scoped_release others_may;
    const std::lock_guard<std::recursive_mutex> one_at_a_time(object.guard);
    return act();
}

/// Storage for an object whose __new__ was called without __init__: throws, because pybind11 would call methods on
/// uninitialised storage.
void* never_initialised(std::size_t) { throw py::type_error("the object is not initialised: its __init__ was not called"); }

/// Installs never_initialised() for the class of T. Objects built by __init__ do not use it.
template <class T>
void needs_init() {
    py::detail::get_type_info(typeid(T), true)->operator_new = &never_initialised;
}

/// numpy 2 has PyArray_CopyInto at place 50 of its table of functions. pybind11 before 2.12 takes place 82, as of numpy
/// 1, and calls another function, which crashes where an Eigen vector is an argument.
void find_copy_into(py::detail::npy_api& api) {
#if PYBIND11_VERSION_HEX < 0x020C0000
    const py::module_ numpy = py::module_::import("numpy");
    if (std::stoi(py::str(numpy.attr("__version__"))) < 2) return;
    const py::object table = py::module_::import("numpy._core.multiarray").attr("_ARRAY_API");
    auto** functions = static_cast<void**>(PyCapsule_GetPointer(table.ptr(), nullptr));
    if (!functions) throw py::error_already_set();
    api.PyArray_CopyInto_ = reinterpret_cast<decltype(api.PyArray_CopyInto_)>(functions[50]);
#else
    static_cast<void>(api);
#endif
}

using Options = std::vector<std::pair<std::string, std::string>>;

/// Whether a value is a bool of Python or of numpy, the latter being the result of comparing numpy values.
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

/// Option list for help(tissue.Simulation).
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
    return text + "\nA yes|no option is a bool, an offset a sequence.";
}

/// A session and its model.
struct Session : ApiSession {
    std::shared_ptr<const TissueModel> tissue;
    std::recursive_mutex guard;
    Session(std::shared_ptr<const TissueModel> t, std::shared_ptr<const HapticModel> m, NamedSurfaces s) : ApiSession(std::move(m), std::move(s)), tissue(std::move(t)) {}
    Session(const Session& other) : ApiSession(other), tissue(other.tissue) {}

    /// One tick of every tool: positions and forces (T x 3).
    NodeField tick_tools(const NodeField& positions_m, double elapsed_s, const std::vector<double>& age_s) {
        const int tools = simulation.tool_count();
        if (positions_m.rows() != tools || positions_m.cols() != 3 || (!age_s.empty() && age_s.size() != static_cast<std::size_t>(tools)))
            throw MismatchError(tools == 1 ? "a tick takes one position of three numbers" : "tick_tools() takes two positions of three numbers each, and as many ages");
        const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> at_m = positions_m;
        Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> force_N(tools, 3);
        tick(at_m.data(), age_s.empty() ? nullptr : age_s.data(), elapsed_s, force_N.data());
        return force_N;
    }

    void one_tool_only(const char* what) const {
        if (simulation.tool_count() > 1) throw MismatchError(std::string(what) + " needs a session of one tool; with two tools call tick_tools()");
    }
};

NodeField ticks(Session& session, const Rows& positions_m, double elapsed_s) {
    session.one_tool_only("ticks()");
    if (positions_m.cols() != 3) throw MismatchError("each position is the device's and has three numbers");
    if (!(elapsed_s >= 0 && std::isfinite(elapsed_s))) throw MismatchError("elapsed_s must be 0 or more and finite: ticks() has no clock");
    NodeField forces(positions_m.rows(), 3);
    Signals signals;
    return alone(session, [&] {
        for (Eigen::Index k = 0; k < forces.rows(); ++k) {
            if (k % 16 == 0) signals.heed();
            DeviceSample sample;
            sample.position_m = positions_m.row(k);
            forces.row(k) = session.simulation.tick(sample, elapsed_s);  // without a clock
        }
        session.forget_clock();  // the time that these ticks took is not a time between two ticks
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
    contact["grasped"] = tick.grasped;
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

/// An adaptation: an energy model that is fitted to measurements of the target tissue.
struct TargetAdaptation {
    std::unique_ptr<Adaptation> adaptation;
    std::recursive_mutex guard;

    Point point(const Eigen::VectorXd& p, const char* what) const {
        if (p.size() != adaptation->base().mesh.dimension()) throw MismatchError(std::string(what) + " must have as many numbers as the tissue has axes");
        return p;
    }
};

/// The model in equilibrium under its tool, for each contact and tool displacement. contacts_m, pushes_m (n x D) [m].
/// ball_m: radius of a rigid ball [m] in place of the model's disc. Returns (force (n x D) [N], displacement (n x N x
/// D) [m], reasons); NaN, and a reason, where there is no equilibrium. Throws MismatchError for wrong shapes, a contact
/// off the free surface, and a ball on a model without an energy model in space.
py::tuple press(const TissueModel& model, const Rows& contacts_m, const Rows& pushes_m, int threads, std::optional<double> ball_m) {
    const int D = model.mesh.dimension(), n = static_cast<int>(contacts_m.rows());
    if (contacts_m.cols() != D || pushes_m.cols() != D || pushes_m.rows() != n)
        throw MismatchError("contacts and pushes must have the same number of rows, each with as many numbers as the tissue has axes");
    std::vector<ContactAnswer> answers(static_cast<std::size_t>(n));
    {
        const py::gil_scoped_release others_may;
        std::optional<IndentationSolver> solver;
        std::optional<SetGrid> sets;
        std::unique_ptr<SpringLaw> springs;
        std::optional<BallIndentation> ball;
        if (ball_m && !model.energy_model) throw MismatchError("a ball needs an energy model in space");
        if (ball_m)
            ball.emplace(model.mesh, *model.energy_model, *ball_m);
        else if (model.energy_model)
            solver.emplace(model);
        else
            sets.emplace(model), springs = make_spring_law(model.law);
        Signals signals;
        const FreeSurface surface(model.mesh);
        const bool pulls = !ball_m && model.energy_model && model.energy_model->patch.curve == ContactCurve::compression;
        for (int k = 0; k < n; ++k) {
            signals.heed();
            if (const std::string why = push_refusal(model.mesh, surface, contacts_m.row(k).transpose(), pushes_m.row(k).transpose(), usual_off_surface_m, pulls); !why.empty())
                throw MismatchError("contact " + std::to_string(k) + " " + why);
        }
        const auto caller = std::this_thread::get_id();
        parallel_for(n, threads, [&](int k) {
            if (std::this_thread::get_id() == caller) signals.heed();
            const Point contact = contacts_m.row(k), push = pushes_m.row(k);
            ContactAnswer& answer = answers[static_cast<std::size_t>(k)];
            if (ball || solver) {
                answer = ball ? answer_of(*ball, contact, push) : answer_of(*solver, contact, push);
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
        if (path.second) {  // a second disc, displaced in proportion to the first
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
        throw FileError(fmt::format("{}: is not JSON: {}", file, one_line(py::str(e.value()))));
    }
    return study;
}

py::dict learn(TargetAdaptation& target, const Eigen::VectorXd& contact_m, const Eigen::VectorXd& push_m, const Eigen::VectorXd& force_N) {
    const UpdateResult answer =
        alone(target, [&] { return target.adaptation->learn({target.point(contact_m, "contact_m"), target.point(push_m, "push_m"), target.point(force_N, "force_N")}); });
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

py::tuple expect(TargetAdaptation& target, const Eigen::VectorXd& contact_m, const Eigen::VectorXd& push_m) {
    Eigen::MatrixXd covariance;
    const Expected expected = alone(target, [&] {
        Expected there = target.adaptation->expect(target.point(contact_m, "contact_m"), target.point(push_m, "push_m"));
        covariance = target.adaptation->covariance(there);
        return there;
    });
    return py::make_tuple(Eigen::VectorXd(expected.force_N), std::sqrt(covariance.trace() / static_cast<double>(covariance.rows())), to_string(expected.status));
}

py::list next(TargetAdaptation& target, double depth_m, std::size_t count) {
    std::vector<Push> pushes;
    Signals signals;
    const std::vector<MeasurementGain> worth = alone(target, [&] {
        Adaptation& a = *target.adaptation;
        pushes = pushes_over(a.surface(), a.base().mesh, depth_m, a.surface().spacing_m());
        return rank_measurements(a, pushes, pushes, [&] { signals.heed(); });
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
    study = tissue.read_study("results/surface")          # model, FE load paths, eval.json
    model = study["model"]
    force, displacement, why = model.press(contacts, pushes)   # equilibria, many contacts at once
    session = tissue.Simulation(model, friction=0.3)           # the tick of tissue-haptic
    force = session.tick([0.05, 0.098, 0])
    adaptation = tissue.Adaptation("results/surface/model.h5") # learns from force measurements
    adaptation.learn(contact, push, force)

SI units. A model has D = 2 or 3 axes and N nodes. Errors are tissue.Error, one line that names file, place and cause; an argument of a wrong
type is a TypeError. Long calls release the interpreter lock; calls of the same object wait for one another. Ctrl-C ends
ticks() between two ticks, press() between two contacts and next() between two indentations.)";
    // import numpy now: two threads that make their first arrays at once would deadlock, one waiting for the import
    // lock and the other for the interpreter lock
    find_copy_into(py::detail::npy_api::get());
    m.attr("__version__") = version;
    // never freed: the interpreter ends before static objects are destroyed
    static const py::handle error = py::exception<Error>(m, "Error", PyExc_ValueError).release();
    error.attr("__doc__") = "A wrong argument, file or option, or a failed write: one line.";
    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            std::rethrow_exception(thrown);
        } catch (const Error& e) {
            PyErr_SetString(error.ptr(), one_line(e.what()).c_str());
        }
    });

    py::class_<TissueModel, std::shared_ptr<TissueModel>>(m, "Model", "A model.h5 of tissuectl train or adapt. Arrays are read-only views of the model, without copies.")
        .def(py::init(&open_model), py::arg("file"), "file: a str or a path")
        .def_readonly("study", &TissueModel::study, "name of the study")
        .def_property_readonly("dimension", [](const TissueModel& t) { return t.mesh.dimension(); }, "D")
        .def_property_readonly("is_law", [](const TissueModel& t) { return t.energy_model.has_value(); }, "whether it is an energy model; else it has spring sets")
        .def_property_readonly("nodes", [](const TissueModel& t) -> const NodeField& { return t.mesh.nodes; }, "nodes at rest [m] (N, D); of a solid in an embedded lattice its own, then the lattice's")
        .def_property_readonly("springs", [](const TissueModel& t) -> const auto& { return t.mesh.springs; }, "node numbers (S, 2)")
        .def_property_readonly("facets", [](const TissueModel& t) -> const auto& { return t.mesh.facets; }, "node numbers of the surface (F, D)")
        .def_property_readonly("fixed", [](const TissueModel& t) { return t.mesh.fixed; }, "fixed nodes")
        .def_readonly("node_mass_kg", &TissueModel::node_mass_kg, "node masses [kg] (N)")
        .def_readonly("modulus", &TissueModel::modulus_N_m, "in the plane E t [N/m], in space Young's modulus E [Pa]")
        .def("with_tool", [](const TissueModel& t, double radius_m) { return with_tool(t, {ToolChoice::Shape::disc, radius_m}); }, py::arg("radius_m"),
             "The model with a disc of another radius [m], between the smallest and the largest of its training (disc_radii_m).")
        .def_property_readonly("case_radius_m", [](const TissueModel& t) { return t.case_radius_m; }, "disc radius of each load case, if an energy model in space was trained with several discs (C); else empty")
        .def_property_readonly("disc_radii_m", [](const TissueModel& t) { return t.energy_model ? t.energy_model->sizes.radii_m : Eigen::VectorXd(); },
                               "disc radii of an energy model in space that was trained with several discs, ascending; else empty")
        .def_property_readonly("disc_radius_m", [](const TissueModel& t) { return t.energy_model ? t.energy_model->disc_radius_m : 0.0; }, "disc radius of an energy model in space; else 0")
        .def_readonly("case_names", &TissueModel::case_names, "names of the training load cases (C)")
        .def_readonly("contact_m", &TissueModel::contact_m, "contact of each load case [m] (C, D)")
        .def_readonly("direction", &TissueModel::direction, "direction of each load case (C, D)")
        .def_readonly("magnitude_m", &TissueModel::magnitude_m, "tool displacement of each load case [m] (C)")
        .def_readonly("fe_force_N", &TissueModel::contact_force_N, "FE force of each load case [N] (C, D); no rows if the file has none")
        .def_property_readonly("terms", [](const TissueModel& t) { return t.energy_model ? t.energy_model->terms : std::vector<std::string>{}; }, "terms of an energy model (P)")
        .def_property_readonly("coefficients", [](const TissueModel& t) { return t.energy_model ? t.energy_model->coefficients : Eigen::VectorXd(); }, "coefficients of those terms (P)")
        .def_property_readonly("constants", [](const TissueModel& t) { return t.energy_model ? t.energy_model->constants : Eigen::VectorXd(); },
                               "constants of an energy model: of its springs, cells and an embedded solid's supports [N/m] (E)")
        .def("press", &press, py::arg("contacts_m"), py::arg("pushes_m"), py::arg("threads") = std::max(1u, std::thread::hardware_concurrency()), py::arg("ball_m") = py::none(),
             "Equilibrium under a prescribed tool displacement: contacts (K, D) on the free surface or within 2 mm of it, tool displacements from there (K, D), none out of the tissue.\n"
             "ball_m: radius of a rigid ball [m] in place of the disc, for an energy model in space; its contact may be as large as the largest disc of the training.\n"
             "Returns force of the tool on the tissue [N] (K, D), displacement [m] (K, N, D), in space with the surface beside the tool as it is drawn, and why there is no equilibrium, "
             "\"\" where there is one (K); without an equilibrium force and displacement are NaN. Of spring sets the nearest is used, as in tissuectl eval.")
        .def("__repr__", [](const TissueModel& t) {
            return "<tissue.Model '" + t.study + "', " + std::to_string(t.mesh.node_count()) + " nodes in " + (t.mesh.is_solid() ? "space" : "the plane") +
                   (t.energy_model ? ", an energy model>" : ", " + std::to_string(t.case_count()) + " spring sets>");
        });

    py::class_<Session>(m, "Simulation", "A running simulation: the tick of tissue-haptic, with its safety. For an energy model in space the constructor takes seconds, in which it computes the eigenvalues of the mesh; Ctrl-C takes effect after it.")
        .def(py::init([](std::shared_ptr<TissueModel> model, const py::kwargs& given) {
                 const HapticOptions options = with(interface_options(), options_of(given));
                 const py::gil_scoped_release others_may;
                 check_options(options);  // before the model is built with them
                 const auto haptic = std::make_shared<HapticModel>(*model, options);
                 if (!all_default(options.tool)) model = std::make_shared<TissueModel>(with_tool(*model, options.tool[0]));
                 return std::make_unique<Session>(model, haptic, NamedSurfaces(*model));
             }),
             py::arg("model").none(false),
             options_text().c_str())
        .def("tick", [](Session& s, const Eigen::Vector3d& position_m, double elapsed_s, double age_s) {
                 s.one_tool_only("tick()");
                 return alone(s, [&] { return Eigen::Vector3d(s.tick_tools(NodeField(position_m.transpose()), elapsed_s, {age_s}).row(0)); });
             },
             py::arg("position_m"), py::arg("elapsed_s") = 0.0, py::arg("age_s") = 0.0,
             "One step: the device's position [m] (3); returns the force on the hand [N] (3), finite and within force_max for any input. elapsed_s: time since the last tick; 0: dt; negative or not finite: "
             "unknown, and the library's own clock is used. age_s: time since the position was measured, where positions come less often than ticks.")
        .def("ticks", &ticks, py::arg("positions_m"), py::arg("elapsed_s") = 0.0,
             "One tick for each position (T, 3), in order, each elapsed_s after the one before (0: dt); returns forces [N] (T, 3). After Ctrl-C the session keeps the state of its last tick.")
        .def("tick_tools", [](Session& s, const NodeField& positions_m, double elapsed_s, const std::optional<std::vector<double>>& age_s) { return alone(s, [&] { return s.tick_tools(positions_m, elapsed_s, age_s.value_or(std::vector<double>())); }); },
             py::arg("positions_m"), py::arg("elapsed_s") = 0.0, py::arg("age_s") = py::none(),
             "One step of all tools (option tools): the devices' positions [m] (tools, 3), an age each [s] (tools), or None; returns the forces on the hands [N] (tools, 3).")
        .def("use_tool", [](Session& s, int tool) { alone(s, [&] { s.use_tool(tool); }); }, py::arg("tool"), "Selects the tool, 0 at the start, that set(), clutch(), grasp(), contact, counts, limits and energies_J refer to. Both tools share the counts ticks, folded, unstable and lost_ms, and the energies kinetic, stored and dissipated.")
        .def_property_readonly("tools", [](const Session& s) { return s.simulation.tool_count(); }, "number of tools")
        .def("reset", [](Session& s) { alone(s, [&] { s.simulation.reset(); }); }, "Puts the tissue to rest; there is no force until the tool has been outside once.")
        .def("set", [](Session& s, const py::kwargs& given) {
                 const Options options = options_of(given);
                 alone(s, [&] { s.simulation.change(with(s.simulation.options(s.tool()), options, changeable(s.simulation)), s.tool()); });
             },
             "Sets options that may change while it runs, by name, and before the first tick limits of the device (force_max, ..). After a change that moves the tool by more than a hand does in a tick there is no force until the tool has been outside once.")
        .def("clutch", [](Session& s, bool on) { alone(s, [&] { s.simulation.clutch(on, s.tool()); }); }, py::arg("on").noconvert(), "On: the hand moves and the tool stays, without force. Off: the tool continues from its place.")
        .def("grasp", [](Session& s, bool on) { alone(s, [&] {
                 if (on) s.simulation.model().check_grasp(s.tool());
                 s.simulation.grasp(on, s.tool());
             }); }, py::arg("on").noconvert(), "On: the tissue that the tool touches in the next tick follows it in every direction, without slip, until this is off or the force exceeds grasp_max. For an energy model whose contact was trained to be pulled, or in the plane.")
        .def_property("state", &state_of, &restore, "The state of the session as bytes; a session of the same model and options that is given these bytes continues identically, bit for bit.")
        .def("begin", [](Session& s) { return alone(s, [&] { return std::make_unique<Session>(s.tissue, s.model, s.surfaces); }); },
             "Another session of the same model, at rest, with the initial options of this one and its surfaces; it takes a thousandth of the time of a new Simulation.")
        .def("copy", [](Session& s) { return alone(s, [&] { return std::make_unique<Session>(s); }); }, "A copy of the session in its present state.")
        .def("follow", [](Session& s, Session& leader) {
                 const Simulation other = alone(leader, [&] { return Simulation(leader.simulation); });
                 alone(s, [&] { s.simulation.follow(other); });
             }, py::arg("session"), "For a session that has not ticked: moves its tool to the place of the other session's tool. Takes the time of some hundred ticks.")
        .def("take_over", [](Session& s, Session& from) {
                 if (&s == &from) throw MismatchError("take_over: the same session");
                 const Session other = alone(from, [&] { return Session(from); });
                 alone(s, [&] { s.take_over(other); });
             }, py::arg("session"), "After follow(): continues with the hand of the other session. Force, limits, properties of the device, energy injected and counts are those of the other session; the difference of the forces decays within some tenths of a second.")
        .def_property_readonly("displacement_m", [](const Session& s) -> const NodeColumns& { return s.simulation.state(0).displacement; },
                               "present displacement of the lattice's nodes [m] (N, D): a view that the next tick changes")
        .def_property_readonly("seen_m", [](Session& s) {
                 return alone(s, [&] {
                     NodeColumns seen;
                     s.simulation.displayed(0, seen);
                     return NodeField(seen);
                 });
             }, "present displacement of the nodes as drawn and compared with FE [m] (N, D): in space, beside the tool, that of the skin (lib/springs/skin.h)")
        .def("add_surface", [](Session& s, const std::string& name, const File& file, double unit_m) { alone(s, [&] { s.surfaces.add(name, file, unit_m); }); }, py::arg("name"), py::arg("file"), py::arg("unit_m"),
             "Adds a surface that moves with the tissue, from a file (.stl, .obj, .ply, ..); unit_m: unit of length of the file [m].")
        .def_property_readonly("surfaces", [](Session& s) { return alone(s, [&] { return s.surfaces.names(); }); }, "names of the surfaces, in space: boundary, nodule if the model has one, and those added")
        .def("surface", [](Session& s, const std::string& name) {
                 return alone(s, [&] {
                     const NamedSurfaces::Surface* of = s.surfaces.find(name);
                     if (!of) throw MismatchError("there is no surface '" + name + "'");
                     NodeColumns seen;
                     s.simulation.displayed(0, seen);
                     Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> places(of->rest_m.rows(), 3);
                     of->places(seen, places.data());
                     return std::pair(places, of->triangles);
                 });
             }, py::arg("name"), "Present positions of a surface's points [m] (V, 3), and its triangles, normals out (W, 3). The order of the points does not change.")
        .def_property_readonly("contact", &contact_of, "contact after the last tick: mesh (-1: no contact), facet, weight, displacement_m, force_N (on the tissue, before safety), slipping, fault, status (done; late: the device had released its force, and the force begins at zero; overrun: time was lost; without force: refused, not armed, folded, diverged)")
        .def_property_readonly("counts", &counts_of, "counts of the session")
        .def_property_readonly("limits", &limits_of, "number of ticks in which the force was limited: clamped, slewed, damped, capped, late (the device had released its force); and lost_s, time that passed and was not simulated")
        .def_property_readonly("energies_J", &energies_of, "the energy log: given (injected at the device port since the start; below 0: taken from the hand), observed and bound (of the passivity observer), kinetic (of the tissue), friction (dissipated), "
                               "and with energy_book=True stored and dissipated in the Maxwell branches of a tissue that relaxes")
        .def_property_readonly("model", [](const Session& s) { return std::const_pointer_cast<TissueModel>(s.tissue); }, "the model that is simulated; with two different tools, that of the first");

    py::class_<TargetAdaptation>(m, "Adaptation", "Adaptation of an energy model to force measurements of a target tissue, as in tissuectl adapt.")
        .def(py::init([](const File& file, const std::string& unknowns, double force_noise, double model_error, double place_error_m, bool rival) {
                 AdaptOptions options;
                 options.unknowns = unknowns;
                 options.force_noise = force_noise;
                 options.model_error = model_error;
                 options.place_error_m = place_error_m;
                 options.rival = rival;
                 auto target = std::make_unique<TargetAdaptation>();
                 const py::gil_scoped_release others_may;
                 target->adaptation = read_adaptation(file.string(), options);
                 return target;
             }),
             py::arg("model_file"), py::arg("unknowns") = "field", py::arg("force_noise") = 0.02, py::arg("model_error") = 0.03, py::arg("place_error_m") = 0.0,
             py::arg("rival") = true, "An adapted file is adapted further, with the options stored in it.")
        .def("learn", &learn, py::arg("contact_m"), py::arg("push_m"), py::arg("force_N"),
             "One measurement: contact at rest [m], tool displacement [m], force of the tool on the tissue [N] (D each). Returns a dict: status (learned, gated, refused), why, ...")
        .def("expect", &expect, py::arg("contact_m"), py::arg("push_m"), "Predicted force of a tool displacement [N] (D; NaN unless the status is held), its standard deviation over the force, and the status of the equilibrium.")
        .def("next", &next, py::arg("depth_m") = usual_depth_m, py::arg("count") = 3, "The most informative measurements: contact, tool displacement, and the part of the mean variance of all forces that each would remove.")
        .def("model", [](TargetAdaptation& p) { return alone(p, [&] { return std::make_shared<TissueModel>(p.adaptation->model()); }); }, "The adapted model.")
        .def("write", [](TargetAdaptation& p, const File& file) { alone(p, [&] { write_adapted_model(file.string(), *p.adaptation, {"python tissue.Adaptation.write", 0, {}}); }); },
             py::arg("file"), "Writes the adapted model.h5, which can be adapted further.")
        .def("forget", [](TargetAdaptation& p) { alone(p, [&] { p.adaptation->forget(); }); }, "Resets to the state before the first measurement.")
        .def_property_readonly("learned", [](TargetAdaptation& p) { return alone(p, [&] { return p.adaptation->state().learned; }); }, "number of measurements learned")
        .def_property_readonly("factor", [](TargetAdaptation& p) { return alone(p, [&] { return Eigen::VectorXd(p.adaptation->x().array().exp()); }); },
                               "exp of each unknown: for a field, stiffness of each node over its trained stiffness (P)")
        .def_property_readonly("sd", [](TargetAdaptation& p) { return alone(p, [&] { return p.adaptation->sd(); }); },
                               "posterior standard deviation of the logarithm of factor (P)");

    needs_init<TissueModel>();
    needs_init<Session>();
    needs_init<TargetAdaptation>();

    m.def("read_study", &read_study, py::arg("folder"), "Reads results/STUDY: a dict of model, paths (as read_cases) and eval (eval.json; None if there is none).");
    m.def("file_hash", [](const File& file) {
              const py::gil_scoped_release others_may;
              return file_hash(file.string());
          }, py::arg("file"), "XXH3 of a file's contents, 32 hexadecimal digits: model_hash of eval.json is that of the model's file.");
    m.def("read_cases", &paths_of, py::arg("file"),
          "Reads the FE load paths of a cases.h5: a list of dicts of name, role, contact_m, direction, lost, magnitude_m (R), in space radius_m of the disc (0: the study's own), force_N (R, D), displacement_m (R, N, D; no rows for measured forces). With two discs at once also second_contact_m, second_direction, second_depth_m (reached with the largest magnitude_m), second_force_N (R, D).");
}
