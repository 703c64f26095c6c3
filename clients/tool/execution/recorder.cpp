// SPDX-License-Identifier: Apache-2.0
#include "execution/recorder.hpp"

#include "convert.hpp"
#include "text_recording.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/wording.hpp"

#include <chrono>
#include <map>
#include <memory>
#include <set>
#include <string_view>
#include <thread>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;
using recording::RecordingError;
using Clock = std::chrono::steady_clock;

/// Short if several benches take turns: one that stands still must not delay the others for long.
constexpr std::chrono::milliseconds kPatienceOfOne{100};
constexpr std::chrono::milliseconds kPatienceOfMany{5};

// Far below the seconds of samples that the stream buffers.
constexpr std::chrono::milliseconds kNap{5};

std::vector<ObjectAddress> all_objects() {
  std::vector<ObjectAddress> objects;
  objects.reserve(kObjectTable.size());
  for (const ObjectDescription& object : kObjectTable) objects.push_back(object.address);
  return objects;
}

std::vector<client::AxisId> ids_of(const ObservedBench& bench) {
  std::vector<client::AxisId> ids;
  ids.reserve(bench.axes.size());
  for (const client::Axis& axis : bench.axes) ids.push_back(axis.id());
  return ids;
}

/// Every object of an axis; a refused one with its code.
client::Result<bridge::ParameterImage> image_of(const client::Axis& axis) {
  static const std::vector<ObjectAddress> objects = all_objects();
  auto readings = axis.read(objects);
  if (!readings) return readings.outcome();
  return bridge::ParameterImage{
      .axis = axis.id(), .tick = readings->tick, .objects = std::move(readings->objects)};
}

/// Prints lines of a recording on standard output.
class TerminalOutput final : public recording::Output {
 public:
  explicit TerminalOutput(Terminal& terminal) : terminal_(terminal) {}

  void write(std::string_view lines) override {
    terminal_.print(lines.substr(0, lines.size() - 1));
  }

 private:
  Terminal& terminal_;
};

}  // namespace

/// The state of one bench during the recording.
struct Recorder::Track {
  Track(std::uint32_t number, client::Follower stream, std::chrono::milliseconds wait)
      : bench(number), follower(std::move(stream)), patience(wait) {}

  std::uint32_t bench = 0;
  client::Follower follower;
  std::chrono::milliseconds patience;
  std::uint64_t ticks = 0;                  ///< to record; 0 = no limit
  std::optional<std::uint64_t> first_tick;  ///< not counting skipped ticks
  std::uint64_t samples = 0;
  bool has_ended = false;
  std::optional<Clock::time_point> silent_since;  ///< none while the bench sends
};

Recorder::Recorder(client::Session& session, Terminal& terminal, const RecordingChoice& choice)
    : session_(session), terminal_(terminal), choice_(choice) {}

std::string Recorder::progress() const {
  constexpr double kPercent = 100.0;
  std::string text = "recorded " + counted(taken_, "sample", "samples");
  const double share = share_;
  if (share > 0.0) text += ", " + std::to_string(static_cast<int>(share * kPercent)) + " %";
  return text;
}

std::unique_ptr<recording::Writer> Recorder::open() {
  if (choice_.file != "-") return recording::open_recording(choice_.file, VDRIVE_VERSION);
  return std::make_unique<recording::TextRecording>(std::make_unique<TerminalOutput>(terminal_),
                                                    choice_.format);
}

Outcome Recorder::record(const std::vector<ObservedBench>& benches) {
  try {
    auto writer = open();
    // Before the stream is opened: reading a thousand axes takes a while, longer than the stream
    // buffers.
    client::Result<std::vector<bridge::ParameterImage>> images =
        std::vector<bridge::ParameterImage>{};
    if (choice_.format == recording::Format::mcap) images = read_parameters(benches);
    if (!images) return images.outcome();
    auto tracks = open_tracks(benches);
    if (!tracks) return tracks.outcome();
    std::vector<recording::RecordedBench> recorded;
    recorded.reserve(benches.size());
    for (const ObservedBench& bench : benches) {
      recorded.push_back(recording::describe(bench.info, ids_of(bench)));
    }
    has_begun_ = true;
    writer->begin(recorded);
    for (const bridge::ParameterImage& image : *images) writer->parameters(image);
    return record_into(std::move(writer), benches, *tracks);
  } catch (const RecordingError& error) {
    has_begun_ = false;
    // After an interrupt the exit code is reported without the message, so it is printed here.
    if (session_.is_interrupted()) terminal_.print_error(std::string("vdrive: ") + error.what());
    return Outcome::failed(error.what());
  }
}

client::Result<std::vector<bridge::ParameterImage>> Recorder::read_parameters(
    const std::vector<ObservedBench>& benches) {
  std::vector<bridge::ParameterImage> images;
  for (const ObservedBench& bench : benches) {
    images.reserve(images.size() + bench.axes.size());
    for (const client::Axis& axis : bench.axes) {
      auto image = image_of(axis);
      if (!image) return image.outcome();
      images.push_back(std::move(*image));
    }
  }
  return images;
}

client::Result<std::vector<Recorder::Track>> Recorder::open_tracks(
    const std::vector<ObservedBench>& benches) {
  std::vector<Track> tracks;
  tracks.reserve(benches.size());
  for (const ObservedBench& bench : benches) {
    auto follower = session_.follow(ids_of(bench), client::Pace::observe);
    if (!follower) return follower.outcome();
    Track track{bench.info.number, std::move(*follower),
                benches.size() == 1 ? kPatienceOfOne : kPatienceOfMany};
    if (choice_.duration) track.ticks = client::ticks_of(*choice_.duration, bench.info.period);
    tracks.push_back(std::move(track));
  }
  return tracks;
}

