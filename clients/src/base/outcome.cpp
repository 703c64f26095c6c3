// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/outcome.hpp"

#include "vdrive/wire/conversion.hpp"

#include <cstdio>
#include <cstdlib>
#include <utility>

namespace vdrive::client {
namespace {

std::string with_code(std::string message, std::uint32_t code) {
  constexpr std::uint32_t kFirstAbortCode = 0x05000000;
  message += ": ";
  if (code == kNotPermitted) {
    return message + "the permissions of this identity do not allow commands";
  }
  if (code < kFirstAbortCode) message += "reason " + std::to_string(code) + ", ";
  return message + wire::describe_reason(code);  // which starts with an abort code itself
}

}  // namespace

std::string_view to_string(OutcomeKind kind) noexcept {
  switch (kind) {
    case OutcomeKind::ok:
      return "ok";
    case OutcomeKind::refused:
      return "refused";
    case OutcomeKind::timed_out:
      return "timed_out";
    case OutcomeKind::not_found:
      return "not_found";
    case OutcomeKind::lost:
      return "lost";
    case OutcomeKind::failed:
      return "failed";
  }
  return "unknown";
}

Outcome::Outcome(OutcomeKind kind, std::uint32_t code, std::string message)
    : kind_(kind), code_(code), message_(std::move(message)) {}

Outcome Outcome::with_prefix(std::string_view words) const {
  Outcome outcome = *this;
  outcome.message_.insert(0, words);
  return outcome;
}

void Outcome::or_throw() const {
  if (kind_ != OutcomeKind::ok) throw OutcomeError(*this);
}

OutcomeError::OutcomeError(Outcome outcome)
    : std::runtime_error(outcome.message()), outcome_(std::move(outcome)) {}

void abort_on_failed_result(const Outcome& outcome) noexcept {
  std::fprintf(stderr, "vdrive: a failed result was used: %s\n", outcome.message().c_str());
  std::abort();
}

Outcome Outcome::refused(std::uint32_t code, std::string message) {
  return {OutcomeKind::refused, code, with_code(std::move(message), code)};
}

Outcome Outcome::timed_out(std::string message) {
  return {OutcomeKind::timed_out, 0, std::move(message)};
}

Outcome Outcome::not_found(std::string message) {
  return {OutcomeKind::not_found, 0, std::move(message)};
}

Outcome Outcome::lost(std::string message) {
  return {OutcomeKind::lost, 0, std::move(message)};
}

Outcome Outcome::failed(std::string message) {
  return {OutcomeKind::failed, 0, std::move(message)};
}

}  // namespace vdrive::client
