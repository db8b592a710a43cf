#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "springs/disc_sizes.h"
#include "springs/disc_tables.h"
#include "springs/energy_law.h"
#include "springs/press.h"
#include "train/nonlinear_fit.h"

namespace tissue {

/// One load path as the law sees it: where on the surface, and at each push what the truth said.
struct PressPath {
    std::string name;
    Point contact_m;              ///< (D)
    double radius_m = 0;          ///< of the disc; 0: the law's own
    struct Record {
        Point push_m, force_N;
        NodeField displacement;   ///< [m] (N x D); empty where only the force is known (measured contacts)
    };
    std::vector<Record> records;  ///< ascending
};

/// The cases' training paths, each at the cases' magnitudes. Paths that FE lost give what they reached.
std::vector<PressPath> press_paths(const Cases& cases);

struct LawTrainingOptions {
    double force_scale = 0.01;    ///< an error of 1 % of |F| counts 1
    double shape_scale = 0.03;    ///< an error of 3 % of the displacement's rms counts 1
    double ridge = 0.1;           ///< a coefficient of 10 (a factor of 22,000) counts 1
    std::vector<int> seen;        ///< nodes whose displacement counts; empty: all
    double disc_radius_m = 0;     ///< in space,
    Eigen::Vector2d curved_range{-INFINITY, INFINITY};  ///< DiscTables::curved_range
    FacetTable correction;        ///< and its correction;
    DiscSizes sizes;              ///< other discs of paths
    int starts = 1;               ///< one from `first`, the others drawn around the heuristic
    Eigen::VectorXd first;        ///< coefficients (P); empty: the heuristic
    double spread = 0.5;          ///< standard deviation of a drawn start's coefficients
    unsigned long seed = 1;
    FitOptions fit;
    PressOptions press;
    int threads = 1;
};

/// The factor of all a law's constants, at coefficients 0, with the smallest sum of squared relative errors of force
/// over the paths: forces are proportional to it, shapes do not change. A push that is lost does not count.
/// Throws MismatchError when none has one, or none a force.
double heuristic_factor(const SpringMesh& mesh, const EnergyLaw& law, const std::vector<PressPath>& paths,
                        const LawTrainingOptions& options = {});

/// What training a law ended with.
struct TrainedLaw {
    Eigen::VectorXd coefficients;          ///< (P)
    double objective = 0;                  ///< mean over records of (force error / scale)^2 + (shape error / scale)^2, and the ridge
    std::vector<FitResult> starts;         ///< of each start
    std::size_t kept = 0;                  ///< of those with the fewest pushes lost
    std::vector<std::string> lost;         ///< "path at 10 mm: lost at 7.5 mm": pushes not `held` at the end
    double seconds = 0;
};

/// Closed loop: for every record the tool holds the contact at its push, everything else finds its rest, and the force it
/// takes and the shape that results are compared with the truth's:
///   mean over records of |F_model - F|^2 / (force_scale |F|)^2 + |u_model - u|^2 / (shape_scale |u|)^2, + |ridge p|^2,
/// without the second where nobody knows u.
/// u: of the nodes that are seen, as they are seen (springs/skin.h). Derivatives of the rest are implicit (PressSolver::derivative). A push that is lost counts as if the model had
/// neither moved nor pushed; no step of the fit may lose one that it has (nonlinear_fit), and of several starts those that end with the fewest lost
/// come first, then the smallest objective. Parallel over paths; the same for any number of threads.
/// Throws MismatchError when there is nothing to train on.
TrainedLaw train_law(const SpringMesh& mesh, const EnergyLaw& law, const std::vector<PressPath>& paths,
                     const LawTrainingOptions& options = {});

/// Where every record's press ended: the next evaluation begins there, in space, where a press from rest costs most of the
/// training. Empty before the first.
using LawRests = std::vector<std::vector<PressState>>;

/// The residuals of that objective (its square sum) and their derivative by the coefficients: for tests and for starts.
/// Rows: record by record force (D) and shape (D * seen where known), then the ridge. gone: of each record 1 where its push is `lost`.
void law_residuals(const SpringMesh& mesh, const EnergyLaw& law, const std::vector<PressPath>& paths,
                   const LawTrainingOptions& options, const Eigen::VectorXd& p, Eigen::Ref<Eigen::VectorXd> f,
                   Eigen::Ref<RowMatrix> J, std::vector<std::string>* lost = nullptr,
                   LawRests* rests = nullptr, std::vector<char>* gone = nullptr);
int law_residual_count(const EnergyLaw& law, const std::vector<PressPath>& paths, const LawTrainingOptions& options);

}  // namespace tissue
