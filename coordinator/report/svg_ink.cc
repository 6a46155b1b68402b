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

std::string DrawLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const char* colour, double width) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{}\"/>\n", from.x(),
      from.y(), to.x(), to.y(), colour, width);
}

std::string DrawLines(const std::vector<InkLine>& lines, const char* colour, double width) {
  std::string path;
  for (const InkLine& line : lines) {
    path += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", line.from.x(), line.from.y(), line.to.x(), line.to.y());
  }
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>\n", path, colour, width);
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

}  // namespace knap
