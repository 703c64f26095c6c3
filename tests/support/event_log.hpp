// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/event.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/number_text.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>

namespace vdrive::test {

/// Maps random session numbers to the names that a test gives these sessions.
class SessionNumbers {
 public:
  explicit SessionNumbers(std::map<std::uint64_t, std::string> names) : names_(std::move(names)) {}

  [[nodiscard]] std::string name_of(std::uint64_t session) const {
    if (session == 0) return "no session";
    const auto found = names_.find(session);
    return found == names_.end() ? "an unknown session" : found->second;
  }

  /// @return the text with numbers replaced by names.
  [[nodiscard]] std::string without_numbers(std::string text) const {
    for (const auto& [session, name] : names_) {
      const std::string number = session_text(session);
      for (auto at = text.find(number); at != std::string::npos; at = text.find(number)) {
        text.replace(at, number.size(), name);
      }
    }
    return text;
  }

 private:
  std::map<std::uint64_t, std::string> names_;
};

/// The events of one bench as a session receives them.
///
/// Of equal events (same kind, axis, code and session) a bench passes on 20 per second of wall time
/// and only counts the others, so two runs of a program receive different events. But each received
/// event carries its number among the equal ones, and all equal ones are counted. Both the numbered
/// events and the counts must agree in two runs.
class EventLog {
 public:
  /// Begins with the events that the bench has kept. @param numbers must outlive this log
  EventLog(client::Session& session, const SessionNumbers& numbers)
      : session_(session), numbers_(numbers) {
    session_.on_event(
        [this](const client::Event& event) {
          note(event);
        },
        client::EventHistory::kept);
  }

  ~EventLog() { session_.on_event({}); }

  EventLog(const EventLog&) = delete;
  EventLog& operator=(const EventLog&) = delete;

  /// @return the number of events, including those that were left out and counted.
  [[nodiscard]] std::uint64_t count() const {
    const std::scoped_lock lock(mutex_);
    return count_;
  }

  /// The numbers of equal events.
  struct Numbers {
    std::uint64_t all = 0;   ///< including those that were left out and counted
    std::uint64_t told = 0;  ///< received by this log
  };

  [[nodiscard]] Numbers numbers_of(client::EventKind kind, std::uint16_t axis, std::uint32_t code,
                                   std::uint64_t session) const {
    const std::scoped_lock lock(mutex_);
    const auto found = equal_.find({kind, axis, code, numbers_.name_of(session)});
    if (found == equal_.end()) return {};
    return {.all = found->second.count, .told = found->second.told.size()};
  }

  /// @return the first difference between the events of two logs, or an empty text.
  friend std::string difference_of(const EventLog& one, const EventLog& other) {
    const std::scoped_lock lock(one.mutex_, other.mutex_);
    for (const auto& [key, equal] : one.equal_) {
      const auto found = other.equal_.find(key);
      if (found == other.equal_.end()) return text_of(key) + in_one_only(equal);
      std::string difference = difference_of(equal, found->second);
      if (!difference.empty()) return text_of(key) + difference;
    }
    for (const auto& [key, equal] : other.equal_) {
      if (!one.equal_.contains(key)) return text_of(key) + in_one_only(equal);
    }
    return "";
  }

  /// @return the number of events that both logs received.
  friend std::uint64_t told_to_both(const EventLog& one, const EventLog& other) {
    const std::scoped_lock lock(one.mutex_, other.mutex_);
    std::uint64_t both = 0;
    for (const auto& [key, equal] : one.equal_) {
      const auto found = other.equal_.find(key);
      if (found == other.equal_.end()) continue;
      for (const auto& [number, content] : equal.told) {
        if (found->second.told.contains(number)) ++both;
      }
    }
    return both;
  }

 private:
  using Key = std::tuple<client::EventKind, std::uint16_t, std::uint32_t, std::string>;

  /// The parts of an event in which equal events may differ.
  struct Content {
    std::uint64_t tick = 0;
    std::uint8_t error_register = 0;
    std::string text;

    friend bool operator==(const Content&, const Content&) = default;
  };

  struct Equal {
    std::uint64_t count = 0;
    std::map<std::uint64_t, Content> told;  ///< by number
  };

  void note(const client::Event& event) {
    std::string text = numbers_.without_numbers(event.text);
    const std::scoped_lock lock(mutex_);
    Equal& equal = equal_[{event.kind, event.axis, event.code, numbers_.name_of(event.session)}];
    const std::uint64_t number = equal.count + event.suppressed;
    equal.told[number] = {event.tick, event.error_register, std::move(text)};
    equal.count = number + 1;
    count_ += event.suppressed + 1;
  }

  static std::string text_of(const Key& key) {
    const auto& [kind, axis, code, session] = key;
    return "events " + std::string(to_string(kind)) + " of axis " + std::to_string(axis) +
           ", code " + hex(code, 4) + ", " + session + ":";
  }

  static std::string text_of(const Content& content) {
    return "tick " + std::to_string(content.tick) + ", error register " +
           std::to_string(content.error_register) + ", \"" + content.text + '"';
  }

  static std::string difference_of(const Equal& one, const Equal& other) {
    for (const auto& [number, content] : one.told) {
      const auto found = other.told.find(number);
      if (found == other.told.end() || found->second == content) continue;
      return " number " + std::to_string(number) + ": " + text_of(content) + "; " +
             text_of(found->second);
    }
    if (one.count == other.count) return "";
    return ' ' + text_of(one) + "; " + text_of(other);
  }

  static std::string text_of(const Equal& equal) {
    return std::to_string(equal.count) + " events, the last one in tick " +
           std::to_string(equal.told.rbegin()->second.tick);
  }

  static std::string in_one_only(const Equal& equal) {
    return " in one log only, first in tick " + std::to_string(equal.told.begin()->second.tick);
  }

  client::Session& session_;
  const SessionNumbers& numbers_;
  mutable std::mutex mutex_;  ///< guards the members below
  std::map<Key, Equal> equal_;
  std::uint64_t count_ = 0;
};

}  // namespace vdrive::test
