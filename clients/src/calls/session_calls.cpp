// SPDX-License-Identifier: Apache-2.0
// The calls of a session that command axes.
#include "calls/axes_stop.hpp"
#include "calls/each_axis.hpp"
#include "session/session_core.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

namespace vdrive::client {

std::vector<Outcome> Session::command_each(std::span<const Axis> axes, EachCommand command,
                                           const CallOptions& options) {
  std::vector<AxisId> ids;
  ids.reserve(axes.size());
  for (const Axis& axis : axes) ids.push_back(axis.id());
  return client::command_each(core_, ids, command, options);
}

Outcome Session::quick_stop(std::uint32_t bench, const CallOptions& options) {
  const Wakeup::StopInProgress in_progress(core_->wakeup);
  const auto found = core_->discovery.find_bench(bench);
  if (!found) return found.outcome();
  AxesCall call(core_, layout_of(found->info), Caller::group);
  AxesStop stop(*core_, call);
  if (Outcome ready = stop.begin(options.timeout); !ready) return ready;
  const Target& target = call.axes().parts().front().target;
  if (core_->discovery.is_paused(target.key)) return Outcome::failed(paused_text(target));
  return stop.quick_stop(options.until);
}

}  // namespace vdrive::client
