// SPDX-License-Identifier: Apache-2.0
//
// Bytes of unknown programs on every topic, with well-formed commands and requests among them. The
// decoder refuses them or gives a message that can be written again. Receivers then process the
// message: the service validates, executes and answers, a client collects status and benches.
#include "engine/bench_engine.hpp"
#include "fuzz/support/bytes.hpp"
#include "presence/directory.hpp"
#include "publish/event_text.hpp"
#include "publish/session_names.hpp"
#include "streams/status_feed.hpp"
#include "support/local_inbox.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive/wire/presence_by_age.hpp"
#include "vdrive/wire/reply.hpp"
#include "vdrive/wire/status_frame.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace {

using namespace vdrive;
using test::Bytes;
using test::demand;

constexpr std::uint32_t kBench = 1;
constexpr std::uint64_t kIncarnation = 1;
constexpr std::size_t kAxes = 3;
constexpr std::size_t kSessions = 3;
constexpr int kMostActions = 48;
constexpr std::uint64_t kMostTicks = 16;

/// @return the same message after encoding and decoding.
template <typename Message>
Message sent(const Message& message) {
  std::vector<std::byte> bytes(wire::encoded_size(message));
  demand(wire::encode(message, bytes) == bytes.size(), "a message can be written");
  Message received;
  demand(wire::decode(bytes, received), "what was written can be read");
  std::vector<std::byte> again(wire::encoded_size(received));
  wire::encode(received, again);
  demand(again == bytes, "reading what was written gives the same");
  return received;
}

service::Configuration bench_configuration() {
  service::Configuration configuration;
  configuration.bench = kBench;
  configuration.clock = service::ClockMode::lockstep;
  configuration.axes = service::default_axes(kAxes);
  return configuration;
}

/// All receivers: a bench without network and clock, and the two parts of a client that keep what
/// they receive.
class Peers {
 public:
  Peers()
      : inbox_(kBench, counters_),
        outbox_(kAxes),
        engine_(bench_configuration(), {.bench = kBench, .incarnation = kIncarnation}, outbox_,
                counters_),
        feed_({kBench, kIncarnation}, {1, 3}, 1) {}

  void receive(const msg::CommandFrame& frame) {
    inbox_.receive(frame, {});
    handle_arrivals();
  }

  void receive(const msg::Request& request) {
    inbox_.receive(request, {});
    handle_arrivals();
  }

  /// Any bytes, as the bench reads them.
  void receive_by_bench(wire::TopicId topic, std::span<const std::byte> bytes) {
    inbox_.receive_sample(topic, bytes, {});
    handle_arrivals();
  }

  void receive(const msg::CommandReply& reply) {
    for (const auto& refusal : reply.refusals) {
      static_cast<void>(wire::describe_reason(wire::number(refusal.reason)));
    }
  }

  void receive(const msg::Reply& reply) {
    std::vector<std::byte> sample(wire::encoded_size(reply));
    demand(wire::encode(reply, sample) == sample.size(), "a reply can be encoded");
    receive_reply(sample);
  }

  /// Any bytes, as a client reads them.
  void receive_reply(std::span<const std::byte> bytes) {
    if (!wire::decode_reply(bytes, reply_, shown_)) return;
    directory_.note_sample({reply_.bench, reply_.incarnation}, reply_.tick, now_);
    static_cast<void>(wire::describe_reason(wire::number(reply_.reason)));
    demand(shown_.size() <= msg::MAX_AXES_PER_FRAME, "a reply shows as many axes as it may");
  }

  void receive(const msg::StatusFrame& frame) {
    directory_.note_sample({frame.bench, frame.incarnation}, frame.tick, now_);
    std::vector<std::byte> sample(wire::encoded_size(frame));
    demand(wire::encode(frame, sample) == sample.size(), "a frame can be encoded");
    receive_status(sample);
  }

