// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::test {

/// The largest sum under linear bounds: objective·z for all z in [-1, 1] with row·z <= bound.
///
/// `solve` is a dual simplex: it starts where the box alone allows the most, and takes in the row
/// that is broken most until none is. Nobody has to believe it. With any prices >= 0 of the rows
///   objective·z <= Σ price·bound + Σ |objective - Σ price·row|
/// holds for each z that is allowed (weak duality), and the same without the objective shows that
/// none is allowed where the right side is below 0. `ceiling` and `proof_of_none` calculate these
/// sides from the rows, `breach` what a z breaks.
class LinearProgramme {
 public:
  enum class End : std::uint8_t {
    optimal,
    infeasible,
    no_end,  ///< too many steps, which rounding may cause
  };

  struct Solution {
    End end = End::no_end;
    std::vector<double> variables;  ///< where optimal
    std::vector<double> prices;     ///< of the rows, >= 0; where infeasible those of the proof
  };

  explicit LinearProgramme(std::vector<double> objective);

  /// Bounds row·z to at most `bound`. @pre some value of `row`, which has one for each variable, is
  /// not 0
  void add(std::vector<double> row, double bound);

  [[nodiscard]] Solution solve() const;

  [[nodiscard]] double value(const std::vector<double>& variables) const;

  /// @return by how much `variables` break the row, or the box, that they break most; <= 0 if none.
  ///         A row counts in units of its largest factor.
  [[nodiscard]] double breach(const std::vector<double>& variables) const;

  /// @return what no allowed z exceeds.
  [[nodiscard]] double ceiling(const std::vector<double>& prices) const;

  /// @return below 0 no z is allowed.
  [[nodiscard]] double proof_of_none(const std::vector<double>& prices) const;

  [[nodiscard]] const std::vector<double>& objective() const { return objective_; }

  [[nodiscard]] std::size_t row_count() const { return rows_.size(); }

  [[nodiscard]] const std::vector<double>& row(std::size_t i) const { return rows_[i]; }

  [[nodiscard]] double bound(std::size_t i) const { return bounds_[i]; }

 private:
  std::vector<double> objective_;
  std::vector<std::vector<double>> rows_;  // the largest factor of each is 1 or -1
  std::vector<double> bounds_;
  std::vector<double> scales_;  // by which a row was divided
};

}  // namespace vdrive::test
