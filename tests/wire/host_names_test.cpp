// SPDX-License-Identifier: Apache-2.0
#include "guard/host_names.hpp"

#include "vdrive/wire/address.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

namespace vdrive::wire {
namespace {

using rtps::IPLocator;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

rtps::Locator_t locator(const std::string& address, std::uint32_t port) {
  rtps::Locator_t made;
  IPLocator::setIPv4(made, address);
  made.port = port;
  return made;
}

/// Names that resolve to the addresses in `zone`.
struct Zone {
  std::map<std::string, HostNames::Addresses> zone;
  HostNames names{[this](const std::string& name) {
    const auto found = zone.find(name);
    return found == zone.end() ? HostNames::Answer{.addresses = {}, .problem = "nobody knows it"}
                               : HostNames::Answer{.addresses = found->second, .problem = {}};
  }};

  /// @return the destinations of a datagram, such as "10.0.0.1:7410".
  [[nodiscard]] std::vector<std::string> leads(const std::string& address,
                                               std::uint32_t port) const {
    std::vector<std::string> texts;
    const rtps::Locator_t wanted = locator(address, port);
    for (const rtps::Locator_t& one : names.destinations(wanted).value_or(std::vector{wanted})) {
      texts.push_back(IPLocator::toIPv4string(one) + ":" + std::to_string(one.port));
    }
    return texts;
  }
};

TEST(HostNames, LeaveAddressesAsTheyAre) {
  Zone hosts;
  EXPECT_EQ(hosts.names.stand_in("10.0.0.9", 11811), "10.0.0.9");
  EXPECT_FALSE(hosts.names.has_names());
  EXPECT_THAT(hosts.leads("10.0.0.9", 11811), ElementsAre("10.0.0.9:11811"));
}

TEST(HostNames, LeadNowhereUntilTheNameResolves) {
  Zone hosts;
  const std::string stand_in = hosts.names.stand_in("bench-0", 0);
  hosts.names.look_up();
  EXPECT_THAT(hosts.leads(stand_in, 7410), IsEmpty());
  EXPECT_THAT(hosts.names.troubles(),
              ElementsAre("the host name 'bench-0' does not resolve: nobody knows it"));
  hosts.zone["bench-0"] = {"10.0.0.7"};
  hosts.names.look_up();
  EXPECT_THAT(hosts.leads(stand_in, 7410), ElementsAre("10.0.0.7:7410"));
  EXPECT_THAT(hosts.names.troubles(), IsEmpty());
}

TEST(HostNames, LeadToEveryAddressOfANameAtThePortAskedFor) {
  Zone hosts;
  hosts.zone["benches"] = {"10.0.0.7", "10.0.0.8"};
  const std::string stand_in = hosts.names.stand_in("benches", 0);
  hosts.names.look_up();
  EXPECT_THAT(hosts.leads(stand_in, 7412), ElementsAre("10.0.0.7:7412", "10.0.0.8:7412"));
}

TEST(HostNames, KeepTheLastAddressWhileTheNameDoesNotResolve) {
  Zone hosts;
  hosts.zone["bench-0"] = {"10.0.0.7"};
  const std::string stand_in = hosts.names.stand_in("bench-0", 0);
  hosts.names.look_up();
  hosts.zone.clear();
  hosts.names.look_up();
  EXPECT_THAT(hosts.leads(stand_in, 7410), ElementsAre("10.0.0.7:7410"));
  EXPECT_THAT(hosts.names.troubles(), ElementsAre(HasSubstr("its last address is used: 10.0.0.7")));
}

TEST(HostNames, LeadFromTheFormerAddressOfAServerToThePresentOne) {
  Zone hosts;
  hosts.zone["discovery"] = {"10.0.0.7"};
  const std::string stand_in = hosts.names.stand_in("discovery", 11811);
  hosts.names.look_up();
  hosts.zone["discovery"] = {"10.0.0.8"};
  hosts.names.look_up();
  EXPECT_THAT(hosts.leads(stand_in, 11811), ElementsAre("10.0.0.8:11811"));
  EXPECT_THAT(hosts.leads("10.0.0.7", 11811), ElementsAre("10.0.0.8:11811"));
  // Another program may now have that address.
  EXPECT_THAT(hosts.leads("10.0.0.7", 7410), ElementsAre("10.0.0.7:7410"));
  hosts.zone["discovery"] = {"10.0.0.7"};
  hosts.names.look_up();
  EXPECT_THAT(hosts.leads("10.0.0.7", 11811), ElementsAre("10.0.0.7:11811"));
}

TEST(HostNames, LeaveTheAddressOfAnotherServerAsItIs) {
  Zone hosts;
  hosts.zone = {{"first", {"10.0.0.7"}}, {"second", {"10.0.0.8"}}};
  (void)hosts.names.stand_in("first", 11811);
  (void)hosts.names.stand_in("second", 11811);
  hosts.names.look_up();
  hosts.zone = {{"first", {"10.0.0.9"}}, {"second", {"10.0.0.7"}}};
  hosts.names.look_up();
  EXPECT_THAT(hosts.leads("10.0.0.7", 11811), ElementsAre("10.0.0.7:11811"));
}

TEST(HostNames, OfHostsAreReadAsThatFileIsWritten) {
  const std::string hosts =
      "127.0.0.1 localhost\n"
      "# 10.0.0.1 bench-0\n"
      "10.0.0.7\tbench-0.lab bench-0 # the first\n"
      "::1 bench-0\n"
      "10.0.0.8 bench-0";
  EXPECT_THAT(HostNames::addresses_in(hosts, "bench-0"), ElementsAre("10.0.0.7", "10.0.0.8"));
  EXPECT_THAT(HostNames::addresses_in(hosts, "bench"), IsEmpty());
  EXPECT_THAT(HostNames::addresses_in(hosts, "first"), IsEmpty());
}

TEST(HostNames, OfTheSystemHaveAddressesOrAReason) {
  // RFC 6761: localhost is a loopback address, and names under "invalid." do not exist.
  EXPECT_THAT(HostNames::system_answer("localhost").addresses, testing::Contains("127.0.0.1"));
  const HostNames::Answer none = HostNames::system_answer("nobody.invalid");
  EXPECT_THAT(none.addresses, IsEmpty());
  EXPECT_FALSE(none.problem.empty());
}

TEST(Addresses, TellHostsFromOtherWords) {
  for (const char* const host : {"10.0.0.1", "bench-0", "a.b.lab", "a_b", "lab.", "3com"}) {
    EXPECT_TRUE(is_host(host)) << host;
  }
  for (const char* const word :
       {"", ".", "10.0.0", "10.0.0.256", "-a", "a..b", "a b", "a:1", "é"}) {
    EXPECT_FALSE(is_host(word)) << word;
  }
  EXPECT_FALSE(is_host(std::string(64, 'a')));  // RFC 1035, 2.3.4
  EXPECT_TRUE(is_host(std::string(63, 'a')));
}

TEST(Addresses, TellInterfacesFromOtherWords) {
  for (const char* const name : {"10.0.0.1", "eth0", "lo", "enp3s0.100", "eth0:1"}) {
    EXPECT_TRUE(is_interface(name)) << name;
  }
  for (const char* const word : {"", "10.0.0", "a b", "an_interface_name"}) {  // over 15 letters
    EXPECT_FALSE(is_interface(word)) << word;
  }
}

TEST(Addresses, OfAnInterfaceAreFoundByItsNameAndByItself) {
  const std::vector<OwnInterface> own{{"lo", "127.0.0.1", true},
                                      {"eth0", "10.0.0.1", true},
                                      {"eth0", "10.0.0.2", true},
                                      {"eth1", "10.1.0.1", false}};
  EXPECT_THAT(addresses_of("eth0", own), ElementsAre("10.0.0.1", "10.0.0.2"));
  EXPECT_THAT(addresses_of("10.0.0.2", own), ElementsAre("10.0.0.2"));
  EXPECT_THAT(addresses_of("eth1", own), IsEmpty());  // the interface is down
  EXPECT_THAT(addresses_of("eth2", own), IsEmpty());
}

TEST(Addresses, OfAServerAreAHostAndAPort) {
  EXPECT_EQ(parse_server_address("discovery-0.lab:11811").value().host, "discovery-0.lab");
  for (const char* const word : {"discovery", "discovery:", ":11811", "discovery:0", "a:1:2"}) {
    EXPECT_FALSE(parse_server_address(word)) << word;
  }
}

}  // namespace
}  // namespace vdrive::wire
