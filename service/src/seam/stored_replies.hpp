// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/stored_list.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>

namespace vdrive::service {

/// The answer to a command frame, stored in place with room for the largest one.
class StoredCommandReply {
 public:
  void keep(const msg::CommandReply& reply);

  /// Copies the answer to `reply`. Does not allocate if `reply` has capacity for MAX_AXES_PER_FRAME
  /// refusals and set-points.
  void show(msg::CommandReply& reply) const;

 private:
  msg::CommandReply head_;  ///< without its sequences
  StoredList<std::uint16_t, msg::MAX_AXES_PER_FRAME> ignored_set_points_;
  StoredList<msg::Refusal, msg::MAX_AXES_PER_FRAME> refusals_;
};

/// The answer to a request without its statuses, stored in place with room for the largest one.
class StoredReply {
 public:
  void keep(const msg::Reply& reply);

  /// Copies the answer to `reply`. Does not allocate if `reply` has capacity for
  /// MAX_OBJECTS_PER_REQUEST objects.
  void show(msg::Reply& reply) const;

 private:
  msg::Reply head_;  ///< without its sequences
  StoredList<msg::ObjectResult, msg::MAX_OBJECTS_PER_REQUEST> objects_;
};

}  // namespace vdrive::service