  /// Any bytes, as a client reads them.
  void receive_status(std::span<const std::byte> bytes) {
    if (const auto frame = wire::StatusFrameView::of(bytes)) feed_.on_frame(*frame);
    while (const auto sample = feed_.take()) {
      demand(
          sample->axes.size() == 2 && sample->axes[0].id.axis == 1 && sample->axes[1].id.axis == 3,
          "a sample shows the wanted axes");
    }
  }

  void receive(const msg::AxisStatus& status) {
    const AxisStatus shown = wire::from_message(status);
    for (std::size_t row = 0; row < kObjectTable.size(); ++row) {
      static_cast<void>(value_of(shown, static_cast<ObjectRow>(row)));
    }
  }

  void receive(const msg::AxisParameters& /*parameters*/) {}

  void receive(const msg::Event& event) { static_cast<void>(wire::describe_reason(event.code)); }

  void receive(const msg::BenchDescription& description) {
    directory_.on_description(description, {}, now_);
    check_directory();
  }

  void receive(const msg::BenchState& state) {
    directory_.on_state(state, now_);
    check_directory();
  }

  /// The name that a program gives itself, and how the bench forwards it.
  void receive(const msg::SessionName& name) {
    static_cast<void>(names_.note(name));
    for (; names_.next() != nullptr; names_.pop()) {
      demand(names_.next()->place < service::SessionNames::kMost, "a session has a place");
      msg::BenchSession passed_on = *names_.next();
      receive(sent(passed_on));
    }
  }

  void receive(const msg::BenchSession& session) {
    for (const std::string& text :
         {escaped(session.program.to_string()), escaped(session.host.to_string())}) {
      demand(is_utf8(text) && text.find('\n') == std::string::npos, "a name can be shown");
    }
  }

  void step(std::uint64_t ticks) {
    for (std::uint64_t tick = 0; tick < ticks; ++tick) engine_.step();
    engine_.queue_status();
    empty_outbox();
  }

  void jump(std::uint64_t ticks) {
    engine_.jump(ticks);
    empty_outbox();
  }

  [[nodiscard]] std::uint64_t tick() const { return engine_.tick(); }

  /// The epoch that a session received last from the bench.
  [[nodiscard]] std::uint32_t epoch(std::uint64_t session) const {
    const auto found = epochs_.find(session);
    return found == epochs_.end() ? 0 : found->second;
  }

 private:
  void handle_arrivals() {
    while (service::Arrival* const arrival = inbox_.front()) {
      const bool is_request = arrival->kind == service::Arrival::Kind::request;
      const std::uint64_t session = arrival->request.session;
      const std::uint64_t number = arrival->request.request_id;
      if (service::StepRequests::is_for(*arrival)) {
        handle_step(*arrival);
      } else {
        engine_.handle(*arrival);
      }
      inbox_.pop();
      if (is_request) {
        const auto* const answer = outbox_.replies.front();
        demand(answer != nullptr && answer->reply.request_id == number, "a request is answered");
        epochs_[session] = answer->reply.epoch;
      }
      empty_outbox();
    }
  }

  /// Works like the lock-step driver, but runs only a few ticks, and then answers as if the
  /// patience of every waiting step were over.
  void handle_step(service::Arrival& arrival) {
    service::StepRequests& steps = engine_.steps();
    const service::StepRequests::Time now{};
    steps.handle(arrival, now);
    for (std::uint64_t tick = std::min(steps.ticks_to_run(now), kMostTicks); tick > 0; --tick) {
      steps.begin_tick();
      engine_.step();
    }
    steps.answer_due(service::StepRequests::Time::max());
    static_cast<void>(steps.refuse_waiting());
  }

