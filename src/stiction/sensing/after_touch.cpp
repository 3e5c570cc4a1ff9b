#include "stiction/sensing/after_touch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stiction::sensing {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

VectorXd mean_of(const MatrixXd& tau, const std::vector<int>& rows) {
  VectorXd out = VectorXd::Zero(tau.rows());
  for (const int i : rows) out += tau.col(i);
  return out / static_cast<double>(rows.size());
}

}  // namespace

AfterTouch find_after_touch(const MatrixXd& tau, const std::vector<double>& times, const std::vector<int>& at_rest,
                            const std::vector<int>& touched, double settle) {
  const auto time = [&](int row) { return times[static_cast<std::size_t>(row)]; };
  struct Row {
    int row;
    bool touches;
  };
  std::vector<Row> rows;
  for (const int i : at_rest) rows.push_back({i, false});
  for (const int i : touched) rows.push_back({i, true});
  std::stable_sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) { return time(a.row) < time(b.row); });

  AfterTouch out;
  std::vector<std::vector<int>> touches;
  double last = -std::numeric_limits<double>::infinity();
  bool touches_now = false;
  for (const auto& [row, touches_row] : rows) {
    if (touches_row) {
      if (!touches_now) touches.emplace_back();
      touches.back().push_back(row);
      last = time(row);
    } else if (time(row) - last >= settle) {
      out.settled.push_back(row);
    } else {
      out.unsettled.push_back(row);
      out.touch.push_back(static_cast<int>(touches.size()) - 1);
    }
    touches_now = touches_row;
  }
  out.sizes = MatrixXd::Zero(tau.rows(), static_cast<Index>(touches.size()));
  if (out.settled.empty()) return out;
  const VectorXd rest = mean_of(tau, out.settled);
  for (std::size_t k = 0; k < touches.size(); ++k)
    for (const int i : touches[k])
      out.sizes.col(static_cast<Index>(k)) = out.sizes.col(static_cast<Index>(k)).cwiseMax((tau.col(i) - rest).cwiseAbs());
  return out;
}

Hysteresis fit_hysteresis(const MatrixXd& tau, const std::vector<AfterTouch>& records, const VectorXd& variance, double settle) {
  double excess = 0, squares = 0, fourths = 0;
  for (const AfterTouch& record : records) {
    if (record.settled.empty()) continue;
    const VectorXd rest = mean_of(tau, record.settled);
    const VectorXd noise = (1 + 1 / static_cast<double>(record.settled.size())) * variance;
    for (Index k = 0; k < record.sizes.cols(); ++k) {
      VectorXd square = VectorXd::Zero(tau.rows());
      int rows = 0;
      for (std::size_t i = 0; i < record.unsettled.size(); ++i) {
        if (record.touch[i] != k) continue;
        square += (tau.col(record.unsettled[i]) - rest).cwiseAbs2();
        ++rows;
      }
      if (rows == 0) continue;
      excess += (square / rows - noise).sum();
      squares += record.sizes.col(k).squaredNorm();
      fourths += record.sizes.col(k).array().pow(4).sum();
    }
  }
  if (!(squares > 0)) return {.settle = settle};
  return {std::sqrt(std::max(0.0, excess / squares)), squares * squares / fourths, settle};
}

}  // namespace stiction::sensing
