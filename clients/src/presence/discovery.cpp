// SPDX-License-Identifier: Apache-2.0
#include "presence/discovery.hpp"

#include "vdrive/number_text.hpp"
#include "vdrive/quantity.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/guard.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <span>
#include <string>
#include <utility>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// A search compares its deadline at least this often.
constexpr milliseconds kSearchPeriod{20};

// A service that had no room for this participant reads its announcement again after a change.
constexpr milliseconds kAnnounceAgain{1'000};

// A program that others have removed has to be found again before it receives anything. The others
// count from its last datagram, some 0.1 s before its pause begins; finding it takes some 0.1 s,
// too, longer on a busy machine.
constexpr milliseconds kForgottenAfter = wire::kPatienceWithVdrive - milliseconds{500};
constexpr milliseconds kTimeToBeFoundAgain{500};

/// @return the number of the bench whose service has a participant of this name; nothing for every
///         other participant.
std::optional<std::uint32_t> bench_of_service(std::string_view name) {
  constexpr std::string_view kService = "vdrived ";
  if (!name.starts_with(kService)) return std::nullopt;
  return parse_digits<std::uint32_t>(name.substr(kService.size()));
}

/// @return the texts, with `mark` in front of each.
std::string marked(std::string_view mark, std::span<const std::string> texts) {
  std::string all;
  for (const std::string& text : texts) all.append(mark).append(text);
  return all;
}

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
          }) {
  if (participant_.knows_who_is_there()) return;  // no age of a sample judges a bench
  pulse_.start([this] {
    const std::scoped_lock lock(mutex_);
    static_cast<void>(running_time());
    return OwnPauses::kPeriod;
  });
}

Discovery::Clock::time_point Discovery::running_time() const {
  const auto now = Clock::now();
  if (participant_.knows_who_is_there()) return now;
  const auto pause = own_pauses_.note(now);
  if (pause != Clock::duration::zero()) {
    directory_.discount(pause);
    if (pause >= kForgottenAfter) directory_.excuse_silence_until(now + kTimeToBeFoundAgain);
  }
  return now;
}

Discovery::Clock::time_point Discovery::time_of_judgement(
    std::optional<std::uint32_t> bench) const {
  const auto now = running_time();
  if (participant_.knows_who_is_there()) {
    directory_.confirm(now, bench, [this](const wire::Source& source) {
      return participant_.has(source);
    });
  }
  return now;
}

Outcome Discovery::check_process() const {
  return origin_.is_inherited() ? Outcome::lost(origin_.problem("the session")) : Outcome();
}

// ---- waiting for a bench ---------------------------------------------------------------------

template <typename Condition>
void Discovery::search(std::optional<std::uint32_t> number, const Condition& condition) {
  const auto begin = Clock::now();
  SearchTime time(begin, options_.find_timeout);
  auto announce_at = begin + kAnnounceAgain;
  while (true) {
    // Before the look: a sample that arrives after it ends the wait at once.
    const std::uint64_t changes = wakeup_.changes();
    const Sight sight = look(number);
    const bool has_found = condition(sight);
    {
      const std::scoped_lock lock(mutex_);
      seen_ = text_of(sight, time.delay());
    }
    const auto now = Clock::now();
    const auto end = time.end(sight.present == 0 && sight.undescribed != 0);
    if (has_found || sight.is_complete || wakeup_.is_interrupted() || now >= end) return;
    if (now >= announce_at) {
      announce_at = now + kAnnounceAgain;
      participant_.announce_again();
      continue;
    }
    const auto planned = std::min(end, now + kSearchPeriod);
    wakeup_.wait_until(changes, planned);
    time.note_wait(planned, Clock::now());
  }
}

/// @param number of the only bench that is looked for
Sight Discovery::look(std::optional<std::uint32_t> number) const {
  const std::vector<wire::OtherParticipant> others = participant_.others();
  Sight sight{.participants = others.size()};
  const std::scoped_lock lock(mutex_);
  const auto now = time_of_judgement(number);
  sight.present = number ? (directory_.find(*number, now) ? 1 : 0) : directory_.count_present(now);
  for (const wire::OtherParticipant& other : others) {
    const auto bench = bench_of_service(other.name);
    if (!bench || (number && *bench != *number)) continue;
    if (other.is_closed != participant_.is_closed()) {
      ++sight.unreachable;
      continue;
    }
    ++sight.services;
    if (!directory_.has_shown_itself(other.source, now)) ++sight.undescribed;
  }
  sight.is_complete = participant_.knows_who_is_there() && sight.undescribed == 0;
  return sight;
}

