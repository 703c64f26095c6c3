// SPDX-License-Identifier: Apache-2.0
//
// A bridge to a plain-text protocol over TCP. Start a new bridge from this file: it has everything
// that a bridge needs, with the simplest protocol. The kit, clients/bridge, keeps track of the
// benches (Roster) and of the connection to each (BenchLink); a bridge implements how benches
// appear in its protocol (BenchHost, BenchAdapter). connection.hpp is the protocol.
//
// The thread of the loop owns the connections and the benches, and never waits for a bench. Calls
// that wait are jobs of a BenchLink; results from the threads of a link are posted to the loop.
//
//   vdrived --clock realtime &
//   text_bridge [domain] [port]
//   nc 127.0.0.1 8766
//     list, status 1.1, enable 1.1, move 1.1 1000, stop
#include "bench_link.hpp"
#include "connection.hpp"
#include "reports.hpp"
#include "roster.hpp"
#include "tcp_listen.hpp"
#include "vdrive/client.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "worker.hpp"

#include <boost/asio.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <exception>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

using namespace vdrive;
using text_bridge::Answer;
using text_bridge::AsioError;
using text_bridge::Connection;
using text_bridge::tcp;
namespace asio = boost::asio;

namespace {

constexpr std::uint16_t kPort = 8766;
constexpr std::chrono::milliseconds kFindPeriod{200};
constexpr std::size_t kMostConnections = 64;

// A stop is never refused: it replaces an older one.
constexpr bridge::AxisJobs::Kind kStop = 1;

using AnswerPointer = std::shared_ptr<Answer>;

/// A bench served by the bridge. Passes the state from the threads of its link to the thread of the
/// loop.
class TextBench final : public bridge::BenchAdapter {
 public:
  /// @param tell sends a line to all clients; any thread
  TextBench(client::Session& session, bridge::Reports& reports, const client::BenchInfo& info,
            std::function<void(const std::string& line)> tell)
      : label_("bench " + std::to_string(info.number)),
        axes_(info.axes),
        tell_(std::move(tell)),
        // Control is acquired with the first command to an axis. A bridge that streams set-points
        // makes its link keep control: BenchLink::want_control().
        link_(*this, session, reports, info, {.label = label_}) {}

  [[nodiscard]] bridge::BenchLink& link() noexcept { return link_; }

  [[nodiscard]] const std::vector<client::AxisInfo>& axes() const noexcept { return axes_; }

  /// @return the newest state; null while the bench is silent.
  [[nodiscard]] State state() const {
    const std::scoped_lock lock(mutex_);
    return state_;
  }

 private:
  void on_state(const State& state) override {
    const bool is_first = exchange_state(state) == nullptr;
    if (is_first) tell_(label_ + " is there");
  }

  void on_lost() override {
    (void)exchange_state(nullptr);
    tell_(label_ + " is silent");
  }

  State exchange_state(State state) {
    const std::scoped_lock lock(mutex_);
    return std::exchange(state_, std::move(state));
  }

  const std::string label_;
  const std::vector<client::AxisInfo> axes_;
  const std::function<void(const std::string& line)> tell_;
  mutable std::mutex mutex_;
  State state_;
  bridge::BenchLink link_;  // last: its threads use the others
};

/// An axis of a bench being served.
struct Place {
  TextBench& bench;
  std::size_t axis = 0;
};

class TextBridge final : private bridge::BenchHost {
 public:
  /// @param port 0 = any free one
  TextBridge(const client::SessionOptions& options, std::uint16_t port)
      : session_(options), acceptor_(loop_), find_timer_(loop_), signals_(loop_, SIGINT, SIGTERM) {
    bridge::listen_on(acceptor_, "127.0.0.1", port, "127.0.0.1:" + std::to_string(port));
    // A bench that announces its end is removed immediately; one that falls silent, after a minute.
    session_.watch_services([this](const client::ServiceChange& change) {
      roster_.note(change, bridge::Roster::Clock::now());
      asio::post(loop_, [this] {
        find();
      });
    });
    signals_.async_wait([this](const AsioError& /*error*/, int /*signal*/) {
      loop_.stop();
    });
    accept();
    find_later();
  }