  void empty_outbox() {
    for (; outbox_.command_replies.front() != nullptr; outbox_.command_replies.pop()) {
      msg::CommandReply reply;
      outbox_.command_replies.front()->show(reply);
      pass_on(reply);
    }
    for (; outbox_.replies.front() != nullptr; outbox_.replies.pop()) {
      pass_on_reply(*outbox_.replies.front());
    }
    for (; outbox_.parameters.front() != nullptr; outbox_.parameters.pop()) {
      pass_on(*outbox_.parameters.front());
    }
    for (; outbox_.events.front() != nullptr; outbox_.events.pop()) {
      demand(service::words_of(*outbox_.events.front()).size() <= kLongestText,
             "the words of an event fit");
    }
    for (; outbox_.status.front() != nullptr; outbox_.status.pop()) {
      msg::StatusFrame frame;
      frame.bench = kBench;
      frame.incarnation = kIncarnation;
      const service::StatusImage& image = *outbox_.status.front();
      frame.tick = image.tick;
      for (std::size_t axis = 0; axis < kAxes; ++axis) {
        wire::to_message(image.status[axis], {kBench, static_cast<std::uint16_t>(axis + 1)},
                         image.tick, image.owners[axis], frame.axes.emplace_back());
      }
      pass_on(frame);
    }
  }

  void pass_on_reply(const service::OutgoingReply& outgoing) {
    std::vector<std::byte> sample(wire::encoded_reply_size(outgoing.reply, outgoing.axes.size()));
    demand(wire::encode_reply(outgoing.reply, outgoing.axes, sample) == sample.size(),
           "a reply can be encoded");
    demand(wire::decode_reply(sample, reply_, shown_), "what the bench answers can be read");
    demand(shown_.size() == outgoing.axes.size(), "a reply shows the axes of its bench");
  }

  /// Messages of the bench keep the bounds, survive the wire and can be received.
  template <typename Message>
  void pass_on(Message& message) {
    receive(sent(message));
  }

  void check_directory() {
    for (const auto& bench : directory_.present(now_)) {
      demand(directory_.find(bench.info.number, now_).has_value(),
             "a bench that is there is found");
      demand(directory_.is_alive(bench.key(), client::kPresence, now_), "and alive");
    }
  }

  static constexpr std::size_t kLongestText = 200;

  service::Counters counters_;
  test::LocalInbox inbox_;
  service::Outbox outbox_;
  service::BenchEngine engine_;
  wire::PresenceByAge presence_{{}};
  client::Directory directory_{presence_};
  client::StatusFeed feed_;
  msg::Reply reply_;
  std::vector<wire::ReceivedStatus> shown_;
  client::Directory::Clock::time_point now_{std::chrono::hours{1}};
  std::map<std::uint64_t, std::uint32_t> epochs_;
  service::SessionNames names_{kBench};
};

/// Any bytes as a sample of this topic. As in a subscription, messages beyond the bounds reach no
/// participant except the bench, which answers them.
template <typename Message>
void receive_raw(std::span<const std::uint8_t> data, Peers& peers) {
  if constexpr (std::is_same_v<Message, msg::StatusFrame>) {
    peers.receive_status(std::as_bytes(data));
  }
  if constexpr (std::is_same_v<Message, msg::Reply>) peers.receive_reply(std::as_bytes(data));
  if constexpr (std::is_same_v<Message, msg::CommandFrame> ||
                std::is_same_v<Message, msg::Request>) {
    peers.receive_by_bench(wire::Topic<Message>::kId, std::as_bytes(data));
  }
  Message message;
  if (wire::decode(std::as_bytes(data), message)) peers.receive(sent(message));
}

using Receiver = void (*)(std::span<const std::uint8_t>, Peers&);

/// The receiver of each topic, by topic number.
constexpr std::array kReceivers = std::apply(
    []<typename... Message>(const wire::TopicRow<Message>&...) {
      return std::array<Receiver, sizeof...(Message)>{receive_raw<Message>...};
    },
    wire::kTopicRows);

ObjectAddress address_from(Bytes& bytes) {
  const std::size_t row = bytes.take();
  return row < kObjectTable.size() ? describe(static_cast<ObjectRow>(row)).address
                                   : ObjectAddress{bytes.take<std::uint16_t>(), bytes.take()};
}

