// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/codec.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace vdrive::wire {

/// Reads plain CDR of either byte order. After the first failure every value is 0.
class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> sample) noexcept
      : sample_(sample),
        is_good_(sample.size() >= kEncapsulation && sample[0] == std::byte{0} &&
                 (sample[1] == std::byte{0} || sample[1] == std::byte{1})),
        swaps_(is_good_ && sample[1] == std::byte{0}) {}

  [[nodiscard]] bool is_good() const noexcept { return is_good_; }

  /// Alignment counts from the end of the encapsulation.
  template <std::integral Number>
  Number next() noexcept {
    Number number = 0;
    next(std::span(&number, 1));
    return number;
  }

  /// Numbers that follow each other, as those of a sequence.
  template <std::integral Number>
  void next(std::span<Number> numbers) noexcept {
    constexpr std::size_t kSize = sizeof(Number);
    if (numbers.empty()) return;
    position_ = (position_ - kEncapsulation + kSize - 1) / kSize * kSize + kEncapsulation;
    if (!is_good_ || position_ + numbers.size_bytes() > sample_.size()) {
      is_good_ = false;
      std::ranges::fill(numbers, Number{0});
      return;
    }
    std::memcpy(numbers.data(), &sample_[position_], numbers.size_bytes());
    position_ += numbers.size_bytes();
    if (!swaps_) return;
    for (Number& number : numbers) {
      auto bytes = std::bit_cast<std::array<std::byte, kSize>>(number);
      std::ranges::reverse(bytes);
      number = std::bit_cast<Number>(bytes);
    }
  }

  double next_double() noexcept { return std::bit_cast<double>(next<std::uint64_t>()); }

  /// @return where the next number is searched, from the beginning of the sample.
  [[nodiscard]] std::size_t position() const noexcept { return position_; }

  /// @return whether the sample has the byte order of this machine.
  [[nodiscard]] bool is_native() const noexcept { return is_good_ && !swaps_; }

 private:
  std::span<const std::byte> sample_;
  std::size_t position_ = kEncapsulation;
  bool is_good_;
  bool swaps_;
};

/// Writes plain CDR in little-endian byte order; the gaps that align numbers are zeros. What does
/// not fit is left out.
class CdrWriter {
 public:
  explicit CdrWriter(std::span<std::byte> output) noexcept : output_(output) {
    constexpr std::array<std::byte, kEncapsulation> kLittleEndian{std::byte{0}, std::byte{1},
                                                                  std::byte{0}, std::byte{0}};
    put_bytes(kLittleEndian);
  }

  template <std::integral Number>
  void put(Number number) noexcept {
    constexpr std::array<std::byte, sizeof(Number)> kZeros{};
    const std::size_t gap =
        (sizeof(Number) - (position_ - kEncapsulation) % sizeof(Number)) % sizeof(Number);
    put_bytes(std::span(kZeros).first(gap));
    put_bytes(std::bit_cast<std::array<std::byte, sizeof(Number)>>(number));
  }

  /// @return how many bytes were written, or would have been.
  [[nodiscard]] std::size_t size() const noexcept { return position_; }

  [[nodiscard]] bool is_good() const noexcept { return position_ <= output_.size(); }

 private:
  void put_bytes(std::span<const std::byte> bytes) noexcept {
    if (position_ + bytes.size() <= output_.size() && !bytes.empty()) {
      std::memcpy(&output_[position_], bytes.data(), bytes.size());
    }
    position_ += bytes.size();
  }

  std::span<std::byte> output_;
  std::size_t position_ = 0;
};

}  // namespace vdrive::wire
