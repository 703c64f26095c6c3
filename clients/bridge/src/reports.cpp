// SPDX-License-Identifier: Apache-2.0
#include "reports.hpp"

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/text.hpp"

#include <iostream>
#include <utility>

namespace vdrive::bridge {
namespace {

// What is kept is bounded: subjects and texts may come from the other world.
constexpr std::size_t kMostSubjects = 1024;
constexpr std::size_t kMostTexts = 64;
constexpr std::chrono::seconds kAgain{1};
constexpr std::size_t kLongestText = 1000;

const char* word_of(Severity severity) {
  if (severity == Severity::info) return "";
  return severity == Severity::warning ? "warning: " : "error: ";
}

}  // namespace

bool ReportLimit::is_due(Subject& subject, const std::string& text, Clock::time_point now) {
  if (subject.texts.size() > kMostTexts) subject.texts.clear();
  const auto [reported, is_new] = subject.texts.try_emplace(text, now);
  subject.limit.refill(now.time_since_epoch());
  if ((!is_new && now - reported->second < kAgain) || !subject.limit.take()) return false;
  reported->second = now;
  return true;
}

std::optional<std::string> ReportLimit::line_of(const std::string& subject, const std::string& text,
                                                Clock::time_point now) {
  if (subjects_.size() > kMostSubjects) subjects_.clear();
  Subject& known = subjects_[subject];
  if (!is_due(known, text, now)) {
    ++known.left_out;
    return std::nullopt;
  }
  std::string line = escaped(subject + ": " + text, kLongestText);
  const std::uint64_t left_out = std::exchange(known.left_out, 0);
  if (left_out > 0) line += " (" + std::to_string(left_out) + " more before)";
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
  // Without what differs from command to command.
  const std::string text = event.text.substr(0, event.text.rfind(" (session "));
  return "a command was refused: " + text.substr(0, text.find(", late by "));
}

}  // namespace vdrive::bridge
