// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "child_process.hpp"

#include <cstdint>

namespace vdrive::process {

/// A DDS domain that no program on this machine uses: claimed by a lock on a file in the temporary
/// directory, for the life of this object, and without a socket on its discovery port.
class PrivateDomain {
 public:
  /// @throws std::runtime_error when all domains are taken.
  PrivateDomain();

  [[nodiscard]] std::uint32_t number() const noexcept { return number_; }

 private:
  std::uint32_t number_ = 0;
  Descriptor lock_;
};

}  // namespace vdrive::process
