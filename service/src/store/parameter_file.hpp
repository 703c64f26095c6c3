// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/parameter_problem.hpp"
#include "vdrive/axis_configuration.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive::service {

/// What is stored of each axis, by its number.
using ParameterTable = std::map<std::uint16_t, std::vector<InitialValue>>;

/// The version of the file that is written. A program that writes a later one reads this one too.
inline constexpr std::uint32_t kParameterFileVersion = 1;

/// A longer file was not written by vdrived: 65,535 axes with every object fill less.
inline constexpr std::uint64_t kLargestParameterFile = 128ULL << 20U;

/// A file of parameters cannot be used.
class ParameterFileError : public std::runtime_error {
 public:
  ParameterFileError(ParameterProblem problem, std::uint64_t number, const std::string& message)
      : std::runtime_error(message), problem_(problem), number_(number) {}

  [[nodiscard]] ParameterProblem problem() const noexcept { return problem_; }

  /// See ParameterProblem.
  [[nodiscard]] std::uint64_t number() const noexcept { return number_; }

 private:
  ParameterProblem problem_;
  std::uint64_t number_;
};

/// @return the file: one line with version, length and check of what follows, then JSON.
[[nodiscard]] std::string encode(const ParameterTable& table);

/// Objects and values are not judged.
/// @throws ParameterFileError unless every byte is as `encode` wrote it.
[[nodiscard]] ParameterTable decode(std::span<const std::byte> file);

}  // namespace vdrive::service
