// Ink that pictures share: colours, panels, and pieces of SVG as text. Lengths on paper in pixels.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "coordinator/learning/evaluation.h"

namespace knap {

inline constexpr const char* kSuccess = "#1a7f37";
inline constexpr const char* kFailure = "#cf222e";
inline constexpr const char* kInk = "#24292f";
inline constexpr const char* kFaint = "#6e7781";
inline constexpr const char* kFrame = "#d0d7de";

// Metres, up-axis upwards, to pixels of one panel, whose top left corner is `corner`.
struct PanelMap {
  Eigen::AlignedBox2d shown;  // [m]
  double scale = 1.0;         // [px/m]
  Eigen::Vector2d corner{0.0, 0.0};

  Eigen::Vector2d operator()(const Eigen::Vector2d& point) const {
    return corner + scale * Eigen::Vector2d(point.x() - shown.min().x(), shown.max().y() - point.y());
  }
};

// The opening tag of a picture of this size, and its white ground.
std::string BeginSvg(double width, double height);

// A panel's ground, `size` at `corner`, and the opening tag of a group that is clipped by it.
std::string BeginPanel(int index, const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const char* border);

// Path data through these points, left open.
std::string DrawPoints(const std::vector<Eigen::Vector2d>& points, const PanelMap& map);

std::string DrawLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const char* colour, double width);

// `anchor`: start, middle or end. Characters that XML reserves are escaped. `rotation`: degrees clockwise about `at`.
std::string DrawText(const Eigen::Vector2d& at, int size, const char* anchor, const char* colour,
                     const std::string& text, const char* weight = "normal", double rotation = 0.0);

// A line of `length` [m] that ends at `right`, with its length before it.
std::string DrawScaleBar(const Eigen::Vector2d& right, const PanelMap& map, double length);

// "Initial: 24.0% of 200 succeed", with this verb.
std::string FormatTitle(const char* name, const TestSummary& test, const char* verb);
std::string FormatInterval(const TestSummary& test);

}  // namespace knap
