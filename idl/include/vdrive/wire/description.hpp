// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <type_traits>

/// The IDL's description of a type. All code that iterates over the members of a message uses its
/// description: encoding, decoding, bounds, keys, texts, columns, metrics.
namespace vdrive::wire {

/// Generated from the IDL. For each struct: kName (fully qualified), kHelp and kMembers, a tuple of
/// `Member` in IDL order. For each enumeration: kName and kValues, an array of EnumerationValue.
template <typename Described>
struct Description;

/// Kind of a figure (metric): a counter only increases, a gauge can go up and down.
enum class FigureKind : std::uint8_t { none, counter, gauge };

/// The properties of a member that do not depend on its type.
struct MemberTraits {
  std::string_view name;
  std::string_view unit{};  ///< empty = none
  std::string_view help{};
  std::size_t bound = 0;  ///< elements of a sequence; 0 = no sequence, or unbounded
  bool is_key = false;
  double least = 0;  ///< range, with `most`; both 0 = range of the type
  double most = 0;
  FigureKind figure = FigureKind::none;  ///< none = not a metric
  bool is_headline = false;              ///< a metric shown even where there is room for only a few
};

/// A member of a struct.
template <typename Struct, typename Value>
struct Member : MemberTraits {
  Value Struct::*pointer;
};

template <typename Struct, typename Value>
Member(MemberTraits, Value Struct::*) -> Member<Struct, Value>;

/// A value of an enumeration.
struct EnumerationValue {
  std::uint32_t number = 0;
  std::string_view name;  ///< the name of the constant in lower case, without its prefix
  std::string_view help;
};

template <typename Type>
concept DescribedStruct = requires {
  Description<Type>::kMembers;
};

/// Calls `visit(member)` for each member of a struct, in IDL order.
template <DescribedStruct Struct, typename Visit>
constexpr void for_each_member(Visit&& visit) {
  std::apply(
      [&](const auto&... members) {
        (visit(members), ...);
      },
      Description<Struct>::kMembers);
}

/// Calls `visit(member)` for each metric of a struct. Metrics are unsigned numbers.
template <DescribedStruct Struct, typename Visit>
constexpr void for_each_figure(Visit&& visit) {
  for_each_member<Struct>([&]<typename Value>(const Member<Struct, Value>& member) {
    if constexpr (std::unsigned_integral<Value>) {
      if (member.figure != FigureKind::none) visit(member);
    }
  });
}

/// @return what the IDL says about a member.
template <DescribedStruct Struct, typename Value>
[[nodiscard]] constexpr const MemberTraits& traits_of(Value Struct::*pointer) {
  const MemberTraits* found = nullptr;
  for_each_member<Struct>([&]<typename Other>(const Member<Struct, Other>& member) {
    if constexpr (std::is_same_v<Other, Value>) {
      if (member.pointer == pointer) found = &member;
    }
  });
  return *found;
}

/// Not constexpr, so that code calling it in a constant expression does not compile.
inline void is_no_member_of_the_struct() noexcept {}

/// @return the position of a member in its struct; an unknown name does not compile.
template <DescribedStruct Struct>
[[nodiscard]] constexpr std::size_t member_index(std::string_view name) {
  std::size_t index = 0;
  bool is_found = false;
  for_each_member<Struct>([&](const MemberTraits& member) {
    is_found = is_found || member.name == name;
    if (!is_found) ++index;
  });
  if (!is_found) is_no_member_of_the_struct();
  return index;
}

/// @return what the IDL says about a value of an enumeration; nullptr for an unknown number.
template <typename Enumeration>
[[nodiscard]] constexpr const EnumerationValue* value_row(Enumeration value) noexcept {
  for (const EnumerationValue& row : Description<Enumeration>::kValues) {
    if (row.number == static_cast<std::uint32_t>(value)) return &row;
  }
  return nullptr;
}

}  // namespace vdrive::wire
