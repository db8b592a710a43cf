#include "api/tissue.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "api/api_session.h"
#include "api/session_counts.h"
#include "error.h"
#include "haptic/session_options.h"
#include "springs/energy_model_at_radius.h"
#include "version.h"

using namespace tissue;

struct tissue_model {
    std::shared_ptr<const HapticModel> model;
    NamedSurfaces surfaces;
};

struct tissue_session : ApiSession {
    mutable NodeColumns seen;  ///< scratch memory of tissue_positions and tissue_surface
    explicit tissue_session(const tissue_model& of) : ApiSession(of.model, of.surfaces), seen(simulation.state(0).displacement) {}
};

namespace {

/// The last failure of this thread: one line without control characters. Static storage, because reporting a failure
/// must not fail.
thread_local char failure[1024] = "";

tissue_status fail(tissue_status status, const char* why) noexcept {
    std::strncpy(failure, why, sizeof failure - 1);
    for (char& c : failure)
        if ((c > 0 && c < ' ') || c == 0x7f) c = '?';
    return status;
}

tissue_status bad(const char* why) noexcept { return fail(TISSUE_BAD_ARGUMENT, why); }

/// Returns the result of `act`, or the status of the exception that it throws.
template <class Act>
tissue_status caught(Act act) noexcept {
    try {
        return act();
    } catch (const FileError& e) {
        return fail(TISSUE_BAD_FILE, e.what());
    } catch (const MismatchError& e) {
        return fail(TISSUE_MISMATCH, e.what());
    } catch (const std::exception& e) {
        return fail(TISSUE_FAILED, e.what());
    } catch (...) {
        return fail(TISSUE_FAILED, "an unknown exception was thrown");
    }
}

/// Sets an option. TISSUE_BAD_ARGUMENT for an option that does not exist, or for a value of another kind.
tissue_status set(HapticOptions& options, const char* name, const char* value, unsigned changeable = everywhere) {
    try {
        set_option(options, name, value, changeable);
    } catch (const MismatchError& e) {
        return bad(e.what());
    }
    return TISSUE_OK;
}

/// Sizes of the structs in the first release.
constexpr size_t first_contact = offsetof(tissue_contact, grasped) + sizeof(int), first_limits = offsetof(tissue_limits, lost_s) + sizeof(double);
static_assert(sizeof(tissue_contact) >= first_contact && sizeof(tissue_limits) >= first_limits, "members are added at the end");

/// Copies `ours` to a caller whose struct may have more or fewer members than this library's.
template <class Struct>
tissue_status hand_out(const Struct& ours, Struct* to, size_t size, size_t first) noexcept {
    if (size < first) return bad("size is too small for this struct of tissue.h: pass sizeof of the struct");
    std::memset(to, 0, size);
    std::memcpy(to, &ours, std::min(size, sizeof ours));
    return TISSUE_OK;
}

tissue_status status_of(const TickRecord& tick) noexcept {
    switch (tick.status) {
        case TickStatus::refused: return TISSUE_FAULT;
        case TickStatus::not_armed: return TISSUE_NOT_ARMED;
        case TickStatus::folded: return TISSUE_FOLDED;
        case TickStatus::diverged: return TISSUE_DIVERGED;
        case TickStatus::done: break;
    }
    return tick.late ? TISSUE_LATE : tick.overrun ? TISSUE_OVERRUN : TISSUE_OK;
}

bool has_force(tissue_status status) noexcept { return status == TISSUE_OK || status == TISSUE_LATE || status == TISSUE_OVERRUN; }

/// Copies to three numbers; the third is 0 in the plane.
void three(const Point& p, double to[3]) noexcept {
    for (Eigen::Index a = 0; a < 3; ++a) to[a] = a < p.size() ? p[a] : 0;
}

}  // namespace

