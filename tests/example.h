#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "cases/sweep.h"
#include "study/study.h"
#include "train/training_diagnostics.h"

namespace tissue {

/// A temporary folder for one test's files, removed by the destructor.
class TemporaryFolder {
   public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::string& path() const { return path_; }
    std::string file(const std::string& name) const { return path_ + "/" + name; }
    /// Writes the text to the file and returns its path.
    std::string file(const std::string& name, const std::string& text) const;
    /// Names of its entries in alphabetical order.
    std::vector<std::string> names() const;

   private:
    std::string path_;
};

/// A complete study of a 4 x 4 lattice, with two load paths at two magnitudes.
const std::string& example_study_text();

/// `text` with `from` replaced by `to`. Fails the test unless `from` occurs exactly once.
std::string with(const std::string& text, const std::string& from, const std::string& to);

Study example_study(const std::string& text = example_study_text());

/// Spring stiffnesses without uniformity or symmetry [N/m] (S).
Eigen::VectorXd example_theta(const SpringMesh& mesh);

/// A reference that is itself a spring mesh with stiffness theta (grid8, axial), so that springs can match it exactly.
Cases example_cases(const Study& study, const Eigen::VectorXd& theta);

/// A load path as if it was solved, with the displacements u(record) and arbitrary forces and numbers.
LoadPath path_as_solved(const PlannedPath& planned, const std::function<NodeField(int)>& u);

/// Reads cases and sorts them into load cases. A study that asks for a magnitude which no record has is no fault of the
/// file, and passes.
void read_load_cases(const std::string& file);

/// A model trained on these cases, with every trained set replaced by theta.
TrainedModel example_model(const Study& study, const Cases& cases, const Eigen::VectorXd& theta);

/// An energy model of a block of 0.1 x 0.1 x 0.05 m with 4 x 4 x 2 cells, with parameters close to those trained on
/// `block3-quick`. Its two cases are a normal indentation in the middle of the top and a tilted one. It has no FE
/// reference.
TissueModel solid_example();

/// Removes a dataset from an HDF5 file, or replaces it by `values` (one dimension) if there are any.
void replace_dataset(const std::string& file, const std::string& dataset, const std::vector<double>& values = {});

/// Irregular displacements of up to size_m per component [m] (N x D), the same in every run.
NodeField scattered(const SpringMesh& mesh, double size_m);

}  // namespace tissue
