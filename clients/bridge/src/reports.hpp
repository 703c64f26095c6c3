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

/// Limits reports: the same text once per second, and no more than five texts per second for a
/// subject, with the number of suppressed ones. Time is passed as an argument.
class ReportLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// @return the line to report, with its subject and without control characters; nothing if it is
  ///         suppressed.
  std::optional<std::string> line_of(const std::string& subject, const std::string& text,
                                     Clock::time_point now);

 private:
  /// The texts reported about a subject.
  struct Subject {
    CountingLimit limit{{.per_second = 5.0, .burst = 10.0}};
    std::map<std::string, Clock::time_point> texts{};  ///< and when they were reported
  };

  /// @return the number of texts suppressed since the last one that passed; nothing = suppress this
  ///         one.
  static std::optional<std::uint64_t> pass(Subject& subject, const std::string& text,
                                           Clock::time_point now);

  std::map<std::string, Subject> subjects_;
};

/// Reports from a bridge to its operator: a line on standard error, which the sink of the bridge
/// also receives. Thread-safe; not for DDS threads.
class Reports {
 public:
  /// Receives each reported line, for example to write it to a log of the other protocol.
  using Sink = std::function<void(Severity severity, const std::string& line)>;

  /// @param program name at the start of each line
  Reports(std::string program, Sink sink) : program_(std::move(program)), sink_(std::move(sink)) {}

  /// @param subject of the report; reports on one subject are limited together
  /// @param text a sentence without a full stop
  void report(Severity severity, const std::string& subject, const std::string& text);

 private:
  const std::string program_;
  const Sink sink_;
  std::mutex mutex_;
  ReportLimit limit_;
};

/// @param own the session of the bridge
/// @return the report for an event that refuses a command of the bridge: the same text for equal
///         refusals, so that they are counted. Nothing for any other event, nor if another session
///         has control: a ControlKeeper reports that.
[[nodiscard]] std::optional<std::string> refusal_report(const client::Event& event,
                                                        std::uint64_t own);

}  // namespace vdrive::bridge