extern "C" {

const char* tissue_version(void) { return version; }

const char* tissue_error(void) { return failure; }

tissue_status tissue_open_model(const char* model_file, const char* const* options, tissue_model** model) {
    if (!model_file || !model) return bad("tissue_open_model: a null pointer");
    return caught([&] {
        HapticOptions haptic = interface_options();
        for (; options && options[0]; options += 2) {
            if (!options[1]) return bad("an option without a value");
            if (const tissue_status status = set(haptic, options[0], options[1]); status != TISSUE_OK) return status;
        }
        check_options(haptic);  // before the model is built with them
        const TissueModel tissue = read_model(model_file);
        *model = new tissue_model{std::make_shared<HapticModel>(tissue, haptic), NamedSurfaces(tissue)};
        return TISSUE_OK;
    });
}

tissue_status tissue_begin(const tissue_model* model, tissue_session** session) {
    if (!model || !session) return bad("tissue_begin: a null pointer");
    return caught([&] {
        *session = new tissue_session(*model);
        return TISSUE_OK;
    });
}

tissue_status tissue_open(const char* model_file, const char* const* options, tissue_session** session) {
    if (!model_file || !session) return bad("tissue_open: a null pointer");
    tissue_model* model = nullptr;
    tissue_status status = tissue_open_model(model_file, options, &model);
    if (status == TISSUE_OK) status = tissue_begin(model, session);
    tissue_close_model(&model);
    return status;
}

void tissue_close_model(tissue_model** model) {
    if (model) delete std::exchange(*model, nullptr);
}

void tissue_close(tissue_session** session) {
    if (session) delete std::exchange(*session, nullptr);
}

tissue_status tissue_tick(tissue_session* s, const double position_m[3], double elapsed_s, double force_N[3]) { return tissue_tick_aged(s, position_m, 0, elapsed_s, force_N); }

tissue_status tissue_tick_aged(tissue_session* s, const double position_m[3], double age_s, double elapsed_s, double force_N[3]) {
    return tissue_tick_tools(s, 1, position_m, &age_s, elapsed_s, force_N, nullptr);
}

tissue_status tissue_tick_tools(tissue_session* s, int tools, const double* position_m, const double* age_s, double elapsed_s, double* force_N, tissue_status* status) {
    if (!s || !position_m || !force_N || tools != s->simulation.tool_count()) {
        constexpr int most = 64;  // a larger number is an error of the caller, whose arrays are not that long
        // else a caller that ignores the status keeps playing the old force
        if (force_N && tools > 0 && tools <= most) std::fill_n(force_N, 3 * tools, 0.0);
        if (status && tools > 0 && tools <= most) std::fill_n(status, tools, TISSUE_BAD_ARGUMENT);
        return TISSUE_BAD_ARGUMENT;
    }
    s->tick(position_m, age_s, elapsed_s, force_N);
    tissue_status first = TISSUE_OK;
    for (int k = 0; k < tools; ++k) {
        const tissue_status of_tool = status_of(s->simulation.record(k));
        if (status) status[k] = of_tool;
        if (first == TISSUE_OK || (has_force(first) && !has_force(of_tool))) first = of_tool;
    }
    return first;
}

tissue_status tissue_use_tool(tissue_session* s, int tool) {
    if (!s) return bad("tissue_use_tool: a null pointer");
    if (tool < 0 || tool >= s->simulation.tool_count()) return bad("tissue_use_tool: the session has no such tool");
    s->use_tool(tool);
    return TISSUE_OK;
}

tissue_status tissue_set(tissue_session* s, const char* name, const char* value) {
    if (!s || !name || !value) return bad("tissue_set: a null pointer");
    return caught([&] {
        HapticOptions options = s->simulation.options(s->tool());
        if (const tissue_status status = set(options, name, value, changeable(s->simulation)); status != TISSUE_OK) return status;
        s->simulation.change(options, s->tool());
        return TISSUE_OK;
    });
}

tissue_status tissue_clutch(tissue_session* s, int on) {
    if (!s) return bad("tissue_clutch: a null pointer");
    s->simulation.clutch(on != 0, s->tool());
    return TISSUE_OK;
}

tissue_status tissue_grasp(tissue_session* s, int on) {
    if (!s) return bad("tissue_grasp: a null pointer");
    return caught([&] {
        if (on) s->model->check_grasp(s->tool());
        s->simulation.grasp(on != 0, s->tool());
        return TISSUE_OK;
    });
}

tissue_status tissue_follow(const tissue_model* model, const tissue_session* leader, tissue_session** session) {
    if (!model || !leader || !session) return bad("tissue_follow: a null pointer");
    return caught([&] {
        auto next = std::make_unique<tissue_session>(*model);
        next->simulation.follow(leader->simulation);
        *session = next.release();
        return TISSUE_OK;
    });
}

tissue_status tissue_take_over(tissue_session* s, const tissue_session* from) {
    if (!s || !from || s == from) return bad("tissue_take_over: a null pointer, or the same session twice");
    return caught([&] {
        s->take_over(*from);
        return TISSUE_OK;
    });
}

size_t tissue_state_size(const tissue_session* s) { return s ? s->simulation.state_size() : 0; }

tissue_status tissue_save(const tissue_session* s, void* state, size_t size) {
    if (!s || !state) return bad("tissue_save: a null pointer");
    if (size != s->simulation.state_size()) return bad("tissue_save: the size is not tissue_state_size");
    s->simulation.save(static_cast<std::byte*>(state));
    return TISSUE_OK;
}

tissue_status tissue_restore(tissue_session* s, const void* state, size_t size) {
    if (!s || !state) return bad("tissue_restore: a null pointer");
    return caught([&] {
        s->restore(static_cast<const std::byte*>(state), size);
        return TISSUE_OK;
    });
}

tissue_status tissue_copy(const tissue_session* s, tissue_session** copy) {
    if (!s || !copy) return bad("tissue_copy: a null pointer");
    return caught([&] {
        *copy = new tissue_session(*s);
        return TISSUE_OK;
    });
}

const char* tissue_status_text(tissue_status status) {
    switch (status) {
        case TISSUE_OK: return "ok";
        case TISSUE_BAD_ARGUMENT: return "an argument was refused: a null pointer, an unknown index or an unknown option";
        case TISSUE_BAD_FILE: return "the file is not a model, or cannot be read";
        case TISSUE_MISMATCH: return "options do not match each other or the model";
        case TISSUE_FAULT: return "the position was refused: not finite, too fast or too old";
        case TISSUE_FAILED: return "failed, memory may have run out";
        case TISSUE_NOT_ARMED: return "no force: the tool has not been outside the tissue yet";
        case TISSUE_FOLDED: return "no force: a surface crosses itself, or two meshes overlap";
        case TISSUE_DIVERGED: return "a mesh diverged, or its cells were inverted, and was put to rest";
        case TISSUE_LATE: return "the tick was so late that the device had released its force: the force begins again at zero";
        case TISSUE_OVERRUN: return "time was lost: more than half a second passed, or ticks took longer than their time step";
    }
    return "no status";
}

tissue_status tissue_reset(tissue_session* s) {
    if (!s) return bad("tissue_reset: a null pointer");
    s->simulation.reset();
    return TISSUE_OK;
}

int tissue_tool_count(const tissue_session* s) { return s ? s->simulation.tool_count() : 0; }
int tissue_dimension(const tissue_session* s) { return s ? s->model->dimension() : 0; }
int tissue_node_count(const tissue_session* s) { return s ? s->model->rest.node_count() : 0; }
int tissue_facet_count(const tissue_session* s) { return s ? static_cast<int>(s->model->rest.facets.rows()) : 0; }
static const ToolChoice& tool_of(const tissue_session* s) { return s->model->tools[static_cast<std::size_t>(s->tool())]; }

double tissue_tool_radius(const tissue_session* s) { return s ? tool_of(s).radius_m : 0; }

const char* tissue_tool_shape(const tissue_session* s) { return s && s->model->is_solid() ? to_string(tool_of(s).shape) : ""; }
const char* tissue_study(const tissue_session* s) { return s ? s->model->study.c_str() : ""; }

tissue_status tissue_facets(const tissue_session* s, int* nodes) {
    if (!s || !nodes) return bad("tissue_facets: a null pointer");
    const auto& facets = s->model->rest.facets;
    for (Eigen::Index f = 0; f < facets.rows(); ++f)
        for (Eigen::Index k = 0; k < facets.cols(); ++k) *nodes++ = facets(f, k);
    return TISSUE_OK;
}

tissue_status tissue_rest_positions(const tissue_session* s, double* position_m) {
    if (!s || !position_m) return bad("tissue_rest_positions: a null pointer");
    const NodeField& nodes = s->model->rest.nodes;
    for (Eigen::Index n = 0; n < nodes.rows(); ++n)
        for (Eigen::Index a = 0; a < nodes.cols(); ++a) *position_m++ = nodes(n, a);
    return TISSUE_OK;
}

tissue_status tissue_positions(const tissue_session* s, double* position_m) {
    if (!s || !position_m) return bad("tissue_positions: a null pointer");
    const NodeField& nodes = s->model->rest.nodes;
    NodeColumns& u = s->seen;
    s->simulation.displayed(0, u);
    for (Eigen::Index n = 0; n < nodes.rows(); ++n)
        for (Eigen::Index a = 0; a < nodes.cols(); ++a) *position_m++ = nodes(n, a) + u(n, a);
    return TISSUE_OK;
}

tissue_status tissue_add_surface(tissue_session* s, const char* name, const char* file, double unit_m) {
    if (!s || !name || !file) return bad("tissue_add_surface: a null pointer");
    return caught([&] {
        s->surfaces.add(name, file, unit_m);
        return TISSUE_OK;
    });
}

/// nullptr: no surface has this name.
static const NamedSurfaces::Surface* surface_of(const tissue_session* s, const char* name) { return s && name ? s->surfaces.find(name) : nullptr; }

int tissue_surface_points(const tissue_session* s, const char* name) {
    const NamedSurfaces::Surface* surface = surface_of(s, name);
    return surface ? static_cast<int>(surface->rest_m.rows()) : 0;
}

int tissue_surface_triangles(const tissue_session* s, const char* name) {
    const NamedSurfaces::Surface* surface = surface_of(s, name);
    return surface ? static_cast<int>(surface->triangles.rows()) : 0;
}

tissue_status tissue_surface(const tissue_session* s, const char* name, int* triangles, double* position_m) {
    if (!s || !name) return bad("tissue_surface: a null pointer");
    const NamedSurfaces::Surface* surface = surface_of(s, name);
    if (!surface) return bad("tissue_surface: there is no surface of this name");
    for (Eigen::Index t = 0; triangles && t < surface->triangles.rows(); ++t)
        for (Eigen::Index k = 0; k < 3; ++k) *triangles++ = surface->triangles(t, k);
    if (position_m) {
        s->simulation.displayed(0, s->seen);
        surface->places(s->seen, position_m);
    }
    return TISSUE_OK;
}

tissue_status tissue_read_contact(const tissue_session* s, tissue_contact* to, size_t size) {
    if (!s || !to) return bad("tissue_read_contact: a null pointer");
    const TickRecord& tick = s->simulation.record(s->tool());
    tissue_contact contact{};
    contact.mesh = tick.mesh;
    contact.facet = tick.facet;
    for (int k = 0; k < 3; ++k) contact.weight[k] = tick.weight[k];
    three(tick.contact_displacement_m, contact.displacement_m);
    three(Point::Zero(tick.coupling_N.size()) - tick.coupling_N, contact.force_N);
    contact.slipping = tick.slipping ? 1 : 0;
    contact.grasped = tick.grasped ? 1 : 0;
    return hand_out(contact, to, size, first_contact);
}

const char* tissue_stiffness(const tissue_session* s) {
    if (!s) return "";
    if (s->model->is_energy_model()) return "law";
    return s->model->set_names[static_cast<std::size_t>(s->simulation.set())].c_str();
}

tissue_status tissue_count(const tissue_session* s, const char* name, long long* count) {
    if (!s || !name || !count) return bad("tissue_count: a null pointer");
    for (const SessionCount& one : session_counts)
        if (std::strcmp(name, one.name) == 0) {
            *count = one.of(s->simulation, s->tool());
            return TISSUE_OK;
        }
    return bad("tissue_count: there is no such count");
}

tissue_status tissue_read_limits(const tissue_session* s, tissue_limits* to, size_t size) {
    if (!s || !to) return bad("tissue_read_limits: a null pointer");
    const SafetyCounters& c = s->simulation.safety(s->tool()).counters();
    return hand_out(tissue_limits{c.clamped, c.slewed, c.damped, c.capped, c.late, s->simulation.counters().lost_s}, to, size, first_limits);
}

tissue_status tissue_energy(const tissue_session* s, const char* name, double* energy_J) {
    if (!s || !name || !energy_J) return bad("tissue_energy: a null pointer");
    for (const SessionEnergy& one : session_energies)
        if (std::strcmp(name, one.name) == 0) {
            *energy_J = one.of(s->simulation, s->tool());
            return TISSUE_OK;
        }
    return bad("tissue_energy: there is no such energy");
}

}  // extern "C"
