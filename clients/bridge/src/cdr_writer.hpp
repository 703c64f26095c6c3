// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace vdrive::bridge {

/// Writes one message as plain CDR version 1, little-endian, behind the encapsulation header of
/// four bytes that ROS 2 and its tools expect. Each number is aligned to its own size, counted from
/// the end of that header.
class CdrWriter {
 public:
  /// @param out takes the message behind what it has; must outlive the writer
  explicit CdrWriter(std::string& out);

  template <typename Number>
  requires std::integral<Number> || std::floating_point<Number>

  void put(Number number) {
    static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");
    align(sizeof(Number));
    const std::size_t place = out_.size();
    out_.resize(place + sizeof(Number));
    std::memcpy(out_.data() + place, &number, sizeof(Number));
  }

  /// Writes `value` as `type`; the type of the member that it is from holds it.
  void put(DataType type, std::int64_t value);

  /// A string: its length with the zero that ends it, its bytes, that zero.
  void put(std::string_view text);

  /// The number of elements that follow.
  /// @param count below 2^32
  void put_count(std::size_t count);

  /// A time of ROS: seconds and nanoseconds. Seconds beyond 2^31 - 1 wrap, as they do there.
  void put_time(std::uint64_t nanoseconds);

 private:
  void align(std::size_t size);

  std::string& out_;
  std::size_t start_;
};

}  // namespace vdrive::bridge
