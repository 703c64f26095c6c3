// SPDX-License-Identifier: Apache-2.0
#include "bounds.hpp"

#include <algorithm>

namespace vdrive::wire {
namespace {

constexpr std::size_t kLatenessBins = 32;

}  // namespace

bool within_bounds(const msg::CommandFrame& message) noexcept {
  return message.axes().size() <= msg::MAX_AXES_PER_FRAME &&
         std::ranges::all_of(message.axes(), [](const auto& axis) {
           return axis.objects().size() <= msg::MAX_OBJECTS_PER_AXIS;
         });
}

bool within_bounds(const msg::CommandReply& message) noexcept {
  return message.refusals().size() <= msg::MAX_AXES_PER_FRAME &&
         message.ignored_set_points().size() <= msg::MAX_AXES_PER_FRAME;
}

bool within_bounds(const msg::Request& message) noexcept {
  return message.axes().size() <= msg::MAX_AXES_PER_FRAME &&
         message.objects().size() <= msg::MAX_OBJECTS_PER_REQUEST;
}

bool within_bounds(const msg::Reply& message) noexcept {
  return message.objects().size() <= msg::MAX_OBJECTS_PER_REQUEST &&
         message.statuses().size() <= msg::MAX_AXES_PER_FRAME;
}

bool within_bounds(const msg::StatusFrame& message) noexcept {
  return message.axes().size() <= msg::MAX_AXES_PER_FRAME;
}

bool within_bounds(const msg::AxisStatus& /*message*/) noexcept {
  return true;
}

bool within_bounds(const msg::AxisParameters& /*message*/) noexcept {
  return true;
}

bool within_bounds(const msg::Event& /*message*/) noexcept {
  return true;
}

bool within_bounds(const msg::BenchDescription& message) noexcept {
  return message.axes().size() <= msg::MAX_AXES_PER_FRAME;
}

bool within_bounds(const msg::BenchState& message) noexcept {
  return message.lateness_histogram().size() <= kLatenessBins;
}

}  // namespace vdrive::wire
