// Random numbers and poses for tests of contact.
#pragma once

#include <Eigen/Core>
#include <random>

#include "sim/math/pose.h"
#include "sim/math/so3.h"

namespace knap::test {

class RandomPlaces {
 public:
  explicit RandomPlaces(unsigned seed) : generator_(seed) {}
  double U(double low, double high) { return std::uniform_real_distribution<double>(low, high)(generator_); }
  Eigen::Vector3d Vec(double size) { return {U(-size, size), U(-size, size), U(-size, size)}; }
  Pose MakePose(double turn, double shift) { return {ExpSo3(Vec(turn)).toRotationMatrix(), Vec(shift)}; }

 private:
  std::mt19937_64 generator_;
};

}  // namespace knap::test
