// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ros_messages_description.hpp"
#include "vdrive/wire/ros_types.hpp"

#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include <cstddef>
#include <string>
#include <string_view>

namespace vdrive::ros {

/// How the samples of a type are sent and kept.
struct Traits {
  bool kept_for_late = false;     ///< by the writer: TRANSIENT_LOCAL
  bool takes_any_writer = false;  ///< by the reader: best effort
};

template <typename Message>
inline constexpr Traits kTraits{};
template <>
inline constexpr Traits kTraits<JointState>{.takes_any_writer = true};
template <>
inline constexpr Traits kTraits<Log>{.kept_for_late = true};

/// @return the name of a type in ROS form, such as "sensor_msgs/msg/JointState" for
///         "sensor_msgs::msg::dds_::JointState_" of the IDL.
template <typename Message>
std::string ros_name() {
  const std::string_view name = wire::Description<Message>::kName;
  const std::size_t package = name.find("::");
  const std::size_t last = name.rfind("::") + 2;
  return std::string(name.substr(0, package)) + "/msg/" +
         std::string(name.substr(last, name.size() - last - 1));
}

[[nodiscard]] eprosima::fastdds::dds::DataWriterQos writer_qos(std::string_view type,
                                                               const Traits& traits);
[[nodiscard]] eprosima::fastdds::dds::DataReaderQos reader_qos(std::string_view type,
                                                               const Traits& traits);

}  // namespace vdrive::ros
