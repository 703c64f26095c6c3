// SPDX-License-Identifier: Apache-2.0
#include "guard_transport.hpp"

#include "receive_coalescing.hpp"

#include <thread>

namespace vdrive::wire {

eprosima::fastdds::rtps::TransportInterface* GuardedTransport::create_transport() const {
  return new GuardTransport(*this);  // NOLINT(cppcoreguidelines-owning-memory): the library's rule
}

GuardTransport::GuardTransport(const GuardedTransport& description)
    : ObservingTransport(description), guard_(description.guard), names_(description.names) {}

bool GuardTransport::OpenOutputChannel(eprosima::fastdds::rtps::SendResourceList& sockets,
                                       const Locator& to) {
  {
    const std::scoped_lock lock(announced_mutex_);
    announced_.insert(to);
  }
  return ChainingTransport::OpenOutputChannel(sockets, to);
}

/// Addresses other than UDP count as announced: the transport of the library handles them.
bool GuardTransport::is_announced(const Locator& to) {
  if (to.kind != LOCATOR_KIND_UDPv4) return true;
  const std::shared_lock lock(announced_mutex_);
  return announced_.contains(to);
}

bool GuardTransport::OpenInputChannel(const Locator& local,
                                      eprosima::fastdds::rtps::TransportReceiverInterface* receiver,
                                      std::uint32_t most) {
  guard_->open(local, receiver);
  return ChainingTransport::OpenInputChannel(local, receiver, most);
}

bool GuardTransport::CloseInputChannel(const Locator& local) {
  guard_->close(local);
  return ChainingTransport::CloseInputChannel(local);
}

void GuardTransport::receive(eprosima::fastdds::rtps::TransportReceiverInterface* receiver,
                             const std::uint8_t* bytes, std::uint32_t size, const Locator& local,
                             const Locator& remote) {
  // Each channel has a thread of the library, which holds no lock here.
  thread_local ReceiveCoalescing coalescing(guard_->receive_coalescing());
  const auto pause = coalescing.pause_after(size, ReceiveCoalescing::Clock::now());
  guard_->receive(*receiver, {bytes, size}, local, remote);
  if (pause.count() > 0) std::this_thread::sleep_for(pause);
  coalescing.resumed(ReceiveCoalescing::Clock::now());
}

bool GuardTransport::sends_directly(const rtps::SenderResource& low, ByteView datagram,
                                    rtps::LocatorsIterator& first,
                                    const rtps::LocatorsIterator& last,
                                    std::vector<Locator>& rest) {
  if (names_ == nullptr) return false;
  const rtps::SenderResource* chosen = nullptr;
  const bool is_chosen = chosen_.compare_exchange_strong(chosen, &low) || chosen == &low;
  for (; first != last; ++first) {
    const auto destinations = names_->destinations(*first);
    if (!destinations && is_announced(*first)) {
      rest.push_back(*first);
    } else if (is_chosen) {
      for (const Locator& one : destinations.value_or(std::vector{*first})) {
        names_->send(datagram, one);
      }
    }
  }
  return true;
}

}  // namespace vdrive::wire