std::uint16_t axis_from(Bytes& bytes) {
  return static_cast<std::uint16_t>(bytes.below(kAxes + 2));  // 0 and 4 are not axes
}

template <typename Object>
void fill(Object& object, Bytes& bytes) {
  const ObjectAddress address = address_from(bytes);
  object.index = address.index;
  object.subindex = address.subindex;
  object.value = bytes.take<std::int32_t>();
}

/// A request as our client builds it.
msg::Request request_from(Bytes& bytes) {
  msg::Request request;
  request.client = 1;
  request.bench = kBench;
  request.kind =
      static_cast<msg::RequestKind>(bytes.below(wire::number(msg::RequestKind::step) + 2));
  request.request_id = bytes.take();
  request.session = bytes.below(kSessions + 1);
  request.ticks = bytes.below(kMostTicks);
  request.last_sequence = bytes.below(4);
  for (std::size_t count = bytes.below(4); count > 0; --count) {
    request.axes.push_back(axis_from(bytes));
  }
  for (std::size_t count = bytes.below(4); count > 0; --count) {
    auto& object = request.objects.emplace_back();
    object.axis = axis_from(bytes);
    fill(object, bytes);
  }
  return request;
}

/// A frame as our client builds it, or one with a small error.
msg::CommandFrame frame_from(Bytes& bytes, const Peers& peers, std::uint64_t sequence) {
  msg::CommandFrame frame;
  frame.bench = kBench;
  frame.incarnation = kIncarnation;
  frame.session = bytes.below(kSessions + 1);
  const std::uint8_t odd = bytes.take();
  frame.epoch = (odd & 0x10U) != 0 ? odd : peers.epoch(frame.session);
  frame.sequence_number = (odd & 0x20U) != 0 ? odd : sequence;
  frame.apply_at_tick = (odd & 0x40U) != 0 ? peers.tick() + bytes.below(8) : 0;
  frame.valid_until_tick = (odd & 0x80U) != 0 ? peers.tick() + bytes.below(8) : 0;
  frame.flags = odd & 0x0FU;
  for (std::size_t count = bytes.below(4); count > 0; --count) {
    auto& command = frame.axes.emplace_back();
    command.axis = axis_from(bytes);
    command.members = bytes.take();
    command.ds402_controlword = bytes.take<std::uint16_t>();
    command.op_mode_cmd = bytes.take<std::int8_t>();
    command.position_user_target_value = bytes.take<std::int32_t>();
    command.profile_velocity = bytes.take<std::uint32_t>();
    command.profile_acc = bytes.take<std::uint32_t>();
    command.profile_dec = bytes.take<std::uint32_t>();
    command.positioning_option_code = bytes.take();
    for (std::size_t objects = bytes.below(3); objects > 0; --objects) {
      fill(command.objects.emplace_back(), bytes);
    }
  }
  return frame;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes({data, size});
  Peers peers;
  for (int actions = 1; actions <= kMostActions && !bytes.empty(); ++actions) {
    const std::size_t action = bytes.below(kReceivers.size() + 6);
    if (action < kReceivers.size()) {
      const std::size_t length = bytes.take<std::uint16_t>() % 1024U;
      kReceivers[action](bytes.take_span(length), peers);
      continue;
    }
    switch (action - kReceivers.size()) {
      case 0:
        peers.step(bytes.below(kMostTicks));
        break;
      case 1:
        peers.jump(bytes.take());
        break;
      case 2:
      case 3: {
        msg::Request request = request_from(bytes);
        peers.receive(sent(request));
        break;
      }
      default: {
        msg::CommandFrame frame = frame_from(bytes, peers, static_cast<std::uint64_t>(actions));
        peers.receive(sent(frame));
        break;
      }
    }
  }
  return 0;
}
