// SPDX-License-Identifier: Apache-2.0
#include "service/engine_under_test.hpp"

#include "vdrive/wire/conversion.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace vdrive::test {

service::Configuration bench_configuration(std::size_t axes) {
  service::Configuration configuration;
  configuration.bench = kBench;
  configuration.clock = service::ClockMode::lockstep;
  configuration.watchdog = std::chrono::milliseconds{100};
  configuration.axes = service::default_axes(axes);
  return configuration;
}

EngineUnderTest::EngineUnderTest(const service::Configuration& with)
    : configuration(with),
      inbox(with.bench, counters),
      outbox(with.axes.size()),
      engine(with, {.bench = with.bench, .incarnation = kIncarnation}, outbox, counters) {}

void EngineUnderTest::receive(const msg::CommandFrame& frame) {
  inbox.receive(frame, {});
  handle_arrivals();
}

void EngineUnderTest::receive(const msg::Request& request) {
  inbox.receive(request, {});
  handle_arrivals();
}

void EngineUnderTest::handle_arrivals() {
  while (service::Arrival* const arrival = inbox.front()) {
    engine.handle(*arrival);
    inbox.pop();
  }
}

namespace {

/// @return the answer as the message that is sent.
msg::Reply message_of(const service::OutgoingReply& outgoing) {
  msg::Reply reply = outgoing.reply;
  for (const wire::ShownAxis& axis : outgoing.axes) {
    wire::to_message(axis.status, {reply.bench, axis.number}, axis.tick, axis.owner,
                     reply.statuses.emplace_back());
  }
  return reply;
}

}  // namespace

msg::Reply EngineUnderTest::reply_to(const msg::Request& request) {
  receive(request);
  service::OutgoingReply* const outgoing = outbox.replies.front();
  if (outgoing == nullptr) {
    ADD_FAILURE() << "a request was not answered";
    return {};
  }
  msg::Reply reply = message_of(*outgoing);
  outbox.replies.pop();
  EXPECT_EQ(reply.request_id, request.request_id);
  EXPECT_EQ(reply.client, request.client);
  return reply;
}

msg::Request EngineUnderTest::make_request(msg::RequestKind kind, std::uint64_t session,
                                           std::vector<std::uint16_t> axes) {
  msg::Request request;
  request.client = 1;
  request.request_id = ++last_request_;
  request.bench = configuration.bench;
  request.session = session;
  request.kind = kind;
  request.axes = std::move(axes);
  return request;
}

msg::Reply EngineUnderTest::acquire(std::uint64_t session, std::vector<std::uint16_t> axes) {
  return reply_to(make_request(msg::RequestKind::acquire, session, std::move(axes)));
}

msg::Reply EngineUnderTest::write(std::uint64_t session, std::uint16_t axis, std::uint16_t index,
                                  std::int64_t value, std::uint8_t subindex) {
  auto request = make_request(msg::RequestKind::write, session);
  auto& object = request.objects.emplace_back();
  object.axis = axis;
  object.index = index;
  object.subindex = subindex;
  object.value = value;
  return reply_to(request);
}

msg::Reply EngineUnderTest::read(std::uint16_t axis, std::uint16_t index, std::uint8_t subindex) {
  auto request = make_request(msg::RequestKind::read, 0);
  auto& object = request.objects.emplace_back();
  object.axis = axis;
  object.index = index;
  object.subindex = subindex;
  return reply_to(request);
}

std::int64_t EngineUnderTest::value(std::uint16_t axis, std::uint16_t index,
                                    std::uint8_t subindex) {
  return read(axis, index, subindex).objects.at(0).value;
}

msg::CommandFrame EngineUnderTest::make_frame(std::uint64_t session) {
  // The reply to a read has the epoch of the session and the number of its last frame.
  const auto reply = reply_to(make_request(msg::RequestKind::read, session));
  msg::CommandFrame frame;
  frame.bench = configuration.bench;
  frame.incarnation = kIncarnation;
  frame.session = session;
  frame.epoch = reply.epoch;
  frame.sequence_number = reply.last_sequence + 1;
  frame.flags = msg::FRAME_WANT_REPLY;
  static_cast<void>(events(msg::EventKind::refused));  // refused, because the read names no object
  return frame;
}

std::optional<msg::Reply> EngineUnderTest::reply() {
  service::OutgoingReply* const outgoing = outbox.replies.front();
  if (outgoing == nullptr) return std::nullopt;
  msg::Reply result = message_of(*outgoing);
  outbox.replies.pop();
  return result;
}

std::optional<msg::CommandReply> EngineUnderTest::command_reply() {
  const service::StoredCommandReply* const reply = outbox.command_replies.front();
  if (reply == nullptr) return std::nullopt;
  msg::CommandReply result;
  reply->show(result);
  outbox.command_replies.pop();
  return result;
}

std::optional<msg::Reason> EngineUnderTest::frame_refusal() {
  const auto reply = command_reply();
  if (!reply || reply->refusals.size() != 1 || reply->refusals[0].axis != 0) {
    return std::nullopt;
  }
  return reply->refusals[0].reason;
}

std::vector<service::EventRecord> EngineUnderTest::events(msg::EventKind kind) {
  std::vector<service::EventRecord> found;
  while (const service::EventRecord* const event = outbox.events.front()) {
    if (event->kind == kind) found.push_back(*event);
    outbox.events.pop();
  }
  return found;
}

void EngineUnderTest::steps(std::uint64_t count) {
  for (std::uint64_t step = 0; step < count; ++step) engine.step();
}

msg::AxisCommand& add_command(msg::CommandFrame& frame, std::uint16_t axis) {
  auto& command = frame.axes.emplace_back();
  command.axis = axis;
  return command;
}

void set_controlword(msg::AxisCommand& command, std::uint16_t word) {
  command.members = static_cast<std::uint16_t>(command.members | msg::HAS_DS402_CONTROLWORD);
  command.ds402_controlword = word;
}

}  // namespace vdrive::test
