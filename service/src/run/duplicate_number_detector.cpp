// SPDX-License-Identifier: Apache-2.0
#include "run/duplicate_number_detector.hpp"

#include "vdrive/wire/codec.hpp"

namespace vdrive::service {

void DuplicateNumberDetector::note(std::span<const std::byte> sample) {
  if (wire::decode(sample, state_) && state_.bench() == identity_.bench &&
      state_.incarnation() < identity_.incarnation) {
    older_ = state_.incarnation();
  }
}

std::optional<std::uint64_t> DuplicateNumberDetector::conflict() const noexcept {
  const std::uint64_t older = older_;
  return older == 0 ? std::nullopt : std::optional(older);
}

}  // namespace vdrive::service
