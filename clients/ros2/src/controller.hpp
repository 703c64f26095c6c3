// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_presence.hpp"
#include "board.hpp"
#include "drops.hpp"
#include "requests.hpp"
#include "settings.hpp"
#include "stamp_order.hpp"
#include "vdrive/wire/ros.hpp"

#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <variant>
#include <vector>

namespace vdrive::ros2 {

/// Commands the benches: takes the messages of ROS, in a thread of its own that never waits for a
/// bench.
class Controller {
 public:
  /// @param session outlives the controller, as the others do
  Controller(client::Session& session, const Settings& settings, bridge::Reports& reports,
             Board& board);

  /// Disables the axes that it has enabled, as far as that is possible within two seconds.
  ~Controller();
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  using Message = std::variant<wire::ros::JointState, wire::ros::JointTrajectory, wire::ros::Bool>;

  /// Any thread; does not wait. When the queue is full the oldest message is dropped and counted.
  /// @param writer who wrote it
  void take(Message message, const wire::WriterId& writer);

  /// @param writers gives the number of nodes that write joint commands now; when the last one
  ///        ends, joints that velocity or effort move brake
  void set_writers(std::function<std::size_t()> writers);

  /// @param counts gives what the guard of the participant has refused until now
  void set_guard_counts(std::function<wire::GuardCounts()> counts);

 private:
  using Clock = std::chrono::steady_clock;

  /// A bench that the bridge serves.
  struct Bench {
    std::unique_ptr<BenchLink> link;
    std::unique_ptr<BenchMotion> motion;
    std::shared_ptr<const client::BenchInfo> info;
    std::shared_ptr<const std::vector<Joint>> joints;
  };

  struct Received {
    wire::WriterId writer;
    Message message;
  };

  /// A bench that the bridge does not serve.
  struct LeftOut {
    std::shared_ptr<const client::BenchInfo> info;
    std::string reason;
  };

  /// A trajectory that waits for its time, or for the limits.
  struct Waiting {
    Trajectory trajectory;
    std::map<std::uint32_t, std::uint64_t> limits;  ///< what limits_read() has to reach, by bench
    bool is_checked = false;
  };

  /// The paths of a trajectory that may start.
  struct Start {
    std::vector<std::shared_ptr<const JointPath>>
        paths;                                      ///< one a joint; none for a joint at its target
    std::map<std::uint32_t, std::uint64_t> begins;  ///< tick, by bench
    std::string problem;
    bool waits = false;  ///< its time has not come
  };

  void run(const std::stop_token& stop);
  void turn();
  void end();
  void wait(const std::stop_token& stop);
  void find_benches(Clock::time_point now);
  void add_bench(const client::BenchInfo& info);
  void remove_bench(std::uint32_t number, bool is_replaced);
  void handle_messages();
  void handle(const wire::ros::JointState& message, const wire::WriterId& writer);
  void handle(const wire::ros::JointTrajectory& message, const wire::WriterId& writer);
  void handle(const wire::ros::Bool& message, const wire::WriterId& writer);
  void check_writers();
  void report_drops(Clock::time_point now);
  [[nodiscard]] std::optional<std::int64_t> time_of(std::uint32_t bench) const;
  [[nodiscard]] std::string stamp_problem(const StampOrder& order, const wire::WriterId& writer,
                                          std::int64_t stamp,
                                          const std::set<std::uint32_t>& benches) const;
  [[nodiscard]] std::optional<KnownJoint> find(const std::string& name) const;
  [[nodiscard]] std::string trajectory_problem(const Trajectory& trajectory,
                                               const wire::WriterId& writer) const;
  void start_waiting();
  [[nodiscard]] bool try_start(Waiting& waiting);
  [[nodiscard]] bool has_limits(const Waiting& waiting) const;
  void find_begins(const Trajectory& trajectory, Start& start,
                   std::map<std::uint32_t, double>& passed);
  [[nodiscard]] Start prepare(const Trajectory& trajectory);
  void add_path(const Trajectory& trajectory, std::size_t joint, double passed, Start& start);
  void begin(const Trajectory& trajectory, const Start& start);
  void break_off(const std::vector<BrokenTrajectory>& broken);
  void forget_trajectories();
  void publish(bool is_urgent);

  [[nodiscard]] BenchMotion& motion_of(const JointPlace& place) {
    return *benches_.at(place.bench).motion;
  }

  void refuse_trajectory(const std::string& problem);

  client::Session& session_;
  const Settings settings_;
  bridge::Reports& reports_;
  Board& board_;
  bridge::Presence presence_;
  std::map<std::uint32_t, Bench> benches_;
  JointDirectory directory_;
  std::map<std::uint32_t, LeftOut> left_out_;  ///< benches whose joints clash
  std::vector<Waiting> waiting_;
  std::map<std::uint64_t, std::string> trajectories_;  ///< under way: number and text
  std::uint64_t last_trajectory_ = 0;
  StampOrder command_stamps_;
  StampOrder trajectory_stamps_;
  Drops drops_;
  bool is_enabled_;
  bool had_writers_ = false;
  Clock::time_point find_due_{};
  std::mutex mutex_;  ///< guards what follows
  std::condition_variable_any woken_;
  bool is_woken_ = false;
  std::deque<Received> messages_;
  std::uint64_t dropped_ = 0;
  std::function<std::size_t()> writers_;
  std::function<wire::GuardCounts()> guard_counts_;
  std::jthread thread_;
};

}  // namespace vdrive::ros2
