// SPDX-License-Identifier: Apache-2.0
#include "hub.hpp"

#include "descriptions.hpp"
#include "metrics.hpp"
#include "vdrive/number_text.hpp"
#include "wall_time.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <memory>
#include <random>
#include <utility>
#include <variant>
#include <vector>

namespace vdrive::gateway {
namespace {

/// Unique to each run, so that a client that reconnects discards what it knew of the previous run.
std::string random_text() {
  std::random_device device;
  return session_text((std::uint64_t{device()} << 32U) | device());
}

}  // namespace

Hub::Hub(WebServer& server, const HubSettings& settings)
    : server_(server),
      server_info_(server_info_text({.is_control = settings.is_control,
                                     .is_token = settings.is_token,
                                     .version = VDRIVE_VERSION,
                                     .session = random_text()})),
      services_(share(advertise_services_text(service_infos()))),
      dictionary_(share(dictionary_text())),
      options_(settings.session),
      session_(options_),
      channels_(server),
      graph_(server, channels_, clients_),
      control_(settings.is_control, *this, server, clients_),
      dictionary_channel_(std::make_shared<Channel>(dictionary_channel())),
      calls_(*this, server, clients_, control_),
      parameters_(*this, server, clients_, control_),
      judges_(session_) {
  channels_.add(ChannelTable::kOwn, {control_.channel(), dictionary_channel_});
  watch_.emplace(session_, events_,
                 FeedSettings{.rate = settings.rate, .clients = &clients_.count()}, *this);
}

/// By now the server has ended: every connection is closed, and nothing is posted any more.
Hub::~Hub() {
  // First: waiting calls of this session return, so that their threads can end.
  session_.interrupt();
  watch_.reset();
  // Before the parts are destroyed: calls of closed connections may still run and use them.
  clients_.join_ended();
}

// ---- news of benches, from other threads; the tables belong to the server's thread

void Hub::came(std::uint32_t bench, const std::vector<ChannelPointer>& channels) {
  server_.post(std::bind_front(&ChannelTable::add, &channels_, bench, channels));
}

void Hub::went(std::uint32_t bench, const std::vector<ChannelPointer>& channels) {
  server_.post(std::bind_front(&ChannelTable::remove, &channels_, bench, channels));
}

void Hub::publish(Batch batch) {
  channels_.put(std::move(batch));
}

// ---- events of the server

std::string Hub::metrics() const {
  return metrics_text({.web = server_.counters(),
                       .channels = channels_.size(),
                       .subscribed = channels_.subscribed(),
                       .subscriptions = channels_.subscriptions(),
                       .lost_batches = channels_.lost_batches(),
                       .is_controlled = control_.is_held(),
                       .benches = watch_->presences()});
}

void Hub::on_open(ConnectionId id) {
  clients_.open(id);
  // The protocol requires the info first.
  server_.send_text(id, server_info_);
  server_.send_answer(id, text_frame(services_), true);
  channels_.open(id);
  if (!troubles_.empty()) server_.send_text(id, network_text(troubles_));
}

void Hub::on_message(ConnectionId id, bool is_text, std::string_view bytes) {
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
  // Last, so that only the remaining connections are told.
  control_.close(id, is_graceful);
}

void Hub::on_turn() {
  control_.forget_ended_jogs();
  clients_.forget_ended();
  parameters_.poll(watch_->benches());
  graph_.send_changes();
  report_troubles();
}

void Hub::report_troubles() {
  std::vector<std::string> troubles = session_.network_troubles();
  if (troubles == troubles_) return;
  for (const std::string& trouble : troubles) {
    const bool is_known = std::ranges::count(troubles_, trouble) != 0;
    if (!is_known) std::cerr << "vdrive-gateway: " << trouble << '\n';
  }
  troubles_ = std::move(troubles);
  if (troubles_.empty()) std::cerr << "vdrive-gateway: the network works again\n";
  for (const ConnectionId id : clients_.all()) server_.send_text(id, network_text(troubles_));
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
    if (channels_.is_full(id)) return;  // one answer covers all that follow
  }
}

/// Messages of the gateway's own topics are sent immediately; those of a bench are sent by its
/// feed.
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

// ---- the parts' access to the benches

HeldSession Hub::open() {
  // The gateway has already found the benches that a client commands, but the holder's session is a
  // new DDS participant, which on a busy machine may take longer than usual to find them.
  constexpr std::chrono::seconds kFindTimeout{5};
  client::SessionOptions own = options_;
  own.find_timeout = std::max<std::chrono::milliseconds>(own.find_timeout, kFindTimeout);
  auto session = std::make_shared<client::Session>(own);
  return {.id = session->id(), .session = session, .jogs = std::make_shared<Jogs>(session)};
}

void Hub::end(HeldSession held, bool is_graceful) {
  // Immediately, because a worker of the connection may be inside a call of this session.
  if (!is_graceful) held.session->abandon();
  // If the queue is full, the job is destroyed here, which ends jogs and session in this thread and
  // makes it wait.
  (void)session_ends_.post([held = std::move(held), is_graceful]() mutable {
    held.jogs.reset();  // its jogs stop before its axes are released
    if (is_graceful) {
      held.session->interrupt();
      (void)held.session->release();
    }
    held.session.reset();
  });
}

CallAnswer Hub::call(const ServiceRow& row, const SessionPointer& own, const Json& request) {
  if (row.right == Right::events) return call_events(events_, request);
  if (row.right == Right::judge) return judges_.call(request);
  return row.carry_out(own ? *own : session_, request);
}

ParameterAnswer Hub::read(const BenchList& benches, const std::vector<std::string>& names) {
  return read_parameters(session_, *benches, names);
}

ParameterAnswer Hub::write(const SessionPointer& own, const BenchList& benches,
                           const std::vector<ParameterChange>& changes) {
  return write_parameters(*own, *benches, changes);
}

}  // namespace vdrive::gateway