  ~TextBridge() override {
    session_.watch_services({});
    session_.interrupt();  // ends calls that wait for a bench
  }

  TextBridge(const TextBridge&) = delete;
  TextBridge& operator=(const TextBridge&) = delete;

  [[nodiscard]] std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

  /// Serves until SIGINT or SIGTERM.
  void run() { loop_.run(); }

 private:
  // ---- benches

  void find() { (void)roster_.take(session_.present_benches(), bridge::Roster::Clock::now()); }

  void find_later() {
    find_timer_.expires_after(kFindPeriod);
    find_timer_.async_wait([this](const AsioError& /*error*/) {
      find();
      if (!is_accepting_) accept();
      find_later();
    });
  }

  [[nodiscard]] bool continues(const client::BenchInfo& known,
                               const client::BenchInfo& found) const override {
    return known.axes == found.axes;
  }

  std::optional<std::string> add(const client::BenchInfo& info) override {
    // The link of a replaced bench may still report something while it ends.
    const auto is_served = is_served_[info.number] = std::make_shared<bool>(true);
    const auto tell = [this, is_served](const std::string& line) {
      asio::post(loop_, [this, is_served, line] {
        if (*is_served) tell_all(line);
      });
    };
    benches_.emplace(info.number, std::make_shared<TextBench>(session_, reports_, info, tell));
    return std::nullopt;
  }

  void remove(std::uint32_t bench, bool /*is_replaced*/) override {
    *is_served_.extract(bench).mapped() = false;
    // Destroying it may wait for the bench, so that must not happen on the thread of the loop.
    (void)closer_.post([ending = benches_.extract(bench).mapped()] {});
    tell_all("bench " + std::to_string(bench) + " has gone");
  }

  // ---- clients

  void accept() {
    is_accepting_ = true;
    acceptor_.async_accept([this](const AsioError& error, tcp::socket socket) {
      is_accepting_ = false;
      if (error) return;  // for example too many open files: retried with the next search
      std::erase_if(connections_, [](const auto& connection) {
        return !connection->is_open();
      });
      if (connections_.size() < kMostConnections) welcome(std::move(socket));
      accept();
    });
  }

  void welcome(tcp::socket&& socket) {
    const auto obey_line = [this](const std::string& line, std::shared_ptr<Connection> connection) {
      obey(line, std::make_shared<Answer>(loop_, std::move(connection)));
    };
    connections_.push_back(std::make_shared<Connection>(std::move(socket), obey_line));
    for (const auto& [number, bench] : benches_) {
      if (bench->state()) {
        connections_.back()->send("bench " + std::to_string(number) + " is there");
      }
    }
    connections_.back()->read();
  }

  void tell_all(const std::string& line) {
    for (const auto& connection : connections_) {
      if (connection->is_open()) connection->send(line);
    }
  }

  // ---- commands

  void obey(const std::string& line, const AnswerPointer& answer) {
    std::istringstream words(line);
    std::string command;
    std::string axis;
    std::string number;
    words >> command >> axis >> number;
    if (command == "list") return answer->set(list());
    if (command == "stop") return stop(answer);
    if (command != "status" && command != "enable" && command != "move") {
      return answer->fail(in_quotes(command) + " is none of list, status, enable, move, stop");
    }
    const auto place = find_axis(axis);
    if (!place) return answer->fail("there is no axis " + in_quotes(axis));
    if (command == "status") return show(*place, answer);
    if (command == "enable") return enable(*place, answer);
    move(*place, number, answer);
  }

  [[nodiscard]] std::optional<Place> find_axis(const std::string& text) const {
    const auto id = client::parse_axis_id(text);
    if (!id || !benches_.contains(id->bench)) return std::nullopt;
    TextBench& bench = *benches_.at(id->bench);
    const auto axis = std::ranges::find(bench.axes(), *id, &client::AxisInfo::id);
    if (axis == bench.axes().end()) return std::nullopt;
    return Place{bench, static_cast<std::size_t>(axis - bench.axes().begin())};
  }

