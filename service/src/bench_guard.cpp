// SPDX-License-Identifier: Apache-2.0
#include "bench_guard.hpp"

namespace vdrive::service {

BenchGuard::BenchGuard(wire::Participant& participant, const BenchIdentity& identity)
    : states_(participant, [this, identity](const msg::BenchState& state, const wire::Source&) {
        if (state.bench() == identity.bench && state.incarnation() < identity.incarnation) {
          older_ = state.incarnation();
        }
      }) {}

std::optional<std::uint64_t> BenchGuard::conflict() const noexcept {
  const std::uint64_t older = older_;
  return older == 0 ? std::nullopt : std::optional(older);
}

}  // namespace vdrive::service
