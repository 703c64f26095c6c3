// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <type_traits>

/// What the IDL says about a type. Everything that goes through the members of a message goes
/// through its description: encoding, decoding, bounds, keys, texts, columns, metrics.
namespace vdrive::wire {

/// Made from the IDL for each struct: kName (in full), kHelp and kMembers, a tuple of `Member` in
/// the order of the IDL; for each enumeration: kName and kValues, an array of EnumerationValue.
template <typename Described>
struct Description;

/// What a figure does: a counter only grows, a gauge rises and falls.
enum class FigureKind : std::uint8_t { none, counter, gauge };

/// What does not depend on the type of a member.
struct MemberTraits {
  std::string_view name;
  std::string_view unit{};  ///< empty = none
  std::string_view help{};
  std::size_t bound = 0;  ///< elements of a sequence; 0 = no sequence, or any number
  bool is_key = false;
  double least = 0;  ///< with `most`, the range; both 0 = that of the type
  double most = 0;
  FigureKind figure = FigureKind::none;  ///< none = no figure
  bool is_headline = false;              ///< a figure that is shown where there is room for a few
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
  std::string_view name;  ///< that of the constant in small letters, without its prefix
  std::string_view help;
};

template <typename Type>
concept DescribedStruct = requires {
  Description<Type>::kMembers;
};

/// Calls `visit(member)` for each member of a struct, in the order of the IDL.
template <DescribedStruct Struct, typename Visit>
constexpr void for_each_member(Visit&& visit) {
  std::apply(
      [&](const auto&... members) {
        (visit(members), ...);
      },
      Description<Struct>::kMembers);
}

/// Calls `visit(member)` for each figure of a struct. Figures are unsigned numbers.
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

/// No constant expression: what calls it does not compile.
inline void is_no_member_of_the_struct() noexcept {}

/// @return the place of a member among those of its struct; a name that it does not have does not
///         compile.
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

/// @return what the IDL says about a value of an enumeration; nullptr for another number.
template <typename Enumeration>
[[nodiscard]] constexpr const EnumerationValue* value_row(Enumeration value) noexcept {
  for (const EnumerationValue& row : Description<Enumeration>::kValues) {
    if (row.number == static_cast<std::uint32_t>(value)) return &row;
  }
  return nullptr;
}

}  // namespace vdrive::wire
