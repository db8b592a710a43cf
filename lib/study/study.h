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

/// One straight indentation at one contact, from rest to its largest depth.
struct StudyPath {
    std::string name;      ///< file name of its results: lower-case letters, digits, '-'
    Point contact_m;       ///< position on the outline, in space on the surface [m] (D)
    Point direction;       ///< unit vector of the tool displacement (D)
    double depth_m = 0;    ///< largest tool displacement; 0: the largest of Loads::magnitudes_m
    double radius_m = 0;   ///< of the disc; in space
    std::optional<SecondTool> second = {};  ///< a second disc that indents at the same time; in space, on a block
};

/// A Maxwell branch of the material: its part of the instantaneous modulus decays as exp(-t / tau).
struct Branch {
    double share;  ///< relative modulus g: part of the instantaneous modulus [1]
    double tau_s;  ///< relaxation time
};

/// The contents of a study file (fem/studies/NAME.toml). results/FORMATS.md lists every key.
struct Study {
    std::string name;  ///< the file's name without its ending
    std::string file;

    struct Geometry {
        double width_m, height_m, thickness_m;  ///< width and height of the block; thickness is 1 for a solid, so that
                                                ///< E t is E
        /// Length of a solid block along y; its width is along x, its height along z. 0: the study is in the plane, or
        /// of a shape.
        double length_m = 0;
        bool solid = false;              ///< whether a shape is three-dimensional
        std::string shape;               ///< mesh or outline file of any other tissue; empty for the block
        double unit_m = 1;               ///< unit of length of that file [m]
        /// Its physical curves that are fixed; in space its physical surfaces, or regions of space.
        std::vector<std::string> fixed;
        /// In space: for each entry of `fixed`, stiffness per area of the elastic bed under it [Pa/m]; 0: rigid.
        /// Empty: all are rigid.
        std::vector<double> bed_Pa_m;
        std::vector<double> beds_Pa_m() const;  ///< the different stiffnesses above 0 [Pa/m], in the order of `fixed`
        /// For each entry of `fixed`, the number of its bed in beds_Pa_m(), from 1; 0: rigid. Empty: all are rigid.
        std::vector<int> beds() const;
        bool is_block() const { return shape.empty(); }
        bool is_solid() const { return length_m > 0 || solid; }
    } geometry;

    /// Constitutive parameters of the base material, of a region or of a nodule. Moduli are instantaneous, also where
    /// the file gives long-term ones.
    struct MaterialParameters {
        double C1_Pa = 0, C2_Pa = 0;       ///< Mooney-Rivlin
        std::vector<double> mu_Pa, alpha;  ///< Ogden, one entry a term
        std::vector<double> share = {};    ///< relative modulus of each Maxwell branch of the material; empty: elastic

        /// Small-strain Young's modulus [Pa]: E = 6 (C1 + C2), or E = 3 mu with 2 mu = sum mu_k alpha_k.
        double youngs_modulus_Pa() const;
        /// C2 / (C1 + C2), from 0 to 1. For Ogden's law it is that of the Mooney-Rivlin material whose force in
        /// uniaxial tension has the same curvature at rest, clamped to 0 .. 1. It is -1 - c, where
        ///   c = sum mu_k alpha_k (alpha_k / 4 - 3/2) / sum mu_k alpha_k
        /// is -1 for C1 alone and -2 for C2 alone.
        double second_share() const;
    };
    struct Region : MaterialParameters {
        std::string name;  ///< physical surface of the shape's file; in space a physical volume
    };
    struct Material : MaterialParameters {
        std::string law;  ///< material law: mooney-rivlin, neo-Hookean (C2 = 0) or ogden
        double density_kg_m3;
        std::string formulation;        ///< plane-stress or plane-strain; for a solid incompressible
        std::vector<Region> regions;    ///< with the same material law, in alphabetical order
        /// Maxwell branches of the base material, ascending tau; empty: elastic. `share` of the regions and of the
        /// nodule belongs to the same relaxation times.
        std::vector<Branch> viscosity;
        bool long_term = false;         ///< whether the file gives long-term moduli, in place of instantaneous ones
        /// Relative moduli are fitted to measured histories. Those of `viscosity` are then 0, and `viscosity` is empty
        /// where the relaxation times are fitted too.
        bool fits_shares = false;

        std::vector<std::string> region_names() const;
        bool relaxes() const { return fits_shares || !viscosity.empty(); }
    } material;

    /// An inclusion of another material in a solid.
    struct Nodule : MaterialParameters {
        Inclusion inclusion;
        std::string shape;  ///< file of its surface, in the same unit as the shape's file; empty for a ball
    };
    std::optional<Nodule> nodule;

    /// Indentations of one depth, straight in, at every x and every y of the top of a solid block. They show how the
    /// force varies over a nodule. Nothing is trained on them.
    struct Map {
        double depth_m;
        std::vector<double> x_m, y_m;  ///< ascending, at least two
    };
    std::optional<Map> map;

