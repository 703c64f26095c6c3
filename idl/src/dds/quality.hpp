// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dds/library/library.hpp"
#include "vdrive/wire/topics.hpp"

namespace vdrive::wire {

/// Quality of service of both sides of a topic. Limits are always explicit: with the default of 10
/// instances, Fast DDS 2.9 and 3.1 silently lose the eleventh axis.
[[nodiscard]] dds::DataWriterQos writer_qos(const TopicTraits& topic);
[[nodiscard]] dds::DataReaderQos reader_qos(const TopicTraits& topic);

}  // namespace vdrive::wire
