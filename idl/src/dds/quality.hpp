// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dds/library/library.hpp"
#include "vdrive/wire/topics.hpp"

namespace vdrive::wire {

/// Quality of service of a topic on its two sides. Limits are always explicit: the
/// default of 10 instances of Fast DDS 2.9 and 3.1 loses the eleventh axis without a word.
[[nodiscard]] dds::DataWriterQos writer_qos(const TopicTraits& topic);
[[nodiscard]] dds::DataReaderQos reader_qos(const TopicTraits& topic);

}  // namespace vdrive::wire
