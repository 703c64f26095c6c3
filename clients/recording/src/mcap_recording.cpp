// SPDX-License-Identifier: Apache-2.0
#include "mcap_recording.hpp"

#include "mcap_reader.hpp"
#include "sample_order.hpp"
#include "status_layout.hpp"
#include "topic_names.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace vdrive::recording {
namespace {

// A crash of the program loses the chunk being filled.
constexpr std::size_t kChunk = std::size_t{1} << 20U;  // [bytes]
constexpr std::chrono::seconds kOldest{1};

constexpr std::string_view kBenchRecord = "vdrive.bench";
constexpr std::string_view kGapsRecord = "vdrive.gaps";
constexpr std::string_view kSummaryRecord = "vdrive.summary";
constexpr std::string_view kBenchKey = "bench";
constexpr std::string_view kAxisKey = "axis.";
constexpr std::string_view kUnitKey = "unit.";
constexpr std::string_view kUnitSizeKey = "unit_size.";
constexpr std::string_view kPeriodKey = "period_ns";

std::string gap_key(std::uint32_t bench, std::uint64_t tick) {
  return std::to_string(bench) + ":" + std::to_string(tick);
}

}  // namespace

// ---- writing -----------------------------------------------------------------------------------

McapRecording::McapRecording(std::unique_ptr<Output> output, const std::string& version)
    : file_(std::move(output), "vdrive " + version) {}

void McapRecording::begin(const std::vector<RecordedBench>& benches) {
  axis_status_ = file_.add_schema(bridge::axis_status_schema());
  bench_status_ = file_.add_schema(bridge::bench_status_schema());
  axis_parameters_ = file_.add_schema(bridge::axis_parameters_schema());
  log_ = file_.add_schema(bridge::log_schema());
  for (const RecordedBench& bench : benches) add_bench(bench);
}

void McapRecording::add_bench(const RecordedBench& bench) {
  TextMap facts = bench.facts;
  const std::string number = std::to_string(bench.number);
  facts[std::string(kBenchKey)] = number;
  facts[std::string(kPeriodKey)] = std::to_string(bench.period.count());
  Channels channels{.period = static_cast<std::uint64_t>(bench.period.count()),
                    .topic = bridge::bench_topic(bench.number)};
  for (const RecordedAxis& axis : bench.axes) {
    const std::string axis_number = std::to_string(axis.id.axis);
    facts[std::string(kAxisKey) + axis_number] = axis.name;
    if (axis.unit) {
      facts[std::string(kUnitKey) + axis_number] = axis.unit->name;
      facts[std::string(kUnitSizeKey) + axis_number] = to_text(axis.unit->size);
    }
    channels.names[axis.id.axis] = axis.topic;
  }
  file_.add_metadata(kBenchRecord, facts);

  const std::string root = "/" + channels.topic + "/";
  const TextMap common{{std::string(kBenchKey), number}};
  channels.events = file_.add_channel(root + "events", log_, common);
  if (bench.axes.size() > kMostTopics) {
    channels.status[0] = file_.add_channel(root + "status", bench_status_, common);
    channels.readings[0] = file_.add_channel(root + "parameters", axis_parameters_, common);
  } else {
    for (const RecordedAxis& axis : bench.axes) {
      TextMap own = common;
      own["axis"] = std::to_string(axis.id.axis);
      own["name"] = axis.name;
      const std::string topic = root + axis.topic;
      channels.status[axis.id.axis] = file_.add_channel(topic + "/status", axis_status_, own);
      channels.readings[axis.id.axis] =
          file_.add_channel(topic + "/parameters", axis_parameters_, own);
    }
  }
  benches_[bench.number] = std::move(channels);
}

void McapRecording::status(const client::Observation& sample) {
  if (sample.axes.empty()) return;
  if (file_.pending() == 0) chunk_began_ = Clock::now();
  const std::uint32_t bench = sample.axes.front().id.bench;
  const Channels& channels = benches_.at(bench);
  const std::uint64_t time = sample.tick * channels.period;
  if (sample.missed != 0) gaps_[gap_key(bench, sample.tick)] = std::to_string(sample.missed);
  const auto common = channels.status.find(0);
  if (common != channels.status.end()) {
    file_.add_message(common->second, time, bridge::encode_bench_status(sample, time));
  } else {
    for (const client::AxisSnapshot& axis : sample.axes) {
      file_.add_message(channels.status.at(axis.id.axis), time,
                        bridge::encode_axis_status(axis, time));
    }
  }
  // Only between samples, so that a truncated file contains complete ones.
  if (file_.pending() >= kChunk) end_chunk();
}

