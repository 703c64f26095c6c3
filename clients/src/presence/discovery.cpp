// SPDX-License-Identifier: Apache-2.0
#include "presence/discovery.hpp"

#include "vdrive/number_text.hpp"
#include "vdrive/quantity.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <utility>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// A search checks its deadline at least this often.
constexpr milliseconds kSearchPeriod{20};

/// @return the host in a place such as "process 12 on bench-0"; the text is not trusted.
std::string host_of(std::string_view place) {
  constexpr std::string_view kBefore = " on ";
  const auto found = place.find(kBefore);
  return found == std::string_view::npos ? std::string()
                                         : std::string(place.substr(found + kBefore.size()));
}

// A search announces this participant again at this interval: a service that had no room for it
// reads its announcement again only if the announcement changes.
constexpr milliseconds kAnnounceAgain{1'000};

/// @return the number of the bench whose service has a participant of this name; nothing for any
///         other participant.
std::optional<std::uint32_t> bench_of_service(std::string_view name) {
  constexpr std::string_view kService = "vdrived ";
  if (!name.starts_with(kService)) return std::nullopt;
  return parse_digits<std::uint32_t>(name.substr(kService.size()));
}

/// @return the texts, each preceded by `mark`.
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

/// Lists benches by number: a bench that is not described yet has no name.
std::string list_of(const std::map<std::uint32_t, wire::Source>& services) {
  std::string text = services.size() == 1 ? "found bench" : "found benches";
  for (const auto& [bench, source] : services) {
    text += (bench == services.begin()->first ? " " : ", ") + std::to_string(bench);
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
      presence_(participant.presence()),
      options_(std::move(options)),
      wakeup_(wakeup),
      directory_(presence_),
      state_subscription_(participant,
                          [this](const msg::BenchState& message, const wire::Source& source) {
                            on_state(message, source);
                          }),
      description_subscription_(
          participant, [this](const msg::BenchDescription& message, const wire::Source& source) {
            on_description(message, source);
          }) {
  if (!presence_.pulse()) return;
  pulse_.start([this] {
    static_cast<void>(own_pauses());
    return presence_.pulse();
  });
}

Outcome Discovery::check_process() const {
  return origin_.is_inherited() ? Outcome::lost(origin_.problem("the session")) : Outcome();
}

// ---- waiting for a bench ---------------------------------------------------------------------

template <typename Condition>
void Discovery::search(std::optional<std::uint32_t> number, const Condition& condition,
                       const SearchCompletion* completion) {
  const auto begin = Clock::now();
  SearchTime time(begin, options_.find_timeout);
  auto announce_at = begin + kAnnounceAgain;
  while (true) {
    // Read before looking, so that a later sample ends the wait immediately.
    const std::uint64_t changes = wakeup_.changes();
    const SearchFindings findings = look(number);
    const bool has_found = condition(findings);
    {
      const std::scoped_lock lock(mutex_);
      seen_ = text_of(findings, time.delay());
    }
    const auto now = Clock::now();
    const auto end = time.end(findings.present == 0 && findings.undescribed != 0);
    if (has_found || findings.is_complete || wakeup_.is_interrupted() || now >= end) return;
    if (now >= announce_at) {
      announce_at = now + kAnnounceAgain;
      participant_.announce_again();
      continue;
    }
    auto planned = std::min(end, now + kSearchPeriod);
    if (completion != nullptr) planned = std::min(planned, completion->next_end(now));
    wakeup_.wait_until(changes, planned);
    time.note_wait(planned, Clock::now());
  }
}

/// @param number if the search is for one bench only
SearchFindings Discovery::look(std::optional<std::uint32_t> number) const {
  const std::vector<wire::OtherParticipant> others = presence_.others();
  SearchFindings findings{.participants = others.size()};
  const std::scoped_lock lock(mutex_);
  const auto now = this->now();
  findings.present =
      number ? (directory_.find(*number, now) ? 1 : 0) : directory_.count_present(now);
  for (const wire::OtherParticipant& other : others) {
    const auto bench = bench_of_service(other.name);
    if (!bench || (number && *bench != *number)) continue;
    if (other.is_closed != participant_.is_closed()) {
      ++findings.unreachable;
      continue;
    }
    ++findings.services;
    if (!directory_.has_shown_itself(other.source, now)) ++findings.undescribed;
  }
  findings.is_complete = !presence_.may_miss_some() && findings.undescribed == 0;
  return findings;
}

std::vector<PresentBench> Discovery::find_benches() {
  if (origin_.is_inherited()) return {};
  SearchCompletion completion(Clock::now());
  std::optional<std::vector<PresentBench>> found;
  const auto has_found = [&](const SearchFindings& findings) {
    if (!completion.has_ended(findings, Clock::now())) return false;
    found = present();
    return true;
  };
  search(options_.bench, has_found, &completion);
  return found ? std::move(*found) : present();
}

Outcome Discovery::no_bench_found() const {
  if (Outcome here = check_process(); !here) return here;
  const std::string what = options_.bench
                               ? "bench " + std::to_string(*options_.bench) + " was not found"
                               : "no bench was found";
  const Services others = others_announced();
  if (!others.empty()) return Outcome::not_found(what + place() + ", " + list_of(others) + seen());
  return Outcome::not_found(what + place() + with_advice(seen()));
}

std::vector<std::string> Discovery::network_troubles() const {
  if (origin_.is_inherited()) return {};
  return participant_.troubles();
}

/// @return the services that this session can meet. They are known before their benches are
///         described.
Discovery::Services Discovery::services() const {
  Services services;
  for (const wire::OtherParticipant& other : presence_.others()) {
    if (other.is_closed != participant_.is_closed()) continue;
    if (const auto bench = bench_of_service(other.name)) services[*bench] = other.source;
  }
  return services;
}

/// @return the services to name in a message although their benches may not be described yet: if
///         the session is limited to one bench, all other services, whose descriptions it ignores;
///         otherwise those whose presence is certain.
Discovery::Services Discovery::others_announced() const {
  Services others = services();
  std::erase_if(others, [this](const auto& other) {
    const auto& [bench, source] = other;
    return options_.bench ? bench == *options_.bench : !presence_.is_certain(source);
  });
  return others;
}

std::string Discovery::found_text() const {
  const std::vector<PresentBench> benches = present();
  const Services others = others_announced();
  if (!benches.empty() && others.size() <= benches.size()) return ", " + list_of(benches) + seen();
  if (!others.empty()) return ", " + list_of(others) + seen();
  return with_advice(", " + list_of(benches) + seen());
}

std::string Discovery::place() const {
  return " " + participant_.place();
}

/// @return the text followed by the interfaces that this session searches and the user's next step;
///         only the text if the search cannot have missed anything.
std::string Discovery::with_advice(const std::string& text) const {
  if (!presence_.may_miss_some()) return text;
  std::string troubles;
  for (const std::string& trouble : participant_.troubles()) troubles += "; " + trouble;
  const std::string interfaces = options_.interfaces.empty()
                                     ? ", loopback only"
                                     : ", interfaces" + marked(" ", options_.interfaces);
  return interfaces + text + troubles + "; next step: vdrive --domain " +
         std::to_string(participant_.domain()) + marked(" --interface ", options_.interfaces) +
         " doctor";
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
    found = directory_.find(wanted, now());
    return found.has_value();
  };
  // First without a search: most calls are for a bench that is present.
  if (!find()) {
    search(wanted, [&](const SearchFindings& /*findings*/) {
      return find();
    });
  }
  if (found) return std::move(*found);
  return not_found(wanted, "no bench " + std::to_string(wanted) + place() + found_text());
}

Outcome Discovery::not_found(std::optional<std::uint32_t> bench, std::string text) const {
  const std::scoped_lock lock(mutex_);
  if (!bench) bench = directory_.ended_bench();
  if (!bench || !directory_.is_offline(directory_.newest_run(*bench))) {
    return Outcome::not_found(std::move(text));
  }
  return lost_in_silence({.key = directory_.newest_run(*bench)}, now(), patience());
}

/// The name of an axis does not begin with a digit, so text that does is an address.
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

/// Ends once an axis with the name is found and every bench met has described its axes: if two axes
/// share the name, neither may be commanded by accident.
Result<AxisInfo> Discovery::find_name(std::string_view name) {
  SearchCompletion completion(Clock::now());
  std::vector<PresentBench> benches;
  std::vector<AxisInfo> matches;
  const auto has_found = [&](const SearchFindings& findings) {
    benches = present();
    matches = axes_named(name, benches);
    return completion.has_ended(findings, Clock::now()) || (!matches.empty() && !expects_more());
  };
  search(options_.bench, has_found, &completion);
  if (matches.size() == 1) return std::move(matches.front());
  if (matches.empty()) {
    std::vector<std::string> names;
    for (const PresentBench& bench : benches) {
      for (const AxisInfo& axis : bench.info.axes) names.push_back(axis.name);
    }
    const std::string text =
        "no axis is named " + in_quotes(name) + suggestion(name, names) + place();
    if (!benches.empty()) return Outcome::not_found(text + ", " + list_of(benches));
    return not_found(std::nullopt, text + found_text());
  }
  return Outcome::not_found("several axes are named " + in_quotes(name) + ": " +
                            to_string(matches[0].id) + ", " + to_string(matches[1].id));
}

/// A session limited to one bench expects no other.
bool Discovery::expects_more() const {
  if (options_.bench) return false;
  const std::size_t matched = description_subscription_.matched();
  const std::scoped_lock lock(mutex_);
  return matched > directory_.described() || directory_.expects_more(now());
}

// ---- receiving -------------------------------------------------------------------------------

bool Discovery::sees(std::uint32_t bench) const {
  return !options_.bench || bench == *options_.bench;
}

void Discovery::on_description(const msg::BenchDescription& message, const wire::Source& source) {
  if (!sees(message.bench)) return;
  {
    const std::scoped_lock lock(mutex_);
    directory_.on_description(message, source, now());
  }
  // Without the lock: a woken condition takes it.
  wakeup_.notify();
}

void Discovery::on_state(const msg::BenchState& message, const wire::Source& source) {
  if (!sees(message.bench)) return;
  {
    const std::scoped_lock lock(mutex_);
    directory_.on_state(message, now());
    directory_.note_sender({message.bench, message.incarnation}, source);
  }
  wakeup_.notify();
}

void Discovery::note_sender(const BenchKey& key, const wire::Source& source) {
  const std::scoped_lock lock(mutex_);
  directory_.note_sender(key, source);
}

void Discovery::note_sample(const BenchKey& key, std::uint64_t tick, const wire::Source& source) {
  const std::scoped_lock lock(mutex_);
  directory_.note_sample(key, tick, now());
  directory_.note_sender(key, source);
}

void Discovery::note_frame(const BenchKey& key, const RunTime& time, const wire::Source& source) {
  const std::scoped_lock lock(mutex_);
  directory_.note_sample(key, time.tick, now());
  directory_.note_time(key, time);
  directory_.note_sender(key, source);
}

void Discovery::set_rate(const BenchKey& key, double rate) {
  const std::scoped_lock lock(mutex_);
  directory_.set_rate(key, rate);
}

// ---- queries -----------------------------------------------------------------------------------

std::vector<PresentBench> Discovery::present() const {
  if (origin_.is_inherited()) return {};
  const std::vector<wire::OtherParticipant> others = presence_.others();
  const std::scoped_lock lock(mutex_);
  std::vector<PresentBench> present = directory_.present(now());
  for (PresentBench& bench : present) {
    const auto service = std::ranges::find(others, bench.source, &wire::OtherParticipant::source);
    if (service != others.end()) bench.info.host = host_of(service->place);
  }
  return present;
}

std::optional<wire::Source> Discovery::source_of(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  return directory_.source_of(key);
}

bool Discovery::is_alive(const BenchKey& key, milliseconds patience) const {
  const std::scoped_lock lock(mutex_);
  return directory_.is_alive(key, patience, now());
}

Outcome Discovery::check_presence(const Target& target) const {
  const std::scoped_lock lock(mutex_);
  const auto now = this->now();
  // First: if a service was restarted quickly, samples of the old run are still recent.
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
  const auto now = this->now();
  // First: samples that have arrived count, even if another run has started since.
  if (directory_.is_alive(target.key, options_.silence, now)) return {};
  if (directory_.is_restarted(target.key, now)) return Outcome::lost(restarted_text(target));
  const auto limit = silence == Silence::is_bridged ? patience() : options_.silence;
  return directory_.is_alive(target.key, limit, now) ? Outcome()
                                                     : lost_in_silence(target, now, limit);
}

/// Called with the lock held.
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
  const auto present = directory_.find_without_axes(bench, now());
  return present ? std::optional(target_of(*present)) : std::nullopt;
}

std::optional<Target> Discovery::continuation_of(const BenchKey& run) const {
  const std::optional<Target> target = present_target(run.number);
  const bool is_another = target && run.incarnation != 0 && target->key != run;
  return is_another && !presence_.may_return() ? std::nullopt : target;
}

bool Discovery::may_be_there(std::uint32_t bench) const {
  return presence_.may_miss_some() || services().contains(bench);
}

Outcome Discovery::loss_of(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  const BenchKey run = key.incarnation == 0 ? directory_.newest_run(key.number) : key;
  return lost_in_silence({.key = run}, now(), patience());
}

Discovery::Clock::duration Discovery::own_pauses() const {
  const std::scoped_lock lock(mutex_);
  return presence_.own_pauses(Clock::now());
}

Discovery::Clock::time_point Discovery::running_time() const {
  const std::scoped_lock lock(mutex_);
  return now();
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

bool Discovery::may_be_ahead(const BenchKey& key) const {
  const auto source = source_of(key);
  return source && presence_.is_certain(*source);
}

std::optional<std::uint64_t> Discovery::driven_tick(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  return directory_.driven_tick(key);
}

std::vector<ServiceChange> Discovery::changes(ServiceWatch& watch) const {
  const std::scoped_lock lock(mutex_);
  return watch.changes(directory_, now());
}

}  // namespace vdrive::client
