/* tissue.h: C interface to a simulated soft tissue under a tool, for programs that run their own loop.
 *
 *   tissue_session *tissue = NULL;
 *   if (tissue_open("model.h5", NULL, &tissue) != TISSUE_OK) puts(tissue_error());
 *   while (running) tissue_tick(tissue, position_m, -1, force_N);   (-1: the library's own clock measures the time)
 *   tissue_close(&tissue);
 *
 * Units are SI. A model has D = 2 or 3 axes. A device always has three; a model in the plane uses the first two of them
 * (option "axes"). Arrays of nodes are N times D doubles, node after node.
 *
 * Errors: every function that can fail returns a tissue_status. On failure its results keep their values, except that a
 * refused tick sets the force to zero. tissue_error() then returns one line with the cause, in the calling thread.
 * Ticks do not set that line, because the first line of a thread may allocate; tissue_status_text() describes their
 * status. No function throws, aborts or prints.
 *
 * Threads: a session belongs to one thread at a time and may be handed over between two calls. Sessions are
 * independent, also sessions of one model, because a model never changes. tissue_tick, tissue_tick_aged,
 * tissue_tick_tools, tissue_use_tool, tissue_reset, tissue_clutch, tissue_grasp, tissue_save, tissue_take_over and all functions that
 * only read take no lock, do not allocate and never wait. They may run at 1 kHz and above. Functions that open, close,
 * copy, restore, set or follow allocate, and are to be called between two ticks.
 *
 * Closing sets the caller's pointer to NULL, and closing NULL does nothing, so closing twice is harmless. Other copies
 * of the pointer are the caller's responsibility.
 *
 * Linking: -ltissue alone (pkg-config tissue-c). Symbols are versioned (TISSUE_1); a released symbol is kept. A struct
 * may get more members at its end. A function that fills a struct takes the caller's sizeof and writes that many bytes;
 * members that the library does not have are zero. A size below that of the first release is refused
 * (TISSUE_BAD_ARGUMENT). */
#ifndef TISSUE_H
#define TISSUE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TISSUE_API __attribute__((visibility("default")))

typedef struct tissue_session tissue_session;
typedef struct tissue_model tissue_model;

typedef enum tissue_status {
    TISSUE_OK = 0,
    /* a null pointer, an invalid index, or an option that does not exist or has a value of another kind */
    TISSUE_BAD_ARGUMENT = 1,
    TISSUE_BAD_FILE = 2,     /* the file is not a model, or cannot be read */
    TISSUE_MISMATCH = 3,     /* options that do not fit each other or the model */
    TISSUE_FAULT = 4,        /* tick: the position was refused (not finite, too fast, too old); the force is zero */
    TISSUE_FAILED = 5,       /* out of memory, or another failure that tissue_error() names */
    /* tick: the tool is inside the tissue and has not been outside since the start, a fault or a reset; the force is
     * zero */
    TISSUE_NOT_ARMED = 6,
    TISSUE_FOLDED = 7,       /* tick: a surface intersects itself, or two meshes overlap; the force is zero */
    /* tick: a mesh diverged, or settled in an equilibrium other than rest (inverted), and was put to rest; the force is
     * zero */
    TISSUE_DIVERGED = 8,
    /* tick: time was lost, because elapsed_s was longer than can be made up for or ticks took longer than the time they
     * advance. The force is valid, as with TISSUE_OK. If the tick was also late, the status is TISSUE_LATE */
    TISSUE_OVERRUN = 9,
    /* tick: it came so late that the device had released its force. The force rises from zero again, limited by slew
     * and by the bound on energy. Time may also have been lost (lost_ms) */
    TISSUE_LATE = 10
} tissue_status;

/* A one-line description of a status. */
TISSUE_API const char *tissue_status_text(tissue_status status);

/* The version, such as "0.1.0". */
TISSUE_API const char *tissue_version(void);

/* The cause of the last failure in this thread, one line; "" before the first failure. Valid until the next failure. */
TISSUE_API const char *tissue_error(void);

/* Opens a model.h5 of tissuectl train or adapt. options: "name", "value", "name", "value", ..., NULL; or NULL.
 * OPTIONS.md (share/doc/tissuectl) lists their names, units, defaults and ranges. A switch is "yes" or "no". A value
 * outside its range, or an option without effect on this model, returns TISSUE_MISMATCH. */
TISSUE_API tissue_status tissue_open(const char *model_file, const char *const *options, tissue_session **session);

TISSUE_API void tissue_close(tissue_session **session);

/* tissue_open in two steps. A model is opened once, with the options that its sessions start with, and serves any
 * number of sessions. Sessions keep what they need of the model, so the model may be closed before them. */
TISSUE_API tissue_status tissue_open_model(const char *model_file, const char *const *options, tissue_model **model);
TISSUE_API tissue_status tissue_begin(const tissue_model *model, tissue_session **session);
TISSUE_API void tissue_close_model(tissue_model **model);

