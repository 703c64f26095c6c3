// SPDX-License-Identifier: Apache-2.0
#include "reports.hpp"

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/text.hpp"

#include <iostream>
#include <utility>

namespace vdrive::bridge {
namespace {

// Bounded, because subjects and texts may come from outside.
constexpr std::size_t kMostSubjects = 1024;
constexpr std::size_t kMostTexts = 64;
constexpr std::chrono::seconds kAgain{1};
constexpr std::size_t kLongestText = 1000;

const char* word_of(Severity severity) {
  if (severity == Severity::info) return "";
  return severity == Severity::warning ? "warning: " : "error: ";
}

}  // namespace

std::optional<std::uint64_t> ReportLimit::pass(Subject& subject, const std::string& text,
                                               Clock::time_point now) {
  if (subject.texts.size() > kMostTexts) subject.texts.clear();
  const auto [reported, is_new] = subject.texts.try_emplace(text, now);
  if (!is_new && now - reported->second < kAgain) {
    subject.limit.leave_out();
    return std::nullopt;
  }
  const auto left_out = subject.limit.pass(now.time_since_epoch());
  if (left_out) reported->second = now;
  return left_out;
}

std::optional<std::string> ReportLimit::line_of(const std::string& subject, const std::string& text,
                                                Clock::time_point now) {
  if (subjects_.size() > kMostSubjects) subjects_.clear();
  const auto left_out = pass(subjects_[subject], text, now);
  if (!left_out) return std::nullopt;
  std::string line = escaped(subject + ": " + text, kLongestText);
  if (*left_out > 0) line += " (" + std::to_string(*left_out) + " earlier suppressed)";
  return line;
}

void Reports::report(Severity severity, const std::string& subject, const std::string& text) {
  const std::scoped_lock lock(mutex_);
  const auto line = limit_.line_of(subject, text, ReportLimit::Clock::now());
  if (!line) return;
  std::cerr << program_ << ": " << word_of(severity) << *line << std::endl;
  if (sink_) sink_(severity, *line);
}

std::optional<std::string> refusal_report(const client::Event& event, std::uint64_t own) {
  constexpr std::uint32_t kControlled = wire_code(AbortCode::refused_local_control);
  if (event.kind != client::EventKind::refused || event.session != own) return std::nullopt;
  if (event.code == kControlled) return std::nullopt;
  // Without the parts that differ from command to command.
  const std::string text = event.text.substr(0, event.text.rfind(" (session "));
  return "a command was refused: " + text.substr(0, text.find(", late by "));
}

}  // namespace vdrive::bridge
