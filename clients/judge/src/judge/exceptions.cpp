// SPDX-License-Identifier: Apache-2.0
#include "judge/exceptions.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::judge {
namespace {

bool covers(const Exception& exception, const Finding& finding, const AxisName& name_of) {
  return exception.rule == finding.rule &&
         (exception.axis.empty() || exception.axis == name_of(finding.axis));
}

}  // namespace

std::vector<Exception> except(Verdict& verdict, const std::vector<Exception>& exceptions,
                              const AxisName& name_of) {
  std::vector<Exception> unused;
  for (const Exception& exception : exceptions) {
    const bool is_used = std::ranges::any_of(verdict.findings, [&](const Finding& finding) {
      return covers(exception, finding, name_of);
    });
    if (!is_used) unused.push_back(exception);
  }
  std::erase_if(verdict.findings, [&](Finding& finding) {
    const auto covering = std::ranges::find_if(exceptions, [&](const Exception& exception) {
      return covers(exception, finding, name_of);
    });
    if (covering == exceptions.end()) return false;
    verdict.excepted.push_back({.finding = std::move(finding), .reason = covering->reason});
    return true;
  });
  return unused;
}

}  // namespace vdrive::judge
