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

/// FE reference of one equilibrium along a load path, or one measurement. A measurement has only magnitude, contact
/// force and aside_m: u and f are empty, the rest is 0.
struct PathRecord {
    double magnitude_m;                ///< tool displacement along the path's direction
    NodeField displacement;            ///< u at the nodes [m] (N x D)
    NodeField force;                   ///< f at the nodes [N] (N x D): non-zero at contact and supports alone
    Point contact_force_N;   ///< of the indenter on the tissue (D)
    Point support_force_N;   ///< of the supports on the tissue (D)
    double energy_J;                   ///< of the strain, and of an elastic bed
    double smallest_J;                 ///< smallest det F in the tissue; FE stops before it reaches 0
    int newton_iterations;             ///< since the record before
    double newton_residual;            ///< relative, at the last iteration
    Point aside_m = {};                ///< measured displacement less its part along the direction (D); empty: 0
    Point second_force_N = {};         ///< of the second disc on the tissue (D); empty: no second disc
};

/// One straight indentation: equilibria from rest to the largest magnitude.
struct LoadPath {
    std::string name;
    Point contact_m;
    Point direction;         ///< unit vector of the tool displacement
    std::string role = "train";        ///< as in PlannedPath (cases/sweep.h)
    double depth_m = 0;                ///< planned depth
    std::string lost;                  ///< cause, where FE ended before that depth; else empty
    std::vector<PathRecord> records;   ///< ascending magnitude, FE's first at rest
    std::optional<Point> again_N;      ///< measured: mean contact force of the other repeats of this indentation
    double radius_m = 0;               ///< of the disc; 0 in the plane, and where it is the study's own
    std::optional<SecondTool> second = {};  ///< a second disc that indents at the same time, in proportion

    /// Displacement of the contact at a record from its place at rest [m] (D).
    Point push_m(const PathRecord& record) const {
        const Point along = direction * record.magnitude_m;
        return record.aside_m.size() > 0 ? Point(along + record.aside_m) : along;
    }

    /// Displacement of the second disc at a record from its place at rest [m] (D). The path must have one.
    Point second_push_m(const PathRecord& record) const { return second->direction * (record.magnitude_m * second->depth_m / depth_m); }

    /// The record at a magnitude [m]; nullptr without one. Magnitudes may differ by a relative 1e-9, because FE adds up
    /// its load steps.
    const PathRecord* record_at(double magnitude_m) const;
};

/// Properties of measured data as a whole.
struct Measurement {
    std::string origin;                ///< the comments at the head of its file
    int rows = 0, contacts = 0;
    int repeats = 0;                   ///< degrees of freedom of the noise estimates; 0: nothing was measured twice
    double force_noise = 0;            ///< standard deviation of a component, relative to the force
    double displacement_noise_m = 0;   ///< standard deviation of a component
    std::string noise_source;          ///< "repeats", "stated" or "unknown"
    std::vector<std::string> outliers; ///< rows far from their repeats, by line; they are kept
};

/// The contents of cases.h5: load paths of a study, at the nodes where displacements are compared.
struct Cases {
    std::string study;
    NodeField nodes;                    ///< at rest [m] (N x D)
    std::optional<Shape> shape;         ///< mesh of these nodes, where the tissue is not the block
    std::vector<double> magnitudes_m;   ///< those that are load cases, ascending; measured: empty, every record is one
    std::vector<LoadPath> paths;
    std::optional<Measurement> measurement = {};  ///< absent where FE computed the cases
    std::vector<History> histories = {};          ///< at most relative moduli and relaxation times are fitted to them
    double disc_radius_m = 0;                     ///< of the study's own disc, where a path has another one; else 0
};

/// One state to train on: a path at one of its magnitudes.
struct LoadCase {
    std::string name;          ///< "left-10mm"
    const LoadPath* path;
    const PathRecord* record;
};

/// Magnitudes [m] at which a training path is a load case, ascending.
/// In the plane: those of the cases, because all paths are equally deep. In space: those of the cases in proportion to
/// the path's disc, up to its depth, and its depth where it ends before the largest. Measured: those of all records.
std::vector<double> load_magnitudes(const Cases& cases, const LoadPath& path);

/// Every training path at each of its load_magnitudes, path by path. Of a path that FE did not finish, only the
/// magnitudes reached. Names have as many digits of the magnitude as make them different.
/// Throws MismatchError where a finished path has no record at a magnitude, or where two magnitudes are equal.
/// The cases must outlive the result.
std::vector<LoadCase> load_cases(const Cases& cases);

/// Reads FreeFEM's CSV of one path (results/FORMATS.md) and puts its rows in the order of `nodes`. second: whether the
/// path has a second disc, so that every record must have its force; default false.
/// Throws FileError with file, line and cause: missing, truncated, a field that is no number, another number of discs,
/// a node that is not on the lattice or occurs twice.
LoadPath read_path_csv(const std::string& file, const NodeField& nodes, bool second = false);

/// The path mirrored in the plane, x to width_m - x, on a symmetric lattice. Its name gets "-mirror".
/// Throws MismatchError when the lattice is not symmetric.
LoadPath mirrored(const LoadPath& path, const NodeField& nodes, double width_m);

/// The cases without the training paths that mirrored() made of others among them. For a model that is symmetric
/// itself, these images would count every path twice.
Cases without_mirrors(const Cases& cases);

/// A measured record (PathRecord).
PathRecord measured_record(double magnitude_m, const Point& force_N, const Point& aside_m);

void write_cases(const std::string& file, const Cases& cases, const Provenance& provenance);

/// Throws FileError.
Cases read_cases(const std::string& file);

}  // namespace tissue
