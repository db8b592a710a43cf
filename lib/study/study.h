#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "field.h"
#include "mesh/inclusion.h"
#include "mesh/spring_mesh.h"
#include "study/second_tool.h"

namespace tissue {

/// One straight push on one contact, from rest to the deepest magnitude.
struct StudyPath {
    std::string name;           ///< file name of its results: lower-case letters, digits, '-'
    Point contact_m;            ///< position on the outline, in space on the surface [m] (D)
    Point direction;            ///< unit vector of the push (D)
    double depth_m = 0;         ///< how deep it goes; 0: to the largest magnitude
    double radius_m = 0;        ///< of the disc that pushes; in space
    std::optional<SecondTool> second = {};  ///< a second disc that pushes at once; in space, on a block
};

/// A part of the instantaneous modulus that goes with time, as exp(-t / tau).
struct Branch {
    double share;  ///< of the instantaneous modulus
    double tau_s;
};

/// Everything a study file (fem/studies/NAME.toml) says. Every key is listed in results/FORMATS.md.
struct Study {
    std::string name;  ///< the file's name without its ending
    std::string file;

    struct Geometry {
        double width_m, height_m, thickness_m;  ///< width and height are the block's; thickness of a solid: 1, so that
                                                ///< E t is E
        double length_m = 0;              ///< of a solid block, along y, between width along x and height along z; 0: the plane
        bool solid = false;               ///< whether a shape is one in space
        std::string shape;                ///< mesh or outline file of any other tissue; empty for the block
        double unit_m = 1;                ///< that file's unit of length
        std::vector<std::string> fixed;   ///< names of its physical curves, in space surfaces, that are held
        std::vector<double> bed_Pa_m;     ///< in space, of each of those the stiffness per area of the bed that it lies on [Pa/m]; 0: it does not move. Empty: none does
        std::vector<double> beds_Pa_m() const;  ///< the beds there are, each stiffness once
        std::vector<int> beds() const;          ///< which of them each of `fixed` lies on, from 1; 0: none. Empty: none does
        bool is_block() const { return shape.empty(); }
        bool is_solid() const { return length_m > 0 || solid; }
    } geometry;

    /// What a law needs to know, of the base material or of a region. Moduli are instantaneous, whatever the file says.
    struct LawParameters {
        double C1_Pa = 0, C2_Pa = 0;       ///< Mooney-Rivlin
        std::vector<double> mu_Pa, alpha;  ///< Ogden, one entry a term
        std::vector<double> share = {};    ///< of the instantaneous modulus, one entry a branch of the material; empty: elastic

        /// Small-strain Young's modulus [Pa]: E = 6 (C1 + C2), or E = 3 mu with 2 mu = sum mu_k alpha_k.
        double youngs_modulus_Pa() const;
        /// C2 / (C1 + C2). Of Ogden's law that of the Mooney-Rivlin material whose force in uniaxial tension has the same curvature at rest, within 0 .. 1: with
        /// c = sum mu_k alpha_k (alpha_k / 4 - 3/2) / sum mu_k alpha_k, which C1 alone makes -1 and C2 alone -2, it is -1 - c.
        double second_share() const;
    };
    struct Region : LawParameters {
        std::string name;  ///< physical surface of the shape's file
    };
    struct Material : LawParameters {
        std::string law;  ///< mooney-rivlin, neo-Hookean (C2 = 0) or ogden
        double density_kg_m3;
        std::string formulation;  ///< plane-stress or plane-strain; of a solid incompressible
        std::vector<Region> regions;  ///< of the same law, in alphabetical order
        std::vector<Branch> viscosity;  ///< ascending tau; `share` of regions and the nodule is of the same taus; empty: elastic
        bool long_term = false;         ///< whether the file's moduli are what is left after all time
        bool fits_shares = false;       ///< measured histories say the shares: those of viscosity are 0, and without taus there either is it empty

        std::vector<std::string> region_names() const;
        bool relaxes() const { return fits_shares || !viscosity.empty(); }
    } material;

    /// A part of other material inside a solid.
    struct Nodule : LawParameters {
        Inclusion inclusion;
        std::string shape;  ///< file of its surface, in the unit of the shape's; empty of a ball
    };
    std::optional<Nodule> nodule;

    /// Straight pushes of one depth all over a solid's top, at every x and every y: what a nodule feels like. Nothing is trained on
    /// them.
    struct Map {
        double depth_m;
        std::vector<double> x_m, y_m;  ///< ascending, two at least
    };
    std::optional<Map> map;

