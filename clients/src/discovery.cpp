// SPDX-License-Identifier: Apache-2.0
#include "discovery.hpp"

#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// After this without a further bench, all benches that are there have been found. A busy machine
// or a slow network took long for the first sign of a bench already: there a search waits this many
// times as long as for that.
constexpr milliseconds kSettle{150};
constexpr int kSettleTimes = 4;

// A search compares its deadline at least this often.
constexpr milliseconds kSearchPeriod{20};

// A service that had no room for this participant reads its announcement again after a change.
constexpr milliseconds kAnnounceAgain{1'000};

/// What a search knows at one time.
struct Found {
  std::size_t present = 0;   ///< benches that have described themselves and live
  std::size_t services = 0;  ///< participants of services: known some 100 ms before their benches
};

/// Some bench is there, and for a while no further one has come: no participant of a service, where
/// each has shown its bench, else no bench.
class Settling {
 public:
  bool has_ended(const Found& found) {
    const auto now = Discovery::Clock::now();
    services_.note(found.services, now);
    benches_.note(found.present, now);
    return found.present != 0 && (benches_.has_ended(now) ||
                                  (found.services == found.present && services_.has_ended(now)));
  }

 private:
  /// A number that changes while more are found.
  class Count {
   public:
    void note(std::size_t count, Discovery::Clock::time_point now) {
      if (count == count_) return;
      if (count_ == 0) {
        settle_ = std::max<Discovery::Clock::duration>(kSettle, kSettleTimes * (now - begin_));
      }
      count_ = count;
      end_ = now + settle_;
    }

    [[nodiscard]] bool has_ended(Discovery::Clock::time_point now) const {
      return count_ != 0 && now >= end_;
    }

   private:
    Discovery::Clock::time_point begin_ = Discovery::Clock::now();
    Discovery::Clock::duration settle_{};
    std::size_t count_ = 0;
    Discovery::Clock::time_point end_ = Discovery::Clock::time_point::max();
  };

  Count services_;
  Count benches_;
};

std::string list_of(std::span<const PresentBench> benches) {
  if (benches.empty()) return "no bench was found";
  std::string text = "found";
  for (const PresentBench& bench : benches) {
    text += text == "found" ? " " : ", ";
    text += "bench " + std::to_string(bench.info.number) + " " + in_quotes(bench.info.name) +
            " with " + counted(bench.info.axes.size(), "axis", "axes");
  }
  return text;
}

std::vector<AxisInfo> axes_named(std::string_view name, std::span<const PresentBench> benches) {
  std::vector<AxisInfo> axes;
  for (const PresentBench& bench : benches) {
    std::ranges::copy_if(bench.info.axes, std::back_inserter(axes), [&](const AxisInfo& axis) {
      return axis.name == name;
    });
  }
  return axes;
}

}  // namespace

Discovery::Discovery(wire::Participant& participant, SessionOptions options, Wakeup& wakeup)
    : participant_(participant),
      options_(std::move(options)),
      wakeup_(wakeup),
      state_subscription_(participant,
                          [this](const msg::BenchState& message, const wire::Source& source) {
                            on_state(message, source);
                          }),
      description_subscription_(
          participant, [this](const msg::BenchDescription& message, const wire::Source& source) {
            on_description(message, source);
          }) {}

// ---- waiting for a bench ---------------------------------------------------------------------

template <typename Condition>
bool Discovery::wait_to_find(const Condition& condition) {
  const auto begin = Clock::now();
  const auto deadline = begin + options_.find_timeout;
  auto announce_at = begin + kAnnounceAgain;
  while (true) {
    const std::uint64_t changes = wakeup_.changes();
    if (condition()) return true;
    const auto now = Clock::now();
    if (wakeup_.is_interrupted() || now >= deadline) return false;
    if (now >= announce_at) {
      announce_at = now + kAnnounceAgain;
      participant_.announce_again();
      continue;
    }
    wakeup_.wait_until(changes, std::min(deadline, now + kSearchPeriod));
  }
}

std::vector<PresentBench> Discovery::find_benches() {
  Settling settling;
  (void)wait_to_find([&] {
    const std::size_t services = count_services();
    const std::scoped_lock lock(mutex_);
    return settling.has_ended(
        {.present = directory_.count_present(Clock::now()), .services = services});
  });
  return present();
}

Result<PresentBench> Discovery::find_bench(std::optional<std::uint32_t> number) {
  if (!number && !options_.bench) {
    std::vector<PresentBench> benches = find_benches();
    if (benches.size() == 1) return std::move(benches.front());
    return Outcome::not_found((benches.empty() ? "" : "several benches, name one: ") +
                              list_of(benches) + " on domain " + std::to_string(*options_.domain));
  }
  const std::uint32_t wanted = number.value_or(options_.bench.value_or(0));
  std::optional<PresentBench> found;
  (void)wait_to_find([&] {
    const std::scoped_lock lock(mutex_);
    found = directory_.find(wanted, Clock::now());
    return found.has_value();
  });
  if (found) return std::move(*found);
  return Outcome::not_found("no bench " + std::to_string(wanted) + " on domain " +
                            std::to_string(*options_.domain) + ", " + list_of(present()));
}

/// The name of an axis does not begin with a digit: what begins so is an address.
Result<AxisInfo> Discovery::find_axis(std::string_view text) {
  const std::size_t dot = std::min(text.find('.'), text.size());
  const auto bench = parse_digits<std::uint32_t>(text.substr(0, dot));
  return bench && dot < text.size() ? find_on_bench(*bench, text.substr(dot + 1)) : find_name(text);
}

