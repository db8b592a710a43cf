/* tissue.h: soft tissue under a tool, for programs that have a loop of their own.
 *
 *   tissue_session *tissue = NULL;
 *   if (tissue_open("model.h5", NULL, &tissue) != TISSUE_OK) puts(tissue_error());
 *   while (running) tissue_tick(tissue, position_m, -1, force_N);   (-1: time as the library's own clock has it)
 *   tissue_close(&tissue);
 *
 * SI units. A model has D = 2 or 3 axes; a device has always three, of which a model in the plane takes the first two
 * (option "axes"). Arrays of nodes are N times D doubles, node after node.
 *
 * Errors: every function that can fail returns a tissue_status and leaves its results as they were, but ticks, whose force is then zero.
 * tissue_error() is then one line that says what, in the calling thread; ticks alone leave it as it was, since a thread's first line takes memory:
 * tissue_status_text() says what its status is. No function throws, aborts or prints.
 *
 * Threads: a session belongs to one thread at a time; who hands it over does so between two calls. Sessions know nothing of
 * each other, also those of one model, which never changes. tissue_tick, tissue_tick_aged, tissue_tick_tools, tissue_use_tool, tissue_reset, tissue_clutch, tissue_save, tissue_take_over and everything that only reads take no lock, allocate nothing and never wait, so
 * that they may run at 1 kHz and above. What opens, closes, copies, restores, sets or follows allocates, and belongs between two ticks.
 *
 * Closing sets the caller's pointer to NULL, and closing NULL does nothing: closing twice is harmless. A second copy of the pointer is the caller's own to forget.
 *
 * Links: -ltissue alone (pkg-config tissue-c). Symbols are versioned (TISSUE_1); what has been in a release stays. A struct may get more members at its end: a call that fills one takes sizeof of the
 * caller's own and writes so many bytes; one that is smaller than the struct of the first release is refused (TISSUE_BAD_ARGUMENT). What the library does not know yet is zero.
 */
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
    TISSUE_BAD_ARGUMENT = 1, /* a null pointer, an index that is none, an option that there is not or of another kind */
    TISSUE_BAD_FILE = 2,     /* no model, or none that can be read */
    TISSUE_MISMATCH = 3,     /* options that do not fit each other or the model */
    TISSUE_FAULT = 4,        /* of a tick: the position was refused (not finite, too fast, too old); the force is zero */
    TISSUE_FAILED = 5,       /* memory has run out, or another failure that tissue_error() names */
    TISSUE_NOT_ARMED = 6,    /* of a tick: the tool is inside tissue and has not been outside since the start, a fault or a reset; the force is zero */
    TISSUE_FOLDED = 7,       /* of a tick: a surface crosses itself, or two meshes lie over each other; the force is zero */
    TISSUE_DIVERGED = 8,     /* of a tick: a mesh flew apart, or came to rest inside out, and was put to rest; the force is zero */
    TISSUE_OVERRUN = 9,      /* of a tick: time was lost, as elapsed_s was more than can be made up for, or ticks cost more than their time; the force is the tissue's, as of TISSUE_OK. TISSUE_LATE where both are so */
    TISSUE_LATE = 10         /* of a tick: it came so late that the device had let go of the force, which rises from zero again, by slew and as far as the bound on energy permits; time may be lost in it too (lost_ms) */
} tissue_status;

/* One line that says what a status is. */
TISSUE_API const char *tissue_status_text(tissue_status status);

/* "0.1.0" */
TISSUE_API const char *tissue_version(void);

/* What the last failure in this thread was, one line; "" before the first. Valid until the next one. */
TISSUE_API const char *tissue_error(void);

/* Opens a model.h5 of tissuectl train or adapt. options: "name", "value", "name", "value", ..., NULL; or NULL. OPTIONS.md (share/doc/tissuectl) has their
 * names, units, defaults and ranges. Yes or no is "yes" or "no".
 * A value out of its range, and an option that would do nothing with this model, is TISSUE_MISMATCH. */
TISSUE_API tissue_status tissue_open(const char *model_file, const char *const *options, tissue_session **session);

TISSUE_API void tissue_close(tissue_session **session);

