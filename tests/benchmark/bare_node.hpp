// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dds/library/library.hpp"
#include "support/signals.hpp"

#include <fastdds/dds/core/condition/StatusCondition.hpp>
#include <fastdds/dds/core/condition/WaitSet.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <functional>
#include <iostream>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

/// The DDS library without vdrive, with the QoS of vdrive's topics: a reference for the figures of
/// the wire.
namespace vdrive::bare {

namespace dds = wire::dds;
namespace rtps = wire::rtps;

/// The size of a status frame on the wire [bytes], and its number of axes.
inline constexpr std::size_t kAxesPerFrame = 256;
inline constexpr std::size_t kFrameHead = 40;
inline constexpr std::size_t kAxis = 112;

using Bytes = std::vector<std::uint8_t>;

/// A type of bytes that are copied onto the wire and from it.
class BytesType final : public wire::LibraryType {
 public:
  BytesType() : LibraryType("Bytes", 2 * (kFrameHead + kAxesPerFrame * kAxis), false) {}

 private:
  [[nodiscard]] std::span<const std::byte> bytes_of(const void* data) const noexcept override {
    return std::as_bytes(std::span(*static_cast<const Bytes*>(data)));
  }

  bool encode(const void* data, rtps::SerializedPayload_t& payload) override {
    const Bytes& bytes = *static_cast<const Bytes*>(data);
    std::memcpy(payload.data, bytes.data(), bytes.size());
    payload.length = static_cast<std::uint32_t>(bytes.size());
    payload.encapsulation = CDR_LE;
    return true;
  }

  bool decode(const rtps::SerializedPayload_t& payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload.data, payload.data + payload.length);
    return true;
  }

  bool put_key(std::span<const std::byte> /*sample*/, rtps::InstanceHandle_t& /*handle*/,
               bool /*force_md5*/) override {
    return false;
  }

  void* make() override { return new Bytes(); }

  void drop(void* data) override { delete static_cast<Bytes*>(data); }
};

/// A participant with UDP on loopback.
class Node {
 public:
  explicit Node(std::uint32_t domain) : type_(new BytesType()) {
    constexpr std::uint32_t kSocketBuffer = 4U * 1024U * 1024U;
    wire::deliver_through_the_transport();
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList = {"127.0.0.1"};
    udp->sendBufferSize = kSocketBuffer;
    udp->receiveBufferSize = kSocketBuffer;
    dds::DomainParticipantQos qos;
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(domain, qos);
    require(participant_, "participant");
    participant_->register_type(type_);
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }

  ~Node() {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  dds::DataWriter& writer(const std::string& topic, bool reliable) {
    dds::DataWriterQos qos;
    apply(reliable, qos);
    qos.publish_mode().kind = dds::SYNCHRONOUS_PUBLISH_MODE;
    qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
    wire::set_times(qos, {.first_heartbeat = {0, 5'000'000},
                          .heartbeat_period = {0, 10'000'000},
                          .nack_response = {0, 1'000'000}});
    auto* const writer = publisher_->create_datawriter(topic_named(topic), qos);
    require(writer, "writer");
    return *writer;
  }

  /// @param listener outlives this
  void read(const std::string& topic, bool reliable, dds::DataReaderListener& listener) {
    dds::DataReaderQos qos;
    apply(reliable, qos);
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_MEMORY_MODE;
    wire::set_times(qos, {.first_acknack = {0, 5'000'000}, .heartbeat_response = {0, 1'000'000}});
    require(subscriber_->create_datareader(topic_named(topic), qos, &listener), "reader");
  }

 private:
  template <typename Qos>
  static void apply(bool reliable, Qos& qos) {
    constexpr std::int32_t kStatusDepth = 64;
    constexpr std::int32_t kQueueDepth = 1'024;
    const std::int32_t depth = reliable ? kQueueDepth : kStatusDepth;
    qos.reliability().kind =
        reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = reliable ? dds::KEEP_ALL_HISTORY_QOS : dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = depth;
    qos.resource_limits().max_instances = 1;
    qos.resource_limits().max_samples_per_instance = depth;
    qos.resource_limits().max_samples = depth;
    qos.resource_limits().allocated_samples = 8;
    qos.data_sharing().off();
  }

  dds::Topic* topic_named(const std::string& name) {
    return participant_->create_topic(name, type_.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  }

  static void require(const void* entity, const char* what) {
    if (entity != nullptr) return;
    std::cerr << "the library refuses a " << what << '\n';
    std::_Exit(1);
  }

  dds::TypeSupport type_;
  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
};

/// Calls `take` with each sample.
class Listener final : public dds::DataReaderListener {
 public:
  explicit Listener(std::function<void(const Bytes&)> take) : take_(std::move(take)) {}

  void on_data_available(dds::DataReader* reader) override {
    dds::SampleInfo info;
    while (wire::is_ok(reader->take_next_sample(&bytes_, &info))) {
      if (info.valid_data) take_(bytes_);
    }
  }

 private:
  std::function<void(const Bytes&)> take_;
  Bytes bytes_;
};

/// Checks every 10 ms. @return whether the condition became true within `patience`.
template <typename Condition>
[[nodiscard]] bool wait_until(const Condition& condition, std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

inline bool wait_for_reader(dds::DataWriter& writer) {
  dds::StatusCondition& matched = writer.get_statuscondition();
  matched.set_enabled_statuses(dds::StatusMask::publication_matched());
  dds::WaitSet wait_set;
  wait_set.attach_condition(matched);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (std::chrono::steady_clock::now() < deadline) {
    dds::PublicationMatchedStatus status;
    writer.get_publication_matched_status(status);
    if (status.current_count > 0) return true;
    dds::ConditionSeq active;
    wait_set.wait(active, {1, 0});
  }
  std::cerr << "no reader\n";
  return false;
}

/// A second process that runs a function; the destructor ends it.
class Partner {
 public:
  explicit Partner(const std::function<void()>& run) : process_(fork()) {
    if (process_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    run();
    std::_Exit(0);
  }

  ~Partner() {
    if (process_ < 0) return;
    test::send_signal(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }

  Partner(const Partner&) = delete;
  Partner& operator=(const Partner&) = delete;

  [[nodiscard]] pid_t process() const noexcept { return process_; }

 private:
  pid_t process_;
};

/// @return a value that this process shares with the partners that it starts later, until they end.
/// @throws std::runtime_error without memory
template <typename Value>
Value& shared_with_partners() {
  void* const memory =
      mmap(nullptr, sizeof(Value), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no memory");
  return *new (memory) Value{};
}

/// Prints a figure as a line of JSON.
inline void print_figure(const std::string& figure, double value, std::size_t axes = 0) {
  std::cout << R"({"figure":")" << figure << '"';
  if (axes != 0) std::cout << R"(,"axes":)" << axes;
  std::cout << R"(,"value":)" << value << "}\n" << std::flush;
}

/// @return the quantile of `sorted` at `share`.
inline double quantile(const std::vector<double>& sorted, double share) {
  const auto place = static_cast<std::size_t>(share * static_cast<double>(sorted.size()));
  return sorted[std::min(place, sorted.size() - 1)];
}

}  // namespace vdrive::bare
