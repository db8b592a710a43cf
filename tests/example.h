#pragma once

#include <string>
#include <vector>

#include "cases/load_path.h"
#include "study/study.h"
#include "train/training_books.h"

namespace tissue {

/// A folder for one test's files, gone with it.
class TemporaryFolder {
   public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::string& path() const { return path_; }
    std::string file(const std::string& name) const { return path_ + "/" + name; }
    /// Writes the text and returns the file's name.
    std::string file(const std::string& name, const std::string& text) const;
    /// Names of what is in it, in alphabetical order.
    std::vector<std::string> names() const;

   private:
    std::string path_;
};

/// A whole study of a 4 x 4 lattice, with two load paths at two magnitudes: every section and key once.
const std::string& example_study_text();

/// `text` with its one `from` replaced. Fails the test when `from` does not stand there exactly once.
std::string with(const std::string& text, const std::string& from, const std::string& to);

Study example_study(const std::string& text = example_study_text());

/// Not uniform, not symmetric: stiffness that differs from spring to spring [N/m] (S).
Eigen::VectorXd example_theta(const SpringMesh& mesh);

/// A "tissue" that is itself a spring mesh with stiffness theta (grid8, axial): springs can meet it exactly.
Cases example_cases(const Study& study, const Eigen::VectorXd& theta);

/// A model trained on these cases, whose every trained set has then been replaced by theta.
TrainedModel example_model(const Study& study, const Cases& cases, const Eigen::VectorXd& theta);

/// A law on a block in space, 0.1 x 0.1 x 0.05 m of 4 x 4 x 2 cells: near what `block3-quick` learns, with one push down the
/// middle of its top and one that is tilted, and no FE.
TissueModel solid_example();

/// Takes a dataset out of an HDF5 file; with values, puts these (one dimension) in its place.
void replace_dataset(const std::string& file, const std::string& dataset, const std::vector<double>& values = {});

/// Displacements [m] (N x D) without structure, the same every time.
NodeField scattered(const SpringMesh& mesh, double size_m);

}  // namespace tissue
