// SPDX-License-Identifier: Apache-2.0
#include "judge/findings.hpp"

#include <algorithm>
#include <tuple>

namespace vdrive::judge {

void History::put(const Line& line) {
  for (Window& window : windows_) {
    if (window.lines == 0) continue;
    --window.lines;
    window.finding->lines.push_back(line);
  }
  std::erase_if(windows_, [](const Window& window) {
    return window.lines == 0 && window.samples == 0;
  });
  if (lines_.size() == kLinesBefore) lines_.pop_front();
  lines_.push_back(line);
}

void History::put(const Sample& sample) {
  for (Window& window : windows_) {
    if (window.samples == 0) continue;
    --window.samples;
    window.finding->samples.push_back(sample);
  }
  if (samples_.size() < kSamplesBefore) {
    samples_.push_back(sample);
  } else {
    samples_[oldest_sample_] = sample;
    oldest_sample_ = oldest_sample_ + 1 == kSamplesBefore ? 0 : oldest_sample_ + 1;
  }
}

void History::open(Finding& finding) {
  finding.lines.assign(lines_.begin(), lines_.end());
  const auto oldest = samples_.begin() + static_cast<std::ptrdiff_t>(oldest_sample_);
  finding.samples.assign(oldest, samples_.end());
  finding.samples.insert(finding.samples.end(), samples_.begin(), oldest);
  windows_.push_back({&finding, kLinesAfter, kSamplesAfter});
}

std::vector<Finding> Findings::all() const {
  std::vector<Finding> all;
  all.reserve(findings_.size());
  for (const auto& [key, finding] : findings_) all.push_back(finding);
  std::ranges::stable_sort(all, {}, [](const Finding& finding) {
    return std::tuple(row_of(finding.rule).severity, finding.rule, finding.axis);
  });
  return all;
}

}  // namespace vdrive::judge
