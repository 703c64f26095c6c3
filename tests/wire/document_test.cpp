// SPDX-License-Identifier: Apache-2.0
// Clients in other languages are written from docs/reference/wire.md: its bytes must be those of
// the real encoder, and no constant or topic of the contract may be missing.
#include "vdrive/event_kind.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/request_kinds.hpp"
#include "vdrive/wire/topics.hpp"
#include "vdrive_messages.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <regex>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::string read(const char* path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string page() {
  return read(VDRIVE_SOURCE_DIR "/docs/reference/wire.md");
}

/// A row of a block of bytes: "0044  3F00   axes[0].ds402_controlword = 0x3F".
struct Row {
  std::size_t offset = 0;
  Bytes bytes;
  std::string member;
  std::string value;  ///< empty for padding
};

Bytes parse_bytes(const std::string& hex) {
  Bytes bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

/// @return the rows below the title `message`, except that of the encapsulation.
std::vector<Row> rows_of(const std::string& message) {
  std::istringstream text(page());
  std::string line;
  while (std::getline(text, line) && line != message) {
  }
  std::getline(text, line);
  EXPECT_TRUE(line.starts_with("----  00010000 ")) << "CDR in little-endian order: " << line;
  const std::regex pattern(R"(^([0-9A-F]{4})  ((?:[0-9A-F]{2})+) +([^ ]+)(?: = (\S+))?$)");
  std::vector<Row> rows;
  std::smatch match;
  while (std::getline(text, line) && std::regex_match(line, match, pattern)) {
    rows.push_back({std::stoul(match[1], nullptr, 16), parse_bytes(match[2]), match[3], match[4]});
  }
  EXPECT_EQ(line, "```") << "not a row";
  return rows;
}

/// @return the bytes without the encapsulation.
template <typename Message>
Bytes encode(const Message& message) {
  std::vector<std::byte> sample(wire::encoded_size(message));
  wire::encode(message, sample);
  Bytes bytes;
  for (const std::byte byte : std::span(sample).subspan(wire::kEncapsulation)) {
    bytes.push_back(std::to_integer<std::uint8_t>(byte));
  }
  return bytes;
}

std::string hex(const Bytes& bytes) {
  std::ostringstream text;
  text << std::hex << std::uppercase << std::setfill('0');
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    text << (i % 8 == 0 ? "\n" : " ") << std::setw(2) << unsigned{bytes[i]};
  }
  return text.str();
}

std::uint64_t little_endian(const Bytes& bytes) {
  std::uint64_t word = 0;
  for (std::size_t i = bytes.size(); i > 0; --i) word = word << 8U | bytes[i - 1];
  return word;
}

/// Expects offsets without gaps, and values that agree with their bytes.
void expect_consistent(const std::vector<Row>& rows) {
  std::size_t offset = 0;
  for (const Row& row : rows) {
    EXPECT_EQ(row.offset, offset) << row.member;
    offset += row.bytes.size();
    const std::uint64_t value =
        row.value.empty() ? 0 : static_cast<std::uint64_t>(std::stoll(row.value, nullptr, 0));
    const std::uint64_t mask = ~std::uint64_t{0} >> (64 - 8 * row.bytes.size());
    EXPECT_EQ(little_endian(row.bytes), value & mask) << row.member;
  }
}

Bytes bytes_of_rows(const std::vector<Row>& rows) {
  Bytes bytes;
  for (const Row& row : rows) bytes.insert(bytes.end(), row.bytes.begin(), row.bytes.end());
  return bytes;
}

constexpr std::uint64_t kIncarnation = 1'700'000'000'000'000'000;
constexpr std::uint64_t kSession = 0x1122334455667788;

TEST(NetworkInterfacePage, ShowsTheBytesOfACommandFrame) {
  msg::CommandFrame frame;
  frame.bench = 1;
  frame.incarnation = kIncarnation;
  frame.session = kSession;
  frame.epoch = 7;
  frame.sequence_number = 3;
  frame.flags = msg::FRAME_WANT_REPLY;
  auto& command = frame.axes.emplace_back();
  command.axis = 2;
  command.members =
      msg::HAS_OP_MODE_CMD | msg::HAS_POSITION_USER_TARGET_VALUE | msg::HAS_DS402_CONTROLWORD;
  command.ds402_controlword = 0x3F;
  command.op_mode_cmd = 1;
  command.position_user_target_value = -10000;
  auto& object = command.objects.emplace_back();
  object.index = 0x6072;
  object.value = 2500;
  const auto rows = rows_of("CommandFrame");
  expect_consistent(rows);
  EXPECT_EQ(bytes_of_rows(rows), encode(frame)) << "encoded:" << hex(encode(frame));
}

