// SPDX-License-Identifier: Apache-2.0
#include "service/probe.hpp"

#include "support/deadline.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

namespace vdrive::test {

template <typename Message, typename Store>
auto Probe::keep(Store store) {
  return [this, store](const Message& message, const wire::Source& /*source*/) {
    {
      const std::lock_guard lock(mutex_);
      store(message);
    }
    changed_.notify_all();
  };
}

template <typename Result>
Result Probe::wait_for(const std::function<Result()>& find) {
  std::unique_lock lock(mutex_);
  Result result{};
  const bool found = changed_.wait_for(lock, kPatience, [&] {
    return static_cast<bool>(result = find());
  });
  if (!found) report_missed_deadline("the probe did not see what it waited for", kPatience);
  return result;
}

Probe::Probe(const wire::NetworkSettings& network, std::uint32_t bench)
    : bench_(bench),
      participant_(wire::make_participant(network, "probe")),
      requests_(*participant_),
      frames_(*participant_),
      reply_reader_(*participant_, keep<msg::Reply>([this](const auto& message) {
        if (message.client == client) replies_.push_back(message);
      })),
      command_reply_reader_(*participant_, keep<msg::CommandReply>([this](const auto& message) {
        command_replies_.push_back(message);
      })),
      event_reader_(*participant_, keep<msg::Event>([this](const auto& message) {
        events_.push_back(message);
      })),
      description_reader_(*participant_, keep<msg::BenchDescription>([this](const auto& m) {
        descriptions_.push_back(m);
      })),
      state_reader_(*participant_, keep<msg::BenchState>([this](const auto& message) {
        // A wire's own probe sends bench 0, to check that discovery works.
        if (message.bench != 0) state_ = message;
      })),
      status_reader_(*participant_, keep<msg::StatusFrame>([this](const auto& message) {
        status_ = message;
      })),
      parameter_reader_(*participant_, keep<msg::AxisParameters>([this](const auto& /*message*/) {
        ++parameter_sets_;
      })) {}

bool Probe::find_bench() {
  const bool announced = wait_until([this] {
    const auto found = std::find_if(descriptions_.begin(), descriptions_.end(), [this](auto& part) {
      return part.bench == bench_ && part.alive;
    });
    if (found != descriptions_.end()) incarnation = found->incarnation;
    return found != descriptions_.end();
  });
  if (!announced) return false;
  const bool matched =
      requests_.wait_for_matched(1, kPatience) && frames_.wait_for_matched(1, kPatience);
  if (!matched) report_missed_deadline("the bench did not receive requests", kPatience);
  return matched;
}

std::uint64_t Probe::next_client() {
  static std::atomic<std::uint64_t> last = 0x1234;
  return ++last;
}

msg::Request Probe::make_request(msg::RequestKind kind) {
  msg::Request request;
  request.client = client;
  request.request_id = ++last_request_;
  request.bench = bench_;
  request.session = session;
  request.kind = kind;
  return request;
}

std::optional<msg::Reply> Probe::exchange(const msg::Request& request) {
  if (!requests_.write(request)) return std::nullopt;
  return wait_for<std::optional<msg::Reply>>([&]() -> std::optional<msg::Reply> {
    for (auto reply = replies_.begin(); reply != replies_.end(); ++reply) {
      if (reply->request_id == request.request_id) {
        auto result = std::move(*reply);
        replies_.erase(reply);
        return result;
      }
    }
    return std::nullopt;
  });
}

std::optional<msg::Reply> Probe::acquire(std::vector<std::uint16_t> axes) {
  auto request = make_request(msg::RequestKind::acquire);
  request.axes = std::move(axes);
  auto reply = exchange(request);
  if (reply) epoch = reply->epoch;
  return reply;
}

std::optional<msg::Reply> Probe::step(std::uint64_t ticks, std::vector<std::uint16_t> axes) {
  auto request = make_request(msg::RequestKind::step);
  request.ticks = ticks;
  request.axes = std::move(axes);
  request.last_sequence = last_sequence;
  return exchange(request);
}

std::optional<msg::Reply> Probe::read(std::uint16_t axis, std::uint16_t index) {
  auto request = make_request(msg::RequestKind::read);
  auto& object = request.objects.emplace_back();
  object.axis = axis;
  object.index = index;
  return exchange(request);
}

std::optional<msg::Reply> Probe::write(std::uint16_t axis, std::uint16_t index,
                                       std::int64_t value) {
  auto request = make_request(msg::RequestKind::write);
  auto& object = request.objects.emplace_back();
  object.axis = axis;
  object.index = index;
  object.value = value;
  return exchange(request);
}

msg::CommandFrame Probe::make_frame() {
  msg::CommandFrame frame;
  frame.bench = bench_;
  frame.incarnation = incarnation;
  frame.session = session;
  frame.epoch = epoch;
  frame.sequence_number = ++last_sequence;
  frame.flags = msg::FRAME_WANT_REPLY;
  return frame;
}

bool Probe::send(const msg::CommandFrame& frame) {
  return frames_.write(frame);
}

std::optional<msg::CommandReply> Probe::reply_to(std::uint64_t sequence) {
  return wait_for<std::optional<msg::CommandReply>>([&]() -> std::optional<msg::CommandReply> {
    const auto found =
        std::find_if(command_replies_.begin(), command_replies_.end(), [&](const auto& reply) {
          return reply.sequence_number == sequence;
        });
    return found == command_replies_.end() ? std::nullopt : std::optional(*found);
  });
}

std::optional<msg::Event> Probe::event(const std::function<bool(const msg::Event&)>& condition) {
  return wait_for<std::optional<msg::Event>>([&]() -> std::optional<msg::Event> {
    const auto found = std::find_if(events_.begin(), events_.end(), condition);
    return found == events_.end() ? std::nullopt : std::optional(*found);
  });
}

bool Probe::wait_until(const std::function<bool()>& condition) {
  return wait_for<bool>(condition);
}

bool Probe::seen_offline() const {
  return std::any_of(descriptions_.begin(), descriptions_.end(), [this](const auto& part) {
    return part.bench == bench_ && !part.alive;
  });
}

std::vector<msg::BenchDescription> Probe::descriptions() {
  const std::lock_guard lock(mutex_);
  return descriptions_;
}

std::optional<msg::StatusFrame> Probe::status() {
  const std::lock_guard lock(mutex_);
  return status_;
}

}  // namespace vdrive::test
