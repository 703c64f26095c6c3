// SPDX-License-Identifier: Apache-2.0
// A reliable writer made of datagrams, which may begin with any sequence number.
#pragma once

#include "attacker.hpp"
#include "datagrams.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/topics.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace vdrive::test {

/// A participant in the test's domain with one writer of requests. It reads nothing, so a reader
/// that misses a datagram gets only the next ones.
class RawWriter {
 public:
  static constexpr std::uint32_t kEntity = 0x00000103;  // a writer of a topic without keys

  explicit RawWriter(const GuidPrefix& prefix) : prefix_(prefix) {}

  /// Announces the participant and its writer.
  void announce() const {
    Body participant;
    participant.raw(without_sentinel(announcement(prefix_, "raw writer", 600)))
        .parameter(0x32, locator())
        .parameter(0x31, locator())
        .parameter(0x58, Body().u32(0b101).bytes())  // it announces itself and its writers
        .u32(1);
    network_.send_to_discovery(DatagramWriter(prefix_).add(0x15, 5, participant.bytes()).bytes());
    Body guid;
    guid.raw({prefix_.begin(), prefix_.end()}).entity(kEntity);
    const wire::TopicTraits& topic = wire::traits_of(wire::Topic<msg::Request>::kId);
    Body writer = data_to(kPublicationsReader, kPublicationsWriter, 1);
    writer.raw({0, 3, 0, 0})
        .parameter(0x5A, guid.bytes())
        .parameter(0x05, text(std::string(wire::kTopicPrefix) + std::string(topic.name)))
        .parameter(0x07, text(topic.type_name))
        .parameter(0x1A, Body().u32(2).u32(0).u32(0).bytes())  // reliable
        .parameter(0x2F, locator())
        .u32(1);
    network_.send_to_discovery(DatagramWriter(prefix_)
                                   .add(0x15, 5, writer.bytes())
                                   .add(0x07, 3, heartbeat(0, kPublicationsWriter, 1, 1, 1).bytes())
                                   .bytes());
  }

  /// Sends a request, after a heartbeat of a history that holds only this request.
  void send(std::int64_t number, std::uint64_t request_id) {
    msg::Request request;
    request.request_id = request_id;
    Datagram sample(wire::encoded_size(request));
    wire::encode(request, std::as_writable_bytes(std::span(sample)));
    send_to_data(DatagramWriter(prefix_)
                     .add(0x07, 3, heartbeat(0, kEntity, number, number, ++count_).bytes())
                     .add(0x15, 5, data_to(0, kEntity, number).raw(sample).bytes())
                     .bytes());
  }

  /// Sends the heartbeat of a history that holds one sample.
  void send_heartbeat(std::int64_t number, std::uint32_t count) const {
    send_to_data(DatagramWriter(prefix_)
                     .add(0x07, 3, heartbeat(0, kEntity, number, number, count).bytes())
                     .bytes());
  }

 private:
  static Datagram text(std::string_view words) {
    return Body()
        .u32(static_cast<std::uint32_t>(words.size() + 1))
        .raw({words.begin(), words.end()})
        .raw({0})
        .bytes();
  }

  /// 127.0.0.1, port 9, where nobody listens.
  static Datagram locator() {
    return Body().u32(1).u32(9).raw(Datagram(12)).raw({127, 0, 0, 1}).bytes();
  }

  static Datagram without_sentinel(const Body& list) {
    Datagram bytes = list.bytes();
    bytes.resize(bytes.size() - 4);
    return bytes;
  }

  void send_to_data(const Datagram& datagram) const {
    for (std::uint32_t participant = 0; participant < 4; ++participant) {
      network_.send(datagram, 11 + 2 * participant);
    }
  }

  GuidPrefix prefix_;
  Attacker network_;
  std::uint32_t count_ = 0;  ///< of the heartbeats
};

}  // namespace vdrive::test
