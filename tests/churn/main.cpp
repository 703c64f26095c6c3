// SPDX-License-Identifier: Apache-2.0
// The programs that tests/churn runs with a bench. They print one JSON object per line on standard
// output; `time` is in seconds of the monotonic clock. A role that does not end on its own ends
// when its standard input is closed.
#include "churn/roles.hpp"

#include <CLI/CLI.hpp>

#include <functional>

namespace vdrive::churn {
namespace {

void add_range(CLI::App& role, AxisRange& range) {
  role.add_option("--first", range.first, "First axis");
  role.add_option("--last", range.last, "Last axis");
}

/// The values of the command line.
struct Arguments {
  Setting setting;
  AxisRange range;
  Visit visit;
  std::uint32_t duration_ms = 200;
  std::uint32_t lead_ms = 10;
  std::uint16_t axis = 1;
  std::uint16_t index = kStampObject.index;
  std::vector<std::string> axes;
  std::function<int()> run;
};

void add_roles(CLI::App& program, Arguments& to) {
  const auto add = [&](const char* name, const char* help, std::function<int()> run) {
    CLI::App* role = program.add_subcommand(name, help);
    role->callback([&to, run = std::move(run)] {
      to.run = run;
    });
    return role;
  };
  add_range(*add("start", "Let axes move for hours",
                 [&to] {
                   return start(to.setting, to.range);
                 }),
            to.range);
  add_range(*add("observe", "Follow all axes; those of the range move all the time",
                 [&to] {
                   return observe(to.setting, to.range);
                 }),
            to.range);
  CLI::App* visitor = add("visit", "Join, command an axis, leave", [&to] {
    to.visit.duration = std::chrono::milliseconds(to.duration_ms);
    return visit(to.setting, to.visit);
  });
  visitor->add_option("--axis", to.visit.axis, "Axis");
  visitor->add_option("--duration", to.duration_ms, "How long it commands [ms]");
  visitor->add_option("--stamp", to.visit.stamp, "Stamps count from here");
  CLI::App* reader = add("read", "Read an object", [&to] {
    return read(to.setting, to.axis, to.index);
  });
  reader->add_option("--axis", to.axis, "Axis");
  reader->add_option("--object", to.index, "Index");
  add_range(*add("motion", "Move axes one by one",
                 [&to] {
                   return motion(to.setting, to.range);
                 }),
            to.range);
  CLI::App* streamer = add("stream", "Stream positions", [&to] {
    return stream(to.setting, to.range, std::chrono::milliseconds(to.lead_ms));
  });
  add_range(*streamer, to.range);
  streamer->add_option("--lead", to.lead_ms, "How far positions go ahead [ms]");
  CLI::App* together = add("group", "Move axes together", [&to] {
    return group(to.setting, to.axes);
  });
  together->add_option("axes", to.axes, "Addresses")->required();
  add_range(*add("store", "Store parameters",
                 [&to] {
                   return store(to.setting, to.range);
                 }),
            to.range);
  add("step", "Step a lock-step bench", [&to] {
    return step(to.setting);
  });
}

int run(int count, char** words) {
  CLI::App program("Roles of tests/churn");
  Arguments arguments;
  // Generous, since a loaded machine is slow, and a hung wire is noticed within 5 s. The actual
  // time is measured.
  arguments.setting.network.find_timeout = std::chrono::seconds(20);
  arguments.setting.network.silence = std::chrono::seconds(10);
  program.add_option("--domain", arguments.setting.network.domain, "DDS domain")->required();
  program.add_option("--bench", arguments.setting.bench, "Number of the bench");
  program.add_option("--security", arguments.setting.network.security, "Closed mode");
  program.require_subcommand(1);
  add_roles(program, arguments);
  CLI11_PARSE(program, count, words);
  return arguments.run();
}

}  // namespace
}  // namespace vdrive::churn

int main(int count, char** words) {
  return vdrive::churn::run(count, words);
}
