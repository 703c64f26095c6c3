// SPDX-License-Identifier: Apache-2.0
#include "output/junit.hpp"

#include "base/usage_error.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

namespace vdrive::tool {
namespace {

std::string xml_escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        // XML 1.0 has no other control characters.
        result += static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n' ? '?' : c;
    }
  }
  return result;
}

std::string seconds(std::chrono::nanoseconds duration) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6f", std::chrono::duration<double>(duration).count());
  return text.data();
}

/// @return ` name="value"`. XML readers turn a line break into a blank anyway.
std::string attribute(std::string_view name, const std::string& value) {
  std::string escaped_value = xml_escaped(value);
  std::ranges::replace(escaped_value, '\n', ' ');
  return " " + std::string(name) + "=\"" + escaped_value + "\"";
}

/// @param element failure or error
std::string verdict_xml(const std::string& element, const std::string& message,
                        const JunitCase& test) {
  std::string xml = "<" + element + attribute("message", message);
  if (!test.type.empty()) xml += attribute("type", test.type);
  if (test.text.empty()) return xml + "/>";
  return xml + ">" + xml_escaped(test.text) + "</" + element + ">";
}

std::string case_xml(const std::string& suite, const JunitCase& test) {
  std::string xml = "    <testcase" + attribute("classname", suite) + attribute("name", test.name) +
                    " time=\"" + seconds(test.duration) + "\"" + attribute("file", suite);
  if (test.line != 0) xml += attribute("line", std::to_string(test.line));
  std::string content;
  if (test.is_skipped) {
    content = "<skipped/>";
  } else if (test.error) {
    content = verdict_xml("error", *test.error, test);
  } else if (test.failure) {
    content = verdict_xml("failure", *test.failure, test);
  }
  if (!test.output.empty()) {
    content += "<system-out>" + xml_escaped(test.output) + "</system-out>";
  }
  return content.empty() ? xml + "/>\n" : xml + ">" + content + "</testcase>\n";
}

/// The numbers of cases, by result.
struct Counts {
  std::size_t tests = 0;
  std::size_t failures = 0;
  std::size_t skipped = 0;
  std::size_t errors = 0;
  std::chrono::nanoseconds time{};

  void add(const JunitCase& test) {
    ++tests;
    if (test.failure) ++failures;
    if (test.is_skipped) ++skipped;
    if (test.error) ++errors;
    time += test.duration;
  }

  [[nodiscard]] std::string xml() const {
    return " tests=\"" + std::to_string(tests) + "\" failures=\"" + std::to_string(failures) +
           "\" skipped=\"" + std::to_string(skipped) + "\" errors=\"" + std::to_string(errors) +
           "\" time=\"" + seconds(time) + "\"";
  }
};

constexpr const char* kShard = "shard";
constexpr const char* kShards = "shards";
constexpr const char* kFiles = "files";

std::string property_xml(const std::string& name, std::size_t value) {
  return "<property" + attribute("name", name) + attribute("value", std::to_string(value)) + "/>";
}

std::string shard_xml(const Shard& shard) {
  std::string xml =
      "  <properties>" + property_xml(kShard, shard.number) + property_xml(kShards, shard.count);
  if (shard.files != 0) xml += property_xml(kFiles, shard.files);
  return xml + "</properties>\n";
}

using Element = tinyxml2::XMLElement;

std::string text_or_empty(const char* text) {
  return text == nullptr ? std::string() : text;
}

std::chrono::nanoseconds duration_of(const Element& test) {
  constexpr double kLongestTime = 1e9;  // [s] limit for reading, far below that of the type
  const double time = test.DoubleAttribute("time");
  if (!(time >= 0 && time <= kLongestTime)) return {};
  return std::chrono::nanoseconds(std::llround(time * 1e9));
}

JunitCase read_case(const Element& element) {
  JunitCase test{.name = text_or_empty(element.Attribute("name")),
                 .duration = duration_of(element)};
  test.line = element.UnsignedAttribute("line");
  test.is_skipped = element.FirstChildElement("skipped") != nullptr;
  const Element* const failure = element.FirstChildElement("failure");
  const Element* const error = element.FirstChildElement("error");
  if (failure != nullptr) test.failure = text_or_empty(failure->Attribute("message"));
  if (error != nullptr) test.error = text_or_empty(error->Attribute("message"));
  if (const Element* const verdict = failure != nullptr ? failure : error) {
    test.type = text_or_empty(verdict->Attribute("type"));
    test.text = text_or_empty(verdict->GetText());
  }
  if (const Element* const output = element.FirstChildElement("system-out")) {
    test.output = text_or_empty(output->GetText());
  }
  return test;
}

JunitSuite read_suite(const Element& element) {
  JunitSuite suite{.name = text_or_empty(element.Attribute("name")), .cases = {}};
  for (const Element* test = element.FirstChildElement("testcase"); test != nullptr;
       test = test->NextSiblingElement("testcase")) {
    suite.cases.push_back(read_case(*test));
  }
  return suite;
}

/// @return 0 if there is no such property.
std::size_t read_property(const Element& root, const std::string& name) {
  const Element* const properties = root.FirstChildElement("properties");
  if (properties == nullptr) return 0;
  for (const Element* each = properties->FirstChildElement("property"); each != nullptr;
       each = each->NextSiblingElement("property")) {
    if (text_or_empty(each->Attribute("name")) == name) return each->UnsignedAttribute("value");
  }
  return 0;
}

std::optional<Shard> read_shard(const Element& root) {
  const Shard shard{.number = read_property(root, kShard),
                    .count = read_property(root, kShards),
                    .files = read_property(root, kFiles)};
  if (shard.number == 0 || shard.number > shard.count || shard.count > Shard::kMost) {
    return std::nullopt;
  }
  return shard;
}

}  // namespace

JunitContent read_junit(const std::string& xml) {
  tinyxml2::XMLDocument document;
  if (document.Parse(xml.data(), xml.size()) == tinyxml2::XML_ERROR_EMPTY_DOCUMENT) {
    throw UsageError("is empty: its run ended before it was written");
  }
  if (document.Error()) {
    throw UsageError("is truncated or not XML, at line " + std::to_string(document.ErrorLineNum()));
  }
  const Element* const root = document.RootElement();
  if (root == nullptr || text_or_empty(root->Name()) != "testsuites") {
    throw UsageError("is not a JUnit report: it has no element testsuites");
  }
  JunitContent content{.suites = {}, .shard = read_shard(*root)};
  for (const Element* suite = root->FirstChildElement("testsuite"); suite != nullptr;
       suite = suite->NextSiblingElement("testsuite")) {
    content.suites.push_back(read_suite(*suite));
  }
  return content;
}

std::string junit_xml(const std::vector<JunitSuite>& suites, const std::optional<Shard>& shard) {
  Counts all;
  std::string text;
  for (const JunitSuite& suite : suites) {
    Counts counts;
    std::string cases;
    for (const JunitCase& test : suite.cases) {
      counts.add(test);
      all.add(test);
      cases += case_xml(suite.name, test);
    }
    text += "  <testsuite name=\"" + xml_escaped(suite.name) + "\"" + counts.xml() + ">\n" + cases +
            "  </testsuite>\n";
  }
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites" + all.xml() + ">\n" +
         (shard ? shard_xml(*shard) : "") + text + "</testsuites>\n";
}

std::optional<std::string> JunitReport::write(const std::vector<JunitSuite>& suites,
                                              const std::optional<Shard>& shard) {
  return file_.is_wanted() ? file_.write(junit_xml(suites, shard)) : std::nullopt;
}

}  // namespace vdrive::tool