TEST(NetworkInterfacePage, HasARowForEveryConstantOfTheIdl) {
  const std::string idl = read(VDRIVE_SOURCE_DIR "/idl/vdrive_messages.idl");
  const std::string text = page();
  const std::regex constant(
      R"(const \w+ ((?:HAS|FRAME|REQUEST|REASON|EVENT|CLOCK_MODE)_\w+) = (\d+);)");
  int constants = 0;
  for (std::sregex_iterator match(idl.begin(), idl.end(), constant), end; match != end; ++match) {
    const std::string row = "\n| " + (*match)[2].str() + " | `" + (*match)[1].str() + "` | ";
    EXPECT_NE(text.find(row), std::string::npos) << "no row that begins with" << row;
    ++constants;
  }
  EXPECT_GT(constants, 50);
}

TEST(NetworkInterfacePage, HasARowForEveryTopic) {
  const std::string text = page();
  constexpr std::string_view kModule = "vdrive::msg::";
  std::size_t topics = 0;
  for (const wire::TopicTraits& topic : wire::kTopics) {
    const std::string message(topic.type_name.substr(kModule.size()));
    const std::string row = "\n| `" + std::string(topic.name) + "` | " + message + " | ";
    EXPECT_NE(text.find(row), std::string::npos) << "no row that begins with" << row;
    ++topics;
  }
  EXPECT_GE(topics, 10U);
}

/// @return the name of the constant: the prefix and the name of its value in capital letters.
std::string constant_name(std::string_view prefix, std::string_view name) {
  std::string text(prefix);
  std::ranges::transform(name, std::back_inserter(text), [](unsigned char letter) {
    return static_cast<char>(std::toupper(letter));
  });
  return text;
}

/// @return the names of the members in IDL order, as in a cell of the page.
std::string cell_of(const wire::RequestMembers& members) {
  std::string text;
  wire::for_each_member<msg::Request>([&](const auto& member) {
    if (!members.contains(wire::RequestMembers(member.pointer))) return;
    text += (text.empty() ? "`" : ", `") + std::string(member.name) + "`";
  });
  return text.empty() ? "-" : text;
}

TEST(NetworkInterfacePage, SaysOfEveryKindOfRequestWhatItUsesAndWhoMayAskItWhen) {
  constexpr std::array kCallers{"anybody", "session", "owner", "stepper"};
  constexpr std::array kClocks{"any", "lock-step", "realtime", "standing"};
  const std::string text = page();
  for (const wire::RequestKindRow& row : wire::kRequestKinds) {
    const std::string cells = "\n| " + std::to_string(wire::number(row.kind)) + " | `" +
                              constant_name("REQUEST_", wire::value_row(row.kind)->name) + "` | " +
                              cell_of(row.uses) + " | " +
                              kCallers.at(static_cast<std::size_t>(row.caller)) + " | " +
                              kClocks.at(static_cast<std::size_t>(row.clock)) + " | ";
    EXPECT_NE(text.find(cells), std::string::npos) << "no row that begins with" << cells;
  }
}

TEST(NetworkInterfacePage, HasTheSeverityOfEveryKindOfEvent) {
  constexpr std::array kWords{"info", "warning", "error"};  // in the order of EventSeverity
  const std::string text = page();
  for (const EventKindRow& row : kEventKinds) {
    const std::string cells = "| " + std::to_string(static_cast<std::uint32_t>(row.kind)) + " | `" +
                              constant_name("EVENT_", row.name) + "` | " +
                              kWords.at(static_cast<std::size_t>(row.severity)) + " |";
    EXPECT_NE(text.find(cells), std::string::npos) << cells;
  }
}

}  // namespace
}  // namespace vdrive
