// SPDX-License-Identifier: Apache-2.0
#include "settings/rows.hpp"

#include "settings/configuration_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::settings {
namespace {

using testing::ElementsAre;

enum class Colour : std::uint8_t { red, blue };

constexpr std::string_view to_string(Colour colour) {
  return colour == Colour::red ? "red" : "blue";
}

struct Lamp {
  Colour colour = Colour::red;
  std::optional<std::chrono::milliseconds> period{};
  std::optional<double> power{};
  std::vector<std::string> names{};
};

struct Room {
  std::string name = "hall";
  Lamp lamp;
};

void refuse_two_names(const YamlValue& value, Room& room) {
  if (room.lamp.names.size() > 1) value.refuse("has two names");
}

constexpr auto kLampRows = std::to_array<Row<Lamp>>({
    key<&Lamp::colour>("colour", kOneOf<Colour::red, Colour::blue>, "Of its light."),
    key<&Lamp::period>("period_ms", IntegerOrNone{{5, 100, "ms"}, "off"}, "It flashes, {} ms."),
});

constexpr auto kMoreRows = std::to_array<Row<Lamp>>({
    key<&Lamp::power>("power", NumberLimits{0.5, 2.0, "W"}),
    key<&Lamp::names>("names", TextRule{.if_empty = "must be text"}),
});

constexpr auto kPowerRows = std::to_array<Row<Lamp>>({key<&Lamp::power>("power")});

constexpr auto kRoomRows = std::to_array<Row<Room>>({
    key<&Room::name>("name", Any{}, "Of the room.", {.needed = "a room needs a name"}),
    section<kLampRows, &Room::lamp>("lamp"),
    section<kMoreRows, &Room::lamp>("more", {.then = refuse_two_names}),
    section<kPowerRows, &Room::lamp>("supply"),
});

Room read_room(const std::string& text) {
  Room room;
  read_section(YamlValue(read_yaml(text, "room.yaml"), "room.yaml", ""), kRoomRows, room);
  return room;
}

std::string refusal_of_room(const std::string& text) {
  try {
    static_cast<void>(read_room(text));
  } catch (const ConfigurationError& error) {
    return error.what();
  }
  return "accepted";
}

std::string printed_room(const Room& room) {
  YAML::Emitter out;
  write_section(out, kRoomRows, room);
  return out.c_str();
}

TEST(SettingsRows, BringEachValueToItsPlace) {
  const Room room = read_room(
      "name: attic\nlamp: {colour: blue, period_ms: 20}\nmore: {power: 1.5, names: [\"1\"]}\n");
  EXPECT_EQ(room.name, "attic");
  EXPECT_EQ(room.lamp.colour, Colour::blue);
  EXPECT_EQ(room.lamp.period, std::chrono::milliseconds(20));
  EXPECT_EQ(room.lamp.power, 1.5);
  EXPECT_THAT(room.lamp.names, ElementsAre("1"));
  EXPECT_EQ(read_room("name: a\nlamp: {period_ms: off}\n").lamp.period, std::nullopt);
}

TEST(SettingsRows, RefuseAValueWithItsPlaceAndRule) {
  EXPECT_EQ(
      refusal_of_room("name: a\nlamp: {colour: rde, period_ms: 4}\nmore: {names: [a, \"\"]}\n"),
      "room.yaml:2: lamp.colour = rde: must be one of red, blue (did you mean 'red'?)\n"
      "room.yaml:2: lamp.period_ms = 4: must be a whole number from 5 to 100 ms\n"
      "room.yaml:3: more.names[1]: must be text");
  EXPECT_EQ(refusal_of_room("name: a\nmore: {power: 3}\n"),
            "room.yaml:2: more.power = 3: must be from 0.5 to 2 W");
  EXPECT_EQ(refusal_of_room("name: a\nmore: {names: [a, b]}\n"),
            "room.yaml:2: more: has two names");
}

TEST(SettingsRows, RefuseAMapWithoutAKeyThatIsNeeded) {
  EXPECT_EQ(refusal_of_room("lamp: {colour: red}\n"), "room.yaml:1: a room needs a name");
}

TEST(SettingsRows, PrintWhatTheyReadAndNoSectionWithoutAValue) {
  const std::string text = printed_room(read_room("name: attic\nlamp: {colour: blue}\n"));
  EXPECT_EQ(text, "name: attic\nlamp:\n  colour: blue\n  period_ms: off\nmore:\n  names: []");
  EXPECT_EQ(printed_room(read_room(text)), text);
  EXPECT_THAT(printed_room(read_room("name: a\nmore: {power: 0.75}\n")),
              testing::HasSubstr("supply:\n  power: 0.75"));
}

TEST(SettingsRows, AreDescribedInTheirOrderWithTheirLimits) {
  std::vector<ConfigurationKey> keys;
  describe_section("rooms[].", kRoomRows, keys);
  ASSERT_EQ(keys.size(), 6U);
  EXPECT_EQ(keys[0].path, "rooms[].name");
  EXPECT_EQ(keys[2].path, "rooms[].lamp.period_ms");
  EXPECT_EQ(keys[2].what, "It flashes, 5 to 100 ms.");
  EXPECT_EQ(keys[5].path, "rooms[].supply.power");
}

}  // namespace
}  // namespace vdrive::settings
