// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "others.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/security.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive/wire/topics.hpp"
#include "vdrive/wire/writer_id.hpp"

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {

/// DDS objects of a participant. One publisher, one subscriber, each topic once.
struct Participant::Entities {
  eprosima::fastdds::dds::DomainParticipant* participant = nullptr;
  eprosima::fastdds::dds::Publisher* publisher = nullptr;
  eprosima::fastdds::dds::Subscriber* subscriber = nullptr;
  std::optional<Permissions> permissions;  ///< of a closed participant
  Others others;                           ///< listens to the participant

  /// The library replaces lists of addresses of the participant without a lock when its
  /// announcement changes, and reads them when it makes an endpoint: one of these at a time.
  std::mutex changing;

  /// @return the topic `name`, in full, with the type `type`, made at its first use.
  /// @throws NetworkError
  eprosima::fastdds::dds::Topic* topic(const std::string& name,
                                       const eprosima::fastdds::dds::TypeSupport& type);

 private:
  std::mutex mutex_;
};

/// @return the participant that `handle` belongs to.
[[nodiscard]] Source source_of(const eprosima::fastrtps::rtps::InstanceHandle_t& handle) noexcept;

/// @return the writer that `handle` means.
[[nodiscard]] WriterId writer_of(const eprosima::fastrtps::rtps::InstanceHandle_t& handle) noexcept;

/// Which remote endpoints match, to be waited for. Filled by a listener.
class Matches {
 public:
  /// @param change +1 matched, -1 unmatched
  void update(const eprosima::fastrtps::rtps::InstanceHandle_t& endpoint, int change);

  [[nodiscard]] std::size_t count() const;

  /// @return the participants of the endpoints, in the order of their matches.
  [[nodiscard]] std::vector<Source> sources() const;
  [[nodiscard]] bool wait_for(std::size_t count, std::chrono::milliseconds timeout);
  [[nodiscard]] bool wait_for(const Source& source, std::chrono::milliseconds timeout);

 private:
  [[nodiscard]] bool contains(const Source& source) const;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<eprosima::fastrtps::rtps::InstanceHandle_t> endpoints_;
};

}  // namespace vdrive::wire
