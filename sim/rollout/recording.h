// All of a rollout that can be seen: poses of all bodies, coordinates of joints, the scene's signals, contacts, at a
// series of times.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "sim/math/pose.h"

namespace knap {

// Every series has one entry a time.
struct Recording {
  // The scene's bodies in its order, then the links of its ropes, "<rope> link <i>".
  struct Body {
    std::string name;
    bool moves = false;  // it, or what carries it
    std::vector<Pose> X_WB;
  };
  // Of a revolute or prismatic joint.
  struct Joint {
    std::string body;  // that it moves
    std::string unit;  // "rad" or "m"
    std::vector<double> q;
  };
  struct Signal {
    std::string name;
    std::string unit;  // "m/s"; empty: none
    std::vector<double> values;
  };
  // Two of the bodies that touch at some time.
  struct Contact {
    std::array<std::string, 2> bodies;
    std::vector<Eigen::Vector3d> f_W;  // on the first; zero while they do not touch [N]
    std::vector<Eigen::Vector3d> p_W;  // where it acts; not a number while they do not touch [m]
    std::vector<double> depth;         // of the deepest place [m]
  };

  std::vector<double> time;                             // [s]
  Eigen::Vector3d gravity_W = Eigen::Vector3d::Zero();  // [m/s²]
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<Signal> signals;
  std::vector<Contact> contacts;

  const Body& Find(const std::string& body) const;  // must exist
};

}  // namespace knap
