// SPDX-License-Identifier: Apache-2.0
#include "core/support/set_point_model.hpp"

#include "vdrive/motion/profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <optional>
#include <ostream>
#include <sstream>

namespace vdrive::test {
namespace {

struct ModelSetPoint {
  std::int64_t value = 0;
  double velocity = 0.0;
  std::int64_t option = 2;
  bool relative = false;
};

/// Profile position mode by its specification, not by the code of the drive; 605Ah, 605Bh, 605Ch
/// and 605Eh are all 0.
class Model {
 public:
  Model(const AxisUnderTest& axis, std::map<std::string, int>& occurred)
      : axis_(axis), occurred_(occurred) {}

  /// Begins the writes of a tick.
  void begin_writes() { words_in_tick_ = 0; }

  void write(const Command& command) {
    const std::string_view object = command.object;
    if (expected_answer(command) != AbortCode::none) {
      note("a refused mode", moving_);
      return;
    }
    if (object == "ds402_controlword") {
      controlword(static_cast<std::uint16_t>(command.value));
    } else if (object == "position_user_target_value") {
      target_register_ = command.value;
    } else if (object == "profile_velocity") {
      velocity_register_ = static_cast<double>(command.value);
    } else if (object == "profile_acc") {
      acceleration_ = static_cast<double>(command.value);
    } else if (object == "profile_dec") {
      deceleration_ = static_cast<double>(command.value);
    } else if (object == "positioning_option_code") {
      option_ = command.value;
    } else if (object == "position_target_reached_window") {
      window_ = command.value;
    } else if (object.starts_with("test_")) {
      causes_[std::string(object)] = command.value != 0;
    } else if (object == "op_mode_cmd") {
      note("mode 0", command.value == 0 && mode_command_ == 1 && moving_);
      note("mode 1 again", command.value == 1 && mode_command_ == 0 && moving_);
      mode_command_ = command.value;
      follow_mode();
    }
  }

  /// Automatic transitions and the demand of the tick; called before the drive's step.
  void begin_tick() {
    if (state_ == PowerState::fault_reaction_active) {
      state_ = PowerState::fault;  // coasting: the reaction is shown for one tick
    } else if (state_ == PowerState::quick_stop_active && !entered_) {
      state_ = PowerState::switch_on_disabled;  // the same for a quick stop with 605Ah = 0
    }
    entered_ = false;
    watch_causes();
    follow_mode();
    replan();
  }

  /// Demand and bits 10 and 12; called after the drive's step.
  void end_tick() {
    if (!enabled()) {
      x_ = axis_.actual();
      v_ = 0.0;
      moving_ = false;
      fresh_ = false;
      return;
    }
    advance();
    const bool inside =
        window_ == 4294967295 || std::abs(axis_.actual() - target_) <= static_cast<double>(window_);
    inside_ticks_ = inside ? inside_ticks_ + 1 : 0;
    bool reached = arrived_ && !fresh_ && inside && inside_ticks_ > 20;  // 6068h = 20 ms
    if (window_ == 4294967295) reached = arrived_ && !fresh_;
    if (mode_ == 1 && reached && !halted()) {
      active_ = false;
      if (buffered_) {
        note("buffered set-point started", true);
        const ModelSetPoint next = *buffered_;
        buffered_.reset();
        acknowledge_ = acknowledge_ && (word_ & 0x10U) != 0;
        start(next);
        reached = false;
      }
    }
    bit10_ = halted() ? at_rest() : reached;
    fresh_ = false;
  }

  [[nodiscard]] ExpectedTick expected() const {
    unsigned word = statusword_of(state_) | Statusword::kRemote;
    word |= causes_.at("test_dc_link_loss") ? 0U : Statusword::kVoltageEnabled;
    const bool positioning = enabled() && mode_ == 1;
    const bool standing = state_ == PowerState::quick_stop_active && at_rest();
    word |= (positioning && bit10_) || standing ? Statusword::kTargetReached : 0U;
    word |= positioning && acknowledge_ ? Statusword::kSetPointAcknowledge : 0U;
    return {static_cast<std::uint16_t>(word), mode_, std::llrint(x_), std::llrint(v_)};
  }

  [[nodiscard]] std::uint32_t ignored() const { return ignored_; }

 private:
  [[nodiscard]] bool enabled() const { return state_ == PowerState::operation_enabled; }

  [[nodiscard]] bool halted() const { return (word_ & 0x100U) != 0; }

