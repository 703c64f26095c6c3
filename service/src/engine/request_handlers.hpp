// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/reason.hpp"
#include "engine/axis_requests.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "engine/frame_schedule.hpp"
#include "engine/master_watch.hpp"
#include "engine/masters.hpp"
#include "engine/snapshots.hpp"
#include "engine/store_requests.hpp"
#include "engine/windows.hpp"
#include "vdrive_messages.hpp"

#include <tuple>

namespace vdrive::service {

/// The parts of the engine that request handlers use, each found by its type.
using RequestParts = std::tuple<BenchClock&, BenchEvents&, BenchAxes&, FrameSchedule&, Masters&,
                                MasterWatch&, StoreRequests&, AxisRequests&, Snapshots&, Windows&>;

/// Carries out a request that passed the checks of the row of its kind
/// (vdrive/wire/request_kinds.hpp).
/// @return REASON_NONE, or why the request is refused
using RequestHandler = Reason (*)(const RequestParts& parts, const msg::Request& request,
                                  msg::Reply& reply);

/// @return the handler of a known kind; nullptr for the kinds of StepRequests.
[[nodiscard]] RequestHandler handler_of(msg::RequestKind kind) noexcept;

}  // namespace vdrive::service
