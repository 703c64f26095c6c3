// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::test {

/// The largest sum under linear bounds: maximises objective·z over all z in [-1, 1] with
/// row·z <= bound.
///
/// `solve` is a dual simplex: it starts at the corner of the box with the largest objective, and
/// takes in the row that is violated most until none is. The result can be checked without trusting
/// it. With any prices >= 0 of the rows
///   objective·z <= Σ price·bound + Σ |objective - Σ price·row|
/// holds for each allowed z (weak duality). With objective = 0 the left side is 0, so if the right
/// side is then below 0, no z is allowed. `ceiling` and `proof_of_none` calculate these two right
/// sides from the rows; `breach` calculates by how much a z violates the bounds.
class LinearProgramme {
 public:
  enum class End : std::uint8_t {
    optimal,
    infeasible,
    no_end,  ///< too many steps; rounding may cause that
  };

  struct Solution {
    End end = End::no_end;
    std::vector<double> variables;  ///< where optimal
    std::vector<double> prices;     ///< of the rows, >= 0; if infeasible, those of the proof
  };

  explicit LinearProgramme(std::vector<double> objective);

  /// Adds the bound row·z <= `bound`. @pre `row` has one value for each variable, not all 0
  void add(std::vector<double> row, double bound);

  [[nodiscard]] Solution solve() const;

  [[nodiscard]] double value(const std::vector<double>& variables) const;

  /// @return by how much `variables` violate the row, or the box, that they violate most; <= 0 if
  ///         none. A row counts in units of its largest factor.
  [[nodiscard]] double breach(const std::vector<double>& variables) const;

  /// @return an upper limit of the objective for every allowed z.
  [[nodiscard]] double ceiling(const std::vector<double>& prices) const;

  /// @return a value below 0 if no z is allowed.
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
