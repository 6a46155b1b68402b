#include "coordinator/report/landscape_picture.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "coordinator/report/colour_map.h"
#include "coordinator/report/contour.h"
#include "coordinator/report/svg_ink.h"

namespace knap {
namespace {

using Eigen::Vector2d;

constexpr double kSide = 400.0, kTop = 112.0, kLeft = 84.0, kPanel = kLeft + kSide + 116.0, kBottom = 104.0;  // [px]
constexpr double kBarWidth = 18.0, kBarGap = 18.0;                                                            // [px]
constexpr int kTicks = 5, kLevels = 8;

// "10⁻³".
std::string FormatPowerOfTen(int exponent) {
  constexpr const char* kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent))) text += kDigits[digit - '0'];
  return text;
}

// One quantity over the grid, in the unit it is shown in.
struct Field {
  std::string title;
  Eigen::MatrixXd values;  // row i: y_i
  double lower = 0.0, upper = 1.0;
};

// An axis in the unit it is shown in.
struct ShownAxis {
  std::string label;
  double scale = 1.0;  // shown value of 1 in SI
  std::vector<double> values;
  double lower = 0.0, upper = 0.0;  // edges: half a cell beyond the first and last value
};

ShownAxis MakeShownAxis(const LandscapeAxis& axis, const ParameterSpec& parameters) {
  const std::string unit = parameters.GetUnit(axis.parameter);
  ShownAxis shown;
  if (unit == "m") shown.scale = 1e3;
  shown.label = parameters.names[axis.parameter] + (unit.empty() ? "" : unit == "m" ? " [mm]" : " [" + unit + "]");
  for (const double value : axis.values) shown.values.push_back(shown.scale * value);
  const double half = 0.5 * (shown.values.back() - shown.values.front()) / static_cast<double>(shown.values.size() - 1);
  shown.lower = shown.values.front() - half;
  shown.upper = shown.values.back() + half;
  return shown;
}

Field MakeLossField(const Landscape& landscape) {
  const auto rows = static_cast<Eigen::Index>(landscape.plan.y.values.size());
  const auto columns = static_cast<Eigen::Index>(landscape.plan.x.values.size());
  Field field{"Mean loss", Eigen::MatrixXd(rows, columns)};
  field.lower = std::numeric_limits<double>::infinity();
  field.upper = -field.lower;
  for (Eigen::Index k = 0; k < rows * columns; ++k) {
    const double loss = landscape.cells[static_cast<std::size_t>(k)].loss;
    field.values(k / columns, k % columns) = loss;
    if (!std::isfinite(loss)) continue;
    field.lower = std::min(field.lower, loss);
    field.upper = std::max(field.upper, loss);
  }
  if (!(field.lower <= field.upper)) throw std::runtime_error("landscape: no cell has a finite loss to be drawn");
  // A power of ten in the title keeps the bar's numbers short.
  const double largest = std::max(std::abs(field.lower), std::abs(field.upper));
  const int exponent = largest > 0.0 ? static_cast<int>(std::floor(std::log10(largest))) : 0;
  if (exponent < -2 || exponent > 3) {
    const double scale = std::pow(10.0, -exponent);
    field.values *= scale;
    field.lower *= scale;
    field.upper *= scale;
    field.title += fmt::format(" [{}]", FormatPowerOfTen(exponent));
  }
  if (field.upper == field.lower) field.upper = field.lower + 1.0;
  return field;
}

Field MakeSuccessField(const Landscape& landscape) {
  const auto rows = static_cast<Eigen::Index>(landscape.plan.y.values.size());
  const auto columns = static_cast<Eigen::Index>(landscape.plan.x.values.size());
  Field field{"Success rate [%]", Eigen::MatrixXd(rows, columns), 0.0, 100.0};
  for (Eigen::Index k = 0; k < rows * columns; ++k) {
    field.values(k / columns, k % columns) = 100.0 * landscape.cells[static_cast<std::size_t>(k)].success_rate;
  }
  return field;
}

// Both in white on ink, to be seen on any colour.
std::string DrawRing(const Vector2d& p) {
  return fmt::format(
      "<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"6\" fill=\"none\" stroke=\"{2}\" stroke-width=\"4.5\"/>\n"
      "<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"6\" fill=\"none\" stroke=\"white\" stroke-width=\"2\"/>\n",
      p.x(), p.y(), kInk);
}

std::string DrawCross(const Vector2d& p) {
  const std::string data = fmt::format("M{:.1f},{:.1f}l12,12m0,-12l-12,12", p.x() - 6.0, p.y() - 6.0);
  return fmt::format(
      "<path d=\"{0}\" stroke=\"{1}\" stroke-width=\"5\" stroke-linecap=\"round\"/>\n"
      "<path d=\"{0}\" stroke=\"white\" stroke-width=\"2\" stroke-linecap=\"round\"/>\n",
      data, kInk);
}

