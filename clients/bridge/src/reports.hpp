// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "severity.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/token_bucket.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace vdrive::bridge {

/// Which reports are made: an equal text once a second, and of a subject no more than five texts a
/// second, with the number of those left out. Time is an argument.
class ReportLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// @return the line that is due, with its subject and without control characters; none when it
  ///         is left out.
  std::optional<std::string> line_of(const std::string& subject, const std::string& text,
                                     Clock::time_point now);

 private:
  /// What was reported about a subject.
  struct Subject {
    CountingLimit limit{{.per_second = 5.0, .burst = 10.0}};
    std::map<std::string, Clock::time_point> texts{};  ///< when they were reported
  };

  /// @return how many texts were left out since the last that passed; nothing = leave this one out.
  static std::optional<std::uint64_t> pass(Subject& subject, const std::string& text,
                                           Clock::time_point now);

  std::map<std::string, Subject> subjects_;
};

/// Reports of a bridge to its operator: a line on standard error, and what else the bridge does
/// with it. Thread-safe; not for DDS threads.
class Reports {
 public:
  /// Takes a line that is reported, such as into a log of the other world.
  using Sink = std::function<void(Severity severity, const std::string& line)>;

  /// @param program whose name begins each line
  Reports(std::string program, Sink sink) : program_(std::move(program)), sink_(std::move(sink)) {}

  /// @param subject what the report is about; reports of one subject are limited together
  /// @param text a sentence without a full stop
  void report(Severity severity, const std::string& subject, const std::string& text);

 private:
  const std::string program_;
  const Sink sink_;
  std::mutex mutex_;
  ReportLimit limit_;
};

/// @param own the session of the bridge
/// @return what to report about an event that refuses a command of the bridge: the same text for
///         equal refusals, which are counted; nothing for any other event, and for the refusal of
///         control, which a ControlKeeper reports.
[[nodiscard]] std::optional<std::string> refusal_report(const client::Event& event,
                                                        std::uint64_t own);

}  // namespace vdrive::bridge
