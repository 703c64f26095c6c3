// SPDX-License-Identifier: Apache-2.0
#include "output/junit.hpp"

#include "base/usage_error.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <string_view>
#include <system_error>

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

/// @return ` name="value"`. A reader of XML would make a blank of a line break.
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

/// How many cases there are, and what became of them.
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

}  // namespace

std::string junit_xml(const std::vector<JunitSuite>& suites) {
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
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites" + all.xml() + ">\n" + text +
         "</testsuites>\n";
}

JunitReport::JunitReport(const std::string& file) : name_(file) {
  if (file.empty()) return;
  file_.open(file, std::ios::trunc);
  if (!file_) {
    throw UsageError("--junit: cannot write " + in_quotes(file) + ": " +
                     std::generic_category().message(errno));
  }
}

std::optional<std::string> JunitReport::write(const std::vector<JunitSuite>& suites) {
  if (name_.empty()) return std::nullopt;
  file_ << junit_xml(suites);
  if (file_.flush()) return std::nullopt;
  return "cannot write the report " + in_quotes(name_);
}

}  // namespace vdrive::tool
