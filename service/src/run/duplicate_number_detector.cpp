// SPDX-License-Identifier: Apache-2.0
#include "run/duplicate_number_detector.hpp"

#include "vdrive/text.hpp"
#include "vdrive/wire/codec.hpp"

#include <utility>

namespace vdrive::service {

void DuplicateNumberDetector::note(std::span<const std::byte> sample,
                                   std::span<const std::byte> place) {
  if (wire::decode(sample, state_) && state_.bench == identity_.bench &&
      state_.incarnation < identity_.incarnation) {
    keep_place(place);
    older_ = state_.incarnation;
  }
}

/// The bytes come from the network and may be anything; older_text() escapes them.
void DuplicateNumberDetector::keep_place(std::span<const std::byte> bytes) {
  std::string place;
  for (const std::byte each : bytes) place += static_cast<char>(each);
  const std::lock_guard lock(mutex_);
  place_ = std::move(place);
}

std::string DuplicateNumberDetector::older_text() const {
  const std::lock_guard lock(mutex_);
  const std::string place =
      place_.empty() ? "a service at an unknown place" : escaped(place_, kShownOfMessage);
  return place + " (incarnation " + std::to_string(older_) + ")";
}

std::optional<std::uint64_t> DuplicateNumberDetector::conflict() const noexcept {
  const std::uint64_t older = older_;
  return older == 0 ? std::nullopt : std::optional(older);
}

}  // namespace vdrive::service
