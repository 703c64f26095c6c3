// SPDX-License-Identifier: Apache-2.0
#include "run/duplicate_number_detector.hpp"

#include "vdrive/wire/codec.hpp"

namespace vdrive::service {

DuplicateNumberDetector::DuplicateNumberDetector(ByteRing notices, const BenchIdentity& identity)
    : notices_(notices), identity_(identity) {}

void DuplicateNumberDetector::receive() {
  constexpr int kMostAtOnce = 64;  // the calling thread has other work
  for (int count = 0; count < kMostAtOnce; ++count) {
    const auto record = notices_.front();
    if (!record) return;
    if (wire::decode(record->bytes, state_) && state_.bench() == identity_.bench &&
        state_.incarnation() < identity_.incarnation) {
      older_ = state_.incarnation();
    }
    notices_.pop();
  }
}

std::optional<std::uint64_t> DuplicateNumberDetector::conflict() const noexcept {
  const std::uint64_t older = older_;
  return older == 0 ? std::nullopt : std::optional(older);
}

}  // namespace vdrive::service
