// SPDX-License-Identifier: Apache-2.0
// The counters of a bench as a monitoring system reads them.
#include "program/metrics.hpp"

#include "program/metrics_endpoint.hpp"
#include "support/local_http.hpp"
#include "vdrive_messages_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;
using test::answer_to;
using test::connected;
using test::http_get;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class MetricsTest : public testing::Test {
 protected:
  static Configuration cell() {
    Configuration configuration = demo_configuration();
    configuration.name = "cell \"7\"";
    return configuration;
  }

  Configuration configuration_ = cell();
  Counters counters_;

  [[nodiscard]] MetricsEndpoint endpoint(const std::string& address, std::uint16_t port) {
    return {address,
            port,
            std::make_unique<Metrics>(configuration_, BenchIdentity{.bench = 4, .incarnation = 99},
                                      counters_),
            {.is_alive =
                 [this] {
                   return alive_;
                 },
             .is_ready =
                 [this] {
                   return ready_;
                 }}};
  }

  /// Set these before a request that reads them.
  ProbeAnswer alive_{.is_good = true, .text = "bench 4 is alive"};
  ProbeAnswer ready_{.is_good = false, .text = "bench 4 has no network"};
  MetricsEndpoint sut_ = endpoint("127.0.0.1", 0);
};

TEST_F(MetricsTest, AreServedAsPrometheusText) {
  counters_.ticks_run.add(17);
  counters_.inbox_depth.set(5);
  counters_.outbox_depth.set(6);
  counters_.overruns.add(2);
  counters_.commands_applied.add(3);
  counters_.master_losses.add();
  counters_.longest_silence_us.set(112'000);
  counters_.wall_steps.add(3);
  counters_.wall_offset.set(-1.5);
  const std::string answer = http_get(sut_.port(), "/metrics");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 OK"));
  EXPECT_THAT(answer, HasSubstr("text/plain"));
  for (const char* const line :
       {"\nvdrive_ticks_total{bench=\"4\"} 17\n", "\nvdrive_tick_overruns_total{bench=\"4\"} 2\n",
        "\nvdrive_commands_applied_total{bench=\"4\"} 3\n",
        "\nvdrive_wall_clock_steps_total{bench=\"4\"} 3\n",
        "\nvdrive_wall_clock_offset_seconds{bench=\"4\"} -1.5\n",
        "\nvdrive_watchdog_trips_total{bench=\"4\"} 1\n",
        "\nvdrive_longest_silence_seconds{bench=\"4\"} 0.112\n", "\nvdrive_axes{bench=\"4\"} 2\n",
        "\nvdrive_queue_depth{bench=\"4\",queue=\"inbox\"} 5\n",
        "\nvdrive_queue_depth{bench=\"4\",queue=\"outbox\"} 6\n",
        "# TYPE vdrive_ticks_total counter", "name=\"cell \\\"7\\\"\""}) {
    EXPECT_THAT(answer, HasSubstr(line));
  }
}

// Each figure is a member in the IDL, from which its name, kind, unit and help follow.
TEST_F(MetricsTest, HaveEachFigureOfABench) {
  const std::map<std::string_view, std::string> renamed{
      {"overruns", "vdrive_tick_overruns_total"},
      {"jumps", "vdrive_tick_jumps_total"},
      {"inbox_depth", "vdrive_queue_depth"},
      {"outbox_depth", "vdrive_queue_depth"},
      {"pending_frames", "vdrive_queue_depth"},
      {"master_losses", "vdrive_watchdog_trips_total"},
      {"longest_silence_us", "vdrive_longest_silence_seconds"}};
  const std::string answer = http_get(sut_.port(), "/metrics");
  wire::for_each_figure<msg::BenchState>([&](const wire::MemberTraits& figure) {
    const bool is_counter = figure.figure == wire::FigureKind::counter;
    const auto other = renamed.find(figure.name);
    const std::string name = other != renamed.end() ? other->second
                                                    : "vdrive_" + std::string(figure.name) +
                                                          (is_counter ? "_total" : "");
    EXPECT_THAT(answer, HasSubstr("# TYPE " + name + (is_counter ? " counter\n" : " gauge\n")));
    EXPECT_THAT(answer, HasSubstr("\n" + name + "{bench=\"4\""));
    if (name == "vdrive_queue_depth") return;  // all queues share one help text
    EXPECT_THAT(answer, HasSubstr("# HELP " + name + " " + std::string(figure.help) + "\n"));
  });
}

TEST_F(MetricsTest, ShowTheStateOfTheNetworkProcess) {
  counters_.wire_starts.add(3);
  counters_.wire_is_up.set(1);
  counters_.wire_resident.set(50'000'000);
  counters_.datagrams_dropped.add(6);
  counters_.malformed.add(7);
  const std::string answer = http_get(sut_.port(), "/metrics");
  for (const char* const line :
       {"# TYPE vdrive_wire_starts_total counter", "\nvdrive_wire_starts_total{bench=\"4\"} 3\n",
        "# TYPE vdrive_wire_up gauge", "\nvdrive_wire_up{bench=\"4\"} 1\n",
        "# TYPE vdrive_wire_resident_bytes gauge",
        "\nvdrive_wire_resident_bytes{bench=\"4\"} 50000000\n",
        "# TYPE vdrive_datagrams_dropped_total counter",
        "\nvdrive_datagrams_dropped_total{bench=\"4\"} 6\n",
        "# TYPE vdrive_malformed_samples_total counter",
        "\nvdrive_malformed_samples_total{bench=\"4\"} 7\n"}) {
    EXPECT_THAT(answer, HasSubstr(line));
  }
}

TEST_F(MetricsTest, ShowTheLatenessOfTicksAsAHistogram) {
  // The bins are powers of two of microseconds: 0.5 us is below 1 us, 3 us below 4 us.
  counters_.count_lateness(500ns);
  counters_.count_lateness(3us);
  counters_.count_lateness(3us);
  counters_.count_lateness(-2us);  // early is not late
  const std::string answer = http_get(sut_.port(), "/metrics");
  for (const char* const line :
       {"_bucket{bench=\"4\",le=\"1e-06\"} 2\n", "_bucket{bench=\"4\",le=\"2e-06\"} 2\n",
        "_bucket{bench=\"4\",le=\"4e-06\"} 4\n", "_bucket{bench=\"4\",le=\"+Inf\"} 4\n",
        "_count{bench=\"4\"} 4\n", "_sum{bench=\"4\"} 6.5e-06\n"}) {
    EXPECT_THAT(answer, HasSubstr("vdrive_tick_lateness_seconds" + std::string(line)));
  }
}

TEST_F(MetricsTest, CountRefusalsByTheirReason) {
  EXPECT_THAT(http_get(sut_.port(), "/metrics"), Not(HasSubstr("vdrive_refusals_total")));
  counters_.refusals.add(2);  // REASON_STALE_EPOCH
  counters_.refusals.add(0x08000021);
  counters_.refusals.add(0x08000021);
  const std::string answer = http_get(sut_.port(), "/metrics");
  EXPECT_THAT(answer, HasSubstr("reason=\"the epoch is not current: control was lost, released or "
                                "renewed\"} 1\n"));
  EXPECT_THAT(answer, AllOf(HasSubstr("reason=\"0x08000021, "), HasSubstr("local control\"} 2\n")));
}

TEST_F(MetricsTest, AreServedWithTheAnswersToProbes) {
  EXPECT_THAT(http_get(sut_.port(), "/livez"),
              AllOf(StartsWith("HTTP/1.1 200"), EndsWith("\r\n\r\nbench 4 is alive\n")));
  EXPECT_THAT(http_get(sut_.port(), "/readyz"),
              AllOf(StartsWith("HTTP/1.1 503"), EndsWith("\r\n\r\nbench 4 has no network\n")));
  alive_.is_good = false;
  ready_.is_good = true;
  EXPECT_THAT(http_get(sut_.port(), "/livez?verbose"), StartsWith("HTTP/1.1 503"));
  EXPECT_THAT(http_get(sut_.port(), "/readyz"), StartsWith("HTTP/1.1 200"));
}

TEST_F(MetricsTest, HaveNoOtherPageBesideThem) {
  EXPECT_THAT(http_get(sut_.port(), "/"),
              AllOf(StartsWith("HTTP/1.1 404"), HasSubstr("/livez and /readyz")));
}

TEST_F(MetricsTest, SurviveAnInvalidRequest) {
  EXPECT_THAT(answer_to(sut_.port(), "\x16\x03\x01 no HTTP\r\n\r\n"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(answer_to(sut_.port(), "POST /metrics HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc"),
              StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(answer_to(sut_.port(), "GET /metrics HTTP/1.1\r\nContent-Length: 99999999\r\n\r\n"),
              StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(answer_to(sut_.port(), "GET /" + std::string(100'000, 'a')),
              StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(answer_to(sut_.port(), "GET /metrics HTTP/7.5\r\n\r\n"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(answer_to(sut_.port(), "GET /metrics\r\n\r\n"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(http_get(sut_.port(), "/metrics"), StartsWith("HTTP/1.1 200"));
}

TEST_F(MetricsTest, IgnoreAQueryString) {
  EXPECT_THAT(http_get(sut_.port(), "/metrics?x=1"), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(http_get(sut_.port(), "/metrics?"), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(http_get(sut_.port(), "/metricsx"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(http_get(sut_.port(), "/?/metrics"), StartsWith("HTTP/1.1 404"));
}

/// Connections that never read; closed in the destructor.
class IdleConnections {
 public:
  /// @param words the text that each connection sends
  IdleConnections(int port, int count, const std::string& words) {
    for (int i = 0; i < count; ++i) {
      connections_.push_back(connected(port));
      (void)send(connections_.back(), words.data(), words.size(), MSG_NOSIGNAL);
    }
  }

  ~IdleConnections() {
    for (const int connection : connections_) close(connection);
  }

  IdleConnections(const IdleConnections&) = delete;
  IdleConnections& operator=(const IdleConnections&) = delete;

 private:
  std::vector<int> connections_;
};

TEST_F(MetricsTest, AreServedWithinASecondDespiteAHundredIdleClients) {
  for (const char* const words :
       {"", "GET /metrics HTTP/1.1\r\n", "GET /metrics HTTP/1.1\r\n\r\n"}) {
    const IdleConnections idle(sut_.port(), 100, words);
    for (int scrape = 0; scrape < 3; ++scrape) {
      const auto begin = std::chrono::steady_clock::now();
      EXPECT_THAT(http_get(sut_.port(), "/metrics"), StartsWith("HTTP/1.1 200")) << words;
      EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s) << words;
    }
  }
}

TEST_F(MetricsTest, EndAtOnceWithAConnectedClient) {
  std::optional<MetricsEndpoint> ending;
  ending.emplace("127.0.0.1", 0,
                 std::make_unique<Metrics>(configuration_, BenchIdentity{}, counters_), Probes{});
  const int idle = connected(ending->port());
  const auto begin = std::chrono::steady_clock::now();
  ending.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
  close(idle);
}

TEST_F(MetricsTest, NameAnAddressAndPortThatCannotBeHad) {
  const auto refusal = [this](const std::string& address) -> std::string {
    try {
      const MetricsEndpoint second = endpoint(address, sut_.port());
      return "two endpoints have one port";
    } catch (const ConfigurationError& error) {
      return error.what();
    }
  };
  const std::string port = "metrics.port = " + std::to_string(sut_.port());
  EXPECT_THAT(refusal("127.0.0.1"),
              StartsWith(port + ": cannot listen on this port of 127.0.0.1: "));
  // This address is reserved for documentation (RFC 5737), so no interface has it.
  EXPECT_THAT(refusal("192.0.2.1"),
              StartsWith(port + ": cannot listen on this port of 192.0.2.1: "));
}

TEST(RefusalCounters, CountEachReasonFromSeveralThreads) {
  RefusalCounters sut;
  {
    std::array<std::jthread, 4> threads;
    for (auto& thread : threads) {
      thread = std::jthread([&sut] {
        for (std::uint32_t i = 0; i < 10'000; ++i) sut.add(1 + i % 10);
      });
    }
  }
  const auto counts = sut.counts();
  ASSERT_EQ(counts.size(), 10U);
  for (const auto& [reason, count] : counts) EXPECT_EQ(count, 4'000U) << reason;
}

}  // namespace
}  // namespace vdrive::service
