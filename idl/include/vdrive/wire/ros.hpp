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

/// ROS 2 topics over plain DDS. Each type has the quality of service that its readers and writers
/// in ROS expect; the type hash is in USER_DATA. Publication and Subscription are the ends of a
/// topic, like those in wire.
namespace vdrive::ros {

/// @param name in ROS form, such as "/cell1/joint_states"
/// @return the name on DDS, such as "rt/cell1/joint_states".
[[nodiscard]] std::string dds_topic(std::string_view name);

/// @return what is wrong with the name of a ROS topic; empty for a valid one. It starts with '/';
///         its parts consist of letters, digits and '_' and do not start with a digit.
[[nodiscard]] std::string check_topic(std::string_view name);

/// Writes messages of one type: asynchronous, RELIABLE, VOLATILE, KEEP_LAST 10; Log is
/// TRANSIENT_LOCAL, KEEP_LAST 100. Instantiated for Bool, Clock, DiagnosticArray, JointState,
/// JointTrajectory and Log.
template <typename Message>
class Publication {
 public:
  /// @param topic in ROS form
  /// @throws wire::NetworkError when DDS refuses topic or writer.
  Publication(wire::Participant& participant, std::string_view topic);
  ~Publication();
  Publication(const Publication&) = delete;
  Publication& operator=(const Publication&) = delete;

  /// Does not wait for readers. @return false when the message was not accepted.
  bool write(const Message& message) noexcept;

  /// @return how many subscriptions match now.
  [[nodiscard]] std::size_t matched() const noexcept;

 private:
  struct Entities;
  std::unique_ptr<Entities> entities_;
};

/// Receives messages of one type, up to 4 MB each. JointState is best effort, so that it matches
/// every writer; the others are RELIABLE and VOLATILE. Instantiated for the same types as
/// Publication.
template <typename Message>
class Subscription {
 public:
  /// Runs in the DDS receive thread: must be short, must not wait and must not write a message.
  using Handler = std::function<void(const Message& message, const wire::WriterId& writer)>;

  /// @param topic in ROS form
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