  [[nodiscard]] std::string list() const {
    std::string text;
    for (const auto& [number, bench] : benches_) {
      for (const client::AxisInfo& axis : bench->axes()) text += to_string(axis.id) + " ";
    }
    if (text.empty()) return "no axis";
    text.pop_back();
    return text;
  }

  static void show(const Place& place, const AnswerPointer& answer) {
    const bridge::BenchAdapter::State state = place.bench.state();
    if (!state) return answer->fail("the bench is silent");
    const client::AxisSnapshot& axis = state->axes[place.axis];
    answer->set(to_string(axis.id) + " " + std::string(to_string(axis.state())) + " at " +
                std::to_string(axis.status.load_position_actual_value));
  }

  static void enable(const Place& place, const AnswerPointer& answer) {
    post(place, answer, [](client::Axis& axis) {
      return axis.enable();
    });
  }

  static void move(const Place& place, const std::string& number, const AnswerPointer& answer) {
    const auto position = parse_integer(number);
    if (!position || !std::in_range<std::int32_t>(*position)) {
      return answer->fail(in_quotes(number) + " is no position");
    }
    // Not move_to(): a stop would have to wait for the end of the move.
    post(place, answer, [target = static_cast<std::int32_t>(*position)](client::Axis& axis) {
      return axis.start_move(target).outcome();
    });
  }

  /// Runs a command on a worker of the link.
  template <typename Command>
  static void post(const Place& place, const AnswerPointer& answer, const Command& command) {
    const auto job = [answer, command](client::Axis& axis) {
      const client::Outcome outcome = command(axis);
      if (!outcome) return answer->fail(outcome.message());
      answer->set("ok");
    };
    if (place.bench.link().post(place.axis, bridge::AxisJobs::kAccess, job)) return;
    answer->fail("the bench is silent, or too many commands wait");
  }

  /// Halts the enabled axes, each after the commands given before.
  void stop(const AnswerPointer& answer) {
    answer->set("ok");
    for (const auto& [number, bench] : benches_) {
      const bridge::BenchAdapter::State state = bench->state();
      if (!state) continue;
      for (std::size_t place = 0; place < state->axes.size(); ++place) {
        (void)bench->link().post(place, kStop, [answer](client::Axis& axis) {
          const auto seen = axis.status();
          if (!seen || seen->state() != PowerState::operation_enabled) return;
          if (const client::Outcome halted = axis.halt(); !halted) answer->fail(halted.message());
        });
      }
    }
  }

  asio::io_context loop_{1};  // first: the others post to it
  bridge::Reports reports_{"text_bridge", {}};
  client::Session session_;
  bridge::Worker closer_;
  bridge::Roster roster_{*this};
  std::map<std::uint32_t, std::shared_ptr<TextBench>> benches_;
  std::map<std::uint32_t, std::shared_ptr<bool>> is_served_;  ///< by bench
  std::vector<std::shared_ptr<Connection>> connections_;
  tcp::acceptor acceptor_;
  bool is_accepting_ = false;
  asio::steady_timer find_timer_;
  asio::signal_set signals_;
};

template <typename Number>
Number number_of(const std::string& what, std::string_view text) {
  if (const auto number = parse_digits<Number>(text)) return *number;
  throw std::runtime_error(what + " " + in_quotes(text) + " is not a number from 0 to " +
                           std::to_string(std::numeric_limits<Number>::max()));
}

}  // namespace

int main(int argument_count, char** arguments) {
  try {
    std::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c): it cannot fail for this signal
    client::SessionOptions options;
    if (argument_count > 1) options.domain = number_of<std::uint32_t>("domain", arguments[1]);
    const auto port = argument_count > 2 ? number_of<std::uint16_t>("port", arguments[2]) : kPort;
    TextBridge bridge(options, port);
    std::cout << "text_bridge: 127.0.0.1:" << bridge.port() << std::endl;
    bridge.run();
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "text_bridge: " << error.what() << '\n';
    return 1;
  }
}