std::vector<PresentBench> Discovery::find_benches() {
  if (origin_.is_inherited()) return {};
  Settling settling(Clock::now());
  std::optional<std::vector<PresentBench>> found;
  search(options_.bench, [&](const Sight& sight) {
    if (!settling.has_ended(sight, Clock::now())) return false;
    found = present();
    return true;
  });
  return found ? std::move(*found) : present();
}

Outcome Discovery::no_bench_found() const {
  if (Outcome here = check_process(); !here) return here;
  const std::string what = options_.bench
                               ? "bench " + std::to_string(*options_.bench) + " was not found"
                               : "no bench was found";
  const std::string others = others_announced();
  if (!others.empty()) return Outcome::not_found(what + place() + ", " + others + seen());
  return Outcome::not_found(what + place() + interfaces() + seen() + advice());
}

/// By the participants of their services, which come before the descriptions.
std::set<std::uint32_t> Discovery::announced_benches() const {
  std::set<std::uint32_t> numbers;
  for (const wire::OtherParticipant& other : participant_.others()) {
    if (other.is_closed != participant_.is_closed()) continue;
    if (const auto bench = bench_of_service(other.name)) numbers.insert(*bench);
  }
  return numbers;
}

/// A session that finds one bench only takes no description of another one. Where it is known who
/// is there, a bench that has not described itself yet is there, too.
std::string Discovery::others_announced() const {
  if (!options_.bench && !knows_who_is_there()) return {};
  std::set<std::uint32_t> numbers = announced_benches();
  if (options_.bench) numbers.erase(*options_.bench);
  std::string text;
  for (const std::uint32_t number : numbers) {
    text += (text.empty() ? "" : ", ") + std::to_string(number);
  }
  if (text.empty()) return {};
  return (numbers.size() == 1 ? "found bench " : "found benches ") + text;
}

std::string Discovery::what_is_there() const {
  const std::vector<PresentBench> benches = present();
  const bool are_all = !knows_who_is_there() || benches.size() == announced_benches().size();
  if (!benches.empty() && are_all) return ", " + list_of(benches) + seen();
  const std::string others = others_announced();
  if (!others.empty()) return ", " + others + seen();
  return interfaces() + ", " + list_of(benches) + seen() + advice();
}

std::string Discovery::place() const {
  return " " + participant_.place();
}

/// @return through which interfaces this session looks, which matters where it sees nothing.
std::string Discovery::interfaces() const {
  if (knows_who_is_there()) return {};
  return options_.interfaces.empty() ? ", loopback only"
                                     : ", interfaces" + marked(" ", options_.interfaces);
}

/// @return the next step of a person whose session found no bench; nothing where all that there is
///         was seen.
std::string Discovery::advice() const {
  if (knows_who_is_there()) return {};
  return "; next step: vdrive --domain " + std::to_string(participant_.domain()) +
         marked(" --interface ", options_.interfaces) + " doctor";
}

std::string Discovery::seen() const {
  const std::scoped_lock lock(mutex_);
  return " (" + seen_ + ")";
}

Result<PresentBench> Discovery::find_bench(std::optional<std::uint32_t> number) {
  if (Outcome here = check_process(); !here) return here;
  if (!number && !options_.bench) {
    std::vector<PresentBench> benches = find_benches();
    if (benches.size() == 1) return std::move(benches.front());
    if (benches.empty()) return not_found(std::nullopt, no_bench_found().message());
    return Outcome::not_found("several benches, name one: " + list_of(benches) + place());
  }
  if (number && !sees(*number)) {
    return Outcome::not_found("no bench " + std::to_string(*number) +
                              ", this session finds bench " + std::to_string(*options_.bench) +
                              " only");
  }
  const std::uint32_t wanted = number.value_or(options_.bench.value_or(0));
  std::optional<PresentBench> found;
  const auto find = [&] {
    const std::scoped_lock lock(mutex_);
    found = directory_.find(wanted, time_of_judgement(wanted));
    return found.has_value();
  };
  // First without a search: most calls are for a bench that is there.
  if (!find()) {
    search(wanted, [&](const Sight& /*sight*/) {
      return find();
    });
  }
  if (found) return std::move(*found);
  return not_found(wanted, "no bench " + std::to_string(wanted) + place() + what_is_there());
}

