// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// What can be wrong with a file of parameters, or with what it holds of one axis.
enum class ParameterProblem : std::uint8_t {
  none,
  unreadable,       ///< number: errno
  empty,            ///< no byte in it
  too_large,        ///< number: its size
  damaged,          ///< not as it was written: torn, changed, or never a file of parameters
  unknown_version,  ///< number: the version
  missing,          ///< gone without an interrupted save, while the one before it is there
  unknown_object,   ///< of an axis: number: index * 256 + sub-index
  refused_value,    ///< of an axis: likewise
};

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

/// @return such as "damaged" or "version 2 of the format is not supported".
[[nodiscard]] std::string describe_problem(ParameterProblem problem, std::uint64_t number);

}  // namespace vdrive::service
