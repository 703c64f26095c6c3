// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/ros_types.hpp"
#include "vdrive/wire/writer_id.hpp"

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

/// Topics of ROS 2 on plain DDS. Each type has the quality of service that its readers and writers
/// in ROS expect; the hash of the type is in USER_DATA. Publication and Subscription are
/// as in wire: the ends of a topic, here of ROS.
namespace vdrive::ros {

/// @param name as ROS writes it, such as "/cell1/joint_states"
/// @return the name on DDS, such as "rt/cell1/joint_states".
[[nodiscard]] std::string dds_topic(std::string_view name);

/// @return what is wrong with the name of a topic in ROS: empty for a good one. It begins with '/',
///         its parts are letters, digits and '_' and begin with no digit.
[[nodiscard]] std::string check_topic(std::string_view name);

/// Writes messages of one type: asynchronously, RELIABLE, VOLATILE, KEEP_LAST 10; Log is
/// TRANSIENT_LOCAL, KEEP_LAST 100. Instantiated for Bool, Clock, DiagnosticArray, JointState,
/// JointTrajectory and Log.
template <typename Message>
class Publication {
 public:
  /// @param topic as ROS writes it
  /// @throws wire::NetworkError when DDS refuses topic or writer.
  Publication(wire::Participant& participant, std::string_view topic);
  ~Publication();
  Publication(const Publication&) = delete;
  Publication& operator=(const Publication&) = delete;

  /// Does not wait for readers. @return false when the message was not taken.
  bool write(const Message& message) noexcept;

  /// @return how many subscriptions match now.
  [[nodiscard]] std::size_t matched() const noexcept;

 private:
  struct Entities;
  std::unique_ptr<Entities> entities_;
};

/// Receives messages of one type, up to 4 MB each: JointState best effort, so that each writer
/// matches; the others RELIABLE and VOLATILE. Instantiated as Publication is.
template <typename Message>
class Subscription {
 public:
  /// Runs in the DDS receive thread: must be short, must not wait and must not write a message.
  using Handler = std::function<void(const Message& message, const wire::WriterId& writer)>;

  /// @param topic as ROS writes it
  /// @throws wire::NetworkError when DDS refuses topic or reader.
  Subscription(wire::Participant& participant, std::string_view topic, Handler handler);
  ~Subscription();  ///< no handler runs after this returns
  Subscription(const Subscription&) = delete;
  Subscription& operator=(const Subscription&) = delete;

  /// @return how many publications match now.
  [[nodiscard]] std::size_t matched() const noexcept;

 private:
  struct Entities;
  std::unique_ptr<Entities> entities_;
};

}  // namespace vdrive::ros
