// SPDX-License-Identifier: Apache-2.0
#include "bench_control.hpp"

#include <utility>

namespace vdrive::bridge {

BenchControl::BenchControl(client::Session& session, Reports& reports,
                           std::vector<client::AxisId> axes, Options options)
    : session_(session),
      reports_(reports),
      axes_(std::move(axes)),
      options_(std::move(options)),
      keeper_(session.id(), *this, options_.remedies) {
  if (options_.is_automatic) keeper_.want(true);
}

std::optional<client::Observation> BenchControl::keep(std::span<const client::AxisSnapshot> axes) {
  auto held = keeper_.keep(axes, ControlKeeper::Clock::now());
  if (held) {
    // The state of a paused bench contains no owner, but control was just acquired.
    for (client::AxisSnapshot& axis : held->axes) {
      if (!axis.has_owner) axis.owner_session = session_.id();
    }
    return held;
  }
  const bool are_free = !other_owner(axes, session_.id());
  if (options_.is_automatic && are_free && !owns_all(axes, session_.id())) keeper_.want(true);
  return std::nullopt;
}

std::optional<client::Observation> BenchControl::observe() {
  auto now = session_.observe(axes_);
  if (!now) return std::nullopt;
  return std::move(*now);
}

std::string BenchControl::name_of(std::uint64_t session) {
  return client::owner_text(session, session_.find_name(axes_.front().bench, session));
}

}  // namespace vdrive::bridge
