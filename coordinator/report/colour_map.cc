#include "coordinator/report/colour_map.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace knap {
namespace {

// The standard's transfer function, from linear light to code values of 8 bits.
int EncodeSrgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  const double code = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
  return static_cast<int>(std::lround(255.0 * code));
}

}  // namespace

std::string MakeColour(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  const double lightness = 0.28 + 0.66 * t;
  const double hue = (295.0 - 190.0 * t) * std::numbers::pi / 180.0;
  const double chroma = 0.09 + 0.15 * t * (1.0 - t) + 0.05 * t;
  const Eigen::Vector3d lab(lightness, chroma * std::cos(hue), chroma * std::sin(hue));
  Eigen::Matrix3d from_lab, to_rgb;
  from_lab << 1.0, 0.3963377774, 0.2158037573,  //
      1.0, -0.1055613458, -0.0638541728,        //
      1.0, -0.0894841775, -1.2914855480;
  to_rgb << 4.0767416621, -3.3077115913, 0.2309699292,  //
      -1.2684380046, 2.6097574011, -0.3413193965,       //
      -0.0041960863, -0.7034186147, 1.7076147010;
  const Eigen::Vector3d root = from_lab * lab;
  const Eigen::Vector3d rgb = to_rgb * root.array().cube().matrix();
  return fmt::format("#{:02x}{:02x}{:02x}", EncodeSrgb(rgb.x()), EncodeSrgb(rgb.y()), EncodeSrgb(rgb.z()));
}

}  // namespace knap