void McapRecording::event(const client::Event& event) {
  const auto bench = benches_.find(event.bench);
  if (bench == benches_.end()) return;
  if (file_.pending() == 0) chunk_began_ = Clock::now();
  const Channels& channels = bench->second;
  const auto axis = channels.names.find(event.axis);
  const std::string about =
      axis == channels.names.end() ? channels.topic : channels.topic + "/" + axis->second;
  const std::uint64_t time = event.tick * channels.period;
  file_.add_message(channels.events, time, bridge::encode_event(event, about, time));
}

void McapRecording::parameters(const bridge::ParameterImage& image) {
  if (file_.pending() == 0) chunk_began_ = Clock::now();
  const Channels& channels = benches_.at(image.axis.bench);
  const auto common = channels.readings.find(0);
  const std::uint64_t time = image.tick * channels.period;
  file_.add_message(
      common == channels.readings.end() ? channels.readings.at(image.axis.axis) : common->second,
      time, bridge::encode_axis_parameters(image, time));
  if (file_.pending() >= kChunk) end_chunk();
}

void McapRecording::end_chunk() {
  if (!gaps_.empty()) file_.add_metadata(kGapsRecord, std::exchange(gaps_, {}));
  file_.end_chunk();
}

void McapRecording::flush(Clock::time_point now) {
  if (file_.pending() != 0 && now - chunk_began_ >= kOldest) end_chunk();
}

void McapRecording::finish(const Summary& summary) {
  end_chunk();
  TextMap facts{{"samples", std::to_string(summary.samples)},
                {"lost", std::to_string(summary.gaps.missed().total())},
                {"events", std::to_string(summary.events)},
                {"events_lost", std::to_string(summary.events_lost)},
                {"gaps_left_out", std::to_string(summary.gaps.missed().left_out())},
                {"skipped_ticks", std::to_string(summary.gaps.jumps().total())}};
  std::size_t number = 0;
  for (const Gap& gap : summary.gaps.missed().kept()) {
    facts["gap." + std::to_string(++number)] =
        "bench " + std::to_string(gap.bench) + " after " + std::to_string(gap.after) + " before " +
        std::to_string(gap.before) + " missed " + std::to_string(gap.count);
  }
  number = 0;
  for (const Gap& jump : summary.gaps.jumps().kept()) {
    facts["jump." + std::to_string(++number)] =
        "bench " + std::to_string(jump.bench) + " after " + std::to_string(jump.after) +
        " before " + std::to_string(jump.before) + " skipped " + std::to_string(jump.count);
  }
  file_.add_metadata(kSummaryRecord, facts);
  file_.finish();
}

// ---- reading -----------------------------------------------------------------------------------

namespace {

struct Schema {
  std::string name;
  std::string encoding;
  std::string text;
};

struct StatusChannel {
  std::uint32_t bench = 0;
  std::string name{};  ///< of the axis, if the channel has only one
  std::string topic{};
  const StatusLayout* layout = nullptr;
};

class StatusReader {
 public:
  explicit StatusReader(const SampleHandler& handler) : handler_(handler) {}

  void take(const McapRecord& record) {
    switch (record.opcode) {
      case Opcode::schema:
        if (!is_in_summary_) take_schema(record);
        break;
      case Opcode::channel:
        if (!is_in_summary_) take_channel(record);
        break;
      case Opcode::message:
        take_message(record);
        break;
      case Opcode::metadata:
        take_metadata(record);
        break;
      case Opcode::data_end:
        is_in_summary_ = true;
        break;
      default:
        break;
    }
  }

  /// @param cut where the file is truncated
  Contents finish(std::string cut) {
    if (status_.empty() && cut.empty()) refuse();
    contents_.cut = std::move(cut);
    // A program that records the topics of the gateway may stop between two topics of a tick.
    const std::string shortage = order_.shortage(sample_);
    if (shortage.empty()) end_sample();
    if (contents_.cut.empty()) contents_.cut = shortage;
    contents_.benches.reserve(benches_.size());
    for (auto& [number, bench] : benches_) contents_.benches.push_back(std::move(bench));
    return std::move(contents_);
  }

