// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/reason.hpp"
#include "engine/axis_writer.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "engine/frame_schedule.hpp"
#include "engine/masters.hpp"
#include "engine/store_requests.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>

namespace vdrive::service {

/// Requests that read and write objects of axes. Each function returns REASON_NONE, or why the
/// request is refused.
class AxisRequests {
 public:
  AxisRequests(BenchAxes& axes, AxisWriter& writer, const BenchClock& clock, Masters& masters,
               FrameSchedule& schedule, StoreRequests& stores, BenchEvents& events);

  [[nodiscard]] Reason read(const msg::Request& request, msg::Reply& reply) const;
  [[nodiscard]] Reason write(const msg::Request& request, msg::Reply& reply);

 private:
  [[nodiscard]] Reason write_object(const msg::ObjectAccess& object, std::uint64_t session,
                                    std::size_t place);
  [[nodiscard]] Reason stop_axis(std::size_t axis, bool by_halt, std::uint64_t session);
  [[nodiscard]] Reason write_command_object(std::size_t axis, ObjectRow row, std::int64_t value,
                                            std::uint64_t session);

  BenchAxes& axes_;
  AxisWriter& writer_;
  const BenchClock& clock_;
  Masters& masters_;
  FrameSchedule& schedule_;
  StoreRequests& stores_;
  BenchEvents& events_;
};

}  // namespace vdrive::service
