#include "coordinator/report/svg_ink.h"

#include <fmt/format.h>

namespace knap {
namespace {

std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

}  // namespace

std::string BeginSvg(double width, double height) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\">\n<rect width=\"100%\" height=\"100%\" "
      "fill=\"white\"/>\n",
      width, height);
}

std::string BeginPanel(int index, const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const char* border) {
  return fmt::format(
      "<clipPath id=\"panel{0}\"><rect x=\"{1:.1f}\" y=\"{2:.1f}\" width=\"{3:.1f}\" "
      "height=\"{4:.1f}\"/></clipPath>\n"
      "<rect x=\"{1:.1f}\" y=\"{2:.1f}\" width=\"{3:.1f}\" height=\"{4:.1f}\" fill=\"#f6f8fa\" stroke=\"{5}\"/>\n"
      "<g clip-path=\"url(#panel{0})\">\n",
      index, corner.x(), corner.y(), size.x(), size.y(), border);
}

std::string DrawPoints(const std::vector<Eigen::Vector2d>& points, const PanelMap& map) {
  std::string data;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d p = map(point);
    data += fmt::format("{}{:.1f},{:.1f}", data.empty() ? "M" : " ", p.x(), p.y());
  }
  return data;
}

std::string DrawLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const char* colour, double width) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{}\"/>\n", from.x(),
      from.y(), to.x(), to.y(), colour, width);
}

std::string DrawText(const Eigen::Vector2d& at, int size, const char* anchor, const char* colour,
                     const std::string& text, const char* weight, double rotation) {
  const std::string turned =
      rotation == 0.0 ? "" : fmt::format(" transform=\"rotate({:g} {:.1f} {:.1f})\"", rotation, at.x(), at.y());
  return fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{}\" text-anchor=\"{}\" fill=\"{}\" "
      "font-weight=\"{}\"{}>{}</text>\n",
      at.x(), at.y(), size, anchor, colour, weight, turned, Escape(text));
}

std::string DrawScaleBar(const Eigen::Vector2d& right, const PanelMap& map, double length) {
  const double bar = length * map.scale;
  std::string ink = DrawLine({right.x() - bar, right.y() - 5.0}, {right.x(), right.y() - 5.0}, kInk, 3.0);
  ink += DrawText({right.x() - bar - 8.0, right.y()}, 16, "end", kInk, fmt::format("{:.0f} mm", 1e3 * length));
  return ink;
}

std::string FormatTitle(const char* name, const TestSummary& test, const char* verb) {
  return fmt::format("{}: {:.1f}% of {} {}", name, 100.0 * test.success_rate, test.variations, verb);
}

std::string FormatInterval(const TestSummary& test) {
  return fmt::format("95% interval {:.1f} to {:.1f}%", 100.0 * test.success_interval.lower,
                     100.0 * test.success_interval.upper);
}

}  // namespace knap
