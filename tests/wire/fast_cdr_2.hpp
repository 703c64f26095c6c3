// SPDX-License-Identifier: Apache-2.0
// The code generated from our IDL with Fast DDS 2: by fastddsgen 2, for Fast CDR 1.
#pragma once

#include "fast_ros_messages.h"
#include "fast_vdrive_messages.h"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <cstddef>

namespace vdrive::wire {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

inline constexpr auto kPlainCdr = Cdr::DDS_CDR;

template <typename FastMessage>
void read_by_fast_dds(Cdr& cdr, FastMessage& message) {
  message.deserialize(cdr);
}

template <typename FastMessage>
void write_by_fast_dds(Cdr& cdr, const FastMessage& message) {
  message.serialize(cdr);
}

template <typename FastMessage>
std::size_t size_by_fast_dds(const FastMessage& message) {
  return FastMessage::getCdrSerializedSize(message);
}

inline std::size_t length_of(const Cdr& cdr) {
  return cdr.getSerializedDataLength();
}

/// The largest size of fastddsgen 2 is exact.
inline constexpr std::size_t kLargestExceedsBy = 0;

template <typename FastMessage>
std::size_t largest_by_fast_dds() {
  return FastMessage::getMaxCdrSerializedSize();
}

template <typename FastMessage>
bool has_key_by_fast_dds() {
  return FastMessage::isKeyDefined();
}

template <typename FastMessage>
void write_key_by_fast_dds(Cdr& cdr, const FastMessage& message) {
  message.serializeKey(cdr);
}

}  // namespace vdrive::wire