  /// Demand and actual speed are zero (606Fh = 10).
  [[nodiscard]] bool at_rest() const { return !moving_ && std::abs(axis_.velocity()) <= 10; }

  void note(const std::string& event, bool happened) { occurred_[event] += happened ? 1 : 0; }

  [[nodiscard]] bool cause_present() const {
    return std::any_of(causes_.begin(), causes_.end(), [](const auto& cause) {
      return cause.second;
    });
  }

  /// A lost DC link is a fault if the axis has power; otherwise it leads to Switch on disabled.
  void watch_causes() {
    for (const auto& [name, present] : causes_) {
      const bool dc_link = name == "test_dc_link_loss";
      const bool without_power = !enabled() && state_ != PowerState::quick_stop_active;
      const bool faulty =
          state_ == PowerState::fault || state_ == PowerState::fault_reaction_active;
      if (present && !faulty && !(dc_link && without_power)) {
        note("fault by " + name, moving_);
        leave(PowerState::fault_reaction_active);
      } else if (present && dc_link && !faulty) {
        leave(PowerState::switch_on_disabled);
      }
    }
  }

  void controlword(std::uint16_t word) {
    note("several words in a tick", ++words_in_tick_ == 2);
    const std::uint16_t previous = word_;
    word_ = word;
    note("halt", moving_ && (word & ~previous & 0x100U) != 0);
    note("end of a halt in motion", moving_ && enabled() && (previous & ~word & 0x100U) != 0);
    const bool ready = enabled() && mode_ == 1;
    command(word, previous);
    const bool accepting = ready && enabled() && mode_command_ == mode_;
    const bool edge = (word & 0x10U) != 0 && (previous & 0x10U) == 0;
    if (edge) {
      set_point(word, accepting);
    } else if ((word & 0x10U) == 0 && !buffered_) {
      acknowledge_ = false;
    }
  }

  /// The reaction matrix for the words that the sequences use.
  void command(std::uint16_t word, std::uint16_t previous) {
    if ((word & 0x80U) != 0) {
      if (state_ == PowerState::fault && (previous & 0x80U) == 0 && !cause_present()) {
        note("fault reset", true);
        state_ = PowerState::switch_on_disabled;
      }
      return;
    }
    if (state_ == PowerState::fault || state_ == PowerState::fault_reaction_active) return;
    const bool off = state_ == PowerState::switch_on_disabled;
    const bool stopping = state_ == PowerState::quick_stop_active;
    if ((word & 0x02U) == 0) {
      note("disable voltage", moving_);
      leave(PowerState::switch_on_disabled);
    } else if (stopping || (off && causes_.at("test_dc_link_loss"))) {
      return;
    } else if ((word & 0x04U) == 0) {
      note("quick stop", moving_);
      entered_ = enabled();
      leave(enabled() ? PowerState::quick_stop_active : PowerState::switch_on_disabled);
    } else if ((word & 0x01U) == 0) {
      note("shutdown", moving_);
      leave(PowerState::ready_to_switch_on);
    } else if ((word & 0x08U) == 0) {
      note("disable operation", moving_);
      leave(off ? PowerState::switch_on_disabled : PowerState::switched_on);
    } else if (!enabled()) {
      enable();
    }
  }

  void leave(PowerState state) {
    if (state == state_) return;
    state_ = state;
    moving_ = false;
    drop();
  }

  void enable() {
    state_ = PowerState::operation_enabled;
    x_ = axis_.actual();
    v_ = 0.0;
    moving_ = false;
    rest_here();
  }

  /// The axis's position becomes the latched target, which is reached immediately.
  void rest_here() {
    drop();
    target_ = std::nearbyint(x_);
    arrived_ = true;
    inside_ticks_ = 1'000'000;
  }

  void drop() {
    buffered_.reset();
    acknowledge_ = false;
    active_ = false;
    has_target_ = false;
  }

  void set_point(std::uint16_t word, bool accepting) {
    const ModelSetPoint latched{target_register_, velocity_register_, option_, (word & 0x40U) != 0};
    note("relative set-point", accepting && latched.relative);
    if (!accepting) {
      ++ignored_;
    } else if ((word & 0x20U) != 0 || !active_) {
      note("immediate set-point in motion", moving_);
      note("immediate set-point over a full buffer", buffered_.has_value());
      buffered_.reset();
      acknowledge_ = true;
      fresh_ = true;
      start(latched);
    } else if (!buffered_) {
      buffered_ = latched;
      acknowledge_ = true;
      fresh_ = true;
    } else {
      note("set-point into a full buffer", true);
      ++ignored_;
    }
  }