/// @param axis its number or its name
Result<AxisInfo> Discovery::find_on_bench(std::uint32_t bench, std::string_view axis) {
  const std::string what = "no axis " + std::to_string(bench) + "." + escaped(axis);
  const auto found = find_bench(bench);
  if (!found) return Outcome::not_found(what + ": " + found.outcome().message());
  const auto number = parse_digits<std::uint16_t>(axis);
  std::vector<std::string> names;
  for (const AxisInfo& info : found->info.axes) {
    if (number ? info.id.axis == *number : info.name == axis) return info;
    names.push_back(info.name);
  }
  return Outcome::not_found(what + (number ? std::string() : suggestion(axis, names)) + ", " +
                            list_of({&*found, 1}));
}

/// Ends with the bench that has the name, once every bench that was met has described its axes: of
/// two axes with one name none may be commanded by chance.
Result<AxisInfo> Discovery::find_name(std::string_view name) {
  Settling settling;
  std::vector<PresentBench> benches;
  std::vector<AxisInfo> matches;
  (void)wait_to_find([&] {
    benches = present();
    matches = axes_named(name, benches);
    const bool has_settled =
        settling.has_ended({.present = benches.size(), .services = count_services()});
    return has_settled || (!matches.empty() && !expects_more());
  });
  if (matches.size() == 1) return std::move(matches.front());
  if (matches.empty()) {
    std::vector<std::string> names;
    for (const PresentBench& bench : benches) {
      for (const AxisInfo& axis : bench.info.axes) names.push_back(axis.name);
    }
    return Outcome::not_found("no axis is named " + in_quotes(name) + suggestion(name, names) +
                              " on domain " + std::to_string(*options_.domain) + ", " +
                              list_of(benches));
  }
  return Outcome::not_found("several axes are named " + in_quotes(name) + ": " +
                            to_string(matches[0].id) + ", " + to_string(matches[1].id));
}

/// Of a session that sees one bench only, that one.
std::size_t Discovery::count_services() const {
  if (options_.bench) {
    return participant_.count_others("vdrived " + std::to_string(*options_.bench)) == 0 ? 0 : 1;
  }
  return participant_.count_others("vdrived ");
}

/// A session that sees one bench only expects no other.
bool Discovery::expects_more() const {
  if (options_.bench) return false;
  const std::size_t matched = description_subscription_.matched();
  const std::scoped_lock lock(mutex_);
  return matched > directory_.described() || directory_.expects_more(Clock::now());
}

// ---- what arrives ----------------------------------------------------------------------------

bool Discovery::sees(std::uint32_t bench) const {
  return !options_.bench || bench == *options_.bench;
}

void Discovery::on_description(const msg::BenchDescription& message, const wire::Source& source) {
  if (!sees(message.bench())) return;
  {
    const std::scoped_lock lock(mutex_);
    directory_.on_description(message, source, Clock::now());
  }
  wakeup_.notify();
}

void Discovery::on_state(const msg::BenchState& message, const wire::Source& source) {
  if (!sees(message.bench())) return;
  {
    const std::scoped_lock lock(mutex_);
    directory_.on_state(message, Clock::now());
    directory_.note_sender({message.bench(), message.incarnation()}, source);
  }
  wakeup_.notify();
}

void Discovery::note_sender(const BenchKey& key, const wire::Source& source) {
  const std::scoped_lock lock(mutex_);
  directory_.note_sender(key, source);
}

void Discovery::note_sample(const BenchKey& key, std::uint64_t tick, const wire::Source& source) {
  const std::scoped_lock lock(mutex_);
  directory_.note_sample(key, tick, Clock::now());
  directory_.note_sender(key, source);
}

void Discovery::set_rate(const BenchKey& key, double rate) {
  const std::scoped_lock lock(mutex_);
  directory_.set_rate(key, rate);
}

// ---- questions -------------------------------------------------------------------------------

std::vector<PresentBench> Discovery::present() const {
  const std::scoped_lock lock(mutex_);
  return directory_.present(Clock::now());
}

std::optional<wire::Source> Discovery::source_of(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  return directory_.source_of(key);
}

bool Discovery::is_alive(const BenchKey& key, milliseconds patience) const {
  const std::scoped_lock lock(mutex_);
  return directory_.is_alive(key, patience, Clock::now());
}

Outcome Discovery::check_presence(const Target& target) const {
  const std::scoped_lock lock(mutex_);
  const auto now = Clock::now();
  if (directory_.is_restarted(target.key, now)) return Outcome::lost(restarted_text(target));
  if (directory_.is_alive(target.key, options_.silence, now)) return {};
  return Outcome::lost(name_of(target) + " stopped sending or ended");
}

Outcome Discovery::check_samples(const Target& target) const {
  return is_alive(target.key, options_.silence) ? Outcome() : check_presence(target);
}

bool Discovery::is_paused(const BenchKey& key, Clock::time_point since) const {
  const std::scoped_lock lock(mutex_);
  return directory_.is_paused(key, since);
}

std::uint64_t Discovery::slowest_stepper(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  return directory_.slowest_stepper(key);
}

std::uint64_t Discovery::tick(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  return directory_.tick(key);
}

std::vector<ServiceChange> Discovery::changes(ServiceWatch& watch) const {
  const std::scoped_lock lock(mutex_);
  return watch.changes(directory_, Clock::now());
}

}  // namespace vdrive::client
