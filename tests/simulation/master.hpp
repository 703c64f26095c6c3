// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "simulation/control_model.hpp"
#include "simulation/happenings.hpp"
#include "simulation/network.hpp"
#include "support/programs/command.hpp"
#include "support/random_cases.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace vdrive::simulation {

using test::Random;

/// The view of a client: the last status images of the bench.
struct View {
  std::uint64_t incarnation = 0;
  std::uint64_t tick = 0;
  std::span<const AxisStatus> statuses;
  std::span<const wire::Ownership> owners;
};

using Post = Network<ClientMessage>;
using Stamps = std::vector<ControlModel::Stamped>;

inline constexpr std::uint32_t kBench = 7;

/// The behaviour of a master, drawn for each seed.
struct Temper {
  std::int64_t longest_pause = 12 * kMillisecond;  ///< between two messages
  std::uint64_t greed = 8;                         ///< per mille of actions that take axes over
  std::uint64_t rudeness = 30;                     ///< per mille that are wrong in some way
  std::uint64_t lapses = 2;                        ///< per mille that stop its messages for a while
  std::uint64_t haste = 0;  ///< per mille of actions that do not wait for an answer
};

/// A program that acquires axes, commands them and keeps its session alive, as the client library
/// does, until it falls silent, hangs, restarts, repeats itself or sends invalid messages.
class Master {
 public:
  Master(std::size_t place, const Temper& temper, std::uint64_t seed, Stamps& stamps,
         Happenings& happenings);

  [[nodiscard]] std::int64_t next_action() const { return next_; }

  /// Takes one action.
  void act(const View& view, Post& post);

  void on(const msg::Reply& reply);
  void on(const msg::CommandReply& reply);

  [[nodiscard]] std::uint64_t session() const { return session_; }

  [[nodiscard]] std::uint64_t client() const { return client_; }

 private:
  void begin_session();
  void lapse(Post& post);
  void take_axes(const View& view, Post& post, bool by_force);
  void look_up_epoch(const View& view);
  void guess_epoch(const View& view);
  void release(const View& view, Post& post);
  void send_request(const View& view, Post& post);
  void store(const View& view, Post& post);
  void send_frame(const View& view, Post& post);
  void time_frame(const View& view, msg::CommandFrame& frame);
  void spoil(msg::CommandFrame& frame);
  void fill(msg::AxisCommand& command, const AxisStatus& status, const msg::CommandFrame& frame);
  test::Write any_write(const AxisStatus& status, const msg::Request& request);
  msg::CommandFrame new_frame(const View& view);
  msg::Request new_request(msg::RequestKind kind);
  std::uint32_t new_stamp(std::uint64_t incarnation, std::uint32_t epoch);
  std::vector<std::uint16_t> some_axes(const View& view);
  void post(msg::CommandFrame frame, Post& post);
  void post(msg::Request request, Post& post);

  std::size_t place_;
  Temper temper_;
  Random random_;
  Stamps& stamps_;
  Happenings& happenings_;
  std::int64_t now_ = 0;
  std::int64_t next_ = 0;
  std::uint64_t incarnation_ = 0;
  std::uint64_t client_ = 0;
  std::uint64_t session_ = 0;
  std::uint64_t last_request_ = 0;
  std::uint32_t epoch_ = 0;
  std::uint64_t sequence_ = 0;
  std::int64_t last_frame_ = 0;
  msg::CommandFrame old_frame_;
};

}  // namespace vdrive::simulation
