// From a scenario's files to what an engine simulates at given design parameters and variation: the same scene, masses,
// contacts and signals, whichever engine it is.
#pragma once

#include <Eigen/Core>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/rollout/build_model.h"
#include "sim/rollout/build_signals.h"
#include "sim/rollout/scene_design.h"
#include "sim/scenarios/scene.h"

namespace knap {

struct BuiltScene {
  Scene scene;                                   // varied, with attachments where the file has them
  Scene moved;                                   // with attachments where theta has them
  std::shared_ptr<const DesignedShapes> shapes;  // empty without a design
  SceneModel model;
  std::unique_ptr<SignalSet> signals;
};

class SceneSource {
 public:
  // `files` holds the scenario and the meshes it names (scenario_files.h). Throws std::runtime_error with one line.
  explicit SceneSource(const std::map<std::string, std::string>& files);

  const Scene& scene() const { return scene_; }
  const std::optional<SceneDesign>& design() const { return design_; }
  const FixedMeshes& meshes() const { return meshes_; }
  int num_parameters() const { return design_ ? design_->num_parameters() : 0; }

  // Shapes of recent parameters are kept, which changes no bit.
  std::shared_ptr<const DesignedShapes> GetShapes(const Eigen::VectorXd& theta);
  // The first fault of these shapes (DesignedShape::fault); empty when there is none.
  std::string FindFault(const Eigen::VectorXd& theta);

  SceneModel BuildInitialModel();
  // Theta without a fault. Throws std::invalid_argument with one line where the scene does not allow the variation.
  BuiltScene Build(const Eigen::VectorXd& theta, const std::vector<double>& variation);

 private:
  Scene scene_;
  FixedMeshes meshes_;
  RecordedPaths paths_;
  std::optional<SceneDesign> design_;
  std::list<std::pair<Eigen::VectorXd, std::shared_ptr<const DesignedShapes>>> shapes_;
};

}  // namespace knap
