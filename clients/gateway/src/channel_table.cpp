// SPDX-License-Identifier: Apache-2.0
#include "channel_table.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>

namespace vdrive::gateway {
namespace {

/// Encoded once for all connections, including later ones.
SharedBytes advertisement(const std::vector<ChannelPointer>& channels) {
  std::vector<ChannelInfo> infos;
  infos.reserve(channels.size());
  for (const ChannelPointer& channel : channels) infos.push_back(channel->info);
  return share(advertise_text(infos));
}

std::string name_of_bench(const std::string& topic) {
  return topic.substr(1, topic.find('/', 1) - 1);
}

}  // namespace

void ChannelTable::open(ConnectionId id) {
  connections_[id];
  // Encoded already, because a bench may have a thousand topics.
  for (const auto& [bench, text] : advertisements_) {
    server_.send_answer(id, text_frame(text), true);
  }
}

void ChannelTable::close(ConnectionId id) {
  const auto found = connections_.extract(id);
  if (found.empty()) return;
  for (const auto& [subscription, channel] : found.mapped()) end(id, subscription, *channel);
}

void ChannelTable::send_to_all(const SharedBytes& text) {
  for (const auto& [id, subscriptions] : connections_) {
    server_.send_answer(id, text_frame(text), true);
  }
}

void ChannelTable::add(std::uint32_t bench, const std::vector<ChannelPointer>& channels) {
  for (const ChannelPointer& channel : channels) channels_[channel->info.id] = channel;
  const SharedBytes text = advertisement(channels);
  advertisements_[bench] = text;
  send_to_all(text);
  has_changed_ = true;  // the graph is sent later, once for all changes
}

void ChannelTable::remove(std::uint32_t bench, const std::vector<ChannelPointer>& channels) {
  std::vector<std::uint32_t> ids;
  ids.reserve(channels.size());
  for (const ChannelPointer& channel : channels) {
    ids.push_back(channel->info.id);
    removed_topics_.push_back(channel->info.topic);
    // Removes the subscriptions too, because a client may reuse their numbers.
    for (const Receiver& receiver : std::exchange(channel->receivers, {})) {
      const auto connection = connections_.find(receiver.connection);
      if (connection != connections_.end()) connection->second.erase(receiver.subscription);
    }
    channel->subscriptions = 0;
    channels_.erase(channel->info.id);
  }
  advertisements_.erase(bench);
  send_to_all(share(unadvertise_text(ids)));
  has_changed_ = true;
}

ChannelTable::Problem ChannelTable::subscribe(ConnectionId id, const Subscription& wanted,
                                              ChannelPointer& subscribed) {
  Subscriptions& subscriptions = connections_.at(id);
  const auto channel = channels_.find(wanted.channel);
  if (channel == channels_.end()) {
    return "channel " + std::to_string(wanted.channel) + " does not exist";
  }
  if (is_full(id)) {
    return "a connection can have at most " + std::to_string(kMostSubscriptions) + " subscriptions";
  }
  if (!subscriptions.emplace(wanted.id, channel->second).second) {
    return "subscription " + std::to_string(wanted.id) + " exists already";
  }
  subscribed = channel->second;
  subscribed->receivers.push_back({id, wanted.id});
  ++subscribed->subscriptions;
  // The flag is set after the count: a feed that takes the flag must see that the topic is wanted.
  subscribed->has_new_receiver = true;
  has_changed_ = true;
  return {};
}

ChannelTable::Problem ChannelTable::unsubscribe(ConnectionId id, std::uint32_t subscription) {
  const auto found = connections_.at(id).extract(subscription);
  if (found.empty()) return "subscription " + std::to_string(subscription) + " does not exist";
  end(id, subscription, *found.mapped());
  return {};
}

void ChannelTable::end(ConnectionId id, std::uint32_t subscription, Channel& channel) {
  const auto ended = std::erase_if(channel.receivers, [&](const Receiver& receiver) {
    return receiver.connection == id && receiver.subscription == subscription;
  });
  ensure(channel.subscriptions >= ended, "a topic counts each of its receivers");
  channel.subscriptions -= static_cast<std::uint32_t>(ended);
  has_changed_ = true;
}

void ChannelTable::put(Batch batch) {
  if (batches_on_their_way_ >= kMostBatches) {
    ++lost_batches_;
    return;
  }
  ++batches_on_their_way_;
  server_.post([this, batch = std::move(batch)] {
    --batches_on_their_way_;
    publish(batch, Clock::now());
  });
}

void ChannelTable::publish(const Batch& batch, Clock::time_point now) {
  for (const ChannelMessage& message : batch.messages) {
    for (const Receiver& receiver : message.channel->receivers) {
      server_.send_data(receiver.connection,
                        message_frame(receiver.subscription, batch.time, message.bytes));
    }
  }
  send_time(batch, now);
}

void ChannelTable::send_time(const Batch& batch, Clock::time_point now) {
  const auto first = advertisements_.upper_bound(kOwn);
  const bool is_clock = first != advertisements_.end() && first->first == batch.bench;
  // Time 0 means a bench without a tick so far; tools would jump to 1970.
  if (!is_clock || batch.time == 0 || now - time_sent_ < kTimePeriod) return;
  time_sent_ = now;
  for (const auto& [id, subscriptions] : connections_) {
    server_.send_data(id, time_frame(batch.time));
  }
}

void ChannelTable::add_to(Graph& graph, const ClientTable& clients) const {
  for (const auto& [number, channel] : channels_) {
    const std::string& topic = channel->info.topic;
    graph.published.push_back({topic, {name_of_bench(topic)}});
    GraphEntry subscribed{topic, {}};
    for (const Receiver& receiver : channel->receivers) {
      subscribed.ids.push_back(clients.name(receiver.connection));
    }
    // Topics without subscribers are included too: otherwise clients would keep showing the former
    // subscribers.
    graph.subscribed.push_back(std::move(subscribed));
  }
  graph.removed_topics = removed_topics_;
}

std::size_t ChannelTable::subscribed() const {
  return static_cast<std::size_t>(std::ranges::count_if(channels_, [](const auto& entry) {
    return entry.second->is_wanted();
  }));
}

std::size_t ChannelTable::subscriptions() const {
  std::size_t count = 0;
  for (const auto& [id, channel] : channels_) count += channel->subscriptions;
  return count;
}

}  // namespace vdrive::gateway