/* One tick. position_m: device position [m]; force_N: force of the device on the hand [N].
 *
 * elapsed_s: time since the last tick by the system's clock. 0 means dt, so where a measured difference is 0, pass -1.
 * A negative or non-finite value means that the host does not know it: the library's own clock is used (dt in the first
 * tick).
 *
 * Time. The tissue advances by the elapsed time. The force on a hand at rest is the same at any rate from 50 Hz to 8
 * kHz; with hold "inf" from 10 Hz on, at an even rate. While the hand moves, the tool is led one period ahead. The part
 * of a stall beyond half a second is lost: TISSUE_OVERRUN, or TISSUE_LATE where the device had released its force
 * meanwhile; count "lost_ms", tissue_read_limits. Where ticks take longer than the time by which they advance the
 * tissue, the tissue runs slower than the clock, and lost_ms counts the difference. Where they take more than half of
 * that time, a stall is not made up for. The library detects this over some fifty ticks, or over five between which
 * elapsed_s changes by a tenth, if elapsed_s is measured by the system's clock right before the tick. A host that
 * passes another time loses none, unless its ticks take that time to within some tenths of a percent. A host that keeps
 * up loses none while its periods vary by less than a tenth.
 *
 * Hold. A force that the device still holds after option "hold" (0.05 s) is not in the energy log. A host whose ticks
 * may stall must make the device release the force by then, or set hold to "inf". A tick later than half of hold (0.025
 * s) starts from zero force, which rises by slew and as far as the bound on energy permits (TISSUE_LATE; counted by
 * `late` of tissue_limits). So 50 Hz, with a clock that varies by 5 ms, is the slowest rate by default.
 *
 * Bound on energy. The energy given at the port is at most r * force-max * speed-max * dt. r is 1 while ticks come
 * every dt, each with a new position (0.0066 J by default). r is at most hold / dt after a stall (0.33 J; 0.066 J with
 * hold 0.01, which serves hosts from 200 Hz on), and (hold + stale) / dt for positions given with an age (0.66 J).
 * tissue_energy "bound" is the present bound. The energy given decays in this account with a time constant of 5 s, so
 * over a long time another r times 1.3 mW may be given.
 *
 * Guarantees. The force is finite and within force-max for any input. It is zero where the status is not TISSUE_OK,
 * TISSUE_LATE or TISSUE_OVERRUN, also where an argument is refused. The energy given to the hand is bounded for every
 * device (lib/haptic/safety.h). That a hand comes to rest on the tissue is guaranteed only for a device whose mass is
 * stated (option "device-mass") and whose positions come with every tick, every dt, at most half of dt old
 * (tissue_tick_aged); with positions one dt old a device of 45 g may oscillate. The thread's floating-point mode
 * (rounding, traps, denormals) is set for the tick and restored after it. */
TISSUE_API tissue_status tissue_tick(tissue_session *session, const double position_m[3], double elapsed_s, double force_N[3]);

/* tissue_tick for a device whose positions come less often than ticks. age_s: time since this position was measured; a
 * position that is passed again has aged by the time passed. The speed of the hand is then computed over the time
 * between two measurements. A position older than option "stale", or with an age that is not a number, is refused. A
 * negative age counts as 0. */
TISSUE_API tissue_status tissue_tick_aged(tissue_session *session, const double position_m[3], double age_s, double elapsed_s, double force_N[3]);

/* ---- two tools (option "tools" "2"): two devices on one tissue, each with its own energy log and safety. The options
 * of tissue_open apply to both at first. */

/* One tick of all tools. position_m, force_N: three numbers per tool, one tool after the other. age_s: one number per
 * tool, as in tissue_tick_aged; NULL: just measured. status: the status of each tool, or NULL. A tool that is refused,
 * or has not been outside yet, has no force, and the other continues. TISSUE_FOLDED, TISSUE_DIVERGED and tissue_reset
 * stop both. Returns the first status without force, else the first that is not TISSUE_OK. Returns TISSUE_BAD_ARGUMENT,
 * with zero forces (for up to 64 tools), where tools is not tissue_tool_count(). tissue_tick and tissue_tick_aged are
 * for sessions of one tool. */
TISSUE_API tissue_status tissue_tick_tools(tissue_session *session, int tools, const double *position_m, const double *age_s, double elapsed_s, double *force_N, tissue_status *status);

/* Selects the tool (0 at the start) on which tissue_set, tissue_clutch, tissue_grasp, tissue_read_contact, tissue_read_limits,
 * tissue_count and tissue_energy act from now on. A copy and tissue_take_over keep the selection. Both tools share the
 * counts ticks, folded, unstable and lost_ms, and the energies kinetic, stored and dissipated. */
