// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ros_messagesPubSubTypes.h"
#include "vdrive/wire/ros_types.hpp"

#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include <string_view>

namespace vdrive::ros {

/// What publication and subscription of a type need to know.
struct Traits {
  std::string_view type;          ///< as ROS writes it
  bool kept_for_late = false;     ///< of the writer: TRANSIENT_LOCAL
  bool takes_any_writer = false;  ///< of the reader: best effort
};

/// The generated support class of a type, and its traits.
template <typename Message>
struct SupportOf;

template <>
struct SupportOf<Bool> {
  using Type = std_msgs::msg::dds_::Bool_PubSubType;
  static constexpr Traits kTraits{.type = "std_msgs/msg/Bool"};
};

template <>
struct SupportOf<Clock> {
  using Type = rosgraph_msgs::msg::dds_::Clock_PubSubType;
  static constexpr Traits kTraits{.type = "rosgraph_msgs/msg/Clock"};
};

template <>
struct SupportOf<DiagnosticArray> {
  using Type = diagnostic_msgs::msg::dds_::DiagnosticArray_PubSubType;
  static constexpr Traits kTraits{.type = "diagnostic_msgs/msg/DiagnosticArray"};
};

template <>
struct SupportOf<JointState> {
  using Type = sensor_msgs::msg::dds_::JointState_PubSubType;
  static constexpr Traits kTraits{.type = "sensor_msgs/msg/JointState", .takes_any_writer = true};
};

template <>
struct SupportOf<JointTrajectory> {
  using Type = trajectory_msgs::msg::dds_::JointTrajectory_PubSubType;
  static constexpr Traits kTraits{.type = "trajectory_msgs/msg/JointTrajectory"};
};

template <>
struct SupportOf<Log> {
  using Type = rcl_interfaces::msg::dds_::Log_PubSubType;
  static constexpr Traits kTraits{.type = "rcl_interfaces/msg/Log", .kept_for_late = true};
};

/// The generated support class without type objects on the wire and without exceptions out of a
/// malformed payload.
template <typename Message>
class MessageType final : public SupportOf<Message>::Type {
 public:
  MessageType() {
    constexpr std::uint32_t kLargest = 4U << 20U;  // [bytes] a trajectory of thousands of points
    this->auto_fill_type_object(false);
    this->auto_fill_type_information(false);
    this->m_typeSize = kLargest;
  }

  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    try {
      return SupportOf<Message>::Type::deserialize(payload, data);
    } catch (...) {  // unknown encapsulation, absurd length: the sample is dropped
      return false;
    }
  }
};

[[nodiscard]] eprosima::fastdds::dds::DataWriterQos writer_qos(const Traits& traits);
[[nodiscard]] eprosima::fastdds::dds::DataReaderQos reader_qos(const Traits& traits);

}  // namespace vdrive::ros
