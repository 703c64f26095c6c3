// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/outcome.hpp"

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive_messages_description.hpp"

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <utility>

namespace vdrive::client {
namespace {

/// @return how the message of a refusal ends; for an abort code, with the code itself.
std::string end_of_refusal(std::uint32_t code) {
  if (code == kNotPermitted) return ": the permissions of this identity do not allow commands";
  return ": " + wire::describe_reason(code);
}

std::string end_of_refusal(const AxisOwner& owner) {
  return ": " + to_string(owner);
}

}  // namespace

std::vector<RefusalCode> refusal_codes() {
  std::vector<RefusalCode> codes;
  codes.reserve(wire::Description<msg::Reason>::kValues.size() + 1 + kAbortCodes.size());
  for (const auto& row : wire::Description<msg::Reason>::kValues) {
    codes.push_back({row.number, row.name});
  }
  codes.push_back({kNotPermitted, "not_permitted"});
  for (const AbortCodeRow& row : kAbortCodes) {
    if (row.code != AbortCode::none) codes.push_back({wire_code(row.code), row.name});
  }
  return codes;
}

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

Outcome Outcome::with_owner(AxisOwner owner) const {
  if (kind_ != OutcomeKind::refused) return *this;
  Outcome outcome = *this;
  const std::string end = owner_ ? end_of_refusal(*owner_) : end_of_refusal(code_);
  if (message_.ends_with(end)) outcome.message_.resize(message_.size() - end.size());
  outcome.message_ += end_of_refusal(owner);
  outcome.owner_ = std::make_shared<const AxisOwner>(std::move(owner));
  return outcome;
}

Outcome Outcome::with_message(std::string message) const {
  Outcome outcome = *this;
  outcome.message_ = std::move(message);
  return outcome;
}

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
  return {OutcomeKind::refused, code, std::move(message) + end_of_refusal(code)};
}

Outcome Outcome::refused(std::uint32_t code, std::string message, AxisOwner owner) {
  return refused(code, std::move(message)).with_owner(std::move(owner));
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
