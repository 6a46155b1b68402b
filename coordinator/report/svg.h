// Pieces of SVG that all our drawings share, and the colours of the house.
#pragma once

#include <Eigen/Core>
#include <string>

namespace knap {

inline constexpr const char* kSvgInk = "#24292f";
inline constexpr const char* kSvgFaint = "#6e7781";
inline constexpr const char* kSvgFrame = "#d0d7de";

// A document of `width` by `height` pixels on white; what it holds follows, and then "</svg>\n".
std::string BeginSvg(double width, double height);

std::string DrawLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const char* colour, double width);

// `anchor`: start, middle or end. Characters that XML reserves are escaped. `rotation`: degrees clockwise about `at`.
std::string DrawText(const Eigen::Vector2d& at, int size, const char* anchor, const char* colour,
                     const std::string& text, const char* weight = "normal", double rotation = 0.0);

}  // namespace knap
