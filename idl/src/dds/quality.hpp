// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/topics.hpp"

#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

namespace vdrive::wire {

/// Quality of service of a topic on its two sides. Limits are always explicit: the library's
/// default of 10 instances loses the eleventh axis without a word.
[[nodiscard]] eprosima::fastdds::dds::DataWriterQos writer_qos(const TopicTraits& topic);
[[nodiscard]] eprosima::fastdds::dds::DataReaderQos reader_qos(const TopicTraits& topic);

}  // namespace vdrive::wire
