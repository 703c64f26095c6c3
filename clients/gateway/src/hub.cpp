// SPDX-License-Identifier: Apache-2.0
#include "hub.hpp"

#include "metrics.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"
#include "wall_time.hpp"

#include <algorithm>
#include <random>
#include <stdexcept>
#include <utility>

namespace vdrive::gateway {
namespace {

using client::Outcome;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kTidyPeriod{500};
constexpr milliseconds kParameterPoll{500};  // at most twice a second
constexpr milliseconds kGraphPeriod{500};
constexpr milliseconds kTimePeriod{50};
// A lost network is noticed early. A program may be late: on a busy machine all of a browser may
// stand still for some seconds.
constexpr Patience kPatienceOfHolder{.program = WebServer::kPatience.program,
                                     .machine = milliseconds(2000)};
constexpr std::size_t kMostBatches = 256;  // under way to the server's thread
constexpr std::size_t kLongestName = 64;
// The code of a drive when another session holds an axis.
constexpr std::uint32_t kControlled = wire_code(AbortCode::refused_local_control);

/// A client commands a bench that its page shows: this gateway has found it. The holder's session
/// is a new participant, which a busy machine may keep from finding it for longer than a search.
client::SessionOptions options_of_holder(client::SessionOptions options) {
  options.find_timeout = std::max<milliseconds>(options.find_timeout, std::chrono::seconds(5));
  return options;
}

std::string random_text() {
  std::random_device device;
  return session_text((std::uint64_t{device()} << 32U) | device());
}

/// The request of a service: an object; nothing at all stands for an empty one.
Json parse_request(const CallService& message) {
  if (message.encoding != "json") {
    throw ProtocolError("the encoding " + in_quotes(message.encoding) + R"( is not "json")");
  }
  if (message.payload.empty()) return Json::object();
  Json request = Json::parse(message.payload, nullptr, false);
  if (!request.is_object()) throw ProtocolError("the request is not a JSON object");
  return request;
}

/// Carries a service out. What is wrong with the request is an answer too.
CallAnswer carry_out(const ServiceRow& row, client::Session& session, const Json& request) {
  try {
    return row.call(session, request);
  } catch (const ProtocolError& error) {
    return {.outcome = Outcome::failed(error.what())};
  }
}

}  // namespace

Hub::Hub(WebServer& server, HubSettings settings)
    : server_(server),
      settings_(std::move(settings)),
      run_(random_text()),
      session_(settings_.session),
      control_(settings_.is_control),
      parameters_(server, session_),
      channels_(server),
      control_channel_(std::make_shared<Channel>(control_channel())),
      dictionary_channel_(std::make_shared<Channel>(dictionary_channel())),
      dictionary_(share(dictionary_text())),
      services_(share(advertise_services_text(service_infos()))) {
  channels_.add(ChannelTable::kOwn, {control_channel_, dictionary_channel_});
  server_.every(kTidyPeriod, [this] {
    control_.forget_ended();
    forget_workers();
  });
  server_.every(kParameterPoll, [this] {
    parameters_.poll(watch_->benches());
  });
  server_.every(kGraphPeriod, [this] {
    if (channels_.take_change()) send_graphs();
  });
  watch_.emplace(session_, FeedSettings{.rate = settings_.rate, .clients = &client_count_},
                 BenchEvents{.came =
                                 [this](std::uint32_t bench, std::vector<ChannelPointer> channels) {
                                   server_.post([this, bench, channels = std::move(channels)] {
                                     channels_.add(bench, channels);
                                   });
                                 },
                             .went =
                                 [this](std::uint32_t bench, std::vector<ChannelPointer> channels) {
                                   server_.post([this, bench, channels = std::move(channels)] {
                                     channels_.remove(bench, channels);
                                   });
                                 },
                             .publish =
                                 [this](Batch batch) {
                                   post_batch(std::move(batch));
                                 }});
}

/// After the server has ended: every connection is closed, nothing is posted any more.
Hub::~Hub() {
  session_.interrupt();
  watch_.reset();
}

WebEvents Hub::events() {
  return {.opened =
              [this](ConnectionId id) {
                on_open(id);
              },
          .received =
              [this](ConnectionId id, bool is_text, std::string_view bytes) {
                on_bytes(id, is_text, bytes);
              },
          .closed =
              [this](ConnectionId id, bool is_graceful) {
                on_close(id, is_graceful);
              },
          .metrics =
              [this] {
                return metrics();
              }};
}

std::string Hub::metrics() const {
  const GatewayCounts counts{.web = server_.counters(),
                             .channels = channels_.size(),
                             .subscribed = channels_.subscribed(),
                             .subscriptions = channels_.subscriptions(),
                             .lost_batches = lost_batches_,
                             .is_controlled = control_.holder().has_value(),
                             .benches = watch_->presences()};
  return metrics_text(counts);
}

// ---- the server's events

void Hub::on_open(ConnectionId id) {
  Client& client = clients_[id];
  client.name = "client " + std::to_string(id);
  client.worker = std::make_shared<bridge::Worker>();
  client_count_ = clients_.size();
  server_.send_answer(id, server_info_text({.is_control = settings_.is_control,
                                            .is_token = settings_.is_token,
                                            .version = VDRIVE_VERSION,
                                            .session = run_}));
  send_shared(id, services_);
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
    send_status(id, Level::error, error.what());
  }
}

