// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/description.hpp"
#include "vdrive/wire/message_types.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

/// The only code that writes and reads plain CDR (XCDR version 1): numbers, strings, and everything
/// that has a description.
namespace vdrive::wire {

/// Size of the encapsulation header before every sample [bytes].
inline constexpr std::size_t kEncapsulation = 4;

/// The encapsulation header of plain CDR in little-endian byte order.
inline constexpr std::array<std::byte, kEncapsulation> kLittleEndian{std::byte{0}, std::byte{1},
                                                                     std::byte{0}, std::byte{0}};

template <typename Type>
concept CdrNumber = std::is_arithmetic_v<Type> || std::is_enum_v<Type>;

/// Contiguous elements other than characters.
template <typename Type>
concept CdrSequence =
    !std::convertible_to<const Type&, std::string_view> && requires(const Type& elements) {
  elements.data();
  elements.size();
};

/// The type that `ValueOf` returns for an element of a sequence.
template <CdrSequence Elements, typename ValueOf = std::identity>
using CdrElement = std::remove_cvref_t<
    std::invoke_result_t<const ValueOf&, decltype(*std::declval<const Elements&>().data())>>;

/// @return the padding [bytes] that aligns a number of `size` bytes after `position`.
constexpr std::size_t cdr_gap(std::size_t position, std::size_t size) noexcept {
  return (size - position % size) % size;
}

/// Writes a sample of plain CDR, starting with the encapsulation; padding is zero. Data that does
/// not fit is not written but still counted in size().
class CdrWriter {
 public:
  enum class Order : std::uint8_t { native, big_endian };

  /// @param output may be empty, to determine the size
  explicit CdrWriter(std::span<std::byte> output, Order order = Order::native) noexcept
      : output_(output), swaps_(order == Order::big_endian) {
    static_assert(std::endian::native == std::endian::little, "samples are announced as CDR_LE");
    put_bytes(swaps_ ? std::array<std::byte, kEncapsulation>{} : kLittleEndian);
  }

  template <CdrNumber Number>
  void put(Number number) noexcept {
    align(sizeof(Number));
    const auto bytes = bytes_of(number);
    if (auto* const place = take(bytes.size())) std::memcpy(place, bytes.data(), bytes.size());
  }

  /// Writes a string up to its first NUL.
  void put(std::string_view text) noexcept {
    text = text.substr(0, text.find('\0'));
    put(static_cast<std::uint32_t>(text.size() + 1));
    put_bytes(std::as_bytes(std::span(text)));
    put(std::uint8_t{0});
  }

  template <std::size_t kBound>
  void put(const Text<kBound>& text) noexcept {
    put(std::string_view(text));
  }

  void put(const std::string& text) noexcept { put(std::string_view(text)); }

  /// Writes a sequence: its length, then the result of `value_of` for each element.
  template <CdrSequence Elements, typename ValueOf = std::identity>
  void put(const Elements& elements, const ValueOf& value_of = {}) noexcept {
    put(static_cast<std::uint32_t>(elements.size()));
    if constexpr (CdrNumber<CdrElement<Elements, ValueOf>>) {
      if (elements.size() != 0) put_numbers(elements, value_of);
    } else {
      for (const auto& element : elements) put(std::invoke(value_of, element));
    }
  }

  template <DescribedStruct Struct>
  void put(const Struct& value) noexcept {
    for_each_member<Struct>([&](const auto& member) {
      put(value.*member.pointer);
    });
  }

  /// @return the size of the sample so far [bytes], including what did not fit.
  [[nodiscard]] std::size_t size() const noexcept { return position_; }

  [[nodiscard]] bool is_good() const noexcept { return position_ <= output_.size(); }

 private:
  void align(std::size_t size) noexcept {
    for (std::size_t gap = cdr_gap(position_ - kEncapsulation, size); gap != 0; --gap) {
      if (auto* const place = take(1)) *place = std::byte{0};
    }
  }

  template <CdrNumber Number>
  [[nodiscard]] auto bytes_of(Number number) const noexcept {
    auto bytes = std::bit_cast<std::array<std::byte, sizeof(Number)>>(number);
    if (swaps_) std::ranges::reverse(bytes);
    return bytes;
  }

  /// Aligns once, and writes all numbers or none.
  template <typename Elements, typename ValueOf>
  void put_numbers(const Elements& elements, const ValueOf& value_of) noexcept {
    using Number = CdrElement<Elements, ValueOf>;
    align(sizeof(Number));
    if constexpr (std::is_same_v<ValueOf, std::identity>) {
      if (!swaps_) return put_bytes(std::as_bytes(std::span(elements)));
    }
    std::byte* place = take(elements.size() * sizeof(Number));
    if (place == nullptr) return;
    for (const auto& element : elements) {
      const auto bytes = bytes_of<Number>(std::invoke(value_of, element));
      std::memcpy(place, bytes.data(), bytes.size());
      place += bytes.size();
    }
  }