Outcome Discovery::not_found(std::optional<std::uint32_t> bench, std::string text) const {
  const std::scoped_lock lock(mutex_);
  if (!bench) bench = directory_.ended_bench();
  if (!bench || !directory_.is_offline(directory_.newest_run(*bench))) {
    return Outcome::not_found(std::move(text));
  }
  return lost_in_silence({.key = directory_.newest_run(*bench)}, time_of_judgement(*bench),
                         patience());
}

/// The name of an axis does not begin with a digit: what begins so is an address.
Result<AxisInfo> Discovery::find_axis(std::string_view text) {
  if (Outcome here = check_process(); !here) return here;
  const std::size_t dot = std::min(text.find('.'), text.size());
  const auto bench = parse_digits<std::uint32_t>(text.substr(0, dot));
  return bench && dot < text.size() ? find_on_bench(*bench, text.substr(dot + 1)) : find_name(text);
}

/// @param axis its number or its name
Result<AxisInfo> Discovery::find_on_bench(std::uint32_t bench, std::string_view axis) {
  const std::string what = "no axis " + std::to_string(bench) + "." + escaped(axis);
  const auto found = find_bench(bench);
  if (!found) return found.outcome().with_prefix(what + ": ");
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
  Settling settling(Clock::now());
  std::vector<PresentBench> benches;
  std::vector<AxisInfo> matches;
  search(options_.bench, [&](const Sight& sight) {
    benches = present();
    matches = axes_named(name, benches);
    return settling.has_ended(sight, Clock::now()) || (!matches.empty() && !expects_more());
  });
  if (matches.size() == 1) return std::move(matches.front());
  if (matches.empty()) {
    std::vector<std::string> names;
    for (const PresentBench& bench : benches) {
      for (const AxisInfo& axis : bench.info.axes) names.push_back(axis.name);
    }
    const std::string text =
        "no axis is named " + in_quotes(name) + suggestion(name, names) + place();
    if (!benches.empty()) return Outcome::not_found(text + ", " + list_of(benches));
    return not_found(std::nullopt, text + what_is_there());
  }
  return Outcome::not_found("several axes are named " + in_quotes(name) + ": " +
                            to_string(matches[0].id) + ", " + to_string(matches[1].id));
}

/// A session that sees one bench only expects no other.
bool Discovery::expects_more() const {
  if (options_.bench) return false;
  const std::size_t matched = description_subscription_.matched();
  const std::scoped_lock lock(mutex_);
  return matched > directory_.described() || directory_.expects_more(time_of_judgement());
}

// ---- what arrives ----------------------------------------------------------------------------

bool Discovery::sees(std::uint32_t bench) const {
  return !options_.bench || bench == *options_.bench;
}

void Discovery::on_description(const msg::BenchDescription& message, const wire::Source& source) {
  if (!sees(message.bench())) return;
  {
    const std::scoped_lock lock(mutex_);
    directory_.on_description(message, source, running_time());
  }
  // Without the lock: a woken condition takes it.
  wakeup_.notify();
}

