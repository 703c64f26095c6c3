// SPDX-License-Identifier: Apache-2.0
#include "guard.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>
#include <vector>

namespace vdrive::wire {
namespace {

// Participants of vdrive announce themselves every 100 ms.
constexpr std::chrono::milliseconds kBetweenJudgements{100};

std::string text_of_locator(const Guard::Locator& locator) {
  return rtps::IPLocator::ip_to_string(locator) + ":" +
         std::to_string(rtps::IPLocator::getPhysicalPort(locator));
}

std::chrono::steady_clock::duration patience_with(const Announcement& announcement) {
  if (announcement.announcer != Announcer::foreign) return kPatienceWithVdrive;
  return announcement.lease == std::chrono::milliseconds::max()
             ? std::chrono::steady_clock::duration::max()
             : std::chrono::steady_clock::duration(announcement.lease);
}

}  // namespace

Guard::Guard(const NetworkSettings& settings)
    : role_(settings.role),
      mode_(settings.security.empty() ? Mode::open : Mode::closed),
      // A server announces its clients, and the library handles their leases.
      keeps_leases_(settings.discovery_servers.empty()),
      raises_leases_(mode_ == Mode::open || kMembersMayLeaveInClear),
      sink_(settings.guard_sink),
      receive_coalescing_(settings.receive_coalescing) {
  judge_ = std::thread([this] {
    judge();
  });
}

Guard::~Guard() {
  {
    const std::scoped_lock lock(end_mutex_);
    ends_ = true;
  }
  end_changed_.notify_all();
  judge_.join();
}

void Guard::open(const Locator& local, Receiver* channel) {
  const std::scoped_lock lock(channels_mutex_);
  channels_.try_emplace(local, channel);  // a second receiver of a channel gets nothing
}

void Guard::begin() {
  has_begun_ = true;
  has_begun_.notify_all();
}

void Guard::close(const Locator& local) {
  begin();  // if creating a participant failed, its receivers are still waiting
  const std::scoped_lock lock(handing_over_, channels_mutex_, keeper_mutex_);
  const auto found = channels_.find(local);
  if (found != channels_.end()) {
    keeper_.closed(found->second);
    silent_readers_.closed(found->second);
    channels_.erase(found);
  }
}

void Guard::receive(Receiver& channel, ByteView datagram, const Locator& local,
                    const Locator& remote) {
  has_begun_.wait(false);
  const DatagramReport report = check_datagram(datagram, mode_);
  if (report.refusal != Refusal::none) {
    refuse(report.refusal, remote);
    return;
  }
  if (!keeps_leases_) {
    const std::scoped_lock lock(keeper_mutex_);
    if (servers_.holds_back(datagram.first(report.length), Clock::now())) {
      ++held_back_;
      return;
    }
    silent_readers_.received(datagram.first(report.length), &channel);
  }
  const auto now = Clock::now();
  std::vector<std::uint8_t> renumbered;
  // Datagrams that are held back below are read too: the first heartbeat of a writer shows where
  // its numbers start.
  const auto readable =
      with_plausible_numbers(datagram.first(report.length), now, remote, renumbered);
  if (keeps_leases_) {
    const std::scoped_lock lock(keeper_mutex_);
    keeper_.note_datagram(sender_of(datagram), now);
    if (has_returned_ && comes_too_early(datagram, now)) {
      ++held_back_;
      return;
    }
  }
  if (!readable) return;
  const auto receiving = deletions_.receive();
  if (report.announces) {
    pass_discovery(channel, *readable, local, remote);
  } else {
    hand_over(channel, *readable, local, remote);
  }
}

/// In the closed mode the numbers are encrypted, so the datagram passes.
/// @return the datagram for the library, possibly renumbered; nothing if it must not read it.
std::optional<ByteView> Guard::with_plausible_numbers(ByteView datagram, Clock::time_point now,
                                                      const Locator& remote,
                                                      std::vector<std::uint8_t>& renumbered) {
  if (mode_ == Mode::closed) return datagram;
  const WriterNumbers::Report report = numbers_.receive(datagram, now, renumbered);
  if (report.needs_resync && !keeps_leases_) {
    // With discovery servers the library handles the leases, and the guard cannot make it forget a
    // participant. So the library processes the numbers as it would without the guard.
    numbers_.removed(*report.needs_resync);
    return datagram;
  }
  if (report.needs_resync) {
    const std::scoped_lock lock(keeper_mutex_);
    keeper_.expire(*report.needs_resync);
  }
  if (report.refusal == Refusal::none) {
    return report.is_renumbered ? ByteView(renumbered) : datagram;
  }
  refuse(report.refusal, remote);
  return std::nullopt;
}

void Guard::hand_over(Receiver& channel, ByteView datagram, const Locator& local,
                      const Locator& remote) {
  ++handed_over_;
  channel.OnDataReceived(datagram.data(), static_cast<std::uint32_t>(datagram.size()), local,
                         remote);
}

bool Guard::found(const GuidPrefix& participant) {
  numbers_.found(participant);
  const std::scoped_lock lock(keeper_mutex_);
  servers_.found(participant);
  if (!keeps_leases_) silent_readers_.found(participant);
  return closed_.contains(participant);
}

void Guard::lost(const GuidPrefix& participant) {
  numbers_.removed(participant);
  const std::scoped_lock lock(keeper_mutex_);
  servers_.removed(participant);
  silent_readers_.removed(participant);
}

GuardCounts Guard::counts() const {
  GuardCounts counts;
  std::ranges::copy(refused_, counts.refused.begin());
  counts.handed_over = handed_over_;
  counts.ignored = ignored_;
  counts.judged = judged_;
  counts.held_back = held_back_;
  const std::scoped_lock lock(keeper_mutex_);
  counts.kept = keeper_.size();
  return counts;
}

void Guard::refuse(Refusal refusal, const Locator& remote) {
  const auto kind = static_cast<std::size_t>(refusal);
  ensure(kind < refused_.size(), "each refusal has a counter");
  ++refused_[kind];
  if (sink_) sink_(refusal, text_of_locator(remote));
}

/// If the library encrypts complete datagrams, no heartbeat is visible and none is held back.
bool Guard::comes_too_early(ByteView datagram, Clock::time_point now) const {
  const GuidPrefix sender = sender_of(datagram);
  bool is_early = false;
  Submessages submessages(datagram);
  for (Submessage submessage; !submessages.at_end() && submessages.next(submessage);) {
    const auto heartbeat = parse_heartbeat(submessage);
    is_early = is_early || (heartbeat && returned_.holds_back(sender, heartbeat->writer, now));
  }
  return is_early;
}

ByteView Guard::sends(ByteView datagram, std::vector<std::uint8_t>& renumbered) {
  note_initial_acknacks(datagram);
  if (!keeps_leases_) {
    const std::scoped_lock lock(keeper_mutex_);
    silent_readers_.sends(datagram);
  }
  const bool differs = mode_ == Mode::open && numbers_.send(datagram, renumbered);
  return differs ? ByteView(renumbered) : datagram;
}

void Guard::note_initial_acknacks(ByteView datagram) {
  if (!has_returned_) return;
  GuidPrefix receiver{};
  Submessages submessages(datagram);
  for (Submessage submessage; !submessages.at_end() && submessages.next(submessage);) {
    if (submessage.kind == SubmessageKind::info_dst) {
      ByteReader reader = submessage.reader();
      const ByteView prefix = reader.bytes(receiver.size());
      if (reader.ok()) std::ranges::copy(prefix, receiver.begin());
    } else if (const auto acknack = parse_acknack(submessage); acknack && acknack->base == 0) {
      const std::scoped_lock lock(keeper_mutex_);
      returned_.initial_acknack_sent(receiver, acknack->writer);
    }
  }
}

/// Works on a copy, because others may read the transport's buffer too (shared memory).
void Guard::pass_discovery(Receiver& channel, ByteView datagram, const Locator& local,
                           const Locator& remote) {
  std::vector<std::uint8_t> copy(datagram.begin(), datagram.end());
  Submessages submessages(copy);
  std::unique_lock lock(announcing_, std::defer_lock);
  for (Submessage submessage; !submessages.at_end() && submessages.next(submessage);) {
    if (submessage.kind != SubmessageKind::data) continue;
    if (!passes(submessage, copy, channel, remote)) return;
    if (!lock && may_announce(submessage, parse_data(submessage, kDataFixed))) lock.lock();
  }
  hand_over(channel, copy, local, remote);
}

/// Changes the parameter lists of the submessage in `datagram`.
/// @return whether the library may have the datagram.
bool Guard::passes(const Submessage& submessage, std::vector<std::uint8_t>& datagram,
                   Receiver& channel, const Locator& remote) {
  const DataSubmessage data = parse_data(submessage, kDataFixed);
  const bool has_list = submessage.has(kThird) && data.is_list();
  if (!keeps_leases_ || !may_announce(submessage, data)) {
    if (has_list && is_discovery(submessage, data)) {
      hide_types(list_in(datagram, submessage, data), data.list_is_little());
    }
    return true;
  }
  const auto announcement = read_announcement(submessage, data);
  if (announcement && role_ == Role::client &&
      announcement->announcer == Announcer::vdrive_visitor) {
    ++ignored_;
    return false;
  }
  const Refusal refusal = announcement
                              ? take_announcement(*announcement, sender_of(datagram), channel)
                              : Refusal::announcement;
  if (refusal != Refusal::none) {
    refuse(refusal, remote);
    return false;
  }
  if (has_list && raises_leases_)
    raise_leases(list_in(datagram, submessage, data), data.list_is_little());
  return true;
}

Refusal Guard::take_announcement(const Announcement& announcement, const GuidPrefix& sender,
                                 Receiver& channel) {
  const std::scoped_lock lock(keeper_mutex_);
  if (announcement.gone) {
    if (announcement.library_knows_key) {
      keeper_.left(announcement.participant);
      returned_.left(announcement.participant);
      closed_.erase(announcement.participant);
    } else {
      keeper_.expire(announcement.participant);
    }
    return Refusal::none;
  }
  if (announcement.participant != sender) return Refusal::announcement;
  const auto now = Clock::now();
  if (!keeper_.announced(sender, patience_with(announcement), &channel, now)) {
    return Refusal::participants;
  }
  if (announcement.is_closed) closed_.insert(sender);
  returned_.announced(sender, now);
  has_returned_ = !returned_.empty();
  return Refusal::none;
}

void Guard::judge() {
  std::unique_lock lock(end_mutex_);
  while (!end_changed_.wait_for(lock, kBetweenJudgements, [this] {
    return ends_;
  })) {
    lock.unlock();
    if (keeps_leases_) {
      remove_silent();
    } else {
      acknowledge_for_silent();
    }
    lock.lock();
  }
}

void Guard::remove_silent() {
  std::vector<Keeper::Silent> silent;
  {
    const std::scoped_lock keeping(keeper_mutex_);
    const auto now = Clock::now();
    silent = keeper_.take_silent(now);
    returned_.forget_old(now);
    for (const Keeper::Silent& each : silent) {
      returned_.removed(each.participant);
      closed_.erase(each.participant);
    }
    has_returned_ = !returned_.empty();
  }
  for (const Keeper::Silent& each : silent) remove(each);
}

void Guard::acknowledge_for_silent() {
  std::vector<SilentReaders<Receiver*>::Acknowledgement> due;
  {
    const std::scoped_lock keeping(keeper_mutex_);
    due = silent_readers_.take_due(Clock::now());
  }
  for (const auto& each : due) {
    const auto receiving = deletions_.receive();
    const std::scoped_lock lock(handing_over_);
    const std::optional<Locator> local = locator_of(each.channel);
    if (!local) continue;
    each.channel->OnDataReceived(each.datagram.data(),
                                 static_cast<std::uint32_t>(each.datagram.size()), *local, *local);
  }
}

/// @return the address on which an open channel receives.
std::optional<Guard::Locator> Guard::locator_of(const Receiver* channel) {
  const std::scoped_lock channels(channels_mutex_);
  const auto found = std::ranges::find_if(channels_, [channel](const auto& each) {
    return each.second == channel;
  });
  return found == channels_.end() ? std::nullopt : std::optional(found->first);
}

/// Passes the library an announcement that the participant has left, as if the participant had sent
/// it, on the channel on which it had announced itself: the only removal that cannot collide with a
/// timer of the library.
void Guard::remove(const Keeper::Silent& silent) {
  const auto receiving = deletions_.receive();  // before the other locks, as in receive()
  const std::scoped_lock lock(announcing_, handing_over_);
  const std::optional<Locator> local = locator_of(silent.channel);
  if (!local) return;
  const auto datagram = end_datagram(silent.participant);
  ++judged_;  // before the library reports the departure to a program that reads the counts
  silent.channel->OnDataReceived(datagram.data(), static_cast<std::uint32_t>(datagram.size()),
                                 *local, *local);
}

}  // namespace vdrive::wire