 private:
  void take_schema(const McapRecord& record) {
    BodyReader body(record.body, where(record));
    const auto id = body.get<std::uint16_t>();
    Schema schema;
    schema.name = body.get_text();
    schema.encoding = body.get_text();
    schema.text = body.get_text();
    schemas_[id] = std::move(schema);
  }

  void take_channel(const McapRecord& record) {
    BodyReader body(record.body, where(record));
    const auto id = body.get<std::uint16_t>();
    const auto schema_id = body.get<std::uint16_t>();
    StatusChannel channel{.topic = std::string(body.get_text())};
    const std::string encoding(body.get_text());
    const TextMap metadata = body.get_map();
    topics_.insert(channel.topic);
    known_.insert(id);
    const auto schema = schemas_.find(schema_id);
    if (schema == schemas_.end()) return;
    const std::string& name = schema->second.name;
    if (name == log_) logs_.insert(id);
    if (name == parameters_) readings_.insert(id);
    if (name != axis_status_ && name != bench_status_) return;
    if (encoding != "cdr" || schema->second.encoding != "ros2msg") {
      throw RecordingError("the topic " + in_quotes(channel.topic) + " is encoded as " +
                           in_quotes(encoding) + " with a schema of " +
                           in_quotes(schema->second.encoding) +
                           "; only cdr with ros2msg is supported");
    }
    channel.bench = bench_of(channel.topic, metadata);
    channel.name = name_of(channel.topic, metadata);
    channel.layout = &layouts_.try_emplace(schema_id, schema->second.text).first->second;
    status_[id] = std::move(channel);
  }

  static std::uint32_t bench_of(std::string_view topic, const TextMap& metadata) {
    constexpr std::string_view kRoot = "/bench";
    const auto own = metadata.find(std::string(kBenchKey));
    std::string_view text;
    if (own != metadata.end()) {
      text = own->second;
    } else if (topic.starts_with(kRoot)) {
      text = topic.substr(kRoot.size());
      text = text.substr(0, text.find('/'));
    }
    const auto number = parse_digits<std::uint32_t>(text);
    if (!number) throw RecordingError("the topic " + in_quotes(topic) + " names no bench");
    return *number;
  }

  static std::string name_of(std::string_view topic, const TextMap& metadata) {
    const auto own = metadata.find("name");
    if (own != metadata.end()) return own->second;
    const auto last = topic.rfind('/');
    const auto first = topic.find('/', 1);
    if (first == std::string_view::npos || first >= last) return {};
    return std::string(topic.substr(first + 1, last - first - 1));
  }

  void take_message(const McapRecord& record) {
    BodyReader body(record.body, where(record));
    const auto id = body.get<std::uint16_t>();
    if (!known_.contains(id)) {
      throw RecordingError(where(record) + " refers to channel " + std::to_string(id) +
                           ", which does not exist");
    }
    contents_.events += logs_.contains(id) ? 1U : 0U;
    contents_.parameters += readings_.contains(id) ? 1U : 0U;
    const auto channel = status_.find(id);
    if (channel == status_.end()) return;
    (void)body.take(sizeof(std::uint32_t) + 2 * sizeof(std::uint64_t));  // sequence, times
    for (client::AxisSnapshot& axis : channel->second.layout->decode(body.rest())) {
      axis.id.bench = channel->second.bench;
      if (axis.id.axis == 0) {
        throw RecordingError(where(record) + " on " + in_quotes(channel->second.topic) +
                             " is of an axis with the number 0, which does not exist");
      }
      try {
        order_.note(axis.id, axis.tick);
      } catch (const RecordingError& error) {
        throw RecordingError(where(record) + ": " + error.what());
      }
      add(axis, channel->second);
    }
  }

  /// Messages of axes with the same bench and tick form one sample.
  void add(const client::AxisSnapshot& axis, const StatusChannel& channel) {
    if (!sample_.axes.empty()) {
      const client::AxisSnapshot& first = sample_.axes.front();
      if (axis.tick != sample_.tick || axis.id.bench != first.id.bench) end_sample();
    }
    sample_.tick = axis.tick;
    sample_.axes.push_back(axis);
    if (axes_.insert(axis.id).second) note_axis(axis.id, channel);
  }

  void note_axis(const client::AxisId& id, const StatusChannel& channel) {
    RecordedAxis& axis = axis_numbered(bench_numbered(id.bench), id.axis);
    if (axis.name.empty()) axis.name = channel.name;
  }

