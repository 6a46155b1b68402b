// Level lines of a function sampled on a grid.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace knap {

// Pieces of the line f = level, by linear interpolation on the edges of each square of four samples (marching squares);
// a saddle is cut by the mean of its corners. values(i, j): f at row i and column j; points come as (column, row),
// fractional. Squares with a corner that is not finite have no line.
using Segment = std::pair<Eigen::Vector2d, Eigen::Vector2d>;
std::vector<Segment> CalcContour(const Eigen::MatrixXd& values, double level);

// About `count` round numbers (1, 2 or 5 times a power of ten apart) within [lower, upper]; count >= 2, lower < upper.
std::vector<double> ListRoundNumbers(double lower, double upper, int count);

}  // namespace knap