    std::vector<int> cells = {0, 0};  ///< cells of the block's lattice along x and y, for a solid also z
    /// Side of the triangles or tetrahedra with which gmsh fills an outline or a surface; in the plane they are the
    /// springs. 0 for a block, and for a shape that is a mesh already.
    double spring_size_m = 0;

    /// Measured contact forces in place of finite elements.
    struct Data {
        std::string file;             ///< CSV (results/FORMATS.md), found from the study's folder
        std::string histories;        ///< CSV of measured histories, found from the study's folder; empty: none
        /// Of the split into training, validation and test set, where the CSV has no roles.
        unsigned long seed;
        double validation_part, held_out_part;  ///< part of the contacts in the validation set and in the test set
        double surface_tolerance_m;   ///< largest distance of a contact from the outline
        /// Relative standard deviation of a force component; used where no indentation was repeated.
        std::optional<double> stated_force_noise;
    };
    std::optional<Data> data;  ///< absent: finite elements compute the cases, as the members from here to `loads` say

    int refine = 0;  ///< finite elements along the side of a lattice cell or along a spring; 0 for a solid
    std::array<double, 2> sizes_m{};  ///< size of a solid's finite elements, at the contact and far from it

    struct Indenter {
        /// point: one FE node; patch: all boundary points within half_width_m have the same displacement; disc: all
        /// points of a solid's surface within radius_m, with less displacement towards the rim.
        std::string kind;
        double half_width_m = 0;  ///< of a patch, along the boundary; 0 for a point
        double radius_m = 0;      ///< of a disc; a contact may have another one (StudyPath::radius_m)

        /// Least distance [m] of a contact from the edge of the free surface.
        /// Disc: radius + 5 mm from its centre to every wall, on a shape to where the surface ends or turns.
        /// Patch: three half widths along the surface to the fixed edge, but at most 15 mm and at least one half width.
        /// Point: 15 mm along the surface to the fixed edge.
        double clearance_m() const { return clearance_m(radius_m); }
        double clearance_m(double disc_radius_m) const;

        /// Ratio of a disc's radius to the study's own. Depths, record steps and near elements of its contacts are
        /// multiplied by it. 1 for a point or patch.
        double times(double disc_radius_m) const { return kind == "disc" ? disc_radius_m / radius_m : 1; }
    } indenter;

    struct Solver {
        double tolerance = 0;  ///< largest force on a free node over the largest reaction
        int max_newton = 0;    ///< iterations before a load step is halved
    } solver;

    struct Loads {
        std::vector<double> magnitudes_m;  ///< tool displacements that are load cases, ascending; every one a record
        double record_step_m = 0;
        /// In the plane: the listed load paths; empty with a sweep. For a solid block: every indentation of its
        /// contacts. Empty for a solid shape.
        std::vector<StudyPath> paths;

        /// Training contacts all along the free surface, in place of a list of load paths.
        struct Sweep {
            double spacing_m;              ///< between contacts, along the surface; 0 where they are listed
            double clearance_m;            ///< of the first and the last contact from the fixed edge
            std::vector<double> angles_deg;  ///< of the tool displacement from the inward normal, ascending
            std::vector<double> arcs_m = {};  ///< listed places along the surface, ascending; on the block each stands
                                              ///< for its mirror image too
        };
        std::optional<Sweep> sweep;

        /// Tilt from the inward normal, and azimuth about it [degrees].
        using Pushes = std::vector<std::array<double, 2>>;

        /// A training contact on a solid shape. cases/solid_training.h finds its place on the surface once the shape is
        /// meshed.
        struct Contact {
            Point at_m;  ///< (3), near the surface
            Pushes pushes_deg;
            double depth_m, radius_m;
        };
        std::vector<Contact> contacts;

        /// Training contacts spread over the surface of a solid shape, in place of a list.
        struct Spread {
            int count;
            double clearance_m;  ///< distance from where the surface ends or turns
            Pushes pushes_deg;   ///< azimuths turn from contact to contact
            int pushes_each;     ///< directions of one contact; contacts take the rows of pushes_deg in turn
            /// Radii of discs, which the contacts take in turn; empty: the study's own.
            std::vector<double> radii_m = {};
        };
        std::optional<Spread> spread;

        std::size_t path_count() const;  ///< number of training paths of a solid
        double depth_m() const { return magnitudes_m.back(); }
        int records() const;  ///< of a path of depth_m(), without the record at rest
    } loads;

    struct Springs {
        /// `law`: the force law of the springs of spring sets (springs/spring_law.h); for an energy model `geometric`,
        /// by which springs turn with the tissue.
        std::string topology, law;
        std::string stiffness;           ///< sets: one theta a load case; law: an energy model (springs/energy_model_terms.h)
        std::vector<std::string> terms;  ///< of an energy model
        double spacing_m = 0;            ///< edge of the cubes of an embedded lattice
        double area_cap_E2 = 0;          ///< of an energy model: upper bound of the stiffness of its cells, over E2
        /// Of an energy model: springs are Hooke's; else they have the material's curve (springs/spring_curve.h).
        bool hookean = true;
        bool is_energy_model() const { return stiffness == "law"; }
    } springs;