void Discovery::on_state(const msg::BenchState& message, const wire::Source& source) {
  if (!sees(message.bench())) return;
  {
    const std::scoped_lock lock(mutex_);
    directory_.on_state(message, running_time());
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
  directory_.note_sample(key, tick, running_time());
  directory_.note_sender(key, source);
}

void Discovery::note_frame(const BenchKey& key, const RunTime& time, const wire::Source& source) {
  const std::scoped_lock lock(mutex_);
  directory_.note_sample(key, time.tick, running_time());
  directory_.note_time(key, time);
  directory_.note_sender(key, source);
}

void Discovery::set_rate(const BenchKey& key, double rate) {
  const std::scoped_lock lock(mutex_);
  directory_.set_rate(key, rate);
}

// ---- questions -------------------------------------------------------------------------------

std::vector<PresentBench> Discovery::present() const {
  if (origin_.is_inherited()) return {};
  const std::scoped_lock lock(mutex_);
  return directory_.present(time_of_judgement());
}

std::optional<wire::Source> Discovery::source_of(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  return directory_.source_of(key);
}

bool Discovery::is_alive(const BenchKey& key, milliseconds patience) const {
  const std::scoped_lock lock(mutex_);
  return directory_.is_alive(key, patience, time_of_judgement(key.number));
}

Outcome Discovery::check_presence(const Target& target) const {
  const std::scoped_lock lock(mutex_);
  const auto now = time_of_judgement(target.key.number);
  // First: of a service that was restarted at once, samples of the old run are still young.
  if (directory_.is_restarted(target.key, now)) return Outcome::lost(restarted_text(target));
  if (directory_.is_alive(target.key, options_.silence, now)) return {};
  return lost_in_silence(target, now, options_.silence);
}

Outcome Discovery::check_last_run(std::uint32_t bench) const {
  BenchKey key;
  {
    const std::scoped_lock lock(mutex_);
    key = directory_.newest_run(bench);
  }
  return check_presence({.key = key});
}

Outcome Discovery::check_samples(const Target& target, Silence silence) const {
  const std::scoped_lock lock(mutex_);
  const auto now = time_of_judgement(target.key.number);
  // First: samples that have arrived count, whatever has begun since.
  if (directory_.is_alive(target.key, options_.silence, now)) return {};
  if (directory_.is_restarted(target.key, now)) return Outcome::lost(restarted_text(target));
  const auto limit = silence == Silence::is_bridged ? patience() : options_.silence;
  return directory_.is_alive(target.key, limit, now) ? Outcome()
                                                     : lost_in_silence(target, now, limit);
}

/// With the lock.
Outcome Discovery::lost_in_silence(const Target& target, Clock::time_point now,
                                   milliseconds limit) const {
  if (directory_.is_offline(target.key)) {
    return Outcome::lost(name_of(target) + " went offline: its service has ended");
  }
  std::string text = name_of(target) + " stopped sending or ended";
  if (const auto age = directory_.age(target.key, now)) {
    text += ": its newest sample is " + std::to_string(age->count()) + " ms old, the limit is " +
            std::to_string(limit.count()) + " ms";
  }
  return Outcome::lost(std::move(text));
}

std::optional<Target> Discovery::present_target(std::uint32_t bench) const {
  const std::scoped_lock lock(mutex_);
  const auto present = directory_.find_without_axes(bench, time_of_judgement(bench));
  return present ? std::optional(target_of(*present)) : std::nullopt;
}

bool Discovery::may_be_there(std::uint32_t bench) const {
  return !knows_who_is_there() || announced_benches().contains(bench);
}

Outcome Discovery::loss_of(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  const BenchKey run = key.incarnation == 0 ? directory_.newest_run(key.number) : key;
  return lost_in_silence({.key = run}, time_of_judgement(key.number), patience());
}

Discovery::Clock::duration Discovery::own_pauses() const {
  const std::scoped_lock lock(mutex_);
  return own_pauses_.total();
}

bool Discovery::is_paused(const BenchKey& key, Clock::time_point since) const {
  const std::scoped_lock lock(mutex_);
  return directory_.is_paused(key, since);
}

Unit Discovery::unit_of(const AxisId& axis) const {
  const std::scoped_lock lock(mutex_);
  return directory_.unit_of(axis).value_or(user_unit());
}

std::uint32_t Discovery::steppers(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  return directory_.steppers(key);
}

std::uint64_t Discovery::slowest_stepper(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  return directory_.slowest_stepper(key);
}

std::uint64_t Discovery::tick(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  return directory_.tick(key);
}

std::optional<std::uint64_t> Discovery::driven_tick(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  return directory_.driven_tick(key);
}

std::vector<ServiceChange> Discovery::changes(ServiceWatch& watch) const {
  const std::scoped_lock lock(mutex_);
  return watch.changes(directory_, time_of_judgement());
}

}  // namespace vdrive::client
