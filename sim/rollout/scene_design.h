// All designed bodies of a scene: from theta to their meshes, masses and contact surfaces and to what hangs on them,
// and cotangents of all these back to theta.
//
// Everything that moves with a body's mesh does so through its cage (cage_design.h): vertices, and the points of the
// body where joints are attached and that signals watch,  x(theta) = x + dx/dtheta (theta − theta0).  Mass,
// centre and inertia of a body with a density are volume integrals over the mesh (mass_properties.h); with an explicit
// inertia they stay.
#pragma once

#include <Eigen/Dense>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/contact/contact_mesh.h"
#include "sim/contact/moving_pieces.h"
#include "sim/geometry/mass_properties.h"
#include "sim/gradient/adjoint.h"
#include "sim/morphology/cage_design.h"
#include "sim/rollout/build_model.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Cotangent of a point that a signal watches.
struct PointCotangent {
  std::string body;
  Eigen::Vector3d p_B = Eigen::Vector3d::Zero();    // as on file: before theta moved it
  Eigen::Vector3d bar_B = Eigen::Vector3d::Zero();  // [per m]
};

class SceneDesign {
 public:
  // `files` as in scenario_files.h. Throws std::invalid_argument and std::runtime_error as CageDesign and ReadMesh do,
  // the message beginning with the body's name.
  SceneDesign(const World& world, const std::map<std::string, std::string>& files);

  int num_parameters() const { return static_cast<int>(initial_theta_.size()); }
  const Eigen::VectorXd& initial_theta() const { return initial_theta_; }
  const Eigen::VectorXd& ranges() const { return ranges_; }  // upper − lower

  // Names of the designed bodies, in the order of the file, and the cage of one; null for another body.
  const std::vector<std::string>& bodies() const { return names_; }
  const CageDesign* Find(const std::string& body) const;

  // Of the convex pieces of the initial mesh of a designed body that meets another one [m³]; none of others.
  std::vector<double> CalcPieceVolumes(const std::string& body) const;

  DesignedShapes CalcShapes(const Eigen::VectorXd& theta) const;

  // The first fault that CalcShapes would find (DesignedShape::fault), at less cost; empty when there is none.
  std::string FindFault(const Eigen::VectorXd& theta) const;

  // Moves joints, points of grips and those that signals watch, where they hang on designed bodies, from where the file
  // has them to where theta does.
  void MoveAttachments(const Eigen::VectorXd& theta, World* world) const;

  // dloss/dtheta. `scene` is the one before MoveAttachments, `model` was built after it with these shapes.
  Eigen::VectorXd PullBack(const World& world, const DesignedShapes& shapes, const SceneModel& model,
                           const TrajectoryGradient& gradient, const std::vector<PointCotangent>& points) const;

 private:
  struct Part {
    CageDesign cage;
    bool touches = false;            // some contact has it
    std::vector<PieceFaces> pieces;  // where another designed body is what it touches, else none
  };

  std::vector<std::string> names_;
  std::map<std::string, Part> parts_;
  Eigen::VectorXd initial_theta_;
  Eigen::VectorXd ranges_;
};

}  // namespace knap