/* The same in two: a model is opened once, with the options that its sessions begin with, and serves any number of them. They keep what they need of it: it may be closed before they are. */
TISSUE_API tissue_status tissue_open_model(const char *model_file, const char *const *options, tissue_model **model);
TISSUE_API tissue_status tissue_begin(const tissue_model *model, tissue_session **session);
TISSUE_API void tissue_close_model(tissue_model **model);

/* One step of dt: where the device is [m], and the force that it puts on the hand [N]. elapsed_s: since the last tick, as the clock says; 0: dt, so where a measured difference is 0, pass -1; negative or not finite: the host does not
 * know, and the library's own clock tells (of the first tick: dt). The tissue goes through that time, whatever the rate, and the force is the same at any from 50 Hz to 8 kHz (of a hand that rests; while it moves the tool is led one period ahead), with hold "inf" from 10 Hz at an even rate; a stall of more than
 * half a second is lost to it (TISSUE_OVERRUN, or TISSUE_LATE where the device had let go meanwhile; count "lost_ms", tissue_read_limits). Where ticks take longer than the time that they go through, the tissue runs slower than the clock, and lost_ms
 * counts by how much; where they take more than half of it, a stall is not made up for. That needs an elapsed_s that is the system's clock, taken right before the tick, over some fifty ticks, or five between
 * which it changes by a tenth: a host that plays another time loses none, unless its ticks take that time to some tenths of a percent, and one that keeps up loses none while its periods stray by less than a tenth.
 * A force that the device still holds after option "hold" (0.05 s) is in no energy log: a host whose ticks may stall sees to it that the device lets go, or sets hold to "inf". A tick that comes
 * later than half of it, 0.025 s, begins at zero force, and rises by slew and as far as the bound on energy permits (TISSUE_LATE; limits' `late` counts it): 50 Hz, with a clock that strays by 5 ms, is the slowest rate by default. That long a hold has a price. The energy that the port may give is bounded by r force-max speed-max dt: r is 1
 * while ticks come every dt with positions of their own (0.0066 J by default), and at most hold / dt after a stall (0.33 J; with hold 0.01, which serves hosts from 200 Hz on, 0.066 J), (hold + stale) / dt of
 * positions that are given with an age (0.66 J). tissue_energy "bound" is the bound as it is now. Energy given leaves that account with a time constant of 5 s, so that over a long time r times 1.3 mW may go out besides.
 * The force is finite and within force-max whatever comes in, and zero where the status is none of TISSUE_OK, TISSUE_LATE and TISSUE_OVERRUN, also where an argument is refused. What it gives the hand is
 * bounded for every device (lib/haptic/safety.h); that a hand comes to rest on the tissue is promised for a device whose mass is stated, option "device-mass", and whose positions come with every
 * tick, every dt, at most half of dt old (tissue_tick_aged); at one dt a device of 45 g may swing. The thread's floating-point mode (rounding, traps, denormals) is set for the tick, and after it is
 * as it was. */
TISSUE_API tissue_status tissue_tick(tissue_session *session, const double position_m[3], double elapsed_s, double force_N[3]);

/* The same for a device whose positions come less often than ticks: age_s is how long ago this one was measured; a position that is given again has grown older by
 * as much as has passed. The hand's speed is then judged by the time between two measurements. A position older than option "stale", or whose age is no number, is refused; a negative age is 0. */
TISSUE_API tissue_status tissue_tick_aged(tissue_session *session, const double position_m[3], double age_s, double elapsed_s, double force_N[3]);

/* ---- two tools (option "tools" "2"): two devices on one tissue, each with its own energy log and safety. Options of tissue_open are of both at first. */

/* One tick of both: positions and forces are three numbers a tool, one tool after the other; age_s one number a tool, as of tissue_tick_aged, or NULL: just measured. A tool that is refused, or
 * has not been outside yet, has no force, and the other one goes on; TISSUE_FOLDED, TISSUE_DIVERGED and tissue_reset stop both. status: what the tick came to for each tool, or NULL. Returns the first of them that is without force, else the first that is not TISSUE_OK. TISSUE_BAD_ARGUMENT, with zero forces (of 64 tools at most): tools is not tissue_tool_count(). tissue_tick and tissue_tick_aged are of sessions of one tool. */
TISSUE_API tissue_status tissue_tick_tools(tissue_session *session, int tools, const double *position_m, const double *age_s, double elapsed_s, double *force_N, tissue_status *status);

