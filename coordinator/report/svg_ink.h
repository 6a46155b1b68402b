// Ink that pictures share: colours, and pieces of SVG as text. Lengths on paper in pixels.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace knap {

inline constexpr const char* kInk = "#24292f";
inline constexpr const char* kFaint = "#6e7781";

// The opening tag of a picture of this size, and its white ground.
std::string BeginSvg(double width, double height);

std::string DrawLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const char* colour, double width);

// Many lines as one path.
struct InkLine {
  Eigen::Vector2d from, to;
};
std::string DrawLines(const std::vector<InkLine>& lines, const char* colour, double width);

// `anchor`: start, middle or end. Characters that XML reserves are escaped. `rotation`: degrees clockwise about `at`.
std::string DrawText(const Eigen::Vector2d& at, int size, const char* anchor, const char* colour,
                     const std::string& text, const char* weight = "normal", double rotation = 0.0);

}  // namespace knap
