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

/// The stored values of each axis, by its number.
using ParameterTable = std::map<std::uint16_t, std::vector<InitialValue>>;

/// The version of the file format. A program that writes a later version must also read this one.
inline constexpr std::uint32_t kParameterFileVersion = 1;

/// The largest file that is read [bytes]: 65,535 axes with all objects need less.
inline constexpr std::uint64_t kLargestParameterFile = 128ULL << 20U;

/// A parameter file cannot be used.
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

/// @return the content of a file: one line with version, length and check of the rest, then JSON.
[[nodiscard]] std::string encode(const ParameterTable& table);

/// Does not check objects and values.
/// @throws ParameterFileError unless every byte is as `encode` writes it
[[nodiscard]] ParameterTable decode(std::span<const std::byte> file);

}  // namespace vdrive::service
