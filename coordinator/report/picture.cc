#include "coordinator/report/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "coordinator/report/svg_ink.h"
#include "coordinator/report/top_view.h"

namespace knap {
namespace {

constexpr std::uint64_t kShownVariations = 12;
constexpr double kPanelWidth = 460.0, kGap = 40.0, kMargin = 30.0, kTitleHeight = 76.0, kLegendHeight = 64.0;  // [px]
constexpr double kBorder = 0.015;  // around what is shown [m]

struct Colours {
  const char* fill;
  const char* line;
};
constexpr Colours kGrey{"#afb8c1", "#57606a"};
constexpr Colours kBlue{"#54aeff", "#0550ae"};

std::string DrawOutline(const Outline& outline, const PanelMap& map, const Colours& colours, double opacity) {
  std::string data;
  for (const auto& loop : outline) data += DrawPoints(loop, map) + "Z";
  return fmt::format(
      "<path d=\"{}\" fill=\"{}\" fill-opacity=\"{}\" stroke=\"{}\" stroke-opacity=\"{}\" stroke-width=\"1.5\" "
      "stroke-linejoin=\"round\"/>\n",
      data, colours.fill, 0.75 * opacity, colours.line, opacity);
}

constexpr double kContactOpacity = 0.55, kBetweenOpacity = 0.18;

std::string DrawPath(const TracedPath& path, const PanelMap& map, double radius) {
  const char* colour = path.success ? kSuccess : kFailure;
  std::string ink = fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\" stroke-opacity=\"0.8\" "
      "stroke-linejoin=\"round\"{}/>\n",
      DrawPoints(path.points, map), colour, path.success ? "" : " stroke-dasharray=\"6 3\"");
  const Eigen::Vector2d start = map(path.points.front()), end = map(path.points.back());
  ink += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.6\" fill=\"{}\"/>\n", start.x(), start.y(), colour);
  ink += fmt::format(
      "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"{}\" fill-opacity=\"0.25\" stroke=\"{}\"/>\n", end.x(),
      end.y(), std::max(3.0, radius * map.scale), colour, colour);
  return ink;
}

std::string DrawOpening(const Opening& opening, const PanelMap& map) {
  const double left = opening.opening_center - opening.opening_half_width;
  const double right = opening.opening_center + opening.opening_half_width;
  std::string ink = DrawLine(map({map.shown.min().x(), opening.at}), map({left, opening.at}), kInk, 5.0);
  ink += DrawLine(map({right, opening.at}), map({map.shown.max().x(), opening.at}), kInk, 5.0);
  return ink;
}

std::string DrawStartBox(const Eigen::AlignedBox2d& box, const PanelMap& map) {
  if (box.isEmpty()) return "";
  const Eigen::Vector2d top_left = map({box.min().x(), box.max().y()});
  return fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"#fff8c5\" stroke=\"#9a6700\" "
      "stroke-dasharray=\"4 3\"/>\n",
      top_left.x(), top_left.y(), map.scale * box.sizes().x(), map.scale * box.sizes().y());
}

void Extend(const Outline& outline, Eigen::AlignedBox2d* box) {
  for (const auto& loop : outline) {
    for (const Eigen::Vector2d& point : loop) box->extend(point);
  }
}

// All of the tools, the opening and the starts; paths of lost bodies may leave it.
Eigen::AlignedBox2d CalcShown(const std::vector<const TopView*>& views, const Eigen::AlignedBox2d& start,
                              const Opening& opening, double radius) {
  Eigen::AlignedBox2d box = start;
  for (const TopView* view : views) {
    Extend(view->tool_at_contact, &box);
    Extend(view->tool_at_end, &box);
    for (const TracedPath& path : view->paths) {
      box.extend(path.points.front());
      if (path.success) box.extend(path.points.back());
    }
  }
  const double side = 1.5 * opening.opening_half_width;
  box.extend(Eigen::Vector2d(opening.opening_center - side, opening.at));
  box.extend(Eigen::Vector2d(opening.opening_center + side, opening.at));
  const Eigen::Vector2d border = Eigen::Vector2d::Constant(kBorder + radius);
  return {box.min() - border, box.max() + border};
}

