// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "child_process.hpp"

#include <cstddef>
#include <cstdint>

namespace vdrive::process {

/// A DDS domain that no other program of any user on this machine uses. This object holds the port
/// at which participants of the domain announce themselves, and so find each other. The port is
/// free again when the process has ended, however it ended.
class PrivateDomain {
 public:
  /// Above the numbers that people choose by hand, below the domains with ports in the ephemeral
  /// range.
  static constexpr std::uint32_t kFirst = 20;
  static constexpr std::uint32_t kCount = 80;

  /// Domains per user. The domains of another user who has more do not count as used, if the ports
  /// can be shared.
  static constexpr std::size_t kMostOfOneUser = 64;

  /// @throws std::runtime_error if no domain is left, naming the users who hold them.
  PrivateDomain();

  [[nodiscard]] std::uint32_t number() const noexcept { return number_; }

 private:
  std::uint32_t number_ = 0;
  Descriptor claim_;
};

}  // namespace vdrive::process
