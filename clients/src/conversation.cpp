// SPDX-License-Identifier: Apache-2.0
#include "conversation.hpp"

#include "vdrive/cia402/error_code.hpp"
#include "vdrive/number_text.hpp"

#include <array>

namespace vdrive::client {
namespace {

// Wall time that one look waits for a sample before it thinks about the deadline.
constexpr std::chrono::milliseconds kPatience{500};

constexpr auto kRefusedInState = wire_code(AbortCode::refused_in_present_device_state);

}  // namespace

msg::AxisCommand controlword_command(std::uint16_t axis, std::uint16_t word) {
  msg::AxisCommand command;
  command.axis(axis);
  command.members(msg::HAS_DS402_CONTROLWORD);
  command.ds402_controlword(word);
  return command;
}

Outcome refused_in_state(const AxisSnapshot& axis, std::string_view command,
                         std::string_view hint) {
  return Outcome::refused(kRefusedInState, "axis " + to_string(axis.id) + " is in " +
                                               std::string(to_string(axis.state())) + ", " +
                                               std::string(command) + " needs " +
                                               std::string(hint));
}

std::string what_it_shows(const AxisSnapshot& axis) {
  std::string text = "shows " + describe_statusword(axis.status.ds402_statusword, axis.mode());
  if (axis.status.error_code != 0) {
    text += ", error " + hex(axis.status.error_code, 4) + " " +
            std::string(vdrive::describe(static_cast<ErrorCode>(axis.status.error_code)));
  }
  return text;
}

Conversation::Conversation(std::shared_ptr<SessionCore> core, AxisId id,
                           std::chrono::nanoseconds timeout)
    : core_(std::move(core)), id_(id), timeout_(timeout) {}

Outcome Conversation::listen() {
  auto target = core_->connection.connect(id_.bench);
  if (!target) return target.outcome();
  target_ = *target;
  const std::array axes{id_.axis};
  follower_ = core_->follow(target_, {axes.begin(), axes.end()}, Pace::drive);
  if (Outcome seen = note(core_->observer.observe(target_, axes)); !seen) return seen;
  deadline_ = now_.tick + ticks_of(timeout_, target_.period);
  return {};
}

Outcome Conversation::take_control() {
  if (Outcome heard = listen(); !heard) return heard;
  if (!core_->connection.may_command()) return not_permitted(target_);
  if (core_->discovery.is_paused(target_.key)) return Outcome::failed(paused_text(target_));
  const std::array axes{id_.axis};
  if (now_.owner_session == core_->id && core_->control.holds(target_, axes)) return {};
  return core_->control.acquire(target_, axes);
}

Outcome Conversation::say(std::span<const msg::AxisCommand> commands) {
  std::vector<FrameContent> frames;
  for (const msg::AxisCommand& command : commands) frames.push_back({.commands = {command}});
  SentFrames sent{.target = target_, .sequences = {}};
  Outcome outcome = core_->commands.send(sent, frames);
  if (outcome && target_.steps()) outcome = core_->clocks.step(target_, 1, {}).outcome();
  const Applied applied = core_->commands.collect(sent, std::move(outcome));
  if (!applied.outcome) return applied.outcome;
  if (!applied.ignored_set_points.empty()) {
    return Outcome::refused(
        kRefusedInState, "axis " + to_string(id_) + " ignored the set-point, its buffer is full");
  }
  if (!target_.steps()) return look_at(applied.tick, "the command to be in force");
  const std::array axes{id_.axis};
  return note(core_->observer.observe(target_, axes));
}

Outcome Conversation::say(const std::vector<std::uint16_t>& controlwords) {
  std::vector<msg::AxisCommand> commands;
  commands.reserve(controlwords.size());
  for (const std::uint16_t word : controlwords) {
    commands.push_back(controlword_command(id_.axis, word));
  }
  return say(commands);
}

Outcome Conversation::look(std::string_view awaited) {
  if (now_.tick >= deadline_) {
    return Outcome::timed_out("axis " + to_string(id_) + ": timed out while waiting for " +
                              std::string(awaited) + ", " + what_it_shows(now_));
  }
  // Drive time may pass slower than wall time; where none passes at all the same time has to do.
  const auto begin = std::chrono::steady_clock::now();
  while (true) {
    auto sample = follower_->next(kPatience);
    if (sample.outcome().kind() != OutcomeKind::timed_out) return note(std::move(sample));
    if (std::chrono::steady_clock::now() - begin >= timeout_) {
      return Outcome::timed_out("axis " + to_string(id_) + ": timed out while waiting for " +
                                std::string(awaited) + ", " + sample.outcome().message());
    }
  }
}

Outcome Conversation::look_at(std::uint64_t tick, std::string_view awaited) {
  return look_until(awaited, [&](const AxisSnapshot& axis) {
    return axis.tick >= tick;
  });
}

Outcome Conversation::note(Result<Observation> sample) {
  if (!sample) return sample.outcome();
  now_ = sample->axes.front();
  now_.tick = sample->tick;
  return {};
}

Result<std::int64_t> Conversation::read(ObjectAddress object) {
  msg::ObjectAccess access;
  access.axis(id_.axis);
  access.index(object.index);
  access.subindex(object.subindex);
  msg::Request request;
  request.kind(msg::REQUEST_READ);
  request.objects().push_back(access);
  const auto reply =
      core_->requests.exchange(target_, std::move(request), "read of axis " + to_string(id_));
  if (!reply) return reply.outcome();
  if (reply->objects().size() != 1) {
    return Outcome::failed("the read of axis " + to_string(id_) + " was answered only in part");
  }
  const msg::ObjectResult& result = reply->objects().front();
  if (result.abort_code() != 0) {
    return Outcome::refused(result.abort_code(), "read of axis " + to_string(id_) + " refused");
  }
  return result.value();
}

Outcome Conversation::not_now(std::string_view command, std::string_view hint) const {
  return refused_in_state(now_, command, hint);
}

Outcome Conversation::ended(std::string_view awaited) const {
  return Outcome::failed("axis " + to_string(id_) + ": waited for " + std::string(awaited) + ", " +
                         what_it_shows(now_));
}

}  // namespace vdrive::client