void Hub::on_close(ConnectionId id, bool is_graceful) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  Client client = std::move(found->second);
  clients_.erase(found);
  client_count_ = clients_.size();
  channels_.close(id);
  parameters_.forget(id);
  client.worker->close();
  ended_.push_back(client.worker);
  if (!control_.is_holder(id)) return;
  if (is_graceful) {
    control_.release();
  } else {
    control_.abandon();
  }
  send_control();
}

void Hub::forget_workers() {
  std::erase_if(ended_, [](const std::shared_ptr<bridge::Worker>& worker) {
    return worker->has_ended();
  });
}

// ---- channels

void Hub::handle(ConnectionId id, const Subscribe& message) {
  for (const Subscription& wanted : message.subscriptions) {
    ChannelPointer channel;
    const std::string problem = channels_.subscribe(id, wanted, channel);
    if (problem.empty()) {
      send_first(id, wanted.id, *channel);
      continue;
    }
    send_status(id, Level::error, problem);
    if (channels_.is_full(id)) return;  // one answer is enough for all that follow
  }
}

/// The topics of the gateway itself have their message at once; a feed sends those of a bench.
void Hub::send_first(ConnectionId id, std::uint32_t subscription, const Channel& channel) {
  if (&channel == dictionary_channel_.get()) {
    server_.send_answer(
        id,
        message_frame(subscription, static_cast<std::uint64_t>(bridge::wall_time()), dictionary_),
        true);
  } else if (&channel == control_channel_.get()) {
    send_control_to(id, subscription);
  }
}

void Hub::handle(ConnectionId id, const Unsubscribe& message) {
  for (const std::uint32_t subscription : message.ids) {
    const std::string problem = channels_.unsubscribe(id, subscription);
    if (!problem.empty()) send_status(id, Level::warning, problem);
  }
}

void Hub::send_control() {
  for (const Receiver& receiver : control_channel_->receivers) {
    send_control_to(receiver.connection, receiver.subscription);
  }
}

void Hub::send_control_to(ConnectionId id, std::uint32_t subscription) {
  const auto client = clients_.find(id);
  if (client == clients_.end()) return;
  const std::string text =
      control_text(control_.state(holder_name()), client->second.name, control_.is_holder(id));
  server_.send_answer(
      id,
      message_frame(subscription, static_cast<std::uint64_t>(bridge::wall_time()), share(text)));
}

std::string Hub::holder_name() const {
  const auto holder = control_.holder();
  return holder ? clients_.at(*holder).name : std::string();
}

// ---- benches

void Hub::post_batch(Batch batch) {
  // The thread of the server stands still: what it cannot take now it does not need later.
  if (batches_under_way_ >= kMostBatches) {
    ++lost_batches_;
    return;
  }
  ++batches_under_way_;
  server_.post([this, batch = std::move(batch)] {
    --batches_under_way_;
    publish(batch);
  });
}

void Hub::publish(const Batch& batch) {
  channels_.publish(batch);
  if (!channels_.is_clock(batch) || batch.time == 0) return;
  const auto now = Clock::now();
  if (now - time_sent_ < kTimePeriod) return;
  time_sent_ = now;
  for (const auto& [id, client] : clients_) server_.send_data(id, time_frame(batch.time));
}

