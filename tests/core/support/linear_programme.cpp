// SPDX-License-Identifier: Apache-2.0
#include "core/support/linear_programme.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

namespace vdrive::test {
namespace {

double product(const std::vector<double>& left, const std::vector<double>& right) {
  return std::inner_product(left.begin(), left.end(), right.begin(), 0.0);
}

/// A vertex: as many bounds as there are variables, which hold with equality at one point, and the
/// prices with which they add up to the objective. Bound 2k is z[k] <= 1, bound 2k + 1 is -z[k] <=
/// 1; the rows follow.
class Vertex {
 public:
  explicit Vertex(const LinearProgramme& programme)
      : programme_(programme),
        count_(programme.objective().size()),
        active_(count_),
        prices_(count_),
        columns_(count_, std::vector<double>(count_, 0.0)),
        point_(count_),
        factors_(count_) {
    for (std::size_t k = 0; k < count_; ++k) {
      const double factor = programme.objective()[k];
      const double side = factor < 0.0 ? -1.0 : 1.0;
      active_[k] = factor < 0.0 ? 2 * k + 1 : 2 * k;
      prices_[k] = std::abs(factor);
      columns_[k][k] = side;
      point_[k] = side;
    }
  }

  /// @return the bound that the point violates most, if it violates one.
  [[nodiscard]] std::optional<std::size_t> most_broken() const {
    constexpr double kEnough = 1.0e-11;
    double worst = kEnough;
    std::optional<std::size_t> found;
    const std::size_t bounds = 2 * count_ + programme_.row_count();
    for (std::size_t i = 0; i < bounds; ++i) {
      const double excess = excess_of(i);
      if (excess > worst) {
        worst = excess;
        found = i;
      }
    }
    return found;
  }

  /// Exchanges the bound whose price reaches 0 first for `bound`. @return false if no price falls:
  /// then the bounds contradict each other.
  [[nodiscard]] bool take(std::size_t bound) {
    constexpr double kNothing = 1.0e-9;
    std::optional<std::size_t> leaving;
    double least = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
      factors_[i] = along(bound, columns_[i]);
      if (factors_[i] <= kNothing) continue;
      const double ratio = prices_[i] / factors_[i];
      const bool is_first = !leaving || ratio < least;
      // Among equal ratios take the larger factor: it is the divisor below.
      if (is_first || (ratio <= least && factors_[i] > factors_[*leaving])) {
        least = ratio;
        leaving = i;
      }
    }
    if (!leaving) return false;
    exchange(*leaving, bound, least);
    return true;
  }

  [[nodiscard]] const std::vector<double>& point() const { return point_; }

  /// @return the prices of the rows.
  [[nodiscard]] std::vector<double> prices() const { return of_rows(prices_); }

  /// @return the prices with which the active bounds and `bound`, which could not be taken in, add
  ///         up to 0.
  [[nodiscard]] std::vector<double> contradiction(std::size_t bound) const {
    std::vector<double> weights(count_);
    std::transform(factors_.begin(), factors_.end(), weights.begin(), [](double factor) {
      return std::max(-factor, 0.0);
    });
    std::vector<double> prices = of_rows(weights);
    if (bound >= 2 * count_) prices[bound - 2 * count_] += 1.0;
    return prices;
  }

 private:
  /// @return the left side of `bound` at `vector`.
  [[nodiscard]] double along(std::size_t bound, const std::vector<double>& vector) const {
    if (bound >= 2 * count_) return product(programme_.row(bound - 2 * count_), vector);
    return bound % 2 == 0 ? vector[bound / 2] : -vector[bound / 2];
  }

  [[nodiscard]] double excess_of(std::size_t bound) const {
    const double most = bound < 2 * count_ ? 1.0 : programme_.bound(bound - 2 * count_);
    return along(bound, point_) - most;
  }

  void exchange(std::size_t leaving, std::size_t bound, double price) {
    const double excess = excess_of(bound);
    const double divisor = factors_[leaving];
    std::vector<double>& column = columns_[leaving];
    for (double& value : column) value /= divisor;
    for (std::size_t k = 0; k < count_; ++k) point_[k] -= excess * column[k];
    for (std::size_t i = 0; i < count_; ++i) {
      if (i == leaving || factors_[i] == 0.0) continue;
      prices_[i] = std::max(prices_[i] - price * factors_[i], 0.0);
      for (std::size_t k = 0; k < count_; ++k) columns_[i][k] -= factors_[i] * column[k];
    }
    prices_[leaving] = price;
    active_[leaving] = bound;
  }

  [[nodiscard]] std::vector<double> of_rows(const std::vector<double>& weights) const {
    std::vector<double> prices(programme_.row_count(), 0.0);
    for (std::size_t i = 0; i < count_; ++i) {
      if (active_[i] >= 2 * count_) prices[active_[i] - 2 * count_] += weights[i];
    }
    return prices;
  }

  const LinearProgramme& programme_;
  std::size_t count_;
  std::vector<std::size_t> active_;
  std::vector<double> prices_;                // of the active bounds
  std::vector<std::vector<double>> columns_;  // of the inverse of their matrix
  std::vector<double> point_;
  std::vector<double> factors_;  // with which the active bounds add up to the new one
};

}  // namespace

LinearProgramme::LinearProgramme(std::vector<double> objective)
    : objective_(std::move(objective)) {}

void LinearProgramme::add(std::vector<double> row, double bound) {
  double scale = 0.0;
  for (const double factor : row) scale = std::max(scale, std::abs(factor));
  for (double& factor : row) factor /= scale;
  rows_.push_back(std::move(row));
  bounds_.push_back(bound / scale);
  scales_.push_back(scale);
}

LinearProgramme::Solution LinearProgramme::solve() const {
  constexpr int kMostSteps = 20'000;  // about three per variable are usual
  Vertex vertex(*this);
  Solution solution;
  for (int step = 0; step < kMostSteps; ++step) {
    const std::optional<std::size_t> broken = vertex.most_broken();
    if (broken && vertex.take(*broken)) continue;
    solution.end = broken ? End::infeasible : End::optimal;
    solution.variables = vertex.point();
    solution.prices = broken ? vertex.contradiction(*broken) : vertex.prices();
    for (std::size_t i = 0; i < scales_.size(); ++i) solution.prices[i] /= scales_[i];
    break;
  }
  return solution;
}

double LinearProgramme::value(const std::vector<double>& variables) const {
  return product(objective_, variables);
}

double LinearProgramme::breach(const std::vector<double>& variables) const {
  double worst = -1.0;
  for (const double variable : variables) worst = std::max(worst, std::abs(variable) - 1.0);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    worst = std::max(worst, product(rows_[i], variables) - bounds_[i]);
  }
  return worst;
}

double LinearProgramme::ceiling(const std::vector<double>& prices) const {
  std::vector<double> left = objective_;
  double sum = 0.0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const double price = prices[i] * scales_[i];
    sum += price * bounds_[i];
    for (std::size_t k = 0; k < left.size(); ++k) left[k] -= price * rows_[i][k];
  }
  for (const double factor : left) sum += std::abs(factor);
  return sum;
}

double LinearProgramme::proof_of_none(const std::vector<double>& prices) const {
  std::vector<double> left(objective_.size(), 0.0);
  double sum = 0.0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const double price = prices[i] * scales_[i];
    sum += price * bounds_[i];
    for (std::size_t k = 0; k < left.size(); ++k) left[k] += price * rows_[i][k];
  }
  for (const double factor : left) sum += std::abs(factor);
  return sum;
}

}  // namespace vdrive::test
