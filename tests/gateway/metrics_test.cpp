// SPDX-License-Identifier: Apache-2.0
// The counters of the gateway in the format read by monitoring.
#include "metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::gateway {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

TEST(GatewayMetrics, AreInThePrometheusTextFormat) {
  GatewayCounts counts{.channels = 12,
                       .subscribed = 3,
                       .subscriptions = 7,
                       .lost_batches = 2,
                       .is_controlled = true};
  counts.web.clients = 2;
  counts.web.connections = 9;
  counts.web.messages_sent = 1'000;
  counts.web.bytes_sent = 54'321;
  counts.web.dropped = 8;
  const std::string text = metrics_text(counts);
  for (const char* line :
       {"# TYPE vdrive_gateway_clients gauge", "vdrive_gateway_clients 2\n",
        "# TYPE vdrive_gateway_connections_total counter", "vdrive_gateway_connections_total 9\n",
        "vdrive_gateway_messages_sent_total 1000\n", "vdrive_gateway_bytes_sent_total 54321\n",
        "vdrive_gateway_messages_dropped_total 8\n", "vdrive_gateway_channels 12\n",
        "vdrive_gateway_channels_subscribed 3\n", "vdrive_gateway_subscriptions 7\n",
        "vdrive_gateway_batches_lost_total 2\n", "vdrive_gateway_controlled 1\n",
        "vdrive_gateway_benches 0\n", "vdrive_gateway_info{version=\""}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
  EXPECT_THAT(text, Not(HasSubstr("bench=")));
}

TEST(GatewayMetrics, CountRefusalsByTheirReason) {
  GatewayCounts counts;
  counts.web.refused[static_cast<std::size_t>(Refusal::origin)] = 4;
  counts.web.cut_off[static_cast<std::size_t>(CutOff::flood)] = 5;
  const std::string text = metrics_text(counts);
  const std::string refused = "vdrive_gateway_upgrades_refused_total{reason=";
  EXPECT_THAT(text, HasSubstr(refused + "\"origin\"} 4\n"));
  for (const char* reason : {"host", "token", "subprotocol", "clients"}) {
    EXPECT_THAT(text, HasSubstr(refused + "\"" + reason + "\"} 0\n"));
  }
  const std::string cut_off = "vdrive_gateway_clients_cut_off_total{reason=";
  EXPECT_THAT(text, HasSubstr(cut_off + "\"flood\"} 5\n"));
  for (const char* reason : {"silent", "unread"}) {
    EXPECT_THAT(text, HasSubstr(cut_off + "\"" + reason + "\"} 0\n"));
  }
  EXPECT_THAT(text, Not(HasSubstr("unknown"))) << "every reason has a name";
}

TEST(GatewayMetrics, GiveTheAgeOfTheNewestSampleOfEachBench) {
  const GatewayCounts counts{.benches = {{.number = 1, .is_alive = true, .sample_age = 250ms},
                                         {.number = 7, .is_alive = false, .sample_age = 8s}}};
  const std::string text = metrics_text(counts);
  for (const char* line :
       {"vdrive_gateway_benches 2\n", "vdrive_gateway_bench_alive{bench=\"1\"} 1\n",
        "vdrive_gateway_bench_alive{bench=\"7\"} 0\n",
        "vdrive_gateway_newest_sample_age_seconds{bench=\"1\"} 0.25\n",
        "vdrive_gateway_newest_sample_age_seconds{bench=\"7\"} 8\n"}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
}

}  // namespace
}  // namespace vdrive::gateway