// ---- the graph of connections

void Hub::handle(ConnectionId id, const SubscribeGraph& message) {
  clients_.at(id).wants_graph = message.is_on;
  if (message.is_on) send_graph(id);
}

void Hub::send_graphs() {
  for (const auto& [id, client] : clients_) {
    if (client.wants_graph) send_graph(id);
  }
  channels_.forget_removed();
}

void Hub::send_graph(ConnectionId id) {
  Graph graph;
  channels_.add_to(graph, [this](ConnectionId client) {
    return clients_.at(client).name;
  });
  for (const ServiceRow& row : services()) {
    graph.services.push_back({std::string(row.name), {"gateway"}});
  }
  server_.send_answer(id, graph_text(graph));
}

// ---- parameters

bool Hub::post(ConnectionId id, std::function<void()> job) {
  if (clients_.at(id).worker->post(std::move(job))) return true;
  send_status(id, Level::error, "too many requests wait: this one is dropped");
  return false;
}

void Hub::handle(ConnectionId id, const GetParameters& message) {
  const BenchList benches = watch_->benches();
  std::vector<std::string> names = message.names;
  if (names.empty()) {
    names = all_parameters(*benches);
    if (names.empty() && !benches->empty()) {
      send_status(id, Level::warning,
                  "the benches have more than " + std::to_string(kMostAxesOfAll) +
                      R"( axes: ask for parameters by name, such as "bench1/x/0x6081")");
    }
  }
  (void)post(id, [this, id, benches, names = std::move(names), request = message.id] {
    auto read = read_parameters(session_, *benches, names);
    server_.post([this, id, read = std::move(read), request] {
      send_parameters(id, read, request);
    });
  });
}

void Hub::handle(ConnectionId id, const SetParameters& message) {
  if (const Outcome right = check_right(id, Right::command); !right) {
    send_status(id, Level::error, right.message());
    return;
  }
  (void)post(id, [this, id, benches = watch_->benches(), message, session = control_.session()] {
    auto written = write_parameters(*session, *benches, message.parameters);
    server_.post([this, id, written = std::move(written), message] {
      send_parameters(id, written, message.id);
    });
  });
}

void Hub::send_parameters(ConnectionId id, const ParameterAnswer& answer,
                          const std::optional<std::string>& request) {
  if (!clients_.contains(id)) return;
  for (const std::string& complaint : answer.complaints) send_status(id, Level::error, complaint);
  if (clients_.contains(id)) server_.send_answer(id, parameters_text(answer.parameters, request));
}

void Hub::handle(ConnectionId id, const SubscribeParameters& message) {
  if (parameters_.subscribe(id, message)) return;
  send_status(
      id, Level::error,
      "a connection subscribes " + std::to_string(ParameterWatch::kMost) + " parameters at most");
}

// ---- services

Outcome Hub::check_right(ConnectionId id, Right right) const {
  if (right == Right::none) return {};
  if (!control_.is_enabled()) {
    return Outcome::refused(kControlled,
                            "this gateway is view only: start it with --control to command axes");
  }
  const bool needs_control = right == Right::command || right == Right::jog;
  if (!needs_control || control_.is_holder(id)) return {};
  if (control_.holder()) return held_outcome();
  return Outcome::refused(kControlled, "take control first, with /take_control");
}

Outcome Hub::held_outcome() const {
  return Outcome::refused(kControlled,
                          "control is held by " + in_quotes(holder_name()) +
                              ": /take_control takes it over when its request has force");
}

void Hub::handle(ConnectionId id, const CallService& message) {
  try {
    if (message.service == 0 || message.service > services().size()) {
      throw ProtocolError("service " + std::to_string(message.service) + " does not exist");
    }
    const ServiceRow& row = services()[message.service - 1];
    Json request = parse_request(message);
    if (Outcome right = check_right(id, row.right); !right) {
      answer(id, message, {.outcome = std::move(right)});
    } else if (row.right == Right::change_control) {
      change_control(id, message, row, request);
    } else if (row.right == Right::jog) {
      jog(id, message, request);
    } else {
      run_call(id, message, row, std::move(request));
    }
  } catch (const ProtocolError& error) {
    server_.send_answer(id, call_failure_text(message.service, message.call, error.what()));
  }
}