/* Which tool, 0 at the start, tissue_set, tissue_clutch, tissue_read_contact, tissue_read_limits, tissue_count and tissue_energy act on from now on. A copy and tissue_take_over keep it. Shared by
 * both tools are the counts ticks, folded, unstable and lost_ms, and the energies kinetic, stored and dissipated. */
TISSUE_API tissue_status tissue_use_tool(tissue_session *session, int tool);
TISSUE_API int tissue_tool_count(const tissue_session *session); /* 0 of NULL */

/* The tissue to rest; every tool must be outside once before it has force again. */
TISSUE_API tissue_status tissue_reset(tissue_session *session);

/* ---- while it runs */

/* One option that may change while a session runs (OPTIONS.md: offset, rotation, axes, scale, force-scale, friction, device-mass, ...); before its first tick also a limit of the device
 * (force-max, slew, speed-max, stale, passivity), so that each of two tools has its own. A change that moves the
 * tool in the tissue by more than a hand does in a tick is a new start: the tool must be outside once. Refused values leave everything as it was. */
TISSUE_API tissue_status tissue_set(tissue_session *session, const char *name, const char *value);

/* on: the hand moves and the tool stays, without force; the offset follows. Off: the tool goes on from there. */
TISSUE_API tissue_status tissue_clutch(tissue_session *session, int on);

/* Another model at the same hand, without a jump of force. tissue_follow begins a session of a model of as many axes whose tool is led to where the tool of `leader` is: some hundred ticks,
 * for which no device can wait, so in another thread, with a copy of the session that plays (tissue_copy). tissue_take_over then puts it in the place of the one that plays, between two
 * ticks: force, energy given, options and counts go on, and what forces differ by fades within some tenths of a second. TISSUE_MISMATCH: of another number of axes, too stiff for the
 * device, or of another shape where the tool is, or of a dt above half of hold; and where the tool that plays has begun another contact since it was followed. Limits (force-max, slew, speed-max, stale, hold, passivity), what is known of the device, and the clock are those of the one that
 * plays. A session that is to take over has ticked no more since tissue_follow. tissue_take_over allocates nothing but where it refuses. */
TISSUE_API tissue_status tissue_follow(const tissue_model *model, const tissue_session *leader, tissue_session **session);
TISSUE_API tissue_status tissue_take_over(tissue_session *session, const tissue_session *from);

/* A session as a value: all that changes while it runs, as bytes, for this version of the library on this machine. A session of the same model goes on from them bit for bit. */
TISSUE_API size_t tissue_state_size(const tissue_session *session); /* bytes; 0 of NULL; the same for the session's whole life with one model */
TISSUE_API tissue_status tissue_save(const tissue_session *session, void *state, size_t size);
TISSUE_API tissue_status tissue_restore(tissue_session *session, const void *state, size_t size); /* TISSUE_MISMATCH: of another model, or damaged; not for bytes of strangers. The limits (force-max, ..) of a session that has ticked stay its own. The force is the saved one, cut to this session's force-max: with a hand on the device, restore where it was; of the first tick after it the library's own clock knows dt alone */

/* Another session that goes on as this one does; its next tick comes, by the library's clock, after the last one of this. */
TISSUE_API tissue_status tissue_copy(const tissue_session *session, tissue_session **copy);

/* ---- what stays as it is */

TISSUE_API int tissue_dimension(const tissue_session *session);           /* D; 0 of NULL, as all counts */
TISSUE_API int tissue_node_count(const tissue_session *session);          /* N */
TISSUE_API int tissue_facet_count(const tissue_session *session);         /* F of the surface: segments in the plane, triangles in space */
TISSUE_API double tissue_tool_radius(const tissue_session *session);      /* of the tool that presses tissue in space [m], as option tool has it or else the model; 0 in the plane, and of NULL */
TISSUE_API const char *tissue_tool_shape(const tissue_session *session);  /* "disc" or "ball"; "" in the plane, and of NULL */
TISSUE_API const char *tissue_study(const tissue_session *session);       /* "" of NULL; valid until tissue_close */

/* Node numbers of each facet (F times D), in space counter-clockwise seen from outside, in the plane the tissue on the left. */
TISSUE_API tissue_status tissue_facets(const tissue_session *session, int *nodes);