    /// Contacts drawn by seed before any solve, 2 mm or 5 degrees from every training contact: the validation set, or a
    /// test set.
    struct Draws {
        std::string role;                  ///< validation, held_out or held_out_full; for a solid held_out_WORD too
        unsigned long seed;
        int count;
        double depth_m[2];                 ///< range of the depth; in space times Indenter::times of the contact's disc
        double max_angle_deg;              ///< in the plane: largest angle from the inward normal
        double tilt_deg[2] = {0, 0};       ///< in space: range of the angle from the inward normal
        /// In space: range of the distance from the nearest wall, on a shape from where the surface ends or turns.
        double clearance_m[2] = {0, 0};
        std::vector<double> radii_m = {};  ///< in space: radii of discs, which the contacts take in turn
        /// On a block in space: range of the distance from a first disc to a second one that indents at the same time.
        /// 0: one disc alone.
        double pair_apart_m[2] = {0, 0};
        bool of_pairs() const { return pair_apart_m[1] > 0; }
    };
    std::vector<Draws> draws;

    /// A group of trajectories of the tool, each at a contact drawn as above; the statics of the energy model are not
    /// trained on them. A ramp is a minimum-jerk polynomial from rest to rest (cases/trajectory.h). Fields that a kind does
    /// not have are 0.
    struct Histories : Draws {             ///< role: validation, held_out or train; the other inherited fields as above
        std::string name;                  ///< its trajectories are NAME-0001, ...
        std::string kind;                  ///< ramp, release, sine, poke, again or file
        double rise_s[2];                  ///< ramp, release, poke, again: range of a ramp's time, drawn log-uniformly
        double hold_s;                     ///< ramp, release, again: time at the end of a ramp
        double frequency_Hz[2];            ///< sine: range, drawn log-uniformly
        double duration_s;                 ///< sine, poke
        double wander_deg;                 ///< poke: largest angle between the direction of a ramp and the contact's
        double apart_m;                    ///< again, in the plane: from first to second contact, along the surface
        std::string file;                  ///< file: CSV of the trajectory (results/FORMATS.md)
        Point contact_m;                   ///< file: contact at rest (D)
    };
    std::vector<Histories> histories;
    double check_fraction = 0;  ///< part of the listed paths, or of the role held_out, solved again on a finer mesh
    int check_refine = 0;       ///< `refine` of that mesh; 0: none
    std::array<double, 2> check_sizes_m{};  ///< for a solid: `sizes_m` of that mesh; 0: none

    /// An energy model uses `force_scale`, `shape_scale`, `ridge`, `starts` and `seed` alone. Spring sets use all but
    /// `force_scale`, `shape_scale` and `starts`.
    struct Training {
        std::string optimizer;
        std::vector<std::string> also;     ///< other optimisers, trained and evaluated for comparison
        std::string objective;             ///< force: (9); contact: force at the contact itself
        /// Weight of the L2 regularisation, of sets towards the heuristic, of an energy model's coefficients towards 0.
        /// 0: none.
        double ridge;
        unsigned long seed;
        int iterations;
        std::optional<double> max_seconds, target_rel_loss;  ///< stop criteria of Fig. 5
        double k_min_E2, k_max_E2;         ///< bounds of every spring's stiffness, over E2
        /// Ranges of the weights Q of (9): for the nodes about the contact, and for the others.
        double weight_near[2], weight_far[2];
        /// Relative errors of force and of displacement that count 1 (train/train_energy_model.h).
        double force_scale, shape_scale;
        int starts;  ///< number of starts; the first is the heuristic, for a solid a rough fit from it
    } training;

    /// The energy model with some settings changed, for comparison on the same contacts. Keys that a variant does not
    /// have are the study's.
    struct Variant {
        std::string name;
        std::vector<std::string> terms;    ///< the first terms of the study
        double area_cap_E2, shape_scale;
        std::vector<double> arcs_m;        ///< training contacts kept; empty where the sweep has a spacing: all
        std::vector<double> angles_deg;    ///< angles of training contacts kept
        std::vector<double> magnitudes_m;  ///< load cases kept
        int first_paths = 0;               ///< for a solid: number of training paths kept, in the study's order; 0: all
    };
    std::vector<Variant> variants;

    /// The study itself, as one of its variants.
    Variant whole() const;

    /// The block's lattice.
    Lattice lattice() const;

    /// E2 = E t [N/m], the two-dimensional Young's modulus of (7). For a solid t is 1, and the result is E [Pa].
    double modulus_N_m() const { return material.youngs_modulus_Pa() * geometry.thickness_m; }

    /// The other interpretation of E2 in (7): (C1 + C2) t; E t / 6 for a material law without C1 and C2.
    double second_modulus_N_m() const {
        const double sum = material.alpha.empty() ? material.C1_Pa + material.C2_Pa : material.youngs_modulus_Pa() / 6;
        return sum * geometry.thickness_m;
    }
};

/// Reads a study and the studies that it is based on, and checks every key and value.
/// Throws StudyError with file, line, key and what is allowed; FileError when a file cannot be read.
Study read_study(const std::string& file);

}  // namespace tissue
