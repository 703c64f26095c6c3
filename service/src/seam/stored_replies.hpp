// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/stored_list.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>

namespace vdrive::service {

/// The answer to a command frame, with room for the largest one and without an allocation.
class StoredCommandReply {
 public:
  void keep(const msg::CommandReply& reply);

  /// Allocates nothing where `reply` has room for MAX_AXES_PER_FRAME refusals and set-points.
  void show(msg::CommandReply& reply) const;

 private:
  msg::CommandReply head_;  ///< without its sequences
  StoredList<std::uint16_t, msg::MAX_AXES_PER_FRAME> ignored_set_points_;
  StoredList<msg::Refusal, msg::MAX_AXES_PER_FRAME> refusals_;
};

/// The answer to a request without the statuses that it shows, with room for the largest one and
/// without an allocation.
class StoredReply {
 public:
  void keep(const msg::Reply& reply);

  /// Allocates nothing where `reply` has room for MAX_OBJECTS_PER_REQUEST objects.
  void show(msg::Reply& reply) const;

 private:
  msg::Reply head_;  ///< without its sequences
  StoredList<msg::ObjectResult, msg::MAX_OBJECTS_PER_REQUEST> objects_;
};

}  // namespace vdrive::service