/// Always writes the end of the recording, unless the file cannot be written.
Outcome Recorder::record_into(std::unique_ptr<recording::Writer> writer,
                              const std::vector<ObservedBench>& benches,
                              std::vector<Track>& tracks) {
  queue_ = std::make_unique<recording::RecordingQueue>(std::move(writer));
  if (choice_.format == recording::Format::mcap) watch_events(benches);
  watch_services();
  const bool has_end = choice_.duration || choice_.count != 0;
  if (!has_end && terminal_.is_read_by_person()) {
    terminal_.print_error("vdrive: recording; Ctrl-C ends it");
  }
  Outcome outcome = follow(tracks);
  session_.watch_services(nullptr);
  session_.on_event(nullptr);
  summary_ = queue_->finish();
  return outcome;
}

void Recorder::watch_events(const std::vector<ObservedBench>& benches) {
  std::set<client::AxisId> chosen;
  for (const ObservedBench& bench : benches) {
    chosen.insert({bench.info.number, 0});  // events of the bench itself
    for (const client::Axis& axis : bench.axes) chosen.insert(axis.id());
  }
  session_.on_event([this, chosen](const client::Event& event) {
    if (chosen.contains({event.bench, event.axis})) queue_->push(event);
  });
}

void Recorder::watch_services() {
  session_.watch_services([this](const client::ServiceChange& change) {
    const std::scoped_lock lock(ended_mutex_);
    silent_since_.erase(change.bench);
    if (change.news == client::ServiceNews::fell_silent) {
      silent_since_[change.bench] = Clock::now() - change.silence;
    }
    if (change.news == client::ServiceNews::restarted ||
        change.news == client::ServiceNews::went_offline) {
      ended_[change.bench] = change.text;
    }
  });
}

Outcome Recorder::follow(std::vector<Track>& tracks) {
  bool goes_on = true;
  while (goes_on && terminal_.is_open()) {
    goes_on = false;
    for (Track& track : tracks) {
      if (Outcome seen = take_samples(track); !seen) return seen;
      goes_on = goes_on || !track.has_ended;
    }
    std::string failure = queue_->failure();
    if (!failure.empty()) return Outcome::failed(std::move(failure));
    // Waking for each frame costs a tenth of a core at 1,024 axes; the stream buffers seconds.
    if (goes_on) std::this_thread::sleep_for(kNap);
  }
  return {};
}

/// Waits for the next sample of a bench, and takes all that have arrived.
Outcome Recorder::take_samples(Track& track) {
  // Limited, because a bench that sends faster than it is read must not delay the others or the
  // end.
  constexpr int kMostAtOnce = 1000;
  auto patience = track.patience;
  for (int i = 0; i < kMostAtOnce && !track.has_ended; ++i) {
    auto sample = track.follower.next(patience);
    if (sample.outcome().kind() == OutcomeKind::timed_out) {
      return is_silent(track.bench) ? wait_for(track) : Outcome();
    }
    if (sample.outcome().kind() == OutcomeKind::lost) return wait_for(track);
    if (!sample) return sample.outcome();
    if (track.silent_since) {
      track.silent_since.reset();
      terminal_.print_error("vdrive: bench " + std::to_string(track.bench) + " sends again");
    }
    take(track, std::move(*sample));
    patience = std::chrono::milliseconds(0);
  }
  return {};
}

/// The follower bridges a silence without reporting it, but the user should know.
bool Recorder::is_silent(std::uint32_t bench) {
  const std::scoped_lock lock(ended_mutex_);
  const auto since = silent_since_.find(bench);
  return since != silent_since_.end() &&
         Clock::now() - since->second >= client::SessionOptions().silence;
}

/// Waits, because the bench may send again: perhaps the network is down, or the service hangs.
Outcome Recorder::wait_for(Track& track) {
  const std::string bench = "bench " + std::to_string(track.bench);
  {
    const std::scoped_lock lock(ended_mutex_);
    if (const auto ended = ended_.find(track.bench); ended != ended_.end()) {
      return Outcome::lost("the recording ends: " + ended->second);
    }
  }
  const auto seconds = to_text(std::chrono::duration<double>(choice_.lost_after).count()) + " s";
  const Clock::time_point now = Clock::now();
  if (!track.silent_since) {
    track.silent_since = now;
    terminal_.print_error("vdrive: " + bench + " sends nothing: waiting " + seconds + " for it");
  }
  if (now - *track.silent_since < choice_.lost_after) return {};
  return Outcome::lost("the recording ends: " + bench + " has sent nothing for " + seconds);
}

void Recorder::take(Track& track, client::Observation&& sample) {
  // Drive time that was skipped does not count.
  ensure(!sample.axes.empty(), "an observation has the axes that are followed");
  const std::uint64_t tick = sample.axes.front().driven_tick();
  if (!track.first_tick) track.first_tick = tick;
  if (track.ticks != 0 && tick - *track.first_tick >= track.ticks) {
    track.has_ended = true;
    return;
  }
  queue_->push(std::move(sample));
  ++track.samples;
  ++taken_;
  if (track.ticks != 0) {
    share_ = static_cast<double>(tick - *track.first_tick) / static_cast<double>(track.ticks);
  } else if (choice_.count != 0) {
    share_ = static_cast<double>(track.samples) / static_cast<double>(choice_.count);
  }
  track.has_ended = track.samples == choice_.count;
}

}  // namespace vdrive::tool
