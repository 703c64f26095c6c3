// SPDX-License-Identifier: Apache-2.0
#include "bus/ascii_gateway.hpp"

#include "node/cob_id.hpp"
#include "node/node.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

namespace vdrive::canopen {
namespace {

constexpr std::chrono::milliseconds kLongestSdoTimeOut{65'535};
// For "info version" (CiA 309-1): a gateway that is the NMT master of its network.
constexpr unsigned kGatewayClass = 3;

struct NmtRow {
  GatewayVerb verb{};
  std::uint8_t specifier = 0;
};

// CiA 301, 7.2.8.3.1: NMT command specifiers.
constexpr std::array kNmtCommands{
    NmtRow{GatewayVerb::start, 0x01},
    NmtRow{GatewayVerb::stop, 0x02},
    NmtRow{GatewayVerb::preoperational, 0x80},
    NmtRow{GatewayVerb::reset_node, 0x81},
    NmtRow{GatewayVerb::reset_communication, 0x82},
};

std::optional<std::uint8_t> nmt_specifier(GatewayVerb verb) {
  const auto found = std::ranges::find(kNmtCommands, verb, &NmtRow::verb);
  return found == kNmtCommands.end() ? std::nullopt : std::optional(found->specifier);
}

bool is_data_of(const Frame& frame, std::uint32_t base, std::uint8_t size) {
  return frame.id > base && frame.id <= base + kHighestNodeId && frame.size == size &&
         !frame.is_extended && !frame.is_remote;
}

/// @return the node id in an identifier of the predefined connection set.
std::uint8_t node_of(const Frame& frame) {
  return static_cast<std::uint8_t>(frame.id & kHighestNodeId);
}

bool is_boot_up(const Frame& frame) {
  return is_data_of(frame, kHeartbeatId, 1) && frame.data[0] == 0;
}

bool is_emergency(const Frame& frame) {
  return is_data_of(frame, kEmergencyId, kMostData);
}

std::string emergency_text(const Frame& frame) {
  const auto code = static_cast<std::uint32_t>(frame.data[0] | frame.data[1] << 8);
  std::string text = "EMCY " + hex(code, 4).substr(2) + " " + hex(frame.data[2], 2).substr(2);
  for (std::size_t i = 3; i < kMostData; ++i) text += " " + std::to_string(frame.data.at(i));
  return text;
}

std::string abort_text(AbortCode abort) {
  return "ERROR:" + hex(wire_code(abort), 8) + " #" + std::string(describe(abort));
}

std::string error_text(GatewayError error) {
  return "ERROR:" + std::to_string(static_cast<unsigned>(error)) + " #" +
         std::string(describe(error));
}

/// The answer to a command whose transfer has ended.
std::string outcome_text(const GatewayCommand& command, const SdoOutcome& outcome) {
  AbortCode abort = outcome.abort;
  if (abort == AbortCode::none) {
    if (command.verb == GatewayVerb::write) return "OK";
    if (!command.type) return hex_bytes(outcome.data);
    if (auto value = decode_value(*command.type, outcome.data)) return *std::move(value);
    abort = AbortCode::data_length_does_not_match;
  }
  return abort_text(abort);
}

bool is_for_pdo(GatewayVerb verb) {
  return verb == GatewayVerb::set_receive_pdo || verb == GatewayVerb::set_transmit_pdo ||
         verb == GatewayVerb::read_pdo || verb == GatewayVerb::write_pdo;
}

}  // namespace

AsciiGateway::AsciiGateway(const GatewaySettings& settings, GatewayHost& host)
    : settings_(settings), host_(host) {}

GatewaySession AsciiGateway::open() {
  sessions_.try_emplace(++last_session_);
  return last_session_;
}

void AsciiGateway::close(GatewaySession session, BusTime now) {
  sessions_.erase(session);
  for (auto& [node, channel] : channels_) {
    if (channel.user != session) continue;
    channel.client.cancel(AbortCode::cannot_store_or_transfer);
    channel.user.reset();
    serve(channel, now);
  }
}

void AsciiGateway::take_line(GatewaySession session, std::string_view line, BusTime now) {
  sessions_.at(session).lines.emplace_back(line);
  work(session, now);
}

std::size_t AsciiGateway::waiting(GatewaySession session) const {
  const Session& open = sessions_.at(session);
  return open.lines.size() + (open.transfer ? 1 : 0);
}

bool AsciiGateway::awaits(const Frame& frame) const {
  if (is_boot_up(frame) || is_emergency(frame)) return !sessions_.empty();
  if (std::ranges::any_of(sessions_, [&frame](const auto& entry) {
        return entry.second.pdos.awaits(frame);
      })) {
    return true;
  }
  const auto found = channels_.find(node_of(frame));
  return found != channels_.end() && found->second.user && found->second.client.is_for(frame);
}

void AsciiGateway::receive(const Frame& frame, BusTime now) {
  report(frame);
  report_pdos(frame);
  const auto found = channels_.find(node_of(frame));
  if (found == channels_.end()) return;
  found->second.client.receive(frame, now);
  finish(found->second, now);
}

bool AsciiGateway::has_syncs() const {
  return std::ranges::any_of(sessions_, [](const auto& entry) {
    return entry.second.syncs > 0;
  });
}

void AsciiGateway::send_sync(BusTime now) {
  for (auto& [id, session] : sessions_) {
    if (session.syncs == 0) continue;
    host_.send({.id = kSyncId});
    if (--session.syncs > 0) continue;
    answer(id, session.transfer->sequence, "OK");
    session.transfer.reset();
    work(id, now);
  }
}

void AsciiGateway::advance(BusTime now) {
  for (auto& [node, channel] : channels_) {
    channel.client.advance(now);
    finish(channel, now);
  }
}

std::optional<BusTime> AsciiGateway::next_due() const {
  std::optional<BusTime> next;
  for (const auto& [node, channel] : channels_) {
    const auto due = channel.client.next_due();
    if (due && (!next || *due < *next)) next = due;
  }
  return next;
}

/// Carries out lines until one has to wait for its node.
void AsciiGateway::work(GatewaySession id, BusTime now) {
  Session& session = sessions_.at(id);
  while (!session.transfer && !session.lines.empty()) {
    const auto parsed = parse_gateway_command(session.lines.front());
    session.lines.pop_front();
    if (const auto* const refusal = std::get_if<GatewayRefusal>(&parsed)) {
      answer_error(id, refusal->sequence, refusal->error);
    } else if (const auto* const command = std::get_if<GatewayCommand>(&parsed)) {
      carry_out(id, session, *command, now);
    }
  }
}

void AsciiGateway::carry_out(GatewaySession id, Session& session, const GatewayCommand& command,
                             BusTime now) {
  if (command.net && *command.net != settings_.network) {
    return answer_error(id, command.sequence, GatewayError::unsupported_net);
  }
  if (command.verb == GatewayVerb::info_version) {
    return answer(id, command.sequence, version_text());
  }
  if (command.verb == GatewayVerb::sync) {
    session.transfer = command;
    session.syncs = command.value;
    return;
  }
  if (is_for_pdo(command.verb)) return carry_out_pdo(id, session, command);
  if (!is_for_node(command.verb)) return set(id, session, command);
  if (!command.node && !session.default_node) {
    return answer_error(id, command.sequence, GatewayError::no_default_node);
  }
  const std::uint64_t node = command.node ? *command.node : std::uint64_t{*session.default_node};
  const auto specifier = nmt_specifier(command.verb);
  const bool is_disturbance = command.verb == GatewayVerb::disturb;
  // Node 0 means all nodes for NMT commands and for faults of the bus.
  if (node > kHighestNodeId || (node == 0 && !specifier && !is_disturbance)) {
    return answer_error(id, command.sequence, GatewayError::unsupported_node);
  }
  if (is_disturbance) return disturb(id, static_cast<std::uint8_t>(node), command);
  if (!specifier) return begin_transfer(id, static_cast<std::uint8_t>(node), command, now);
  send_nmt(*specifier, static_cast<std::uint8_t>(node));
  answer(id, command.sequence, "OK");
}

void AsciiGateway::set(GatewaySession id, Session& session, const GatewayCommand& command) {
  std::optional<GatewayError> error;
  if (command.verb == GatewayVerb::set_network) {
    if (command.value != settings_.network) error = GatewayError::unsupported_net;
  } else if (command.verb == GatewayVerb::set_node) {
    if (command.value == 0 || command.value > kHighestNodeId) {
      error = GatewayError::unsupported_node;
    } else {
      session.default_node = static_cast<std::uint8_t>(command.value);
    }
  } else if (command.verb == GatewayVerb::set_sdo_timeout) {
    const std::chrono::milliseconds wanted(command.value);
    if (command.value == 0 || wanted > kLongestSdoTimeOut) {
      error = GatewayError::syntax;
    } else {
      session.sdo_time_out = wanted;
    }
  } else {
    ensure(command.verb == GatewayVerb::boot_up_indication, "every command is carried out");
    session.has_boot_up = command.value != 0;
  }
  if (error) return answer_error(id, command.sequence, *error);
  answer(id, command.sequence, "OK");
}

void AsciiGateway::carry_out_pdo(GatewaySession id, Session& session,
                                 const GatewayCommand& command) const {
  PdoRefusal refusal;
  std::string done = "OK";
  if (command.verb == GatewayVerb::read_pdo) {
    const auto values = session.pdos.read(command.value);
    if (!values) refusal = GatewayError::internal_state;  // nothing has been received
    done = std::to_string(settings_.network) + " pdo " + values.value_or("");
  } else if (command.verb == GatewayVerb::write_pdo) {
    Frame frame;
    refusal = session.pdos.write(command, frame);
    if (std::holds_alternative<std::monostate>(refusal)) host_.send(frame);
  } else {
    refusal = session.pdos.set(command);
  }
  if (const auto* const error = std::get_if<GatewayError>(&refusal)) {
    answer_error(id, command.sequence, *error);
  } else if (const auto* const abort = std::get_if<AbortCode>(&refusal)) {
    answer(id, command.sequence, abort_text(*abort));
  } else {
    answer(id, command.sequence, done);
  }
}

void AsciiGateway::disturb(GatewaySession id, std::uint8_t node,
                           const GatewayCommand& command) const {
  const auto refusal = host_.disturb(node, command.fault);
  if (!refusal) return answer(id, command.sequence, "OK");
  answer(id, command.sequence, error_text(GatewayError::syntax) + ": " + *refusal);
}

void AsciiGateway::report_pdos(const Frame& frame) {
  for (auto& [id, session] : sessions_) {
    for (const std::string& values : session.pdos.receive(frame)) {
      host_.report(id, std::to_string(settings_.network) + " pdo " + values);
    }
  }
}

void AsciiGateway::send_nmt(std::uint8_t specifier, std::uint8_t node) const {
  Frame frame{.id = 0, .size = 2};
  frame.data[0] = specifier;
  frame.data[1] = node;
  host_.send(frame);
}

void AsciiGateway::begin_transfer(GatewaySession id, std::uint8_t node,
                                  const GatewayCommand& command, BusTime now) {
  sessions_.at(id).transfer = command;
  const auto entry = channels_.try_emplace(node, Channel{.client = SdoClient(node, host_)});
  Channel& channel = entry.first->second;
  channel.queue.push_back(id);
  serve(channel, now);
}

/// Begins the transfer of the session that has waited longest.
void AsciiGateway::serve(Channel& channel, BusTime now) {
  while (!channel.user && !channel.queue.empty()) {
    const GatewaySession id = channel.queue.front();
    channel.queue.pop_front();
    const auto found = sessions_.find(id);
    if (found == sessions_.end()) continue;  // it was closed while it waited
    const Session& session = found->second;
    channel.user = id;
    if (session.transfer->verb == GatewayVerb::read) {
      channel.client.read(session.transfer->object, session.sdo_time_out, now);
    } else {
      channel.client.write(session.transfer->object, session.transfer->data, session.sdo_time_out,
                           now);
    }
  }
}

/// Sends the answer once the transfer has ended.
void AsciiGateway::finish(Channel& channel, BusTime now) {
  const auto outcome = channel.client.take_outcome();
  if (!outcome) return;
  ensure(channel.user.has_value(), "a transfer has a session");
  const GatewaySession id = *channel.user;
  Session& session = sessions_.at(id);
  answer(id, session.transfer->sequence, outcome_text(*session.transfer, *outcome));
  session.transfer.reset();
  channel.user.reset();
  // Other sessions first, because a session with many commands for a node would lock them out.
  serve(channel, now);
  work(id, now);
}

void AsciiGateway::report(const Frame& frame) const {
  if (is_boot_up(frame)) {
    report_to_all(frame, "BOOT_UP", true);
  } else if (is_emergency(frame)) {
    report_to_all(frame, emergency_text(frame), false);
  }
}

void AsciiGateway::report_to_all(const Frame& frame, std::string_view what,
                                 bool is_optional) const {
  const std::string line = std::to_string(settings_.network) + " " +
                           std::to_string(node_of(frame)) + " " + std::string(what);
  for (const auto& [id, session] : sessions_) {
    if (session.has_boot_up || !is_optional) host_.report(id, line);
  }
}

void AsciiGateway::answer(GatewaySession id, std::uint32_t sequence, std::string_view text) const {
  host_.answer(id, "[" + std::to_string(sequence) + "] " + std::string(text));
}

void AsciiGateway::answer_error(GatewaySession id, std::uint32_t sequence,
                                GatewayError error) const {
  answer(id, sequence, error_text(error));
}

/// Vendor, product, revision (major.minor), serial number, gateway class, protocol version,
/// implementation version. The protocol version is the one that public gateways report for CiA
/// 309-1 and 309-3.
std::string AsciiGateway::version_text() const {
  constexpr std::string_view kVersions = " 2.1 2.1";
  return std::to_string(settings_.vendor_id) + " " + std::to_string(settings_.product_code) + " " +
         std::to_string(settings_.revision_number >> 16U) + "." +
         std::to_string(settings_.revision_number & 0xFFFFU) + " " +
         std::to_string(settings_.serial_number) + " " + std::to_string(kGatewayClass) +
         std::string(kVersions);
}

}  // namespace vdrive::canopen