TISSUE_API tissue_status tissue_use_tool(tissue_session *session, int tool);
TISSUE_API int tissue_tool_count(const tissue_session *session); /* 0 for NULL */

/* Puts the tissue to rest. Every tool must be outside once before it has force again. */
TISSUE_API tissue_status tissue_reset(tissue_session *session);

/* ---- while a session runs */

/* Sets one option that may change while a session runs (OPTIONS.md: offset, rotation, axes, scale, force-scale,
 * friction, device-mass, ...). Before the first tick it also sets limits of the device (force-max, slew, speed-max,
 * stale, passivity), so that each of two tools can have its own. After a change that moves the tool in the tissue by
 * more than speed-max times dt, the tool must be outside once. A refused value changes nothing. */
TISSUE_API tissue_status tissue_set(tissue_session *session, const char *name, const char *value);

/* on: the hand moves while the tool stays, without force, and the offset follows. Off: the tool moves with the hand
 * again, from where it is. */
TISSUE_API tissue_status tissue_clutch(tissue_session *session, int on);

/* on: the tool grasps the tissue that it touches, which then follows it in every direction without slip. The
 * grasp begins in the next tick if the tool presses the tissue in that tick. Otherwise, and after a release, set on to 0
 * for one tick and then to 1. It is released when on is 0; when the force on the tissue exceeds option "grasp-max" or,
 * where that is finite, reaches the device's limit (count "let_go"); with a fault or a reset; and after a late tick. The
 * heuristic mesh in the plane is not grasped. TISSUE_MISMATCH: spring sets, and in space a ball, or a contact that was
 * not trained to be pulled (term contact.compression of its study). RESULTS.md compares a model with
 * finite elements that pull. */
TISSUE_API tissue_status tissue_grasp(tissue_session *session, int on);

/* Continue with another model at the same hand, without a jump of force.
 *
 * tissue_follow begins a session of a model with as many axes, and leads its tool to where the tool of `leader` is.
 * This takes some hundred ticks, longer than a device can wait: call it in another thread, with a copy of the running
 * session (tissue_copy). tissue_take_over then replaces the running session `from`, between two ticks. Force, energy
 * given, options and counts continue; the difference of the two forces fades within some tenths of a second. Limits
 * (force-max, slew, speed-max, stale, hold, passivity), the stated properties of the device and the clock are those of
 * `from`. The session must not tick between tissue_follow and tissue_take_over.
 *
 * TISSUE_MISMATCH: another number of axes or tools; too stiff for the device; another shape where the tool is; dt above
 * half of hold; or the tool of `from` has begun another contact since tissue_follow. tissue_take_over allocates only
 * where it refuses. */
TISSUE_API tissue_status tissue_follow(const tissue_model *model, const tissue_session *leader, tissue_session **session);
TISSUE_API tissue_status tissue_take_over(tissue_session *session, const tissue_session *from);

/* A session as a value: everything that changes while it runs, as bytes, for this version of the library on this
 * machine. A session of the same model continues from these bytes bit for bit. tissue_state_size: in bytes; 0 for NULL;
 * constant as long as the session has the same model. */
TISSUE_API size_t tissue_state_size(const tissue_session *session);
TISSUE_API tissue_status tissue_save(const tissue_session *session, void *state, size_t size);
/* TISSUE_MISMATCH: bytes of another model, or damaged. The checksum finds accidental damage only: do not pass bytes
 * from an untrusted source. A session that has ticked keeps its own limits (force-max, ..). The force is the saved one,
 * limited to this session's force-max: with a hand on the device, restore only at the hand's position when it was
 * saved. In the next tick the library's own clock assumes dt */
TISSUE_API tissue_status tissue_restore(tissue_session *session, const void *state, size_t size);

/* A new session that continues from the present state of this one. By the library's clock its next tick is timed from
 * the last tick of this session. */
TISSUE_API tissue_status tissue_copy(const tissue_session *session, tissue_session **copy);

/* ---- constant properties */

TISSUE_API int tissue_dimension(const tissue_session *session);           /* D; 0 for NULL, as are all counts */
TISSUE_API int tissue_node_count(const tissue_session *session);          /* N */
/* F, facets of the surface: segments in the plane, triangles in space */
TISSUE_API int tissue_facet_count(const tissue_session *session);
/* radius of the selected tool (tissue_use_tool) in space [m], as option tool or else the model defines it; 0 in the
 * plane and for NULL */
TISSUE_API double tissue_tool_radius(const tissue_session *session);
/* of the selected tool: "disc" or "ball"; "" in the plane and for NULL */
TISSUE_API const char *tissue_tool_shape(const tissue_session *session);
TISSUE_API const char *tissue_study(const tissue_session *session);       /* "" for NULL; valid until tissue_close */

