// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <string_view>
#include <type_traits>

namespace vdrive::wire {

/// A string in a message: up to `kBound` bytes stored inline, without a NUL. It is cut off at its
/// bound and, as in DDS libraries, at its first NUL.
template <std::size_t kBound>
class Text {
 public:
  Text() = default;

  // NOLINTBEGIN(google-explicit-constructor,*-explicit-conversions): stands for a text
  Text(std::string_view text) noexcept
      : size_(std::min(text.substr(0, text.find('\0')).size(), kBound)) {
    std::copy_n(text.begin(), size_, bytes_.begin());
  }

  Text(const char* text) noexcept : Text(std::string_view(text)) {}

  Text(const std::string& text) noexcept : Text(std::string_view(text)) {}

  operator std::string_view() const noexcept { return {bytes_.data(), size_}; }

  // NOLINTEND(google-explicit-constructor,*-explicit-conversions)

  [[nodiscard]] std::string to_string() const { return std::string(std::string_view(*this)); }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }

  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }

  template <std::convertible_to<std::string_view> Other>
  friend bool operator==(const Text& one, const Other& other) noexcept {
    return std::string_view(one) == std::string_view(other);
  }

  friend std::ostream& operator<<(std::ostream& stream, const Text& text) {
    return stream << std::string_view(text);
  }

 private:
  std::size_t size_ = 0;
  std::array<char, kBound> bytes_{};
};

/// @return the number of an enumeration value, as used in counters, events and outcomes.
template <typename Enumeration>
[[nodiscard]] constexpr std::uint32_t number(Enumeration value) noexcept {
  static_assert(std::is_same_v<std::underlying_type_t<Enumeration>, std::uint32_t>);
  return static_cast<std::uint32_t>(value);
}

}  // namespace vdrive::wire
