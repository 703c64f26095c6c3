// SPDX-License-Identifier: Apache-2.0
// The code generated from our IDL with Fast DDS 3: by fastddsgen 4, for Fast CDR 2.
#pragma once

#include "fast_ros_messagesCdrAux.ipp"
#include "fast_vdrive_messagesCdrAux.ipp"

#include <fastcdr/Cdr.h>
#include <fastcdr/CdrSizeCalculator.hpp>
#include <fastcdr/FastBuffer.h>

#include <cstddef>

namespace vdrive::wire {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

inline constexpr auto kPlainCdr = eprosima::fastcdr::CdrVersion::XCDRv1;

template <typename FastMessage>
void read_by_fast_dds(Cdr& cdr, FastMessage& message) {
  cdr >> message;
}

template <typename FastMessage>
void write_by_fast_dds(Cdr& cdr, const FastMessage& message) {
  cdr << message;
}

template <typename FastMessage>
std::size_t size_by_fast_dds(const FastMessage& message) {
  eprosima::fastcdr::CdrSizeCalculator calculator(kPlainCdr);
  std::size_t alignment = 0;
  return calculator.calculate_serialized_size(message, alignment);
}

inline std::size_t length_of(const Cdr& cdr) {
  return cdr.get_serialized_data_length();
}

struct SizesOfFastDds {
  std::size_t largest = 0;
  std::size_t key = 0;
};

template <typename FastMessage>
inline constexpr SizesOfFastDds kSizesOfFastDds{};

// The generator puts the type into the names of the constants.
#define VDRIVE_SIZES(type)                                                                   \
  template <>                                                                                \
  inline constexpr SizesOfFastDds kSizesOfFastDds<fast_msg::type> {                          \
    vdrive_fast_msg_##type##_max_cdr_typesize, vdrive_fast_msg_##type##_max_key_cdr_typesize \
  }
VDRIVE_SIZES(CommandFrame);
VDRIVE_SIZES(CommandReply);
VDRIVE_SIZES(Request);
VDRIVE_SIZES(Reply);
VDRIVE_SIZES(StatusFrame);
VDRIVE_SIZES(AxisStatus);
VDRIVE_SIZES(AxisParameters);
VDRIVE_SIZES(Event);
VDRIVE_SIZES(BenchDescription);
VDRIVE_SIZES(BenchState);
VDRIVE_SIZES(SessionName);
VDRIVE_SIZES(BenchSession);
#undef VDRIVE_SIZES

/// The largest size of fastddsgen 4 is an upper bound: a sample may be up to 8 bytes shorter.
inline constexpr std::size_t kLargestExceedsBy = 8;

template <typename FastMessage>
std::size_t largest_by_fast_dds() {
  return kSizesOfFastDds<FastMessage>.largest;
}

template <typename FastMessage>
bool has_key_by_fast_dds() {
  return kSizesOfFastDds<FastMessage>.key != 0;
}

/// For a type without a key, the generator makes one from all members.
template <typename FastMessage>
void write_key_by_fast_dds(Cdr& cdr, const FastMessage& message) {
  if (has_key_by_fast_dds<FastMessage>()) eprosima::fastcdr::serialize_key(cdr, message);
}

}  // namespace vdrive::wire