    std::vector<int> cells = {0, 0};  ///< of the block's spring lattice, along x and y, of a solid z too
    double spring_size_m = 0;  ///< sides of the triangles or tetrahedra that gmsh fills an outline or a surface with, in the plane the springs; 0 for a shape that is a mesh

    /// Measured contact forces in place of finite elements.
    struct Data {
        std::string file;             ///< CSV (results/FORMATS.md), found from the study's folder
        std::string histories;        ///< CSV of the tool in time, likewise; empty: none
        unsigned long seed;           ///< of the split, where the CSV makes none itself
        double validation_part, held_out_part;  ///< of the contacts
        double surface_tolerance_m;   ///< how far a contact may lie off the outline
        std::optional<double> stated_force_noise;  ///< relative, of a component; serves where nothing is repeated
    };
    std::optional<Data> data;         ///< absent: the cases are FE's; what follows, down to `springs`, says how

    int refine = 0;          ///< finite elements along a lattice cell's, or a spring's, side; of a solid 0
    std::array<double, 2> sizes_m{};  ///< of a solid's finite elements, at the contact and far from it

    struct Indenter {
        std::string kind;      ///< point: one FE node; patch: all boundary points within half_width_m move alike; disc: of a
                               ///< solid's top, all within radius_m
        double half_width_m = 0;  ///< of a patch, along the boundary; 0 for a point
        double radius_m = 0;      ///< of a disc; a contact may have another one (StudyPath::radius_m)

        /// Least distance [m] of a contact from the edge of the free surface: of a disc's middle from every wall; in the plane along the
        /// surface from the fixed edge, of a patch three half widths up to 15 mm, and its half width where that is more; of a point 15 mm.
        double clearance_m() const { return clearance_m(radius_m); }
        double clearance_m(double disc_radius_m) const;

        /// How large a disc is over the study's own. Depths, records' steps and near elements of its contacts are as many times larger.
        double times(double disc_radius_m) const { return kind == "disc" ? disc_radius_m / radius_m : 1; }
    } indenter;

    struct Solver {
        double tolerance = 0;
        int max_newton = 0;
    } solver;

    struct Loads {
        std::vector<double> magnitudes_m;  ///< ascending; every one a record
        double record_step_m = 0;
        std::vector<StudyPath> paths;      ///< listed one by one; empty when swept; of a solid block: every push of
                                           ///< its contacts; of a solid shape empty

        /// Training contacts all along the free surface, in place of a list.
        struct Sweep {
            double spacing_m;              ///< between contacts, along the surface; 0 where they are listed
            double clearance_m;            ///< of the first and the last from the fixed edge
            std::vector<double> angles_deg;  ///< of the pushes off the inward normal, ascending
            std::vector<double> arcs_m = {};  ///< listed places along the surface, ascending; on the block each stands
                                              ///< for its mirror image too
        };
        std::optional<Sweep> sweep;

        using Pushes = std::vector<std::array<double, 2>>;  ///< tilt off the inward normal, and azimuth about it [degrees]

        /// A training contact on a solid shape, whose surface is known once it is meshed: cases/solid_training.h.
        struct Contact {
            Point at_m;  ///< (3), near the surface
            Pushes pushes_deg;
            double depth_m, radius_m;
        };
        std::vector<Contact> contacts;

        /// Training contacts all over a solid shape, in place of a list.
        struct Spread {
            int count;
            double clearance_m;  ///< from where the surface ends or turns
            Pushes pushes_deg;   ///< azimuths turn from contact to contact
            int pushes_each;     ///< of pushes_deg, which the contacts take in turn
            std::vector<double> radii_m = {};  ///< of discs, which the contacts take in turn; empty: of the study's own
        };
        std::optional<Spread> spread;

        std::size_t path_count() const;  ///< training paths of a solid
        double depth_m() const { return magnitudes_m.back(); }
        int records() const;  ///< after the one at rest
    } loads;

    struct Springs {
        std::string topology, law;       ///< of a stiffness that is a law: geometric, springs that turn
        std::string stiffness;           ///< sets: one theta a load case; law: an energy (springs/energy_law.h)
        std::vector<std::string> terms;  ///< of a law
        double spacing_m = 0;            ///< of an embedded lattice
        double area_cap_E2 = 0;          ///< of a law: what its cells stay below
        bool hookean = true;             ///< of a law: springs are Hooke's, not the material's own (springs/spring_curve.h)
        bool is_law() const { return stiffness == "law"; }
    } springs;

