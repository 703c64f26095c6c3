// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "child_process.hpp"

#include <cstddef>
#include <cstdint>

namespace vdrive::process {

/// A DDS domain that no other program on this machine uses, of no user: this object has the port at
/// which participants of the domain announce themselves, which is what makes them meet. The port is
/// free when its process has ended, however it ended.
class PrivateDomain {
 public:
  /// Above what people use by hand, below the domains whose ports are in the ephemeral range.
  static constexpr std::uint32_t kFirst = 20;
  static constexpr std::uint32_t kCount = 80;

  /// How many of them one user gets. Domains of another user who has more do not count as used,
  /// where the ports can be shared.
  static constexpr std::size_t kMostOfOneUser = 64;

  /// @throws std::runtime_error when there is no domain left, with the users who have them.
  PrivateDomain();

  [[nodiscard]] std::uint32_t number() const noexcept { return number_; }

 private:
  std::uint32_t number_ = 0;
  Descriptor claim_;
};

}  // namespace vdrive::process
