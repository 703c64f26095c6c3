// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "guard.hpp"
#include "host_names.hpp"

#include <atomic>
#include <memory>
#include <set>
#include <shared_mutex>
#include <utility>

namespace vdrive::wire {

/// Describes a transport with a guard in front of it.
struct GuardedTransport final : eprosima::fastdds::rtps::ChainingTransportDescriptor {
  GuardedTransport(std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> low,
                   std::shared_ptr<Guard> its_guard, std::shared_ptr<const HostNames> its_names)
      : ChainingTransportDescriptor(std::move(low)),
        guard(std::move(its_guard)),
        names(std::move(its_names)) {}

  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override;

  std::shared_ptr<Guard> guard;
  std::shared_ptr<const HostNames>
      names;  ///< null: the library sends only to addresses that it has announced
};

/// A transport of the library with a guard between it and its receiver.
class GuardTransport final : public ObservingTransport {
 public:
  using Locator = Guard::Locator;

  explicit GuardTransport(const GuardedTransport& description);

  eprosima::fastdds::rtps::TransportDescriptorInterface* get_configuration() override {
    return low_level_transport_->get_configuration();
  }

  bool OpenOutputChannel(eprosima::fastdds::rtps::SendResourceList& sockets,
                         const Locator& to) override;
  bool OpenInputChannel(const Locator& local,
                        eprosima::fastdds::rtps::TransportReceiverInterface* receiver,
                        std::uint32_t most) override;
  bool CloseInputChannel(const Locator& local) override;
  void receive(eprosima::fastdds::rtps::TransportReceiverInterface* receiver,
               const std::uint8_t* bytes, std::uint32_t size, const Locator& local,
               const Locator& remote) override;

  void shutdown() override { low_level_transport_->shutdown(); }

 private:
  ByteView sends(ByteView datagram, std::vector<std::uint8_t>& changed) override {
    return guard_->sends(datagram, changed);
  }

  bool sends_directly(const rtps::SenderResource& low, ByteView datagram,
                      rtps::LocatorsIterator& first, const rtps::LocatorsIterator& last,
                      std::vector<Locator>& rest) override;

  [[nodiscard]] bool is_announced(const Locator& to);

  std::shared_ptr<Guard> guard_;
  std::shared_ptr<const HostNames> names_;
  std::shared_mutex announced_mutex_;
  std::set<Locator> announced_;  ///< destinations announced by the library to its transport
  /// The first socket of the library that sends. The library calls sends_directly() for each
  /// socket, and the datagram must leave only once.
  std::atomic<const rtps::SenderResource*> chosen_{nullptr};
};

/// `Descriptor` with a guard in front of the transport that it creates. Derived from `Descriptor`
/// because Fast DDS 2.9 and 3.1 check by the type of a descriptor whether it is one of shared
/// memory, and a GuardedTransport is not.
template <typename Descriptor>
class Guarded final : public Descriptor {
 public:
  Guarded(const Descriptor& low, std::shared_ptr<Guard> guard,
          std::shared_ptr<const HostNames> names)
      : Descriptor(low), guard_(std::move(guard)), names_(std::move(names)) {}

  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override {
    return GuardedTransport(std::make_shared<Descriptor>(*this), guard_, names_).create_transport();
  }

 private:
  std::shared_ptr<Guard> guard_;
  std::shared_ptr<const HostNames> names_;
};

}  // namespace vdrive::wire
