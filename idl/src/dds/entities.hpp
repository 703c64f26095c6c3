// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dds/known_participants.hpp"
#include "guard/deletion_gate.hpp"
#include "vdrive/wire/matches.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/security.hpp"
#include "vdrive/wire/source.hpp"

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>

namespace vdrive::wire {

/// The DDS objects of a participant: one publisher, one subscriber, each topic once.
struct DdsEntities {
  dds::DomainParticipant* participant = nullptr;
  dds::Publisher* publisher = nullptr;
  dds::Subscriber* subscriber = nullptr;
  std::optional<Permissions> permissions;  ///< of a closed participant
  KnownParticipants others;                ///< listens to the participant

  /// Serialises changes to the announcement and the creation of endpoints. Fast DDS 2.9 and 3.1
  /// replace address lists of the participant when its announcement changes (2.9 without a lock),
  /// and read them without a lock when they create an endpoint.
  std::mutex changing;

  DeletionGate* deletions = nullptr;  ///< of the guard; null without one

  /// @return a lock to hold while deleting a reader or a writer.
  [[nodiscard]] std::unique_lock<std::shared_mutex> erase() const {
    return deletions == nullptr ? std::unique_lock<std::shared_mutex>() : deletions->erase();
  }

  /// @return the topic with the full name `name` and the type `type`, created on first use.
  /// @throws NetworkError
  dds::Topic* topic(const std::string& name, const dds::TypeSupport& type);

 private:
  std::mutex mutex_;
};

/// @return the participant that `handle` belongs to.
[[nodiscard]] Source source_of(const rtps::InstanceHandle_t& handle) noexcept;

/// @return the writer or reader that `handle` identifies.
[[nodiscard]] EndpointId endpoint_of(const rtps::InstanceHandle_t& handle) noexcept;

/// @return the DDS objects of a participant.
/// @throws NetworkError when it is on a local bus
[[nodiscard]] DdsEntities& dds_entities(Participant& participant);

}  // namespace vdrive::wire
