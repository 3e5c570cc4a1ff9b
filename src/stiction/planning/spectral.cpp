#include "stiction/planning/spectral.hpp"

#include <Eigen/Eigenvalues>

namespace stiction::planning {
namespace {

constexpr double kLeastShare = 1e-10;  // of the largest σ²: below it rounding speaks

}  // namespace

Eigen::MatrixXd principal_directions(const Eigen::MatrixXd& B) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(B * B.transpose());  // σ² rising; B has few rows
  const Eigen::VectorXd& squares = eigen.eigenvalues();
  const double largest = squares.tail(1)[0];
  const Eigen::Index rank = largest > 0 ? (squares.array() > kLeastShare * largest).count() : 0;
  Eigen::MatrixXd V(B.cols(), rank);
  for (Eigen::Index k = 0; k < rank; ++k) V.col(k) = (B.transpose() * eigen.eigenvectors().col(B.rows() - 1 - k)).normalized();
  return V;
}

}  // namespace stiction::planning