void Hub::run_call(ConnectionId id, const CallService& message, const ServiceRow& row,
                   Json request) {
  const SessionPointer own = control_.is_holder(id) ? control_.session() : nullptr;
  auto job = [this, id, message, &row, request = std::move(request), own] {
    auto answered = carry_out(row, own ? *own : session_, request);
    server_.post([this, id, message, answered = std::move(answered)] {
      answer(id, message, answered);
    });
  };
  // A stop waits for no other call of this client.
  const bool is_posted = row.right == Right::stop ? stops_.post(std::move(job))
                                                  : clients_.at(id).worker->post(std::move(job));
  if (!is_posted) {
    answer(id, message, {.outcome = Outcome::failed("too many calls wait: this one is dropped")});
  }
}

void Hub::jog(ConnectionId id, const CallService& message, const Json& request) {
  try {
    control_.jog(jog_of(request), Clock::now(), [this, id, message](const CallAnswer& answered) {
      server_.post([this, id, message, answered] {
        answer(id, message, answered);
      });
    });
  } catch (const ProtocolError& error) {
    answer(id, message, {.outcome = Outcome::failed(error.what())});
  }
}

void Hub::answer(ConnectionId id, const CallService& message, const CallAnswer& answer) {
  if (!clients_.contains(id)) return;
  server_.send_answer(id, response_frame(message.service, message.call, answer_text(answer)));
}

// ---- control

void Hub::change_control(ConnectionId id, const CallService& message, const ServiceRow& row,
                         const Json& request) {
  if (row.name == "/take_control") {
    take_control(id, message, request);
    return;
  }
  if (control_.is_holder(id)) {
    control_.release();
    server_.set_patience(id, WebServer::kPatience);
    send_control();
  }
  answer(id, message, {});
}

void Hub::take_control(ConnectionId id, const CallService& message, const Json& request) {
  std::string name = escaped(text_of(request, "name"), kLongestName);
  const bool by_force = flag_of(request, "force");
  if (control_.holder() && !control_.is_holder(id) && !by_force) {
    answer(id, message, {.outcome = held_outcome()});
    return;
  }
  if (control_.is_holder(id)) {
    if (!name.empty()) clients_.at(id).name = std::move(name);
    send_control();
    answer(id, message, {});
    return;
  }
  const bool is_posted =
      clients_.at(id).worker->post([this, id, message, by_force, name = std::move(name)] {
        SessionPointer session;
        std::string error;
        try {
          session = std::make_shared<client::Session>(options_of_holder(settings_.session));
        } catch (const std::exception& failure) {
          error = failure.what();
        }
        server_.post([this, id, message, by_force, name, session = std::move(session), error] {
          on_session(id, message, {.name = name, .by_force = by_force}, session, error);
        });
      });
  if (!is_posted) answer(id, message, {.outcome = Outcome::failed("too many calls wait")});
}

void Hub::on_session(ConnectionId id, const CallService& message, const Taking& taking,
                     const SessionPointer& session, const std::string& error) {
  const auto client = clients_.find(id);
  if (client == clients_.end()) return;  // it closed meanwhile, and the session held nothing yet
  if (!session) {
    answer(id, message, {.outcome = Outcome::failed(error)});
    return;
  }
  if (control_.holder() && !control_.is_holder(id)) {
    // Another connection may have taken control while the session was made.
    if (!taking.by_force) {
      answer(id, message, {.outcome = held_outcome()});
      return;
    }
    const ConnectionId before = *control_.holder();
    server_.set_patience(before, WebServer::kPatience);
    send_status(before, Level::warning, "control was taken over");
  }
  if (!taking.name.empty()) client->second.name = taking.name;
  control_.take(id, session);
  server_.set_patience(id, kPatienceOfHolder);
  send_control();
  answer(id, message, {});
}

void Hub::send_status(ConnectionId id, Level level, std::string_view text) {
  server_.send_answer(id, status_text(level, text));
}

void Hub::send_shared(ConnectionId id, const SharedBytes& text) {
  server_.send_answer(id, text_frame(text), true);
}

}  // namespace vdrive::gateway
