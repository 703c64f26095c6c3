// SPDX-License-Identifier: Apache-2.0
#include "vdrive/event_kind.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <string_view>
#include <utility>

namespace vdrive {
namespace {

/// @return the name of the enumerator, as the compiler writes it.
template <EventKind kKind>
std::string_view enumerator_of_kind() {
  std::string_view text = __PRETTY_FUNCTION__;
  text.remove_prefix(text.rfind("EventKind::") + std::string_view("EventKind::").size());
  return text.substr(0, text.find_first_of(";]"));
}

template <std::size_t... kPlaces>
auto enumerators_of_kinds(std::index_sequence<kPlaces...> /*places*/) {
  return std::array{enumerator_of_kind<static_cast<EventKind>(kPlaces + 1)>()...};
}

TEST(EventKinds, AreNamedAsTheirEnumeratorsInTheOrderOfTheirNumbers) {
  const auto names = enumerators_of_kinds(std::make_index_sequence<kEventKinds.size()>());
  for (std::size_t place = 0; place < names.size(); ++place) {
    EXPECT_EQ(names[place], kEventKinds[place].name);
    EXPECT_EQ(static_cast<std::size_t>(kEventKinds[place].kind), place + 1);
    EXPECT_EQ(to_string(kEventKinds[place].kind), kEventKinds[place].name);
  }
}

TEST(EventKinds, OfALaterVersionAreUnknownAndNoAlarm) {
  for (const auto kind : {EventKind{}, static_cast<EventKind>(kEventKinds.size() + 1)}) {
    EXPECT_EQ(to_string(kind), "unknown");
    EXPECT_EQ(severity_of(kind), EventSeverity::info);
  }
}

// An axis that loses its master stops, and so does an axis with a fault; a refusal stops nothing.
TEST(EventKinds, AreErrorsWhereAxesStop) {
  EXPECT_EQ(severity_of(EventKind::fault), EventSeverity::error);
  EXPECT_EQ(severity_of(EventKind::master_lost), EventSeverity::error);
  EXPECT_EQ(severity_of(EventKind::refused), EventSeverity::warning);
  EXPECT_EQ(severity_of(EventKind::control_changed), EventSeverity::info);
}

}  // namespace
}  // namespace vdrive