/* Where nodes are without the tool [m] (N times D). Nodes of no facet lie inside; of a solid in an embedded lattice the last of them are the lattice's, outside the tissue too: draw facets. */
TISSUE_API tissue_status tissue_rest_positions(const tissue_session *session, double *position_m);

/* ---- as the last tick has left it */

/* Where nodes are [m] (N times D). In space, while the tool touches, nodes of the surface within 2.5 radii of it follow the tool (lib/springs/skin.h), of two tools the second where they are that near: the surface to draw, with the
 * tool's middle at `displacement_m` of tissue_read_contact from the contact's place at rest. One thread at a time calls it for a session. */
TISSUE_API tissue_status tissue_positions(const tissue_session *session, double *position_m);

/* ---- surfaces in space that move with the tissue, by name: "boundary", the model's own triangles; "nodule", of the other material in it, where the model has its surface; and those that
 * tissue_add_surface adds, such as the organ's own. For engines that keep meshes of their own (a mapping in SOFA, a Mesh in Unity): point v of a surface stays point v. None in the plane. A copy has them; a session that
 * follows another (tissue_follow) has its own model's, and gets others anew. One thread at a time for a session. */

/* Adds the surface of a file (.stl, .obj, .ply, .off, .glb, ..) under a name of its own; unit_m: of the file's numbers [m]. Not in the loop: it reads and allocates. TISSUE_BAD_FILE,
 * TISSUE_MISMATCH: it lies farther from the tissue than a tenth of that, or the name is in use. */
TISSUE_API tissue_status tissue_add_surface(tissue_session *session, const char *name, const char *file, double unit_m);

/* How many points and triangles one has; 0 where there is none of this name. */
TISSUE_API int tissue_surface_points(const tissue_session *session, const char *name);
TISSUE_API int tissue_surface_triangles(const tissue_session *session, const char *name);

/* Its triangles, three points each, normals out; and where its points are [m], three numbers each, as the last tick has left them. Either may be NULL. */
TISSUE_API tissue_status tissue_surface(const tissue_session *session, const char *name, int *triangles, double *position_m);

typedef struct tissue_contact {
    int mesh;                  /* that the tool presses: 0 the learned one, 1 the heuristic; -1 none, and the rest means nothing */
    int facet;                 /* of the surface, */
    double weight[3];          /* and of its nodes */
    double displacement_m[3];  /* of the touched point of the learned mesh; of a law the tool's own */
    double force_N[3];         /* of the tool on the tissue; of an energy model at most force-max / force-scale */
    int slipping;              /* 1 where it went along the surface in this tick */
    int reserved;              /* 0: without it the struct would end in padding, which a new member would take */
} tissue_contact;

TISSUE_API tissue_status tissue_read_contact(const tissue_session *session, tissue_contact *contact, size_t size); /* sizeof *contact */

/* Which stiffness is at work: the name of the spring set that serves, "law" of a law, the first one before anything was touched. Valid until tissue_close. */
TISSUE_API const char *tissue_stiffness(const tissue_session *session);

/* Counts of the session by name: ticks, folded, unstable, not_yet_outside, bad_input, jumps, stale, late, clamped, slewed, damped, capped, lost_ms. */
TISSUE_API tissue_status tissue_count(const tissue_session *session, const char *name, long long *count);

/* What limits have done to the force so far, in ticks, and time that passed and that the tissue did not go through. */
typedef struct tissue_limits {
    long long clamped; /* at force-max */
    long long slewed;  /* rise of force cut to slew */
    long long damped;  /* the passivity controller at work */
    long long capped;  /* force cut to what the bound on energy leaves */
    long long late;    /* so late that the device had let go: the force began at zero */
    double lost_s;
} tissue_limits;

TISSUE_API tissue_status tissue_read_limits(const tissue_session *session, tissue_limits *limits, size_t size); /* sizeof *limits */

/* The energy log [J] by name: given (to the hand since the start; below 0: the hand gave), observed and bound (of the passivity observer: E and r B in lib/haptic/safety.h),
 * kinetic (of the tissue), friction (dissipated between tool and tissue), and of a tissue that relaxes, opened with "energy-book" "yes", stored and dissipated in its branches; 0 otherwise. */
TISSUE_API tissue_status tissue_energy(const tissue_session *session, const char *name, double *energy_J);

#ifdef __cplusplus
}
#endif
#endif
