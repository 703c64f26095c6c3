// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <iterator>
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

  /// A sequence: the number of its elements, and them. Room is made once for all.
  /// @param value_of gives the number of an element, as a type of its own width
  template <typename Elements, typename Value = std::identity>
  void put_sequence(const Elements& elements, const Value& value_of = {}) {
    using Number =
        std::remove_cvref_t<std::invoke_result_t<const Value&, decltype(*std::begin(elements))>>;
    static_assert(std::integral<Number> || std::floating_point<Number>);
    put_count(std::size(elements));
    if (std::empty(elements)) return;
    align(sizeof(Number));
    const std::size_t place = out_.size();
    out_.resize(place + std::size(elements) * sizeof(Number));
    char* next = out_.data() + place;
    for (const auto& element : elements) {
      const Number number = std::invoke(value_of, element);
      std::memcpy(next, &number, sizeof(Number));
      next += sizeof(Number);
    }
  }

  /// The same with elements of `type`, which holds each of the numbers.
  template <typename Elements, typename Value>
  void put_sequence(DataType type, const Elements& elements, const Value& value_of) {
    // Of the width of the type: negative numbers have the same bits without a sign.
    const auto put_as = [&]<typename Number>(Number /*width*/) {
      put_sequence(elements, [&](const auto& element) {
        return static_cast<Number>(value_of(element));
      });
    };
    switch (size_of(type)) {
      case sizeof(std::uint8_t):
        return put_as(std::uint8_t{});
      case sizeof(std::uint16_t):
        return put_as(std::uint16_t{});
      default:
        return put_as(std::uint32_t{});
    }
  }

  /// A time of ROS: seconds and nanoseconds. Seconds beyond 2^31 - 1 wrap, as they do there.
  void put_time(std::uint64_t nanoseconds);

 private:
  void align(std::size_t size);

  std::string& out_;
  std::size_t start_;
};

}  // namespace vdrive::bridge
