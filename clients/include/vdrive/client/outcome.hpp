// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session_name.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::client {

/// How a call ended.
enum class OutcomeKind : std::uint8_t {
  ok,
  refused,  ///< not allowed by the service, the dictionary or the state of the drive: see the code
  timed_out,  ///< the deadline passed first
  not_found,  ///< no such bench, axis or name was found
  lost,       ///< the service stopped sending, is shutting down, has ended or was restarted
  failed,     ///< accepted, but ended by a fault, another command or an interrupt
};

/// Code of a refusal by this program's own permissions (closed mode): nothing was sent to a bench.
inline constexpr std::uint32_t kNotPermitted = 1000;

/// The code of a refusal and its symbolic name, such as "refused_local_control".
struct RefusalCode {
  std::uint32_t code = 0;
  std::string_view name;
};

/// @return every code that an outcome can have, in numerical order: reasons of the wire contract,
///         kNotPermitted and CiA 301 abort codes.
[[nodiscard]] std::vector<RefusalCode> refusal_codes();

/// @return the kind as one word, such as "timed_out".
[[nodiscard]] std::string_view to_string(OutcomeKind kind) noexcept;

/// The outcome of a client call. Converts to true if the call succeeded.
class [[nodiscard]] Outcome {
 public:
  /// Success.
  Outcome() = default;

  /// @param code a CiA 301 abort code, or a reason of the wire contract (below 0x05000000)
  static Outcome refused(std::uint32_t code, std::string message);

  /// As above, if another session is the reason: the message ends with the owner instead of the
  /// meaning of the code.
  static Outcome refused(std::uint32_t code, std::string message, AxisOwner owner);
  static Outcome timed_out(std::string message);
  static Outcome not_found(std::string message);
  static Outcome lost(std::string message);
  static Outcome failed(std::string message);

  [[nodiscard]] OutcomeKind kind() const noexcept { return kind_; }

  explicit operator bool() const noexcept { return kind_ == OutcomeKind::ok; }

  /// The code of a refusal, otherwise 0.
  [[nodiscard]] std::uint32_t code() const noexcept { return code_; }

  /// For a program that exits on failure, or handles all failures in one place.
  /// @throws OutcomeError with this outcome, unless it is success.
  void or_throw() const;

  /// The other session that holds the axis and is the reason why the call was refused or lost the
  /// axis; nullptr if no such session is known.
  [[nodiscard]] const AxisOwner* owner() const noexcept { return owner_.get(); }

  /// @return the same refusal, attributed to `owner`, which replaces the previous owner or the
  ///         meaning of the code at the end of the message. Other outcomes are returned unchanged.
  [[nodiscard]] Outcome with_owner(AxisOwner owner) const;

  /// @return the same outcome with `words` in front of its message, to say what the failure led to.
  [[nodiscard]] Outcome with_prefix(std::string_view words) const;

  /// @return the same outcome with another message.
  [[nodiscard]] Outcome with_message(std::string message) const;

  /// The message: a sentence without a full stop; empty on success. The message of a refusal ends
  /// with the meaning of its code, or with the session that holds the axis.
  [[nodiscard]] const std::string& message() const noexcept { return message_; }

 private:
  Outcome(OutcomeKind kind, std::uint32_t code, std::string message);

  OutcomeKind kind_ = OutcomeKind::ok;
  std::uint32_t code_ = 0;
  std::string message_;
  std::shared_ptr<const AxisOwner> owner_;
};

/// Thrown by Outcome::or_throw() and Result::value(), with the message of the outcome.
class OutcomeError final : public std::runtime_error {
 public:
  explicit OutcomeError(Outcome outcome);

  [[nodiscard]] const Outcome& outcome() const noexcept { return outcome_; }

 private:
  Outcome outcome_;
};

/// Writes the message of the outcome to standard error and ends the program.
[[noreturn]] void abort_on_failed_result(const Outcome& outcome) noexcept;

/// A value, or the outcome of the call that failed to produce it.
template <typename Value>
class [[nodiscard]] Result {
 public:
  // Implicit by design, so that a function can return either.
  Result(Value value) : value_(std::move(value)) {}  // NOLINT(google-explicit-constructor)

  Result(Outcome failure) : outcome_(std::move(failure)) {}  // NOLINT(google-explicit-constructor)

  explicit operator bool() const noexcept { return value_.has_value(); }

  /// The value.
  /// @throws OutcomeError if there is none.
  [[nodiscard]] const Value& value() const& {
    throw_if_failed();
    return *value_;
  }

  [[nodiscard]] Value& value() & {
    throw_if_failed();
    return *value_;
  }

  /// For a temporary result, by value: a reference into it would dangle at the end of the
  /// expression, also in `for (auto& axis : session.axes().value())`.
  [[nodiscard]] Value value() && {
    throw_if_failed();
    return std::move(*value_);
  }

  /// A copy: a constant result cannot be moved from.
  [[nodiscard]] Value value() const&& {
    throw_if_failed();
    return *value_;
  }

  /// The value; only if this converts to true. Otherwise the program ends with the message of the
  /// outcome, in every build.
  [[nodiscard]] const Value& operator*() const& noexcept {
    abort_if_failed();
    return *value_;
  }

  [[nodiscard]] Value& operator*() & noexcept {
    abort_if_failed();
    return *value_;
  }

  /// By value, like value().
  [[nodiscard]] Value operator*() && noexcept {
    abort_if_failed();
    return std::move(*value_);
  }

  [[nodiscard]] Value operator*() const&& noexcept {
    abort_if_failed();
    return *value_;
  }

  /// A member of the value, like `*`. For a temporary result it is valid until the end of the
  /// expression: for anything longer-lived, such as the range of a `for`, use value() and its
  /// member.
  [[nodiscard]] const Value* operator->() const noexcept {
    abort_if_failed();
    return &*value_;
  }

  [[nodiscard]] Value* operator->() noexcept {
    abort_if_failed();
    return &*value_;
  }

  /// Success if there is a value.
  [[nodiscard]] const Outcome& outcome() const noexcept { return outcome_; }

 private:
  void throw_if_failed() const {
    if (!value_) throw OutcomeError(outcome_);
  }

  void abort_if_failed() const noexcept {
    if (!value_) abort_on_failed_result(outcome_);
  }

  std::optional<Value> value_;
  Outcome outcome_;
};

}  // namespace vdrive::client
