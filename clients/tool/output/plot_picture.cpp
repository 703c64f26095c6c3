// SPDX-License-Identifier: Apache-2.0
#include "output/plot_picture.hpp"

#include "output/xml_text.hpp"
#include "terminal/columns.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

namespace vdrive::tool {
namespace {

// Layout of the picture [px].
constexpr double kLeft = 80.0;
constexpr double kRight = 16.0;
constexpr double kBandTop = 68.0;
constexpr double kBandHeight = 16.0;
constexpr double kHead = 92.0;        // title, note, fault names and band
constexpr double kFoot = 42.0;        // times
constexpr double kPanelTitle = 30.0;  // above each panel
constexpr double kUsualPanel = 120.0;
constexpr double kSmallestPanel = 40.0;
constexpr double kLetter = 6.8;  // approximate width of a letter in the small font

constexpr std::size_t kMostBins = 2'000;
constexpr std::size_t kMostPoints = 8'000;  // bins of all curves together; each bin has two points
                                            // of 13 bytes
constexpr std::size_t kMostDescribedStates = 200;  // with a tooltip
constexpr std::size_t kColors = 3;

// Light colours, and dark ones if the viewer prefers them. Both have their own background, because
// the surroundings may differ.
constexpr std::string_view kStyle = R"(<style>
text{font:12px system-ui,sans-serif;fill:#24292f}
.t{font-size:14px;font-weight:600}.h{font-weight:600}.n{font-size:11px;fill:#57606a}
.p{fill:#fff}.f{fill:none;stroke:#8c959f}.g{fill:none;stroke:#d8dee4}
.c{fill:none;stroke-width:1.4;stroke-linejoin:round}.w{stroke-width:3}
.c0{stroke:#3b8eea}.c1{stroke:#bc4c00}.c2{stroke:#1a7f37}
.e{fill:none;stroke:#cf222e;stroke-dasharray:4 3}
.m{font-size:11px;fill:#cf222e}
.s0{fill:#d0d7de}.s1{fill:#aceebb}.s2{fill:#fae17d}.s3{fill:#ffaba8}.s{font-size:10px}
@media (prefers-color-scheme:dark){
text{fill:#e6edf3}.n{fill:#9198a1}
.p{fill:#0d1117}.f{stroke:#656c76}.g{stroke:#2a313c}
.c0{stroke:#388bfd}.c1{stroke:#f0883e}.c2{stroke:#3fb950}
.e{stroke:#f85149}.m{fill:#ff7b72}
.s0{fill:#3d444d}.s1{fill:#196c2e}.s2{fill:#7d5e00}.s3{fill:#b62324}
}
</style>
)";

/// @return a number without an exponent; -0 becomes 0.
std::string fixed_text(double number, int decimals) {
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number,
                                 std::chars_format::fixed, decimals);
  const std::string_view shown(text.data(), static_cast<std::size_t>(end.ptr - text.data()));
  const bool is_zero = shown.find_first_not_of("-0.") == std::string_view::npos;
  return std::string(is_zero && shown.starts_with('-') ? shown.substr(1) : shown);
}

/// @return a coordinate, with as many digits as a viewer can show.
std::string pixels_text(double pixels) {
  std::string text = fixed_text(pixels, 1);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text;
}

/// A text that begins at x, unless `anchor` says otherwise.
std::string text_at(double x, double y, std::string_view style, std::string_view text,
                    std::string_view anchor = "start") {
  return "<text x=\"" + pixels_text(x) + "\" y=\"" + pixels_text(y) + "\" class=\"" +
         std::string(style) + "\" text-anchor=\"" + std::string(anchor) + "\">" + xml_text(text) +
         "</text>\n";
}

std::string path_of(std::string_view style, const std::string& path) {
  return "<path class=\"" + std::string(style) + "\" d=\"" + path + "\"/>\n";
}

std::string rectangle(std::string_view style, double x, double y, double width, double height) {
  return "<rect class=\"" + std::string(style) + "\" x=\"" + pixels_text(x) + "\" y=\"" +
         pixels_text(y) + "\" width=\"" + pixels_text(width) + "\" height=\"" +
         pixels_text(height) + "\"/>\n";
}

/// Round values on a scale: multiples of a step of 1, 2 or 5 times a power of ten.
struct TickScale {
  double step = 1.0;
  int decimals = 0;  ///< needed to show the step

  [[nodiscard]] std::string text_of(double value) const { return fixed_text(value, decimals); }
};

/// @param most steps between the limits
TickScale ticks_between(double low, double high, double most) {
  const double raw = (high - low) / std::max(most, 1.0);
  const double exponent = std::floor(std::log10(raw));
  const double power = std::pow(10.0, exponent);
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= raw) step = factor * power;
  }
  const double shown = std::floor(std::log10(step) + 1e-9);
  return {.step = step, .decimals = shown < 0.0 ? static_cast<int>(-shown) : 0};
}

std::vector<double> tick_values(const TickScale& ticks, double low, double high) {
  std::vector<double> values;
  const double last = std::floor(high / ticks.step + 1e-9);
  for (double n = std::ceil(low / ticks.step - 1e-9); n <= last; n += 1.0) {
    values.push_back(n * ticks.step);
  }
  return values;
}

/// A unit of time that gives readable numbers.
struct TimeUnit {
  std::string_view name;
  double seconds;
};

TimeUnit unit_for(double seconds) {
  constexpr double kFewest = 0.5;  // a unit is used if the full width is at least this many of it
  constexpr std::array kTimeUnits{TimeUnit{"s", 1.0}, TimeUnit{"ms", 1e-3}};
  for (const TimeUnit& unit : kTimeUnits) {
    if (seconds >= kFewest * unit.seconds) return unit;
  }
  return {"us", 1e-6};
}

/// @return the style class of a state in the band.
std::string_view style_of(PowerState state) {
  if (is_fault(state)) return "s3";
  if (state == PowerState::quick_stop_active) return "s2";
  return state == PowerState::operation_enabled ? "s1" : "s0";
}

double label_width(std::string_view text) {
  return kLetter * static_cast<double>(display_width(text));
}

/// Curves that share a scale.
struct Panel {
  std::string_view title;
  std::vector<const PlotTrace*> traces{};
};

std::vector<Panel> panels_of(const PlotTraces& traces) {
  std::vector<Panel> panels;
  for (const PlotTrace& trace : traces.traces) {
    auto panel = std::ranges::find(panels, trace.column.panel, &Panel::title);
    if (panel == panels.end()) {
      panel = panels.insert(panel, Panel{.title = trace.column.panel});
    }
    panel->traces.push_back(&trace);
  }
  return panels;
}

struct Limits {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
};

/// @return the scale of a panel, with a margin above and below the curves.
Limits limits_of(const Panel& panel) {
  constexpr double kMargin = 0.06;
  Limits limits;
  for (const PlotTrace* const trace : panel.traces) {
    for (const PlotPoint& point : trace->points) {
      const double value = static_cast<double>(point.value) * trace->column.size;
      limits = {.low = std::min(limits.low, value), .high = std::max(limits.high, value)};
    }
  }
  if (limits.low == limits.high) limits = {.low = limits.low - 1.0, .high = limits.high + 1.0};
  const double margin = (limits.high - limits.low) * kMargin;
  return {.low = limits.low - margin, .high = limits.high + margin};
}

/// Draws the parts of one picture.
class Picture {
 public:
  Picture(const PlotTraces& traces, const PlotStyle& style)
      : traces_(traces),
        style_(style),
        panels_(panels_of(traces)),
        width_(style.width),
        height_(height_of(style, panels_.size())),
        panel_height_((height_ - kHead - kFoot) / static_cast<double>(panels_.size()) -
                      kPanelTitle) {}

  [[nodiscard]] std::string draw() {
    const std::string width = pixels_text(width_);
    const std::string height = pixels_text(height_);
    svg_ = R"(<svg xmlns="http://www.w3.org/2000/svg" width=")" + width + R"(" height=")" + height +
           R"(" viewBox="0 0 )" + width + " " + height + "\">\n<title>" + xml_text(style_.title) +
           "</title>\n" + std::string(kStyle);
    svg_ += R"(<rect class="p" width=")" + width + R"(" height=")" + height + "\" rx=\"6\"/>\n";
    svg_ += text_at(kLeft, 22.0, "t", style_.title);
    svg_ += text_at(kLeft, 41.0, "n", style_.note);
    draw_band();
    for (std::size_t i = 0; i < panels_.size(); ++i) draw_panel(panels_[i], top_of(i));
    draw_times();
    draw_faults();
    svg_ += "</svg>\n";
    return std::move(svg_);
  }

 private:
  static double height_of(const PlotStyle& style, std::size_t panels) {
    if (style.height != 0) return style.height;
    return kHead + kFoot + static_cast<double>(panels) * (kUsualPanel + kPanelTitle);
  }

  [[nodiscard]] double top_of(std::size_t panel) const {
    return kHead + kPanelTitle + static_cast<double>(panel) * (panel_height_ + kPanelTitle);
  }

  [[nodiscard]] double bottom() const { return top_of(panels_.size() - 1) + panel_height_; }

  [[nodiscard]] double right() const { return width_ - kRight; }

  [[nodiscard]] double seconds_of(std::uint64_t tick) const {
    constexpr double kNanosecond = 1e-9;
    return static_cast<double>(tick - style_.origin) * static_cast<double>(style_.period.count()) *
           kNanosecond;
  }

  /// A recording with one sample is drawn at the left edge.
  [[nodiscard]] double x_of(std::uint64_t tick) const {
    const std::uint64_t ticks = std::max<std::uint64_t>(traces_.last_tick - traces_.first_tick, 1);
    return kLeft + (right() - kLeft) * static_cast<double>(tick - traces_.first_tick) /
                       static_cast<double>(ticks);
  }

  void draw_band() {
    svg_ += text_at(kLeft - 6.0, kBandTop + 12.0, "n", "state", "end");
    const bool is_described = traces_.states.size() <= kMostDescribedStates;
    for (std::size_t i = 0; i < traces_.states.size(); ++i) {
      const PlotState& state = traces_.states[i];
      const double x = x_of(state.from);
      const bool is_last = i + 1 == traces_.states.size();
      const double width = (is_last ? right() : x_of(traces_.states[i + 1].from)) - x;
      const std::string_view name = to_string(state.state);
      if (is_described) svg_ += "<g><title>" + xml_text(name) + "</title>\n";
      svg_ += rectangle(style_of(state.state), x, kBandTop, width, kBandHeight);
      if (label_width(name) + 8.0 <= width) svg_ += text_at(x + 4.0, kBandTop + 12.0, "s", name);
      if (is_described) svg_ += "</g>\n";
    }
  }

  void draw_panel(const Panel& panel, double top) {
    constexpr double kPixelsATick = 24.0;
    const Limits limits = limits_of(panel);
    const auto y_of = [&](double value) {
      return top + panel_height_ * (limits.high - value) / (limits.high - limits.low);
    };
    const TickScale ticks = ticks_between(limits.low, limits.high, panel_height_ / kPixelsATick);
    std::string grid;
    for (const double value : tick_values(ticks, limits.low, limits.high)) {
      grid +=
          "M" + pixels_text(kLeft) + " " + pixels_text(y_of(value)) + "H" + pixels_text(right());
      svg_ += text_at(kLeft - 6.0, y_of(value) + 4.0, "n", ticks.text_of(value), "end");
    }
    for (const double time : times()) {
      grid += "M" + pixels_text(x_at(time)) + " " + pixels_text(top) + "V" +
              pixels_text(top + panel_height_);
    }
    svg_ += path_of("g", grid) + rectangle("f", kLeft, top, right() - kLeft, panel_height_) +
            text_at(kLeft, top - 8.0, "h", panel.title);
    for (std::size_t i = 0; i < panel.traces.size(); ++i) {
      const PlotTrace& trace = *panel.traces[i];
      svg_ += "<polyline class=\"" + style_of_curve(panel, i) + "\" points=\"";
      std::string_view separator;
      for (const PlotPoint& point : trace.points) {
        svg_.append(separator).append(pixels_text(x_of(point.tick))).append(",");
        svg_ += pixels_text(y_of(static_cast<double>(point.value) * trace.column.size));
        separator = " ";
      }
      svg_ += "\"/>\n";
    }
    draw_legend(panel, top - 8.0);
  }

  /// The first of several curves is wide, so that it remains visible below another one.
  static std::string style_of_curve(const Panel& panel, std::size_t curve) {
    const bool is_wide = curve == 0 && panel.traces.size() > 1;
    return "c c" + std::to_string(curve % kColors) + (is_wide ? " w" : "");
  }

  /// Draws, from the right edge, each curve as a line with its label.
  void draw_legend(const Panel& panel, double y) {
    constexpr double kLine = 18.0;
    double x = right();
    for (std::size_t i = panel.traces.size(); i-- > 0;) {
      const std::string& label = panel.traces[i]->column.label;
      if (label.empty()) continue;
      svg_ += text_at(x, y, "n", label, "end");
      x -= label_width(label) + 6.0;
      svg_ +=
          path_of(style_of_curve(panel, i), "M" + pixels_text(x - kLine) + " " +
                                                pixels_text(y - 4.0) + "h" + pixels_text(kLine));
      x -= kLine + 14.0;
    }
  }

  [[nodiscard]] TickScale time_ticks() const {
    constexpr double kPixelsATime = 90.0;
    const TimeUnit unit = time_unit();
    const double first = seconds_of(traces_.first_tick) / unit.seconds;
    return ticks_between(first, first + span() / unit.seconds, (right() - kLeft) / kPixelsATime);
  }

  [[nodiscard]] double span() const {
    const std::uint64_t ticks = std::max<std::uint64_t>(traces_.last_tick - traces_.first_tick, 1);
    return seconds_of(style_.origin + ticks);
  }

  [[nodiscard]] TimeUnit time_unit() const { return unit_for(span()); }

  /// Round times between the edges [time_unit()].
  [[nodiscard]] std::vector<double> times() const {
    const TimeUnit unit = time_unit();
    const double first = seconds_of(traces_.first_tick) / unit.seconds;
    return tick_values(time_ticks(), first, first + span() / unit.seconds);
  }

  [[nodiscard]] double x_at(double time) const {
    const double seconds = time * time_unit().seconds - seconds_of(traces_.first_tick);
    return kLeft + (right() - kLeft) * seconds / span();
  }

  void draw_times() {
    const TickScale ticks = time_ticks();
    for (const double time : times()) {
      svg_ += text_at(x_at(time), bottom() + 16.0, "n", ticks.text_of(time), "middle");
    }
    svg_ += text_at((kLeft + right()) / 2.0, bottom() + 33.0, "n",
                    "drive time [" + std::string(time_unit().name) + "]", "middle");
  }

  /// Draws a line through all panels, with a text above the band unless it would cover another one.
  void draw_faults() {
    double free_from = 0.0;
    for (const PlotFault& fault : traces_.faults) {
      const double x = x_of(fault.tick);
      const std::string text = "fault " + index_text(fault.code) + " " +
                               std::string(describe(static_cast<ErrorCode>(fault.code)));
      svg_ += path_of(
          "e", "M" + pixels_text(x) + " " + pixels_text(kBandTop) + "V" + pixels_text(bottom()));
      const double width = label_width(text) + 8.0;
      const bool is_left = x + width > right();
      const double begin = is_left ? x - width : x;
      if (begin < free_from) continue;
      free_from = begin + width;
      svg_ += text_at(is_left ? x - 4.0 : x + 4.0, kBandTop - 5.0, "m", text,
                      is_left ? "end" : "start");
    }
  }

  const PlotTraces& traces_;
  const PlotStyle& style_;
  std::vector<Panel> panels_;
  double width_;
  double height_;
  double panel_height_;
  std::string svg_;
};

}  // namespace

std::size_t count_panels(const std::vector<PlotColumn>& columns) {
  std::vector<std::string_view> titles;
  for (const PlotColumn& column : columns) {
    if (std::ranges::find(titles, column.panel) == titles.end()) titles.push_back(column.panel);
  }
  return titles.size();
}

std::uint32_t smallest_plot_height(std::size_t panels) noexcept {
  return static_cast<std::uint32_t>(kHead + kFoot +
                                    static_cast<double>(panels) * (kSmallestPanel + kPanelTitle));
}

std::size_t plot_bins(std::uint32_t width, std::size_t columns) noexcept {
  const auto pixels = static_cast<std::size_t>(static_cast<double>(width) - kLeft - kRight);
  return std::min({pixels, kMostBins, kMostPoints / std::max<std::size_t>(columns, 1)});
}

std::string plot_svg(const PlotTraces& traces, const PlotStyle& style) {
  return Picture(traces, style).draw();
}

}  // namespace vdrive::tool