class Panel {
 public:
  Panel(const Landscape& landscape, const ShownAxis& x, const ShownAxis& y, const Field& field, double left)
      : landscape_(landscape), x_(x), y_(y), field_(field), corner_(left, kTop) {}

  std::string Draw() const {
    std::string ink = DrawText(corner_ + Vector2d(0.5 * kSide, -14.0), 18, "middle", kInk, field_.title, "bold");
    ink += DrawCells() + DrawContours() + DrawMarks() + DrawAxes() + DrawBar();
    return ink;
  }

 private:
  Vector2d Map(double x, double y) const {
    return corner_ + kSide * Vector2d((x - x_.lower) / (x_.upper - x_.lower), (y_.upper - y) / (y_.upper - y_.lower));
  }
  double Normalise(double value) const { return (value - field_.lower) / (field_.upper - field_.lower); }

  std::string GetColour(std::size_t i, std::size_t j) const {
    const double value = field_.values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    return std::isfinite(value) ? MakeColour(Normalise(value)) : "#d0d7de";
  }

  // In units of a cell, neighbours of one colour in one piece: such a file stays small. What reaches over into the next
  // cell hides the seams of viewers that smooth edges.
  std::string DrawCells() const {
    const std::size_t rows = y_.values.size(), columns = x_.values.size();
    std::string cells, hatched;
    for (std::size_t i = 0; i < rows; ++i) {
      const std::size_t from_top = rows - 1 - i;
      for (std::size_t j = 0, run = 0; j < columns; j += run) {
        const std::string colour = GetColour(i, j);
        for (run = 1; j + run < columns && GetColour(i, j + run) == colour;) ++run;
        cells += fmt::format("<path d=\"M{} {}h{}.02v1.02h-{}.02\" fill=\"{}\"/>\n", j, from_top, run, run, colour);
      }
      for (std::size_t j = 0; j < columns; ++j) {
        const LandscapeCell& cell = landscape_.at(i, j);
        if (cell.not_finite + cell.not_converged == 0) continue;
        const Vector2d p = MapIndex({static_cast<double>(j) - 0.5, static_cast<double>(i) + 0.5});
        hatched += fmt::format(
            "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"url(#untrusted)\"/>\n", p.x(),
            p.y(), kSide / static_cast<double>(columns), kSide / static_cast<double>(rows));
      }
    }
    return fmt::format("<g shape-rendering=\"crispEdges\" transform=\"translate({} {}) scale({} {})\">\n{}</g>\n{}",
                       corner_.x(), corner_.y(), kSide / static_cast<double>(columns),
                       kSide / static_cast<double>(rows), cells, hatched);
  }

  // Contours run through the cells' centres.
  std::string DrawContours() const {
    std::string ink;
    for (const double level : ListRoundNumbers(field_.lower, field_.upper, kLevels)) {
      if (level <= field_.lower || level >= field_.upper) continue;  // the edge of a plateau is no contour
      std::string data;
      for (const auto& [from, to] : CalcContour(field_.values, level)) {
        const Vector2d a = MapIndex(from), b = MapIndex(to);
        data += fmt::format("M{:.1f},{:.1f}L{:.1f},{:.1f}", a.x(), a.y(), b.x(), b.y());
      }
      if (data.empty()) continue;
      ink += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-opacity=\"0.6\" stroke-width=\"1\"/>\n",
                         data, Normalise(level) > 0.55 ? kInk : "white");
    }
    return ink;
  }

  Vector2d MapIndex(const Vector2d& at) const {
    const double columns = static_cast<double>(x_.values.size()), rows = static_cast<double>(y_.values.size());
    return corner_ + kSide * Vector2d((at.x() + 0.5) / columns, 1.0 - (at.y() + 0.5) / rows);
  }

  std::string DrawMarks() const {
    const auto least = std::min_element(landscape_.cells.begin(), landscape_.cells.end(),
                                        [](const LandscapeCell& a, const LandscapeCell& b) { return a.loss < b.loss; });
    const auto k = static_cast<std::size_t>(least - landscape_.cells.begin());
    std::string ink = DrawRing(Map(x_.values[k % x_.values.size()], y_.values[k / x_.values.size()]));
    const LandscapePlan& plan = landscape_.plan;
    const double x = x_.scale * plan.theta[plan.x.parameter], y = y_.scale * plan.theta[plan.y.parameter];
    const bool inside = x >= x_.lower && x <= x_.upper && y >= y_.lower && y <= y_.upper;
    return inside ? ink + DrawCross(Map(x, y)) : ink;
  }

