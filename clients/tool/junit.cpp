// SPDX-License-Identifier: Apache-2.0
#include "junit.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace vdrive::tool {
namespace {

std::string escaped(const std::string& text) {
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
  std::string xml = "    <testcase classname=\"" + escaped(suite) + "\" name=\"" +
                    escaped(test.name) + "\" time=\"" + seconds(test.duration) + "\"";
  if (test.is_skipped) return xml + "><skipped/></testcase>\n";
  if (!test.failure) return xml + "/>\n";
  return xml + "><failure message=\"" + escaped(*test.failure) + "\"/></testcase>\n";
}

}  // namespace

std::string junit_xml(const std::string& suite, const std::vector<JunitCase>& cases) {
  std::chrono::nanoseconds total{};
  for (const JunitCase& test : cases) total += test.duration;
  const auto failures = std::ranges::count_if(cases, [](const JunitCase& test) {
    return test.failure.has_value();
  });
  const auto skipped = std::ranges::count_if(cases, &JunitCase::is_skipped);
  std::string counts;
  const auto count = [&counts](const char* name, const std::string& value) {
    counts += std::string(" ") + name + "=\"" + value + '"';
  };
  count("tests", std::to_string(cases.size()));
  count("failures", std::to_string(failures));
  count("skipped", std::to_string(skipped));
  count("errors", "0");
  count("time", seconds(total));
  std::string xml = R"(<?xml version="1.0" encoding="UTF-8"?>)";
  xml += "\n<testsuites" + counts + ">\n";
  xml += "  <testsuite name=\"" + escaped(suite) + "\"" + counts + ">\n";
  for (const JunitCase& test : cases) xml += case_xml(suite, test);
  return xml + "  </testsuite>\n</testsuites>\n";
}

}  // namespace vdrive::tool
