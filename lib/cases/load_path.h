#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cases/history.h"
#include "field.h"
#include "io/hdf5_store.h"
#include "mesh/shape.h"
#include "mesh/spring_mesh.h"
#include "study/second_tool.h"

namespace tissue {

/// What FE said of one equilibrium along a load path. Of a measured one, only magnitude, contact force and aside are
/// known: u and f are empty, the rest is 0.
struct PathRecord {
    double magnitude_m;                ///< how far the contact has been pushed
    NodeField displacement;            ///< u at the nodes [m] (N x D)
    NodeField force;                   ///< f at the nodes [N] (N x D): contact, supports, else nothing
    Point contact_force_N;   ///< that the indenter puts on the tissue
    Point support_force_N;
    double energy_J;
    double smallest_J;                 ///< smallest det F in the tissue; FE stops before it reaches 0
    int newton_iterations;             ///< since the record before
    double newton_residual;            ///< relative, at the last iteration
    Point aside_m = {};                ///< what a measured push strayed from its path's direction (D); empty: nothing
    Point second_force_N = {};         ///< that the second disc puts on the tissue (D); empty: there is none
};

/// One straight push: FE equilibria from rest to the deepest magnitude.
struct LoadPath {
    std::string name;
    Point contact_m;
    Point direction;         ///< unit vector
    std::string role = "train";        ///< as in PlannedPath (cases/sweep.h)
    double depth_m = 0;                ///< how deep it was to go
    std::string lost;                  ///< why FE ended before that depth; empty when it did not
    std::vector<PathRecord> records;   ///< ascending magnitude, the first at rest
    std::optional<Point> again_N;  ///< contact force on average when the same push was measured again
    double radius_m = 0;               ///< of the disc that pushes; 0 in the plane, and where it is the study's own
    std::optional<SecondTool> second = {};  ///< a second disc that pushes at once, in proportion

    /// Where the contact stands at a record, from where it was at rest [m].
    Point push_m(const PathRecord& record) const {
        const Point along = direction * record.magnitude_m;
        return record.aside_m.size() > 0 ? Point(along + record.aside_m) : along;
    }

    /// Where the second disc stands at a record, from where it was at rest [m]. The path must have one.
    Point second_push_m(const PathRecord& record) const { return second->direction * (record.magnitude_m * second->depth_m / depth_m); }

    /// The record at a magnitude [m], to a part in 10^9, since FE counts its way there in steps; nullptr without one.
    const PathRecord* record_at(double magnitude_m) const;
};

/// What is known of measured data beside its load paths.
struct Measurement {
    std::string origin;                ///< the comments at the head of its file
    int rows = 0, contacts = 0;
    int repeats = 0;                   ///< degrees of freedom of the noise estimates; 0: nothing was measured twice
    double force_noise = 0;            ///< standard deviation of a component, relative to the force
    double displacement_noise_m = 0;   ///< standard deviation of a component
    std::string noise_source;          ///< "repeats", "stated" or "unknown"
    std::vector<std::string> outliers; ///< rows far from their repeats, by line; they are kept
};

/// The load paths of a study at the nodes where displacements are compared: what cases.h5 holds.
struct Cases {
    std::string study;
    NodeField nodes;                    ///< at rest [m] (N x D)
    std::optional<Shape> shape;         ///< the triangles between them, where the tissue is not the block
    std::vector<double> magnitudes_m;   ///< those that are load cases, ascending; measured: none, every record is one
    std::vector<LoadPath> paths;
    std::optional<Measurement> measurement = {};  ///< absent when FE said it
    std::vector<History> histories = {};          ///< the tool held along a course in time; nothing is trained on most
    double disc_radius_m = 0;                     ///< of the study's own disc, where a path has another one
};

/// One state to train on: a path at one of the magnitudes.
struct LoadCase {
    std::string name;          ///< "left-10mm"
    const LoadPath* path;
    const PathRecord* record;
};

/// Magnitudes [m] at which a training path is a load case, ascending: in the plane, where all are pushed equally deep, the
/// cases' own; in space those up to its depth, in proportion to its disc, and its depth where it ends before the largest; measured: every record's.
std::vector<double> load_magnitudes(const Cases& cases, const LoadPath& path);

/// Every training path at every one of its load_magnitudes, path by path; of a path that FE lost, those it reached. Names
/// have as many digits of the magnitude as tell them apart. Throws MismatchError when another path has no record at a
/// magnitude, or two at one.
/// The cases must outlive the result.
std::vector<LoadCase> load_cases(const Cases& cases);

/// Reads FreeFEM's CSV of one path (results/FORMATS.md) and puts its rows in the order of `nodes`. second: whether the path has a second disc, whose force every
/// record has then; a file that says otherwise is refused.
/// Throws FileError with file, line and cause: missing, truncated, a number that is none, a node that is not on the
/// lattice or stands twice.
LoadPath read_path_csv(const std::string& file, const NodeField& nodes, bool second = false);

/// The same push seen in a mirror, x to width - x, on a lattice that mirrors itself. Its name gets "-mirror". In the plane.
/// Throws MismatchError when the lattice does not.
LoadPath mirrored(const LoadPath& path, const NodeField& nodes, double width_m);

/// The cases without those images, where what they mirror is there too: for what mirrors itself and would count all twice.
Cases without_mirrors(const Cases& cases);

/// A record that was measured (PathRecord).
PathRecord measured_record(double magnitude_m, const Point& force_N, const Point& aside_m);

void write_cases(const std::string& file, const Cases& cases, const Provenance& provenance);

/// Throws FileError.
Cases read_cases(const std::string& file);

}  // namespace tissue
