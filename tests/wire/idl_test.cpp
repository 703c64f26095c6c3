// SPDX-License-Identifier: Apache-2.0
// The contract mirrors the object dictionary: the IDL has the objects of the manual.
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/event_kind.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive_messages_description.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>

namespace vdrive {
namespace {

using Members = std::map<std::string, std::string>;  // name -> type

std::string idl_text(const std::string& path = "/idl/vdrive_messages.idl") {
  std::ifstream file(VDRIVE_SOURCE_DIR + path);
  std::ostringstream text;
  text << file.rdbuf();
  return std::regex_replace(text.str(), std::regex("//[^\n]*"), "");
}

void add_members(const std::string& idl, const std::string& structure, Members& members) {
  const std::regex body_pattern("@final struct " + structure + " \\{([^}]*)\\}");
  std::smatch body;
  ASSERT_TRUE(std::regex_search(idl, body, body_pattern)) << structure;
  const std::string text = body[1];
  const std::regex member_pattern("(u?int(?:8|16|32|64))\\s+(\\w+);");
  for (std::sregex_iterator member(text.begin(), text.end(), member_pattern), end; member != end;
       ++member) {
    members[(*member)[2]] = (*member)[1];
  }
}

std::string idl_type(DataType type) {
  const bool is_signed =
      type == DataType::integer8 || type == DataType::integer16 || type == DataType::integer32;
  return (is_signed ? "int" : "uint") + std::to_string(8 * size_of(type));
}

TEST(Idl, HasAMemberOfSameNameAndTypeForEveryObjectOfTheManual) {
  const std::string idl = idl_text();
  Members members;
  add_members(idl, "AxisCommand", members);
  add_members(idl, "AxisStatus", members);
  add_members(idl, "AxisParameters", members);
  int rows = 0;
  for (const auto& object : kObjectTable) {
    if (object.origin == Origin::manual) {
      const std::string name(object.variable_name);
      ++rows;
      ASSERT_TRUE(members.contains(name)) << "idl/vdrive_messages.idl has no member " << name
                                          << " in AxisCommand, AxisStatus or AxisParameters";
      EXPECT_EQ(members[name], idl_type(object.data_type))
          << "idl/vdrive_messages.idl gives " << name << " another type than "
          << "core/include/vdrive/dictionary/object_table.hpp";
    }
  }
  EXPECT_EQ(rows, 32);  // rows of the manual's tables
}

TEST(Idl, GivesNoMemberTheNameOfAnObjectOfAnotherType) {
  const std::string idl = idl_text();
  for (const char* const structure : {"AxisCommand", "AxisStatus", "AxisParameters"}) {
    Members members;
    add_members(idl, structure, members);
    for (const auto& [name, type] : members) {
      const auto row = find_object(std::string_view(name));
      if (row && name != "digital_inputs") {  // three of its bits, in one byte
        EXPECT_EQ(type, idl_type(describe(*row).data_type))
            << "idl/vdrive_messages.idl: " << structure << "." << name << " has another type than "
            << "core/include/vdrive/dictionary/object_table.hpp";
      }
    }
  }
}

TEST(Idl, HasAConstantForEachKindOfEvent) {
  const std::string idl = idl_text();
  std::map<std::string, unsigned long> constants;
  const std::regex constant("const uint32 EVENT_(\\w+) = (\\d+);");
  for (std::sregex_iterator found(idl.begin(), idl.end(), constant), end; found != end; ++found) {
    std::string name = (*found)[1];
    std::ranges::transform(name, name.begin(), [](unsigned char letter) {
      return static_cast<char>(std::tolower(letter));
    });
    constants[name] = std::stoul((*found)[2]);
  }
  std::map<std::string, unsigned long> kinds;
  for (const EventKindRow& row : kEventKinds) {
    kinds[std::string(row.name)] = static_cast<unsigned long>(row.kind);
  }
  EXPECT_EQ(constants, kinds);
}

TEST(Idl, HasWordsForEachReason) {
  for (const wire::EnumerationValue& row : wire::Description<msg::Reason>::kValues) {
    EXPECT_FALSE(row.help.empty()) << row.name;
    EXPECT_EQ(wire::describe_reason(row.number), row.help);
  }
}

TEST(Idl, UsesOnlyConstructsThatTwoVendorsReadTheSame) {
  const std::string idl = idl_text();
  for (const char* const forbidden :
       {"@optional", "@appendable", "@mutable", "enum ", "bitmask", "bitset", "map<", "wstring",
        "union ", "string ", "string;"}) {
    EXPECT_EQ(idl.find(forbidden), std::string::npos) << forbidden;
  }
  std::size_t structures = 0;
  std::size_t finals = 0;
  const std::regex any("struct ");
  const std::regex only("@final struct ");
  structures = static_cast<std::size_t>(
      std::distance(std::sregex_iterator(idl.begin(), idl.end(), any), std::sregex_iterator()));
  finals = static_cast<std::size_t>(
      std::distance(std::sregex_iterator(idl.begin(), idl.end(), only), std::sregex_iterator()));
  EXPECT_EQ(structures, finals);
  EXPECT_GT(structures, 10U);
}

/// @return the first group of each match, mapped to the second.
std::map<std::string, std::string> found(const std::string& text, const char* pattern) {
  std::map<std::string, std::string> all;
  const std::regex search(pattern);
  for (std::sregex_iterator match(text.begin(), text.end(), search), end; match != end; ++match) {
    all[(*match)[1]] = std::regex_replace((*match)[2].str(), std::regex("\\s+"), " ");
  }
  return all;
}

/// @return the structs without annotations that affect no byte.
std::map<std::string, std::string> structs_of(const std::string& idl) {
  return found(std::regex_replace(idl, std::regex("@(?!key|final)\\w+(\\([^)]*\\))?"), ""),
               "struct (\\w+) \\{([^}]*)\\}");
}

// Plain CDR allows no member to be added or removed (docs/reference/compatibility.md).
TEST(IdlOf1_0, HasEveryStructUnchanged) {
  const auto now = structs_of(idl_text());
  const auto kept = structs_of(idl_text("/tests/data/kept/1.0/vdrive_messages.idl"));
  EXPECT_GT(kept.size(), 15U);
  for (const auto& [name, members] : kept) {
    ASSERT_TRUE(now.contains(name)) << name;
    EXPECT_EQ(now.at(name), members) << name;
  }
}

TEST(IdlOf1_0, HasEveryConstantWithItsTypeAndNumber) {
  constexpr const char* kConstant = "const (\\w+ \\w+) = (\\w+);";
  const auto now = found(idl_text(), kConstant);
  const auto kept = found(idl_text("/tests/data/kept/1.0/vdrive_messages.idl"), kConstant);
  EXPECT_GT(kept.size(), 80U);
  for (const auto& [name, number] : kept) {
    ASSERT_TRUE(now.contains(name)) << name;
    EXPECT_EQ(now.at(name), number) << name;
  }
}

}  // namespace
}  // namespace vdrive
