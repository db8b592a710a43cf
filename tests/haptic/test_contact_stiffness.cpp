#include "haptic/contact_stiffness.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "../tolerances.h"
#include "haptic_example.h"
#include "springs/spring_law.h"

using namespace tissue;

TEST_CASE("the contact stiffness of an outline is the inverse axis-mean compliance for the set selected at first touch") {
    for (const char* law : {"isotropic", "axial", "geometric"})
        for (const int cells : {3, 6}) {
            const TissueModel model = haptic_example({*law == 'i' ? "grid4" : "grid8", law, cells});
            const RealtimeMesh mesh(model.mesh, law, model.node_mass_kg);
            const std::vector<int>& outline = mesh.outline();
            const std::size_t M = outline.size();
            std::vector<int> first_set(M);
            for (std::size_t b = 0; b < M; ++b) first_set[b] = b % 3 == 0 ? 1 : 0;
            Eigen::MatrixXd theta_of_set(mesh.slot_count(), 2);
            std::vector<Eigen::MatrixXd> compliance;  // of every axis of every node; 0 at fixed nodes
            for (int set : {0, 1}) {
                const Eigen::VectorXd theta = model.trained[0].theta.row(set).transpose();
                theta_of_set.col(set) = mesh.to_slots(theta);
                Eigen::MatrixXd K = make_spring_law(law)->stiffness(model.mesh, theta, NodeField::Zero(model.mesh.node_count(), 2));
                for (int node : model.mesh.fixed)
                    for (int axis : {0, 1}) {
                        K.row(2 * node + axis).setZero();
                        K.col(2 * node + axis).setZero();
                        K(2 * node + axis, 2 * node + axis) = 1;
                    }
                compliance.push_back(K.inverse());
                for (int node : model.mesh.fixed)
                    for (int axis : {0, 1}) compliance.back()(2 * node + axis, 2 * node + axis) = 0;
            }
            const ContactStiffness stiffness(mesh, first_set, theta_of_set);
            CHECK(stiffness.without_stiffness() == 0);
            double largest = 0;
            for (std::size_t b = 0; b < M; ++b)
                for (const double w : {0.0, 0.3, 1.0}) {
                    const int i = outline[b], j = outline[(b + 1) % M];
                    const Eigen::MatrixXd& C = compliance[static_cast<std::size_t>(first_set[b])];
                    double own = 0;
                    for (int axis : {0, 1})
                        own += ((1 - w) * (1 - w) * C(2 * i + axis, 2 * i + axis) + w * w * C(2 * j + axis, 2 * j + axis) + 2 * w * (1 - w) * C(2 * i + axis, 2 * j + axis)) / 2;
                    INFO(law << ", segment " << b << ", weight " << w);
                    if (own * stiffness.largest() > 1) CHECK(stiffness.at(static_cast<int>(b), w) == Approx(1 / own).epsilon(1e-9));
                    else CHECK(stiffness.at(static_cast<int>(b), w) == Approx(stiffness.largest()).epsilon(1e-12));
                    if (own > 0 && (w == 0 || w == 1)) largest = std::max(largest, 1 / own);
                }
            CHECK(stiffness.largest() == Approx(largest).epsilon(1e-9));
        }
}