/* Node numbers of each facet (F times D). In space they are counter-clockwise seen from outside; in the plane the
 * tissue is on the left. */
TISSUE_API tissue_status tissue_facets(const tissue_session *session, int *nodes);

/* Node positions at rest [m] (N times D). Nodes of no facet are inside. For a solid embedded in a lattice the last
 * nodes are those of the lattice, some of them outside the tissue: draw facets. */
TISSUE_API tissue_status tissue_rest_positions(const tissue_session *session, double *position_m);

/* ---- state after the last tick */

/* Node positions [m] (N times D), for drawing. In space, while the tool touches, surface nodes within 2.5 tool radii
 * follow the tool (lib/springs/skin.h). Where two tools are that near, the second is applied last. Draw the tool's
 * centre at the contact point at rest plus `displacement_m` of tissue_read_contact. Not thread-safe: one thread at a
 * time per session. */
TISSUE_API tissue_status tissue_positions(const tissue_session *session, double *position_m);

/* ---- surfaces in space that move with the tissue, by name. "boundary": the model's own triangles. "nodule": the
 * surface of the inclusion, where the model has it. Others are added by tissue_add_surface, such as that of the organ.
 * They serve engines that keep their own meshes (a mapping in SOFA, a Mesh in Unity): vertex v of a surface stays
 * vertex v. None in the plane. A copy of a session keeps them; a session made by tissue_follow has those of its own
 * model, and others must be added again. Not thread-safe: one thread at a time per session. */

/* Adds the surface of a file (.stl, .obj, .ply, .off, .glb, ..) under a new name. unit_m: unit of the file's numbers
 * [m]. It reads and allocates: do not call it in the loop. TISSUE_BAD_FILE: the file cannot be read. TISSUE_MISMATCH:
 * the surface is farther from the tissue than a tenth of the tissue's size, or the name is in use. */
TISSUE_API tissue_status tissue_add_surface(tissue_session *session, const char *name, const char *file, double unit_m);

/* Numbers of points and triangles of a surface; 0 where no surface has this name. */
TISSUE_API int tissue_surface_points(const tissue_session *session, const char *name);
TISSUE_API int tissue_surface_triangles(const tissue_session *session, const char *name);

/* Triangles (three point numbers each, normals outward) and point positions after the last tick [m] (three numbers
 * each). Either pointer may be NULL. */
TISSUE_API tissue_status tissue_surface(const tissue_session *session, const char *name, int *triangles, double *position_m);

typedef struct tissue_contact {
    /* mesh in contact: 0 the trained one, 1 the heuristic one; -1 none, and the other members have no meaning */
    int mesh;
    int facet;                 /* facet of the surface that is touched */
    double weight[3];          /* barycentric weights of its nodes at the contact */
    double displacement_m[3];  /* of the touched point of the trained mesh; for an energy model, of the tool */
    double force_N[3];         /* of the tool on the tissue; for an energy model at most force-max / force-scale */
    int slipping;              /* 1 where the contact slipped along the surface in this tick */
    int grasped;               /* 1 while the tool holds the tissue (tissue_grasp) */
} tissue_contact;

/* size: sizeof *contact */
TISSUE_API tissue_status tissue_read_contact(const tissue_session *session, tissue_contact *contact, size_t size);

/* The stiffness in use: the name of the selected spring set (the first one before any contact), or "law" for an energy
 * model. Valid until tissue_close. */
TISSUE_API const char *tissue_stiffness(const tissue_session *session);

/* A count of the session by name: ticks, folded, unstable, not_yet_outside, let_go, bad_input, jumps, stale, late,
 * clamped, slewed, damped, capped, lost_ms. */
TISSUE_API tissue_status tissue_count(const tissue_session *session, const char *name, long long *count);

/* Number of ticks in which each limit acted on the force so far, and the time by which the tissue did not advance. */
typedef struct tissue_limits {
    long long clamped; /* limited to force-max */
    long long slewed;  /* rise of the force limited to slew */
    long long damped;  /* damped by the passivity controller */
    long long capped;  /* limited by the bound on energy */
    long long late;    /* so late that the device had released its force: the force started from zero */
    double lost_s;
} tissue_limits;

/* size: sizeof *limits */
TISSUE_API tissue_status tissue_read_limits(const tissue_session *session, tissue_limits *limits, size_t size);

/* An energy of the session's log [J] by name. given: to the hand since the start (negative: the hand gave energy).
 * observed, bound: E and r B of the passivity observer (lib/haptic/safety.h). kinetic: of the tissue. friction:
 * dissipated between tool and tissue. stored, dissipated: in the Maxwell branches of a model that relaxes, if it was
 * opened with "energy-book" "yes"; else 0. */
TISSUE_API tissue_status tissue_energy(const tissue_session *session, const char *name, double *energy_J);

#ifdef __cplusplus
}
#endif
#endif