  void start(const ModelSetPoint& next) {
    double base = 0.0;
    if (next.relative) {
      const std::array<double, 3> bases{target_, std::nearbyint(x_),
                                        static_cast<double>(axis_.actual())};
      base = bases[static_cast<std::size_t>(next.option)];
    }
    target_ = base + static_cast<double>(next.value);
    set_point_velocity_ = next.velocity;
    has_target_ = true;
    active_ = true;
    arrived_ = false;
    inside_ticks_ = 0;
    replan_ = true;
  }

  void follow_mode() {
    if (mode_command_ == mode_) return;
    if (enabled() && !at_rest()) {
      drop();
      return;
    }
    mode_ = mode_command_;
    rest_here();
  }

  struct Request {
    bool move = false;
    double target = 0.0;
    MotionLimits limits;

    bool operator==(const Request& o) const {
      return move == o.move && (!move || target == o.target) &&
             limits.velocity == o.limits.velocity && limits.acceleration == o.limits.acceleration &&
             limits.deceleration == o.limits.deceleration;
    }
  };

  [[nodiscard]] Request wanted() const {
    const bool moves = mode_ == 1 && mode_command_ == 1 && !halted() && has_target_;
    if (!moves) {
      return {.move = false, .limits = {0.0, 1.0, deceleration_}};
    }
    return {.move = true,
            .target = target_,
            .limits = {std::min(set_point_velocity_, 136'533.0), acceleration_, deceleration_}};
  }

  void replan() {
    if (!enabled()) {
      request_.reset();
      return;
    }
    const Request now = wanted();
    if (request_ && *request_ == now && !replan_) return;
    request_ = now;
    replan_ = false;
    profile_ = now.move ? plan_move({x_, v_}, now.target, now.limits)
                        : plan_stop({x_, v_}, now.limits.deceleration);
    plan_ticks_ = 0.0;
    arrived_ = false;
    moving_ = profile_.segment_count() > 0;
  }

  void advance() {
    if (moving_) {
      plan_ticks_ += 1.0;
      const double time = plan_ticks_ * 8.0 * 125.0e-6;
      const MotionSample now = profile_.at(time);
      x_ = now.position;
      v_ = now.velocity;
      moving_ = time < profile_.duration();
    }
    if (!moving_ && !arrived_) {
      if (request_->move) {
        x_ = profile_.end_position();
        arrived_ = profile_.reaches_target();
      } else if (!has_target_) {
        target_ = std::nearbyint(x_);
        arrived_ = true;
      }
    }
  }

  const AxisUnderTest& axis_;
  std::map<std::string, int>& occurred_;
  PowerState state_ = PowerState::switch_on_disabled;
  std::uint16_t word_ = 0;
  std::int64_t mode_ = 0;
  std::int64_t mode_command_ = 0;
  std::int64_t target_register_ = 0;
  double velocity_register_ = 68'267.0;
  double acceleration_ = 409'600.0;
  double deceleration_ = 409'600.0;
  std::int64_t option_ = 2;
  std::int64_t window_ = 100;
  std::map<std::string, bool> causes_{{"test_over_current", false},
                                      {"test_over_temperature", false},
                                      {"test_encoder_failure", false},
                                      {"test_dc_link_loss", false}};
  bool entered_ = false;  // Quick stop active, since the last tick
  int words_in_tick_ = 0;

  double x_ = 0.0;
  double v_ = 0.0;
  bool moving_ = false;
  Profile profile_;
  double plan_ticks_ = 0.0;
  std::optional<Request> request_;
  bool replan_ = false;

  double target_ = 0.0;
  double set_point_velocity_ = 0.0;
  bool has_target_ = false;
  bool active_ = false;
  bool arrived_ = false;
  bool fresh_ = false;
  bool acknowledge_ = false;
  bool bit10_ = false;
  std::int64_t inside_ticks_ = 0;
  std::optional<ModelSetPoint> buffered_;
  std::uint32_t ignored_ = 0;
};

/// @return the difference after the tick, or "".
std::string difference(const AxisUnderTest& axis, const Model& model) {
  std::ostringstream text;
  const auto compare = [&text](const char* what, std::int64_t drive, std::int64_t expected) {
    if (drive != expected) text << what << ' ' << drive << " instead of " << expected << "; ";
  };
  const ExpectedTick expected = model.expected();
  if (axis.statusword() != expected.statusword) {
    text << "6041h 0x" << std::hex << axis.statusword() << " instead of 0x" << expected.statusword
         << std::dec << "; ";
  }
  compare("6061h", axis.status().op_mode_actual, expected.mode);
  compare("ignored set-points", axis.status().ignored_set_points, model.ignored());
  compare("6062h", axis.demand(), expected.demand);
  compare("606Bh", axis.demand_velocity(), expected.demand_velocity);
  return text.str();
}

/// Writes one step to both. @return the difference between answer and expectation, or "".
std::string write_both(AxisUnderTest& axis, Model& model, const std::vector<Command>& writes) {
  model.begin_writes();
  for (const Command& write : writes) {
    const AbortCode code = axis.try_write(write.object, write.value);
    if (code != expected_answer(write)) {
      return std::string(write.object) + ": " + std::string(describe(code));
    }
    model.write(write);
  }
  return "";
}

std::string line_of(const Command& command) {
  std::ostringstream text;
  const AbortCode code = expected_answer(command);
  if (code != AbortCode::none) {
    text << "refused 0x" << std::hex << std::setw(8) << std::setfill('0')
         << static_cast<std::uint32_t>(code) << std::dec << ' ';
  }
  text << "write 1.1 " << command.object << ' ';
  if (std::string_view(command.object) == "ds402_controlword") text << "0x" << std::hex;
  text << command.value << '\n';
  return text.str();
}

/// The ticks [first, last); consecutive ticks with the same statusword share a line.
void print_ticks(std::ostream& text, const std::vector<ExpectedTick>& ticks, std::size_t first,
                 std::size_t last) {
  for (std::size_t i = first; i < last;) {
    std::size_t end = i + 1;
    while (end < last && ticks[end].statusword == ticks[i].statusword) ++end;
    text << "wait 1ms\nexpect 1.1 0x6041 0x" << std::hex << ticks[i].statusword << std::dec;
    if (end - i > 1) text << " --throughout " << end - i - 1 << "ms";
    text << '\n';
    i = end;
  }
  if (last > first) {
    const ExpectedTick& end = ticks[last - 1];
    text << "expect 1.1 0x6061 " << end.mode << "\nexpect 1.1 0x6062 " << end.demand
         << "\nexpect 1.1 0x606B " << end.demand_velocity << '\n';
  }
}

}  // namespace

AxisConfiguration whole_units_axis() {
  AxisConfiguration axis;
  axis.model.encoder_resolution = 4096.0;
  axis.model.load_encoder_resolution = 4096.0;
  for (const char* const option : {"quick_stop_option_code", "shutdown_option_code",
                                   "disable_operation_option_code", "fault_reaction_option_code"}) {
    axis.parameters.push_back({AxisUnderTest::address_of(option), 0});
  }
  return axis;
}

AbortCode expected_answer(const Command& command) {
  const bool mode = std::string_view(command.object) == "op_mode_cmd";
  return mode && command.value != 0 && command.value != 1 ? AbortCode::value_range_exceeded
                                                          : AbortCode::none;
}

SideBySide run_side_by_side(const std::vector<Step>& steps) {
  SideBySide result;
  AxisUnderTest axis(whole_units_axis());
  Model model(axis, result.occurred);
  for (const Step& step : steps) {
    result.difference = write_both(axis, model, step.writes);
    for (std::uint32_t i = 0; i < step.ticks && result.difference.empty(); ++i) {
      model.begin_tick();
      axis.step();
      model.end_tick();
      result.ticks.push_back(model.expected());
      result.difference = difference(axis, model);
    }
    if (!result.difference.empty()) {
      result.difference = "tick " + std::to_string(axis.ticks()) + ": " + result.difference;
      break;
    }
  }
  return result;
}

std::string scenario_of(const std::vector<Step>& steps, const std::vector<ExpectedTick>& ticks) {
  std::ostringstream text;
  text << "# vdrived --clock lockstep --config tests/data/whole_units.yaml\n";
  std::size_t first = 0;
  for (const Step& step : steps) {
    for (const Command& write : step.writes) text << line_of(write);
    const std::size_t last = std::min(first + step.ticks, ticks.size());
    print_ticks(text, ticks, first, last);
    if (last == ticks.size() && last < first + step.ticks) {
      break;  // the difference
    }
    first = last;
  }
  return text.str();
}

std::ostream& operator<<(std::ostream& out, const Step& step) {
  out << '\n';
  for (const Command& write : step.writes) out << line_of(write);
  return out << "wait " << step.ticks << "ms";
}

}  // namespace vdrive::test
