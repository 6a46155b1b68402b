// Numbers as colours, for reading values off a picture, also in grey and by the colour-blind.
#pragma once

#include <string>

namespace knap {

// "#rrggbb" for x in [0, 1] (clamped): lightness rises linearly from dark violet over blue and green to pale yellow.
// The path is a straight line in lightness and hue, with a bow in chroma, in the perceptual space Oklab [Ottosson
// 2020], whose conversion to linear sRGB is two 3×3 matrices around a cube.
std::string MakeColour(double x);

}  // namespace knap