  void put_bytes(std::span<const std::byte> bytes) noexcept {
    std::byte* const place = take(bytes.size());
    if (place != nullptr && !bytes.empty()) std::memcpy(place, bytes.data(), bytes.size());
  }

  /// @return where to write the next bytes; nullptr if they do not fit.
  std::byte* take(std::size_t bytes) noexcept {
    const std::size_t begin = position_;
    position_ += bytes;
    return position_ <= output_.size() ? output_.data() + begin : nullptr;
  }

  std::span<std::byte> output_;
  std::size_t position_ = 0;
  bool swaps_;
};

/// Writes a sample of any size into `bytes`, a container of bytes, which is resized to fit.
/// @param write called twice with a CdrWriter, first to determine the size
template <typename Bytes, typename Write>
void write_sample(Bytes& bytes, const Write& write) {
  CdrWriter size({});
  write(size);
  bytes.resize(size.size());
  CdrWriter writer(std::as_writable_bytes(std::span(bytes)));
  write(writer);
}

/// @return the minimum size of a value [bytes]; for a string or sequence, the size of its length
///         field.
template <typename Value>
constexpr std::size_t smallest_size() noexcept {
  if constexpr (CdrNumber<Value>) {
    return sizeof(Value);
  } else if constexpr (DescribedStruct<Value>) {
    std::size_t size = 0;
    for_each_member<Value>([&size]<typename Part>(const Member<Value, Part>& /*member*/) {
      size += smallest_size<Part>();
    });
    return size;
  } else {
    return sizeof(std::uint32_t);
  }
}

/// Reads plain CDR in either byte order and checks every length before using it. After the first
/// failure every value is 0 and every string and sequence is empty.
class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> sample) noexcept
      : sample_(sample),
        is_good_(sample.size() >= kEncapsulation && sample[0] == std::byte{0} &&
                 (sample[1] == std::byte{0} || sample[1] == std::byte{1})),
        swaps_(is_good_ && sample[1] == std::byte{0}) {}

  [[nodiscard]] bool is_good() const noexcept { return is_good_; }

  /// @return the name of the member whose sequence is longer than the IDL allows, if that was the
  ///         failure; otherwise empty.
  [[nodiscard]] std::string_view beyond_bound() const noexcept { return beyond_bound_; }

  /// @return whether the sample has the byte order of this machine.
  [[nodiscard]] bool is_native() const noexcept { return is_good_ && !swaps_; }

  /// @return the position of the next value from the start of the sample.
  [[nodiscard]] std::size_t position() const noexcept { return position_; }

  template <CdrNumber Number>
  [[nodiscard]] Number next() noexcept {
    if constexpr (std::is_same_v<Number, bool>) {
      const auto byte = next<std::uint8_t>();
      if (byte > 1) is_good_ = false;
      return byte == 1;
    } else {
      Number number{};
      get(std::span(&number, 1));
      return number;
    }
  }

  /// @return a string up to its first NUL, as a view of the bytes of the sample.
  [[nodiscard]] std::string_view next_text() noexcept {
    const std::size_t length = next<std::uint32_t>();
    if (length == 0 || !has(length)) return {};
    // NOLINTNEXTLINE(*-reinterpret-cast): bytes are characters
    const std::string_view text(reinterpret_cast<const char*>(&sample_[position_]), length);
    position_ += length;
    return text.substr(0, text.find('\0'));
  }

  /// Reads consecutive numbers, such as those of a sequence.
  template <CdrNumber Number>
  void get(std::span<Number> numbers) noexcept {
    constexpr std::size_t kSize = sizeof(Number);
    if (numbers.empty()) return;
    position_ += cdr_gap(position_ - kEncapsulation, kSize);
    if (!has(numbers.size_bytes())) {
      std::ranges::fill(numbers, Number{});
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

  /// The default way to resize a sequence, which keeps its capacity.
  static constexpr auto kResize = [](auto& elements, std::size_t count) {
    elements.resize(count);
  };

  /// Reads a complete struct.
  /// @param resize called with each sequence and its new length
  template <DescribedStruct Struct, typename Resize = decltype(kResize)>
  void get(Struct& value, const Resize& resize = kResize) {
    for_each_member<Struct>([&](const auto& member) {
      get(member, value.*member.pointer, resize);
    });
  }

  // The value of one member:

  template <CdrNumber Number, typename Resize = decltype(kResize)>
  void get(const MemberTraits& /*member*/, Number& number, const Resize& /*resize*/ = kResize) {
    number = next<Number>();
  }

  template <std::size_t kBound, typename Resize>
  void get(const MemberTraits& /*member*/, Text<kBound>& text, const Resize& /*resize*/) {
    text = next_text();
  }

  template <typename Resize>
  void get(const MemberTraits& /*member*/, std::string& text, const Resize& /*resize*/) {
    text = next_text();
  }

  template <DescribedStruct Struct, typename Resize>
  void get(const MemberTraits& /*member*/, Struct& value, const Resize& resize) {
    get(value, resize);
  }

  template <typename Element, typename Resize = decltype(kResize)>
  void get(const MemberTraits& member, std::vector<Element>& elements,
           const Resize& resize = kResize) {
    resize(elements, next_length(member, smallest_size<Element>()));
    if constexpr (CdrNumber<Element>) {
      get(std::span(elements));
    } else {
      for (Element& element : elements) get(member, element, resize);
    }
    // If a sequence in an element is beyond its bound, drop all elements, because that element was
    // read only in part.
    if (!beyond_bound_.empty()) resize(elements, 0);
  }

  /// @param smallest minimum size of an element [bytes], so that a sample that claims more elements
  ///        than it can hold costs no memory
  /// @return the length of a sequence; 0 if it is beyond its bound or the sample is too short
  std::size_t next_length(const MemberTraits& member, std::size_t smallest = 1) noexcept {
    const std::size_t length = next<std::uint32_t>();
    if (member.bound != 0 && length > member.bound) {
      is_good_ = false;
      beyond_bound_ = member.name;
    }
    return has(length * smallest) ? length : 0;
  }

 private:
  /// Fails if fewer than `bytes` are left.
  bool has(std::size_t bytes) noexcept {
    is_good_ = is_good_ && position_ <= sample_.size() && bytes <= sample_.size() - position_;
    return is_good_;
  }

  std::span<const std::byte> sample_;
  std::size_t position_ = kEncapsulation;
  std::string_view beyond_bound_{};
  bool is_good_;
  bool swaps_;
};

/// Not constexpr, so that asking for the place of a member after one of variable size does not
/// compile.
inline void has_no_fixed_place() noexcept {}

/// Returns the position of a member, from the start of its struct.
/// @param begin position of the struct from the end of the encapsulation, where CDR alignment
///        starts
template <DescribedStruct Struct>
constexpr std::size_t place_of_member(std::string_view name, std::size_t begin = 0) {
  std::size_t place = 0;
  bool is_found = false;
  bool is_fixed = true;  // all members so far have a fixed size
  for_each_member<Struct>([&]<typename Number>(const Member<Struct, Number>& member) {
    if (is_found) return;
    if (!is_fixed) has_no_fixed_place();
    if constexpr (CdrNumber<Number>) {
      place += cdr_gap(begin + place, sizeof(Number));
      is_found = member.name == name;
      if (!is_found) place += sizeof(Number);
    } else {
      // The length of a string or of a sequence.
      place += cdr_gap(begin + place, sizeof(std::uint32_t));
      is_found = member.name == name;
      is_fixed = false;
    }
  });
  if (!is_found) is_no_member_of_the_struct();
  return place;
}

/// Returns the end of a value that starts at `begin`, both counted from the end of the
/// encapsulation. Bounded strings and sequences count with their maximum length, unbounded ones as
/// empty.
template <CdrNumber Number>
constexpr std::size_t largest_end(std::size_t begin, std::type_identity<Number>,
                                  std::size_t /*bound*/) noexcept {
  return begin + cdr_gap(begin, sizeof(Number)) + sizeof(Number);
}

template <std::size_t kBound>
constexpr std::size_t largest_end(std::size_t begin, std::type_identity<Text<kBound>>,
                                  std::size_t /*bound*/) noexcept {
  return largest_end(begin, std::type_identity<std::uint32_t>{}, 0) + kBound + 1;
}

constexpr std::size_t largest_end(std::size_t begin, std::type_identity<std::string>,
                                  std::size_t /*bound*/) noexcept {
  return largest_end(begin, std::type_identity<std::uint32_t>{}, 0) + 1;
}

template <DescribedStruct Struct>
constexpr std::size_t largest_end(std::size_t begin, std::type_identity<Struct>,
                                  std::size_t bound) noexcept;

template <typename Element>
constexpr std::size_t largest_end(std::size_t begin, std::type_identity<std::vector<Element>>,
                                  std::size_t bound) noexcept {
  std::size_t end = largest_end(begin, std::type_identity<std::uint32_t>{}, 0);
  for (std::size_t element = 0; element < bound; ++element) {
    end = largest_end(end, std::type_identity<Element>{}, 0);
  }
  return end;
}

template <DescribedStruct Struct>
constexpr std::size_t largest_end(std::size_t begin, std::type_identity<Struct>,
                                  std::size_t /*bound*/) noexcept {
  std::size_t end = begin;
  for_each_member<Struct>([&]<typename Value>(const Member<Struct, Value>& member) {
    end = largest_end(end, std::type_identity<Value>{}, member.bound);
  });
  return end;
}

/// @return the maximum size of a sample of a struct [bytes], including its encapsulation.
template <DescribedStruct Struct>
[[nodiscard]] constexpr std::size_t largest_sample() noexcept {
  return kEncapsulation + largest_end(0, std::type_identity<Struct>{}, 0);
}

}  // namespace vdrive::wire
