// SPDX-License-Identifier: Apache-2.0
#include "dds/dds_participant.hpp"

#include "dds/entities.hpp"
#include "dds/reader.hpp"
#include "dds/writer.hpp"
#include "guard/guard_transport.hpp"
#include "guard/host_names.hpp"
#include "network_participant.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/address.hpp"
#include "vdrive/wire/local_bus.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/ports.hpp"
#include "vdrive/wire/presence_by_age.hpp"
#include "vdrive/wire/security.hpp"

#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/PublisherQos.hpp>
#include <fastdds/dds/subscriber/qos/SubscriberQos.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>

namespace vdrive::wire {
namespace {

using rtps::IPLocator;

// Send buffers, and receive buffers of participants that receive no status.
constexpr std::uint32_t kSocketBuffer = 4U * 1024U * 1024U;
constexpr std::size_t kMostServers = 256;  // the id has one byte
constexpr std::size_t kMostParticipants = 256;
constexpr std::size_t kEndpointsOfParticipant = 16;        // on average; readers and writers each
constexpr std::uint32_t kLargestAnnouncement = 16 * 1024;  // [bytes]; those of vdrive take 1 kB
// A long lease: in Fast DDS 2.9 and 3.1 the lease timer must not fire while a participant is
// leaving. Programs with a guard remove participants earlier; a discovery server has no guard. In
// the closed mode of 3.1 only the library can remove them (kMembersMayLeaveInClear).
constexpr std::int32_t kAnnouncedLease = 600;          // [s]
constexpr std::int32_t kLeaseOfMember = 2;             // [s]
constexpr std::int32_t kLeaseWithServer = 2;           // [s]
constexpr std::chrono::seconds kTimeToFindAServer{1};  // a running server answers within 0.2 s

/// @return the socket buffer size that the kernel permits, up to `wanted` [bytes].
std::uint32_t permitted_socket_buffer(const char* limit_file, std::uint32_t wanted) {
  std::uint32_t limit = 0;
  std::ifstream file(limit_file);
  return file >> limit ? std::min(limit, wanted) : 0;
}

/// @return the addresses of an interface, or throws: the library silently ignores an address that
///         no interface has.
std::vector<std::string> own_addresses(const std::string& interface) {
  if (!is_interface(interface)) {
    throw NetworkError("network interface " + in_quotes(interface) +
                       " is not an IPv4 address or the name of an interface");
  }
  std::vector<OwnInterface> own = own_interfaces();
  std::vector<std::string> addresses = addresses_of(interface, own);
  if (!addresses.empty()) return addresses;
  std::erase_if(own, [](const OwnInterface& one) {
    return !one.is_up;
  });
  throw NetworkError("network interface " + in_quotes(interface) +
                     ": no active interface has this " +
                     (is_address(interface) ? "address" : "name") + "; available: " + to_text(own));
}

/// @return the addresses of the interfaces in `settings`, and loopback.
std::vector<std::string> addresses_to_use(const NetworkSettings& settings) {
  std::vector<std::string> addresses{kLoopback};
  for (const auto& interface : settings.interfaces) {
    for (const auto& address : own_addresses(interface)) {
      if (std::ranges::count(addresses, address) == 0) addresses.push_back(address);
    }
  }
  return addresses;
}

/// @param addresses of our interfaces, to be used
eprosima::fastdds::rtps::UDPv4TransportDescriptor udp_transport(
    const NetworkSettings& settings, const std::vector<std::string>& addresses) {
  eprosima::fastdds::rtps::UDPv4TransportDescriptor udp;
  udp.interfaceWhiteList = addresses;
  udp.sendBufferSize = permitted_socket_buffer("/proc/sys/net/core/wmem_max", kSocketBuffer);
  udp.receiveBufferSize = permitted_socket_buffer(
      "/proc/sys/net/core/rmem_max",
      settings.role == Role::client ? kReceiveBufferOfClient : kSocketBuffer);
  udp.maxInitialPeersRange = kParticipantsOfPeer;
  return udp;
}

/// Multicast first, then the peers: a list of peers replaces the default of the library.
void add_peers(const NetworkSettings& settings, HostNames& names, dds::DomainParticipantQos& qos) {
  if (settings.peers.empty()) return;
  auto& peers = qos.wire_protocol().builtin.initialPeersList;
  rtps::Locator_t group;
  IPLocator::setIPv4(group, kDiscoveryGroup);
  group.port = 0;
  peers.push_back(group);
  for (const auto& host : settings.peers) {
    if (!is_host(host)) {
      throw NetworkError("network peer " + in_quotes(host) +
                         " is not an IPv4 address or the name of a host");
    }
    rtps::Locator_t peer;
    IPLocator::setIPv4(peer, names.stand_in(host, 0));
    peer.port = 0;
    peers.push_back(peer);
  }
}

/// With servers there is no multicast. A server reports to a client only participants that match
/// the client's endpoints, and no part of vdrive needs more.
void add_discovery_servers(const NetworkSettings& settings, HostNames& names,
                           dds::DomainParticipantQos& qos) {
  if (settings.discovery_servers.empty()) return;
  if (settings.discovery_servers.size() > kMostServers) {
    throw NetworkError(std::to_string(settings.discovery_servers.size()) +
                       " discovery servers are too many: the limit is " +
                       std::to_string(kMostServers));
  }
  if (!settings.peers.empty()) {
    throw NetworkError("peers and discovery servers cannot be used together: name only one kind");
  }
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.discoveryServer_client_syncperiod = {0, 100'000'000};
  for (const auto& text : settings.discovery_servers) {
    const auto server = parse_server_address(text);
    if (!server) {
      throw NetworkError("discovery server " + in_quotes(text) +
                         ": expected HOST:PORT, such as 10.0.0.9:11811");
    }
    rtps::Locator_t locator;
    IPLocator::setIPv4(locator, names.stand_in(server->host, server->port));
    locator.port = server->port;
    add_discovery_server(locator, qos);
  }
}

/// The built-in plugins of DDS Security. The files have already been checked.
void add_security(const std::filesystem::path& directory, dds::DomainParticipantQos& qos) {
  auto& properties = qos.properties().properties();
  const auto name_file = [&](const char* property, std::string_view file) {
    properties.emplace_back(property,
                            "file://" + std::filesystem::absolute(directory / file).string());
  };
  properties.emplace_back("dds.sec.auth.plugin", "builtin.PKI-DH");
  name_file("dds.sec.auth.builtin.PKI-DH.identity_ca", SecurityFile::kIdentityCa);
  name_file("dds.sec.auth.builtin.PKI-DH.identity_certificate", SecurityFile::kCertificate);
  name_file("dds.sec.auth.builtin.PKI-DH.private_key", SecurityFile::kPrivateKey);
  properties.emplace_back("dds.sec.access.plugin", "builtin.Access-Permissions");
  name_file("dds.sec.access.builtin.Access-Permissions.permissions_ca",
            SecurityFile::kPermissionsCa);
  name_file("dds.sec.access.builtin.Access-Permissions.governance", SecurityFile::kGovernance);
  name_file("dds.sec.access.builtin.Access-Permissions.permissions", SecurityFile::kPermissions);
  properties.emplace_back("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
}

/// Limits what is accepted: anybody who can send to the discovery port can announce any number of
/// participants and endpoints, and samples of any size.
void limit_discovery(dds::DomainParticipantQos& qos) {
  auto& allocation = qos.allocation();
  allocation.participants.maximum = kMostParticipants;
  allocation.readers.maximum = kEndpointsOfParticipant;
  allocation.writers.maximum = kEndpointsOfParticipant;
  limit_announcements(qos, kLargestAnnouncement);
}

/// @return the lease that the participant announces [s].
std::int32_t announced_lease(const NetworkSettings& settings) {
  if (!settings.discovery_servers.empty()) return kLeaseWithServer;
  const bool is_judged_by_guard = settings.security.empty() || kMembersMayLeaveInClear;
  return is_judged_by_guard ? kAnnouncedLease : kLeaseOfMember;
}

/// The guard, if there is one, is placed in front of each transport.
template <typename Descriptor>
void add_transport(const Descriptor& transport, const std::shared_ptr<Guard>& guard,
                   const std::shared_ptr<const HostNames>& names, dds::DomainParticipantQos& qos) {
  if (guard == nullptr) {
    qos.transport().user_transports.push_back(std::make_shared<Descriptor>(transport));
  } else {
    qos.transport().user_transports.push_back(
        std::make_shared<Guarded<Descriptor>>(transport, guard, names));
  }
}

dds::DomainParticipantQos participant_qos(const NetworkSettings& settings, const std::string& name,
                                          const std::shared_ptr<Guard>& guard,
                                          const std::vector<std::string>& addresses,
                                          const std::shared_ptr<HostNames>& names) {
  dds::DomainParticipantQos qos;
  add_peers(settings, *names, qos);
  add_discovery_servers(settings, *names, qos);
  if (names->has_names() && guard == nullptr) {
    throw NetworkError("host names can be used only with the guard (NetworkSettings::guard)");
  }
  // After losing a server, the library sends to an address of that server without having announced
  // the address to its transport; see HostNames.
  const bool is_redirected = names->has_names() || !settings.discovery_servers.empty();
  const auto redirecting = is_redirected ? names : nullptr;
  qos.name(name.c_str());
  qos.user_data().setValue(std::vector<rtps::octet>(settings.place.begin(), settings.place.end()));
  qos.transport().use_builtin_transports = false;
  add_transport(udp_transport(settings, addresses), guard, redirecting, qos);
  if (settings.shared_memory) {
    add_transport(eprosima::fastdds::rtps::SharedMemTransportDescriptor(), guard, nullptr, qos);
  }
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.leaseDuration = {announced_lease(settings), 0};
  discovery.leaseDuration_announcementperiod = {0, 100'000'000};
  discovery.initial_announcements.count = 10;
  discovery.initial_announcements.period = {0, 50'000'000};
  announce_no_types(qos);
  limit_discovery(qos);
  if (!settings.security.empty()) add_security(settings.security, qos);
  return qos;
}

/// Fast DDS 2.9 reads its profiles without a lock while it creates the first participant; 3.1 has a
/// lock.
dds::DomainParticipant* make_participant(const dds::DomainParticipantQos& qos, std::uint32_t domain,
                                         KnownParticipants& others) {
  static std::mutex making;
  const std::scoped_lock lock(making);
  return dds::DomainParticipantFactory::get_instance()->create_participant(domain, qos, &others,
                                                                           dds::StatusMask::none());
}

/// A participant of a DDS domain.
class DdsParticipant final : public Participant {
 public:
  DdsParticipant(const NetworkSettings& settings, const std::string& name);
  ~DdsParticipant() override;
  DdsParticipant(const DdsParticipant&) = delete;
  DdsParticipant& operator=(const DdsParticipant&) = delete;

  std::unique_ptr<SampleWriter> make_writer(TopicId topic,
                                            SampleWriter::Observer observer) override;
  std::unique_ptr<SampleReader> make_reader(TopicId topic, SampleHandler handler) override;

  [[nodiscard]] std::string place() const override {
    // Members of a closed network cannot find members with another version: docs/SECURITY.md.
    return "on domain " + std::to_string(domain_) +
           (is_closed_ ? std::string(", closed, by Fast DDS ") + kLibraryVersion : "");
  }

  [[nodiscard]] std::uint32_t domain() const noexcept override { return domain_; }

  [[nodiscard]] bool is_closed() const noexcept override { return is_closed_; }

  [[nodiscard]] Source source() const noexcept override;
  void announce_again() override;

  [[nodiscard]] Presence& presence() noexcept override { return presence_; }

  [[nodiscard]] std::vector<std::string> troubles() const override;

  [[nodiscard]] GuardCounts guard_counts() const override;

  [[nodiscard]] DdsEntities& entities() noexcept { return entities_; }

 private:
  std::uint32_t domain_;
  bool is_closed_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::vector<std::string> servers_;  ///< discovery servers
  std::shared_ptr<Guard> guard_;      ///< null without a guard
  std::shared_ptr<HostNames> names_ = std::make_shared<HostNames>();
  DdsEntities entities_;
  PresenceByAge presence_{[this](std::string_view beginning) {
    return entities_.others.named(beginning);
  }};
};

}  // namespace

std::unique_ptr<Participant> make_dds_participant(const NetworkSettings& settings,
                                                  const std::string& name) {
  return std::make_unique<DdsParticipant>(settings, name);
}

DdsEntities& dds_entities(Participant& participant) {
  auto* const over_dds = dynamic_cast<DdsParticipant*>(&participant);
  if (over_dds == nullptr) throw NetworkError("a participant on a local bus has no DDS topics");
  return over_dds->entities();
}

namespace {

DdsParticipant::DdsParticipant(const NetworkSettings& settings, const std::string& name)
    : domain_(settings.domain),
      is_closed_(!settings.security.empty()),
      servers_(settings.discovery_servers),
      guard_(settings.guard ? std::make_shared<Guard>(settings) : nullptr) {
  if (settings.domain > kHighestDomain) {
    throw NetworkError("DDS domain " + std::to_string(settings.domain) +
                       " is above the highest domain " + std::to_string(kHighestDomain));
  }
  if (!settings.security.empty()) {
    if (!settings.discovery_servers.empty()) {
      throw NetworkError(
          "network security: cannot be combined with a discovery server; name peers instead");
    }
    entities_.permissions = check_security(settings.security, settings.domain);
  }
  if (guard_ != nullptr) entities_.others.tell(*guard_);
  // A service and its clients may be in the same process: with delivery in the writing thread, a
  // handler of one would run inside a write of another.
  deliver_through_the_transport();
  const std::vector<std::string> addresses = addresses_to_use(settings);
  const dds::DomainParticipantQos qos = participant_qos(settings, name, guard_, addresses, names_);
  names_->start(addresses);
  entities_.participant = make_participant(qos, settings.domain, entities_.others);
  if (entities_.participant == nullptr) {
    throw NetworkError(
        "DDS could not create a participant in domain " + std::to_string(settings.domain) +
        (settings.security.empty()
             ? ": check that the network interface is up and that the UDP ports are free"
             : ": check that the security material in " + settings.security + " is complete"));
  }
  if (guard_ != nullptr) {
    entities_.deletions = &guard_->deletions();
    guard_->begin();
  }
  entities_.publisher = entities_.participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  entities_.subscriber = entities_.participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  if (entities_.publisher == nullptr || entities_.subscriber == nullptr) {
    entities_.participant->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(entities_.participant);
    throw NetworkError("DDS could not create a publisher or subscriber");
  }
}

DdsParticipant::~DdsParticipant() {
  entities_.participant->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(entities_.participant);
}

std::unique_ptr<SampleWriter> DdsParticipant::make_writer(TopicId topic,
                                                          SampleWriter::Observer observer) {
  return std::make_unique<DdsWriter>(entities_, topic, std::move(observer));
}

std::unique_ptr<SampleReader> DdsParticipant::make_reader(TopicId topic, SampleHandler handler) {
  return std::make_unique<DdsReader>(entities_, topic, std::move(handler));
}

void DdsParticipant::announce_again() {
  const std::scoped_lock lock(entities_.changing);
  dds::DomainParticipantQos qos;
  entities_.participant->get_qos(qos);
  std::vector<rtps::octet> data = qos.user_data().getValue();
  data.resize(1);
  ++data.front();
  qos.user_data().setValue(data);
  entities_.participant->set_qos(qos);
}

Source DdsParticipant::source() const noexcept {
  return source_of(rtps::InstanceHandle_t(entities_.participant->guid()));
}

std::vector<std::string> DdsParticipant::troubles() const {
  std::vector<std::string> troubles = names_->troubles();
  const bool had_time = std::chrono::steady_clock::now() - began_ >= kTimeToFindAServer;
  if (!servers_.empty() && had_time && !entities_.others.has_server()) {
    troubles.push_back("no discovery server answers: " + joined(servers_) +
                       "; until one does, no participant can be found");
  }
  return troubles;
}

GuardCounts DdsParticipant::guard_counts() const {
  return guard_ == nullptr ? GuardCounts{} : guard_->counts();
}

}  // namespace
}  // namespace vdrive::wire

// CMakeLists.txt of idl/ makes the linker pull this function, and with it the participant, into
// every program that links vdrive::dds.
extern "C" [[gnu::constructor(vdrive::wire::kBeforeConstructors)]] void
vdrive_dds_participant() noexcept {
  vdrive::wire::provide_network_participant(&vdrive::wire::make_dds_participant);
}
