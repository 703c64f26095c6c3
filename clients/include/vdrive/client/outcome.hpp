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
  refused,    ///< the service, the dictionary or the drive's state does not allow it: see the code
  timed_out,  ///< the deadline passed first
  not_found,  ///< no such bench, axis or name was found
  lost,       ///< the service stopped sending, shuts down, ended or was restarted
  failed,     ///< accepted, but ended by a fault, another command or an interrupt
};

/// Code of a refusal by this program's own permissions (closed mode): nothing was sent to a bench.
inline constexpr std::uint32_t kNotPermitted = 1000;

/// A code of a refusal and its name in programs, such as "refused_local_control".
struct RefusalCode {
  std::uint32_t code = 0;
  std::string_view name;
};

/// @return every code that an outcome may have, by number: reasons of the wire contract,
///         kNotPermitted and CiA 301 abort codes.
[[nodiscard]] std::vector<RefusalCode> refusal_codes();

/// @return the kind as one word, such as "timed_out".
[[nodiscard]] std::string_view to_string(OutcomeKind kind) noexcept;

/// Answer to a client call. Converts to true when the call did what it is for.
class [[nodiscard]] Outcome {
 public:
  /// Success.
  Outcome() = default;

  /// @param code a CiA 301 abort code, or a reason of the wire contract (below 0x05000000)
  static Outcome refused(std::uint32_t code, std::string message);

  /// The same because of another session: the message ends with the owner instead of the code's
  /// meaning.
  static Outcome refused(std::uint32_t code, std::string message, AxisOwner owner);
  static Outcome timed_out(std::string message);
  static Outcome not_found(std::string message);
  static Outcome lost(std::string message);
  static Outcome failed(std::string message);

  [[nodiscard]] OutcomeKind kind() const noexcept { return kind_; }

  explicit operator bool() const noexcept { return kind_ == OutcomeKind::ok; }

  /// Code of a refusal, else 0.
  [[nodiscard]] std::uint32_t code() const noexcept { return code_; }

  /// For a program that ends, or handles all failures in one place.
  /// @throws OutcomeError with this outcome, unless it is success.
  void or_throw() const;

  /// Who holds the axis that the call was refused for, or lost; nullptr where it is not known that
  /// it was because of another session.
  [[nodiscard]] const AxisOwner* owner() const noexcept { return owner_.get(); }

  /// @return the same refusal because of that session; the owner takes the place of the owner or of
  ///         the code's meaning at the end of its message. Other outcomes stay as they are.
  [[nodiscard]] Outcome with_owner(AxisOwner owner) const;

  /// @return the same outcome with `words` in front of its message: what that came to.
  [[nodiscard]] Outcome with_prefix(std::string_view words) const;

  /// @return the same outcome with another message.
  [[nodiscard]] Outcome with_message(std::string message) const;

  /// What happened, in a sentence without a full stop; empty on success. A refusal's message ends
  /// with the meaning of its code, or with the session that stands in the way.
  [[nodiscard]] const std::string& message() const noexcept { return message_; }

 private:
  Outcome(OutcomeKind kind, std::uint32_t code, std::string message);

  OutcomeKind kind_ = OutcomeKind::ok;
  std::uint32_t code_ = 0;
  std::string message_;
  std::shared_ptr<const AxisOwner> owner_;
};

/// What Outcome::or_throw() and Result::value() throw: the message of the outcome.
class OutcomeError final : public std::runtime_error {
 public:
  explicit OutcomeError(Outcome outcome);

  [[nodiscard]] const Outcome& outcome() const noexcept { return outcome_; }

 private:
  Outcome outcome_;
};

/// Writes the message of the outcome to standard error and ends the program.
[[noreturn]] void abort_on_failed_result(const Outcome& outcome) noexcept;

/// A value, or the outcome that stands in its place.
template <typename Value>
class [[nodiscard]] Result {
 public:
  // Implicit on purpose: a function returns either.
  Result(Value value) : value_(std::move(value)) {}  // NOLINT(google-explicit-constructor)

  Result(Outcome failure) : outcome_(std::move(failure)) {}  // NOLINT(google-explicit-constructor)

  explicit operator bool() const noexcept { return value_.has_value(); }

  /// The value. @throws OutcomeError when there is none.
  [[nodiscard]] const Value& value() const& {
    throw_if_failed();
    return *value_;
  }

  [[nodiscard]] Value& value() & {
    throw_if_failed();
    return *value_;
  }

  /// Of a result that nobody keeps, by value: a reference into it would end with the expression,
  /// also in `for (auto& axis : session.axes().value())`.
  [[nodiscard]] Value value() && {
    throw_if_failed();
    return std::move(*value_);
  }

  /// A copy: what is constant cannot give its value away.
  [[nodiscard]] Value value() const&& {
    throw_if_failed();
    return *value_;
  }

  /// The value; only when this converts to true. Otherwise the program ends with the message of the
  /// outcome, in every build.
  [[nodiscard]] const Value& operator*() const& noexcept {
    abort_if_failed();
    return *value_;
  }

  [[nodiscard]] Value& operator*() & noexcept {
    abort_if_failed();
    return *value_;
  }

  /// By value, as value() is.
  [[nodiscard]] Value operator*() && noexcept {
    abort_if_failed();
    return std::move(*value_);
  }

  [[nodiscard]] Value operator*() const&& noexcept {
    abort_if_failed();
    return *value_;
  }

  /// A member of the value, as `*` is. Of a result that nobody keeps it is valid until the end of
  /// the expression: what lasts longer, such as the range of a `for`, takes value() and its member.
  [[nodiscard]] const Value* operator->() const noexcept {
    abort_if_failed();
    return &*value_;
  }

  [[nodiscard]] Value* operator->() noexcept {
    abort_if_failed();
    return &*value_;
  }

  /// Success when there is a value.
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
