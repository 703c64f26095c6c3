// SPDX-License-Identifier: Apache-2.0
#include "junit.hpp"

#include "usage_error.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
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
        result += static_cast<unsigned char>(c) < 0x20 && c != '\t' ? '?' : c;
    }
  }
  return result;
}

std::string seconds(std::chrono::nanoseconds duration) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6f", std::chrono::duration<double>(duration).count());
  return text.data();
}

std::string case_xml(const std::string& suite, const JunitCase& test) {
  std::string xml = "    <testcase classname=\"" + xml_escaped(suite) + "\" name=\"" +
                    xml_escaped(test.name) + "\" time=\"" + seconds(test.duration) + "\"";
  if (test.is_skipped) return xml + "><skipped/></testcase>\n";
  if (test.error)
    return xml + "><error message=\"" + xml_escaped(*test.error) + "\"/></testcase>\n";
  if (!test.failure) return xml + "/>\n";
  return xml + "><failure message=\"" + xml_escaped(*test.failure) + "\"/></testcase>\n";
}

}  // namespace

std::string junit_xml(const std::string& suite, const std::vector<JunitCase>& cases) {
  std::chrono::nanoseconds total{};
  for (const JunitCase& test : cases) total += test.duration;
  const auto failures = std::ranges::count_if(cases, [](const JunitCase& test) {
    return test.failure.has_value();
  });
  const auto skipped = std::ranges::count_if(cases, &JunitCase::is_skipped);
  const auto errors = std::ranges::count_if(cases, [](const JunitCase& test) {
    return test.error.has_value();
  });
  std::string counts;
  const auto count = [&counts](const char* name, const std::string& value) {
    counts += std::string(" ") + name + "=\"" + value + '"';
  };
  count("tests", std::to_string(cases.size()));
  count("failures", std::to_string(failures));
  count("skipped", std::to_string(skipped));
  count("errors", std::to_string(errors));
  count("time", seconds(total));
  std::string xml = R"(<?xml version="1.0" encoding="UTF-8"?>)";
  xml += "\n<testsuites" + counts + ">\n";
  xml += "  <testsuite name=\"" + xml_escaped(suite) + "\"" + counts + ">\n";
  for (const JunitCase& test : cases) xml += case_xml(suite, test);
  return xml + "  </testsuite>\n</testsuites>\n";
}

JunitReport::JunitReport(const std::string& file) : name_(file) {
  if (file.empty()) return;
  file_.open(file, std::ios::trunc);
  if (!file_) {
    throw UsageError("--junit: cannot write " + in_quotes(file) + ": " +
                     std::generic_category().message(errno));
  }
}

std::optional<std::string> JunitReport::write(const std::string& suite,
                                              const std::vector<JunitCase>& cases) {
  if (name_.empty()) return std::nullopt;
  file_ << junit_xml(suite, cases);
  if (file_.flush()) return std::nullopt;
  return "cannot write the report " + in_quotes(name_);
}

}  // namespace vdrive::tool
