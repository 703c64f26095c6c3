// SPDX-License-Identifier: Apache-2.0
#include "node/emergency.hpp"

#include "node/cob_id.hpp"
#include "node/node_object.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <chrono>
#include <utility>

namespace vdrive::canopen {
namespace {

constexpr std::uint16_t kEmergencyCobId = 0x1014;
constexpr std::uint16_t kEmergencyInhibitTime = 0x1015;

constexpr auto kHeartbeatError = static_cast<std::uint16_t>(ErrorCode::life_guard_or_heartbeat);

/// Generic and communication error (CiA 301, 7.5.2.2): the bits set by every communication error.
constexpr std::uint8_t kCommunicationError = 1U << 0U | 1U << 4U;

/// Bits 11 to 30 of 1014h: reserved, or used only by an extended CAN-ID.
constexpr std::uint32_t kReservedOfEmergencyId = kCobIdExtendedBits | 1U << 30U;

constexpr std::chrono::microseconds kInhibitUnit{100};

/// A drive that still has power has not restarted, even if it has no fault: it may yet react to the
/// loss of its master with one.
bool has_restarted(const AxisStatus& drive, std::uint32_t faults_before) {
  const bool has_power = (drive.ds402_statusword & Statusword::kOperationEnabled) != 0;
  const bool is_fresh = drive.error_code == 0 && drive.fault_count == 0 && !has_power;
  return is_fresh || drive.fault_count < faults_before;
}

}  // namespace

Emergency::Emergency(std::uint8_t node_id, NodeHost& host) : node_id_(node_id), host_(host) {
  reset();
}

AbortCode Emergency::set_cob_id(std::uint32_t value) {
  const bool is_valid = (value & kCobIdNotValid) == 0;
  const bool was_valid = (cob_id_ & kCobIdNotValid) == 0;
  const bool is_other = is_valid && was_valid && value != cob_id_;
  const bool is_restricted = is_valid && is_restricted_can_id(can_id_of(value));
  if ((value & kReservedOfEmergencyId) != 0 || is_other || is_restricted) {
    return AbortCode::value_range_exceeded;
  }
  cob_id_ = value;
  if (!is_valid) waiting_.clear();
  return AbortCode::none;
}

void Emergency::reset() {
  cob_id_ = initial_value({kEmergencyCobId, 0}, node_id_);
  inhibit_time_ = static_cast<std::uint16_t>(initial_value({kEmergencyInhibitTime, 0}));
  is_allowed_ = false;
  drive_ = {};
  has_heartbeat_error_ = false;
  has_error_ = false;
  waiting_.clear();
  last_sent_.reset();
}

void Emergency::set_allowed(bool is_allowed, DriveTime now) {
  is_allowed_ = is_allowed;
  advance(now);
}

void Emergency::await_restart(const AxisStatus& drive, DriveTime now) {
  restart_ = Restart{.faults_before = drive.fault_count, .end = now + kLongestRestart};
  clear_history();
}

bool Emergency::awaits_restart(const AxisStatus& drive, DriveTime now) {
  if (restart_ && (now >= restart_->end || has_restarted(drive, restart_->faults_before))) {
    restart_.reset();
  }
  return restart_.has_value();
}

void Emergency::update(const AxisStatus& drive, DriveTime now) {
  if (awaits_restart(drive, now)) {
    drive_ = drive;
    drive_.error_code = 0;  // not sent, so its end is not sent either
    return;
  }
  if (drive.fault_count < drive_.fault_count) clear_history();  // power cycle
  const bool has_fault = drive.error_code != 0;
  // Compares the count as well as the code: the same fault may have occurred again after a reset
  // within one tick.
  const bool is_new = has_fault && (drive.error_code != drive_.error_code ||
                                    drive.fault_count != drive_.fault_count);
  const bool is_over = !has_fault && drive_.error_code != 0;
  drive_ = drive;
  const bool is_sent = has_heartbeat_error_ && drive.error_code == kHeartbeatError;
  if ((is_new && !is_sent) || is_over) post({.error_code = drive.error_code}, now);
}

void Emergency::begin_error(std::uint16_t error_code, DriveTime now) {
  has_error_ = true;
  post({.error_code = error_code}, now);
}

void Emergency::end_errors(DriveTime now) {
  if (std::exchange(has_error_, false)) note_end(now);
}

void Emergency::begin_heartbeat_error(std::uint8_t producer, DriveTime now) {
  has_heartbeat_error_ = true;
  post({.error_code = kHeartbeatError, .producer = producer}, now);
}

void Emergency::end_heartbeat_error(DriveTime now) {
  if (std::exchange(has_heartbeat_error_, false)) note_end(now);
}

void Emergency::note_end(DriveTime now) {
  if (error_register() == 0 && drive_.error_code == 0) post({}, now);
}

std::uint8_t Emergency::error_register() const noexcept {
  return has_heartbeat_error_ || has_error_ ? kCommunicationError : std::uint8_t{0};
}

void Emergency::advance(DriveTime now) {
  while (!waiting_.empty() && is_allowed_ && now >= next_allowed()) {
    host_.send({.id = can_id_of(cob_id_), .size = kMostData, .data = *waiting_.take()});
    last_sent_ = now;
  }
}

std::optional<DriveTime> Emergency::next_due() const {
  return !waiting_.empty() && is_allowed_ ? std::optional(next_allowed()) : std::nullopt;
}

DriveTime Emergency::next_allowed() const {
  return last_sent_ ? *last_sent_ + inhibit_time_ * kInhibitUnit : DriveTime::min();
}

void Emergency::post(const Cause& cause, DriveTime now) {
  if (cause.error_code != 0) history_.push_front(cause.error_code);
  if (history_.size() > kMostHistory) history_.pop_back();
  if ((cob_id_ & kCobIdNotValid) != 0) return;
  advance(now);  // first send what was already due
  waiting_.put(message_of(cause));
  advance(now);
}

Emergency::Message Emergency::message_of(const Cause& cause) const {
  const auto low = [](std::uint32_t word) {
    return static_cast<std::uint8_t>(word & 0xFFU);
  };
  const std::uint16_t statusword = drive_.ds402_statusword;
  return {low(cause.error_code),
          low(cause.error_code >> 8U),
          static_cast<std::uint8_t>(drive_.error_register | error_register()),
          low(statusword),
          low(statusword >> 8U),
          static_cast<std::uint8_t>(drive_.op_mode_actual),
          low(drive_.fault_count),
          cause.producer};
}

}  // namespace vdrive::canopen