std::string DrawLegend(const PanelMap& map, double y, double width) {
  const double bar_m = map.shown.sizes().x() > 0.15 ? 0.05 : 0.01;
  double x = kMargin;
  std::string ink;
  const auto sample = [&](const char* colour, const char* dash, const char* text, double advance) {
    ink += fmt::format(
        "<line x1=\"{0:.1f}\" y1=\"{2:.1f}\" x2=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"{3}\" stroke-width=\"2.5\"{4}/>\n",
        x, x + 34.0, y - 5.0, colour, dash);
    ink += DrawText({x + 42.0, y}, 16, "start", kInk, text);
    x += advance;
  };
  sample(kSuccess, "", "passes the opening", 216.0);
  sample(kFailure, " stroke-dasharray=\"6 3\"", "misses it", 150.0);
  const auto box = [&](const char* fill, const char* line, const char* dash, const char* text, double advance) {
    ink += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"22\" height=\"14\" fill=\"{}\" stroke=\"{}\"{}/>\n", x,
                       y - 13.0, fill, line, dash);
    ink += DrawText({x + 30.0, y}, 16, "start", kInk, text);
    x += advance;
  };
  box("#fff8c5", "#9a6700", " stroke-dasharray=\"4 3\"", "starts", 104.0);
  box(kGrey.fill, kGrey.line, "", "initial tool", 140.0);
  box(kBlue.fill, kBlue.line, "", "learned tool", 150.0);
  ink += DrawScaleBar({width - kMargin, y}, map, bar_m);
  return ink;
}

}  // namespace

std::optional<std::string> DrawPicture(RolloutModel& model, const VariationSpec& variations,
                                       const PictureFigures& figures) {
  const std::optional<Opening> opening = FindShownOpening(model.scene());
  if (!opening) return DrawRopeView(model, variations, figures);
  std::vector<std::vector<double>> shown;
  for (std::uint64_t i = 0; i < kShownVariations; ++i) {
    shown.push_back(SampleVariation(variations, figures.test_initial.seed, RandomStream::kTestVariations, i));
  }
  std::vector<double> initial;
  for (const DesignParameter& parameter : model.scene().design->parameters) initial.push_back(parameter.initial);
  const TopView before = TraceTopView(model, initial, shown, *opening);
  const TopView after = TraceTopView(model, figures.learned, shown, *opening);
  const Eigen::AlignedBox2d start = FindStartBox(model.scene(), variations, *opening);
  const double radius = FindBodyRadius(model.scene(), opening->body);

  PanelMap map;
  map.shown = CalcShown({&before, &after}, start, *opening, radius);
  map.scale = kPanelWidth / map.shown.sizes().x();
  const double panel_height = map.scale * map.shown.sizes().y();
  const double width = 2.0 * (kMargin + kPanelWidth) + kGap, height = kTitleHeight + panel_height + kLegendHeight;

  std::string svg = BeginSvg(width, height);
  const auto panel = [&](int index, const TopView& view, const Colours& colours, const char* name,
                         const TestSummary& test) {
    map.corner = {kMargin + index * (kPanelWidth + kGap), kTitleHeight};
    const double x = map.corner.x();
    svg += DrawText({x + 0.5 * kPanelWidth, 36.0}, 24, "middle", kInk, FormatTitle(name, test, "succeed"), "bold");
    svg += DrawText({x + 0.5 * kPanelWidth, 62.0}, 16, "middle", kFaint, FormatInterval(test));
    svg += BeginPanel(index, map.corner, {kPanelWidth, panel_height}, kFrame);
    svg += DrawStartBox(start, map);
    svg += DrawOpening(*opening, map);
    svg += DrawOutline(view.tool_at_contact, map, colours, kContactOpacity);
    for (const Outline& outline : view.tool_between) svg += DrawOutline(outline, map, colours, kBetweenOpacity);
    svg += DrawOutline(view.tool_at_end, map, colours, 1.0);
    for (const TracedPath& path : view.paths) svg += DrawPath(path, map, radius);
    svg += "</g>\n";
  };
  panel(0, before, kGrey, "Initial", figures.test_initial);
  panel(1, after, kBlue, "Learned", figures.test_learned);
  svg += DrawLegend(map, height - 24.0, width);
  return svg + "</svg>\n";
}

}  // namespace knap
