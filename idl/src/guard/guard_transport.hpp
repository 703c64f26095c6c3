// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "guard.hpp"

#include <memory>
#include <utility>

namespace vdrive::wire {

/// Describes a transport that a guard stands before.
struct GuardedTransport final : eprosima::fastdds::rtps::ChainingTransportDescriptor {
  GuardedTransport(std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> low,
                   std::shared_ptr<Guard> its_guard)
      : ChainingTransportDescriptor(std::move(low)), guard(std::move(its_guard)) {}

  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override;

  std::shared_ptr<Guard> guard;
};

/// A transport of the library with a guard between it and whoever receives.
class GuardTransport final : public SeeingTransport {
 public:
  using Locator = Guard::Locator;

  explicit GuardTransport(const GuardedTransport& description);

  eprosima::fastdds::rtps::TransportDescriptorInterface* get_configuration() override {
    return low_level_transport_->get_configuration();
  }

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

  std::shared_ptr<Guard> guard_;
};

/// `Descriptor` with a guard before the transport that it makes. Fast DDS 2.9 and 3.1 ask whether a
/// description is one of shared memory, which a GuardedTransport is not.
template <typename Descriptor>
class Guarded final : public Descriptor {
 public:
  Guarded(const Descriptor& low, std::shared_ptr<Guard> guard)
      : Descriptor(low), guard_(std::move(guard)) {}

  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override {
    return GuardedTransport(std::make_shared<Descriptor>(*this), guard_).create_transport();
  }

 private:
  std::shared_ptr<Guard> guard_;
};

}  // namespace vdrive::wire
