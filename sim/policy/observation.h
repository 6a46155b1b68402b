// What a policy sees: smooth functions of the state, one number each, with their exact pull-back.
//
//   coordinate         q of a revolute or prismatic joint, and its rate
//   position           e_A · p_AoP_A of a point P of body B: along an axis e_A of a body A, or of the world
//   velocity           e · v_WP_W
//   direction          e_A · R_AB f_B: a component in A of an axis f of B, an entry of the rotation matrix
//   angular velocity   e · w_WB_W
//   time, constant
//
// all less an offset and divided by a scale. Rotations are seen as entries of their matrix alone: these have neither
// singularities nor a sign to choose, as angles and quaternions would.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/integrators/feedback.h"

namespace knap {

enum class ObservationKind {
  kCoordinate,
  kRate,
  kPosition,
  kVelocity,
  kDirection,
  kAngularVelocity,
  kElapsedTime,
  kConstant,
};

struct Observation {
  ObservationKind kind = ObservationKind::kConstant;
  int index = 0;  // kCoordinate: in q; kRate: in v
  int rate = 0;   // kCoordinate: in v, of the same joint
  int body = 0;
  int in = -1;                                         // body whose frame it is, −1 the world
  Eigen::Vector3d point = Eigen::Vector3d::Zero();     // in B
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();     // e, unit
  Eigen::Vector3d of_axis = Eigen::Vector3d::UnitX();  // f, unit
  double constant = 0.0;
  double offset = 0.0;
  double scale = 1.0;  // > 0
};

// (o − offset)/scale at a state.
double CalcObservation(const Observation& observation, const FeedbackState& at);

// Adds what the cotangent `bar` of CalcObservation puts on the state, and on the observed point (in B) to *bar_point.
void PullBackObservation(const Observation& observation, const FeedbackState& at, double bar, FeedbackCotangents* out,
                         Eigen::Vector3d* bar_point);

}  // namespace knap
