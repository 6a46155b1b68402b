// The scene's signals as functions of what the simulator knows.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/geometry/shape_measures.h"
#include "sim/rollout/build_model.h"
#include "sim/scenarios/scene.h"
#include "sim/signals/signal_function.h"

namespace knap {

// What the signal of a contact's force sees: the sum of the forces of these of the model's contacts, recorded while
// they are simulated.
struct ForceSeries {
  std::vector<int> contacts;
};

// A point of a body that signals watch; it moves with the mesh of a designed one.
struct SignalPoint {
  std::string body;
  Eigen::Vector3d p_B = Eigen::Vector3d::Zero();  // as on file: before theta moved it
};

// What a signal measures of a designed body's shape.
struct SignalMeasure {
  std::string body;
  ShapeMeasure measure;
};

class SignalSet {
 public:
  // `world` varied, with points where the file has them: watched numbers are its. `moved` has them where theta does;
  // `model` was built from it and from `shapes`, none of which has a fault.
  SignalSet(const World& world, const World& moved, const SceneModel& model, const DesignedShapes& shapes);

  const SignalPointer& Find(const std::string& name) const { return by_name_.at(name); }
  const std::vector<SignalPoint>& points() const { return points_; }
  const std::vector<SignalMeasure>& measures() const { return measures_; }
  const std::vector<ForceSeries>& forces() const { return forces_; }
  // Times whose states drifts remember [s], ascending.
  const std::vector<double>& remembered() const { return remembered_; }

 private:
  class Builder;
  std::map<std::string, SignalPointer> by_name_;
  std::vector<SignalPoint> points_;
  std::vector<SignalMeasure> measures_;
  std::vector<ForceSeries> forces_;
  std::vector<double> remembered_;
};

// Row of an actuator's commands among those of the controls, then those of the policy.
int FindCommandRow(const World& world, const std::string& actuator);

}  // namespace knap