    /// Contacts drawn by seed before any solve, between the trained ones: to choose with, or to prove with.
    struct Draws {
        std::string role;                  ///< validation, held_out or held_out_full; of a solid held_out_WORD too
        unsigned long seed;
        int count;
        double depth_m[2];                 ///< range of the push
        double max_angle_deg;              ///< off the inward normal; in the plane
        double tilt_deg[2] = {0, 0};       ///< of a solid: range off the inward normal,
        double clearance_m[2] = {0, 0};    ///< and of the distance from the nearest wall;
        std::vector<double> radii_m = {};  ///< and discs, which the contacts take in turn;
        double pair_apart_m[2] = {0, 0};   ///< of a block in space: range of the distance from a first disc to a second one pushed at once; 0: no second
        bool of_pairs() const { return pair_apart_m[1] > 0; }
    };
    std::vector<Draws> draws;

    /// Courses of the tool in time, each on a contact drawn as above; nothing of the law is trained on them. Every stroke, from rest to
    /// rest, is a minimum-jerk polynomial (cases/course.h). Of a kind that has no such thing a field is 0.
    struct Histories : Draws {             ///< role: validation, held_out or train; max_angle_deg and so on as there
        std::string name;                  ///< its courses are NAME-0001, ...
        std::string kind;                  ///< ramp, release, sine, poke, again or file
        double rise_s[2];                  ///< range of a stroke's time, drawn log-uniformly: ramp, release, poke, again
        double hold_s;                     ///< at the end of a stroke: ramp, release, again
        double frequency_Hz[2];            ///< range, drawn log-uniformly: sine
        double duration_s;                 ///< sine, poke
        double wander_deg;                 ///< poke: how far a stroke's direction strays from the first's
        double apart_m;                    ///< again, in the plane: along the surface, from the first touch to the second
        std::string file;                  ///< of the course, CSV (results/FORMATS.md): file
        Point contact_m;                   ///< (D): file
    };
    std::vector<Histories> histories;
    double check_fraction = 0;             ///< of listed paths, or of held_out contacts, solved again on a finer mesh
    int check_refine = 0;                  ///< that mesh's `refine`; 0: none
    std::array<double, 2> check_sizes_m{};  ///< of a solid: that mesh's `sizes_m`; 0: none

    struct Training {
        std::string optimizer;
        std::vector<std::string> also;  ///< other optimisers, trained and evaluated for comparison
        std::string objective;             ///< force: (9); contact: the force the contact itself carries
        double ridge;                      ///< towards the heuristic; 0: none
        unsigned long seed;
        int iterations;
        std::optional<double> max_seconds, target_rel_loss;  ///< stop criteria of Fig. 5
        double k_min_E2, k_max_E2;
        double weight_near[2], weight_far[2];
        double force_scale, shape_scale;   ///< of a law: relative errors that count 1 (train/train_law.h); then `ridge`,
        int starts;                        ///< the first at the heuristic, and `seed` count too, and nothing above
    } training;

    /// The law with something else in it, for comparison on the same contacts. Absent keys are the study's.
    struct Variant {
        std::string name;
        std::vector<std::string> terms;    ///< of the study's the first few
        double area_cap_E2, shape_scale;
        std::vector<double> arcs_m;        ///< of the training contacts kept; empty where the sweep has a spacing: all
        std::vector<double> angles_deg;    ///< of the pushes kept
        std::vector<double> magnitudes_m;  ///< of the load cases kept
        int first_paths = 0;               ///< of a solid: training paths kept, in the study's order; 0: all
    };
    std::vector<Variant> variants;

    /// The study itself, among its variants.
    Variant whole() const;

    /// Of the block's springs.
    Lattice lattice() const;

    /// E2 = E t [N/m], the two-dimensional Young's modulus of (7).
    double modulus_N_m() const { return material.youngs_modulus_Pa() * geometry.thickness_m; }

    /// The other reading of (7)'s E2, (C1 + C2) t; E t / 6 for a law that has no C1 and C2.
    double second_modulus_N_m() const {
        const double sum = material.alpha.empty() ? material.C1_Pa + material.C2_Pa : material.youngs_modulus_Pa() / 6;
        return sum * geometry.thickness_m;
    }
};

/// Reads a study and what it is based on, and checks every key and value.
/// Throws StudyError with file, line, key and what is allowed; FileError when a file cannot be read.
Study read_study(const std::string& file);

}  // namespace tissue
