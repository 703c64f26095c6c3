// SPDX-License-Identifier: Apache-2.0
#include "hub.hpp"

#include "descriptions.hpp"
#include "metrics.hpp"
#include "vdrive/number_text.hpp"
#include "wall_time.hpp"

#include <functional>
#include <memory>
#include <random>
#include <utility>
#include <variant>
#include <vector>

namespace vdrive::gateway {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTidyPeriod{500};
// Each poll is a request to the bench, for all parameters of all clients: at most twice a second.
constexpr milliseconds kParameterPoll{500};
// A page that opens subscribes a thousand topics: they are one change.
constexpr milliseconds kGraphPeriod{500};

/// Another one in each run: a client that connects again forgets what it knew of the run before.
std::string random_text() {
  std::random_device device;
  return session_text((std::uint64_t{device()} << 32U) | device());
}

}  // namespace

Hub::Hub(WebServer& server, const HubSettings& settings)
    : web_(server),
      server_(server.calls()),
      server_info_(server_info_text({.is_control = settings.is_control,
                                     .is_token = settings.is_token,
                                     .version = VDRIVE_VERSION,
                                     .session = random_text()})),
      services_(share(advertise_services_text(service_infos()))),
      dictionary_(share(dictionary_text())),
      session_(settings.session),
      channels_(server_),
      graph_(server_, channels_, clients_),
      control_(settings.is_control,
               {.open = std::bind_front(open_held_session, settings.session),
                .end =
                    [this](HeldSession held, bool is_graceful) {
                      end_held_session(std::move(held), is_graceful, session_ends_);
                    }},
               server_, clients_),
      dictionary_channel_(std::make_shared<Channel>(dictionary_channel())),
      calls_(server_, clients_, control_,
             [this](const ServiceRow& row, const SessionPointer& own, const Json& request) {
               if (row.right == Right::events) return call_events(events_, request);
               return row.carry_out(own ? *own : session_, request);
             }),
      parameters_({.read =
                       [this](const BenchList& benches, const std::vector<std::string>& names) {
                         return read_parameters(session_, *benches, names);
                       },
                   .write =
                       [](const SessionPointer& own, const BenchList& benches,
                          const std::vector<ParameterChange>& changes) {
                         return write_parameters(*own, *benches, changes);
                       }},
                  server_, clients_, control_),
      batches_(server_.post, [this](const Batch& batch) {
        channels_.publish(batch, ChannelTable::Clock::now());
      }) {
  channels_.add(ChannelTable::kOwn, {control_.channel(), dictionary_channel_});
  begin_timers(server);
  watch_.emplace(session_, events_,
                 FeedSettings{.rate = settings.rate, .clients = &clients_.count()}, bench_news());
}

/// After the server has ended: every connection is closed, nothing is posted any more.
Hub::~Hub() {
  // First: calls of this session that wait return, and the threads that make them can end.
  session_.interrupt();
  watch_.reset();
  // Before the parts: calls of closed connections that are under way use them.
  clients_.join_ended();
}

void Hub::begin_timers(WebServer& server) {
  server.every(kTidyPeriod, [this] {
    control_.forget_ended_jogs();
    clients_.forget_ended();
  });
  server.every(kParameterPoll, [this] {
    parameters_.poll(watch_->benches());
  });
  server.every(kGraphPeriod, [this] {
    graph_.send_changes();
  });
}

/// Comes from threads of the watch and its feeds: the tables are of the server's thread.
BenchNews Hub::bench_news() {
  return {.came =
              [this](std::uint32_t bench, const std::vector<ChannelPointer>& channels) {
                server_.post(std::bind_front(&ChannelTable::add, &channels_, bench, channels));
              },
          .went =
              [this](std::uint32_t bench, const std::vector<ChannelPointer>& channels) {
                server_.post(std::bind_front(&ChannelTable::remove, &channels_, bench, channels));
              },
          .publish = std::bind_front(&BatchQueue::put, &batches_)};
}

WebEvents Hub::events() {
  return {.opened = std::bind_front(&Hub::on_open, this),
          .received = std::bind_front(&Hub::on_bytes, this),
          .closed = std::bind_front(&Hub::on_close, this),
          .metrics = std::bind_front(&Hub::metrics, this)};
}

// ---- what the server reports

std::string Hub::metrics() const {
  return metrics_text({.web = web_.counters(),
                       .channels = channels_.size(),
                       .subscribed = channels_.subscribed(),
                       .subscriptions = channels_.subscriptions(),
                       .lost_batches = batches_.lost(),
                       .is_controlled = control_.is_held(),
                       .benches = watch_->presences()});
}

void Hub::on_open(ConnectionId id) {
  clients_.open(id);
  // The protocol wants the info first.
  server_.send_text(id, server_info_);
  server_.send_answer(id, text_frame(services_), true);
  channels_.open(id);
}

void Hub::on_bytes(ConnectionId id, bool is_text, std::string_view bytes) {
  if (!clients_.contains(id)) return;
  try {
    const ClientMessage message = is_text ? parse_text(bytes) : parse_binary(bytes);
    std::visit(
        [&](const auto& kind) {
          handle(id, kind);
        },
        message);
  } catch (const ProtocolError& error) {
    server_.send_status(id, Level::error, error.what());
  }
}

void Hub::on_close(ConnectionId id, bool is_graceful) {
  if (!clients_.close(id)) return;
  graph_.forget(id);
  channels_.close(id);
  parameters_.forget(id);
  // Last: the others hear of it, and only they.
  control_.close(id, is_graceful);
}

void Hub::handle(ConnectionId id, const Subscribe& message) {
  for (const Subscription& wanted : message.subscriptions) {
    ChannelPointer channel;
    const std::string problem = channels_.subscribe(id, wanted, channel);
    if (problem.empty()) {
      send_first(id, wanted.id, *channel);
      continue;
    }
    server_.send_status(id, Level::error, problem);
    if (channels_.is_full(id)) return;  // one answer is enough for all that follow
  }
}

/// The topics of the gateway itself have their message at once; a feed sends those of a bench.
void Hub::send_first(ConnectionId id, std::uint32_t subscription, const Channel& channel) {
  if (&channel == dictionary_channel_.get()) {
    const auto now = static_cast<std::uint64_t>(bridge::wall_time());
    server_.send_answer(id, message_frame(subscription, now, dictionary_), true);
  } else if (&channel == control_.channel().get()) {
    control_.send_to(id, subscription);
  }
}

void Hub::handle(ConnectionId id, const Unsubscribe& message) {
  for (const std::uint32_t subscription : message.ids) {
    const std::string problem = channels_.unsubscribe(id, subscription);
    if (!problem.empty()) server_.send_status(id, Level::warning, problem);
  }
}

void Hub::handle(ConnectionId id, const GetParameters& message) {
  parameters_.get(id, message, watch_->benches());
}

void Hub::handle(ConnectionId id, const SetParameters& message) {
  parameters_.set(id, message, watch_->benches());
}

void Hub::handle(ConnectionId id, const SubscribeParameters& message) {
  parameters_.subscribe(id, message);
}

void Hub::handle(ConnectionId id, const SubscribeGraph& message) {
  graph_.subscribe(id, message.is_on);
}

void Hub::handle(ConnectionId id, const CallService& message) {
  calls_.handle(id, message);
}

}  // namespace vdrive::gateway