  static RecordedAxis& axis_numbered(RecordedBench& bench, std::uint16_t number) {
    const client::AxisId id{bench.number, number};
    const auto known = std::ranges::find(bench.axes, id, &RecordedAxis::id);
    return known == bench.axes.end() ? bench.axes.emplace_back(RecordedAxis{.id = id}) : *known;
  }

  RecordedBench& bench_numbered(std::uint32_t number) {
    RecordedBench& bench = benches_[number];
    bench.number = number;
    return bench;
  }

  void end_sample() {
    if (sample_.axes.empty()) return;
    const auto gap = gaps_.find(gap_key(sample_.axes.front().id.bench, sample_.tick));
    if (gap != gaps_.end()) {
      sample_.missed = gap->second;
      gaps_.erase(gap);
    }
    ++contents_.samples;
    contents_.rows += sample_.axes.size();
    handler_(sample_);
    sample_ = {};
  }

  void take_metadata(const McapRecord& record) {
    BodyReader body(record.body, where(record));
    const std::string_view name = body.get_text();
    if (name == kBenchRecord) take_bench(body.get_map(), record);
    if (name != kGapsRecord) return;
    for (const auto& [key, value] : body.get_map()) {
      const auto missed = parse_digits<std::uint64_t>(value);
      if (!missed) throw RecordingError(where(record) + " has the count " + in_quotes(value));
      gaps_[key] = *missed;
    }
  }

  void take_bench(const TextMap& facts, const McapRecord& record) {
    const auto value_of = [&](std::string_view key) {
      const auto fact = facts.find(std::string(key));
      const std::string text = fact == facts.end() ? std::string() : fact->second;
      const auto number = parse_digits<std::uint32_t>(text);
      if (!number || (*number == 0 && key == kPeriodKey)) {
        throw RecordingError(where(record) + " has the " + std::string(key) + " " +
                             in_quotes(text));
      }
      return *number;
    };
    RecordedBench& bench = bench_numbered(value_of(kBenchKey));
    bench.period = std::chrono::nanoseconds(value_of(kPeriodKey));
    bench.facts = facts;
    for (const auto& [key, name] : facts) {
      if (!key.starts_with(kAxisKey)) continue;
      const std::string number = key.substr(kAxisKey.size());
      const auto place = parse_digits<std::uint16_t>(number);
      if (!place) continue;
      RecordedAxis& axis = axis_numbered(bench, *place);
      axis.name = name;
      const auto unit = facts.find(std::string(kUnitKey) + number);
      const auto size = facts.find(std::string(kUnitSizeKey) + number);
      if (unit != facts.end() && size != facts.end()) {
        axis.unit = unit_from(unit->second, size->second);
      }
    }
    std::ranges::sort(bench.axes, {}, &RecordedAxis::id);
  }

  [[noreturn]] void refuse() const {
    constexpr std::size_t kShown = 5;
    std::string text = "it has no topic with the status of a bench of vdrive";
    std::size_t shown = 0;
    for (const std::string& topic : topics_) {
      if (shown == kShown) break;
      text += (shown++ == 0 ? "; it has " : ", ") + in_quotes(topic);
    }
    if (topics_.size() > kShown) text += ", ...";
    throw RecordingError(text);
  }

  const SampleHandler& handler_;
  const std::string axis_status_ = bridge::axis_status_schema().name;
  const std::string bench_status_ = bridge::bench_status_schema().name;
  const std::string parameters_ = bridge::axis_parameters_schema().name;
  const std::string log_ = bridge::log_schema().name;
  bool is_in_summary_ = false;
  Contents contents_;
  std::map<std::uint32_t, RecordedBench> benches_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, StatusLayout> layouts_;
  std::map<std::uint16_t, StatusChannel> status_;
  std::set<std::uint16_t> known_;
  std::set<std::uint16_t> logs_;
  std::set<std::uint16_t> readings_;
  std::set<std::string> topics_;
  std::set<client::AxisId> axes_;
  std::map<std::string, std::uint64_t> gaps_;
  client::Observation sample_;
  SampleOrder order_;
};

}  // namespace

Contents read_mcap(std::istream& file, const SampleHandler& handler) {
  McapReader records(file);
  StatusReader reader(handler);
  while (const auto record = records.next()) reader.take(*record);
  return reader.finish(records.cut());
}

}  // namespace vdrive::recording
