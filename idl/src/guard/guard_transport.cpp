// SPDX-License-Identifier: Apache-2.0
#include "guard_transport.hpp"

#include <fastdds/rtps/network/SenderResource.h>

#include <vector>

namespace vdrive::wire {

namespace rtps = eprosima::fastrtps::rtps;

eprosima::fastdds::rtps::TransportInterface* GuardedTransport::create_transport() const {
  return new GuardTransport(*this);  // NOLINT(cppcoreguidelines-owning-memory): the library's rule
}

GuardTransport::GuardTransport(const GuardedTransport& description)
    : ChainingTransport(description), guard_(description.guard) {}

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

bool GuardTransport::send(rtps::SenderResource* low, const std::uint8_t* bytes, std::uint32_t size,
                          rtps::LocatorsIterator* first, rtps::LocatorsIterator* last,
                          const std::chrono::steady_clock::time_point& timeout) {
  std::vector<std::uint8_t> renumbered;
  const ByteView leaving = guard_->sends({bytes, size}, renumbered);
  return low->send(leaving.data(), size, first, last, timeout);
}

void GuardTransport::receive(eprosima::fastdds::rtps::TransportReceiverInterface* receiver,
                             const std::uint8_t* bytes, std::uint32_t size, const Locator& local,
                             const Locator& remote) {
  guard_->receive(*receiver, {bytes, size}, local, remote);
}

}  // namespace vdrive::wire
