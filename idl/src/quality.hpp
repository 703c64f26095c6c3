// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include <cstdint>
#include <string_view>

namespace vdrive::wire {

/// Quality of service of one topic, the same on both sides. Limits are always explicit: the
/// library's default of 10 instances loses the eleventh axis without a word.
struct TopicQuality {
  bool reliable = false;
  bool transient_local = false;
  bool keep_all = false;
  std::int32_t depth = 1;      ///< samples kept of an instance
  std::int32_t instances = 1;  ///< keys in the whole domain
};

/// @return the quality of topic `name` (vdrive/wire/topics.hpp).
[[nodiscard]] TopicQuality quality_of(std::string_view name);

[[nodiscard]] eprosima::fastdds::dds::DataWriterQos writer_qos(const TopicQuality& quality);
[[nodiscard]] eprosima::fastdds::dds::DataReaderQos reader_qos(const TopicQuality& quality);

}  // namespace vdrive::wire