  std::string DrawAxes() const {
    std::string ink = fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" stroke=\"{}\"/>\n",
        corner_.x(), corner_.y(), kSide, kSide, kInk);
    for (const double x : ListRoundNumbers(x_.lower, x_.upper, kTicks)) {
      const Vector2d at(Map(x, y_.lower).x(), corner_.y() + kSide);
      ink += DrawLine(at, at + Vector2d(0.0, 6.0), kInk, 1.0);
      ink += DrawText(at + Vector2d(0.0, 23.0), 15, "middle", kInk, fmt::format("{:.6g}", x));
    }
    for (const double y : ListRoundNumbers(y_.lower, y_.upper, kTicks)) {
      const Vector2d at(corner_.x(), Map(x_.lower, y).y());
      ink += DrawLine(at, at - Vector2d(6.0, 0.0), kInk, 1.0);
      ink += DrawText(at + Vector2d(-10.0, 5.0), 15, "end", kInk, fmt::format("{:.6g}", y));
    }
    ink += DrawText(corner_ + Vector2d(0.5 * kSide, kSide + 48.0), 16, "middle", kInk, x_.label);
    ink += DrawText(corner_ + Vector2d(-54.0, 0.5 * kSide), 16, "middle", kInk, y_.label, "normal", -90.0);
    return ink;
  }

  std::string DrawBar() const {
    constexpr int kSlices = 100;
    const Vector2d top = corner_ + Vector2d(kSide + kBarGap, 0.0);
    std::string ink = "<g shape-rendering=\"crispEdges\">\n";
    for (int k = 0; k < kSlices; ++k) {
      ink += fmt::format("<rect x=\"{:.1f}\" y=\"{:.2f}\" width=\"{:.1f}\" height=\"{:.2f}\" fill=\"{}\"/>\n", top.x(),
                         top.y() + kSide * k / kSlices, kBarWidth, kSide / kSlices + 0.05,
                         MakeColour(1.0 - (k + 0.5) / kSlices));
    }
    ink += fmt::format(
        "</g>\n<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" stroke=\"{}\"/>\n",
        top.x(), top.y(), kBarWidth, kSide, kInk);
    for (const double value : ListRoundNumbers(field_.lower, field_.upper, kTicks)) {
      const Vector2d at = top + Vector2d(kBarWidth, kSide * (1.0 - Normalise(value)));
      ink += DrawLine(at, at + Vector2d(5.0, 0.0), kInk, 1.0);
      ink += DrawText(at + Vector2d(9.0, 5.0), 15, "start", kInk, fmt::format("{:.6g}", value));
    }
    return ink;
  }

  const Landscape& landscape_;
  const ShownAxis& x_;
  const ShownAxis& y_;
  const Field& field_;
  Vector2d corner_;
};

std::string DrawLegend(const Landscape& landscape, const LandscapeCaption& caption, double y) {
  std::string ink = DrawRing({kLeft + 8.0, y - 5.0});
  ink += DrawText({kLeft + 24.0, y}, 15, "start", kInk, "least mean loss");
  ink += DrawCross({kLeft + 164.0, y - 5.0});
  ink += DrawText({kLeft + 180.0, y}, 15, "start", kInk, caption.theta_name);
  const auto untrusted = std::count_if(landscape.cells.begin(), landscape.cells.end(), [](const LandscapeCell& cell) {
    return cell.not_finite + cell.not_converged > 0;
  });
  if (untrusted > 0) {
    ink += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"22\" height=\"14\" fill=\"url(#untrusted)\" stroke=\"{}\"/>\n",
        kLeft + 280.0, y - 13.0, kFaint);
    ink += DrawText({kLeft + 310.0, y}, 15, "start", kInk,
                    fmt::format("rollouts not to be trusted ({} cells)", untrusted));
  }
  return ink;
}

}  // namespace

std::string DrawLandscape(const Landscape& landscape, const ParameterSpec& parameters,
                          const LandscapeCaption& caption) {
  const ShownAxis x = MakeShownAxis(landscape.plan.x, parameters), y = MakeShownAxis(landscape.plan.y, parameters);
  std::vector<Field> fields = {MakeLossField(landscape)};
  if (caption.has_success) fields.push_back(MakeSuccessField(landscape));
  const double width = kPanel * static_cast<double>(fields.size()), height = kTop + kSide + kBottom;
  std::string svg = BeginSvg(width, height);
  svg += fmt::format(
      "<defs><pattern id=\"untrusted\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" "
      "patternTransform=\"rotate(45)\"><rect width=\"2\" height=\"6\" fill=\"#cf222e\"/></pattern></defs>\n");
  svg += DrawText({0.5 * width, 38.0}, 24, "middle", kInk, caption.title, "bold");
  svg += DrawText({0.5 * width, 62.0}, 15, "middle", kFaint, caption.subtitle);
  for (std::size_t k = 0; k < fields.size(); ++k) {
    svg += Panel(landscape, x, y, fields[k], kLeft + kPanel * static_cast<double>(k)).Draw();
  }
  svg += DrawLegend(landscape, caption, height - 20.0);
  return svg + "</svg>\n";
}

}  // namespace knap
