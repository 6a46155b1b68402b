// A policy's weights as a text file: decimal numbers between blanks or line ends, in the order of network.h; what
// follows a # on its line is for people.
#pragma once

#include <Eigen/Core>
#include <string>

namespace knap {

// Throws std::runtime_error with one line "name:line:column: …" for what is no finite number or lies outside the
// bounds, and for a number of weights that is not `count`.
Eigen::VectorXd ParseWeights(const std::string& text, const std::string& name, Eigen::Index count, double lower,
                             double upper);

// One weight a line, with all of its bits; the lines of `remark` stand before them.
std::string FormatWeights(const Eigen::VectorXd& weights, const std::string& remark);

}  // namespace knap
