#include "sim/rollout/built_scene.h"

#include <cstddef>

#include "sim/rollout/perturb_scene.h"
#include "sim/scenarios/apply_variation.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {

using Eigen::VectorXd;

namespace {

constexpr std::size_t kCachedShapes = 4;

}  // namespace

SceneSource::SceneSource(const std::map<std::string, std::string>& files)
    : scene_(ParseScenarioFiles(files)),
      meshes_(ReadFixedMeshes(scene_, files)),
      paths_(ReadRecordedPaths(scene_, files)) {
  if (scene_.design) design_.emplace(scene_, files);
}

std::shared_ptr<const DesignedShapes> SceneSource::GetShapes(const VectorXd& theta) {
  for (auto it = shapes_.begin(); it != shapes_.end(); ++it) {
    if (it->first == theta) {
      shapes_.splice(shapes_.begin(), shapes_, it);
      return shapes_.front().second;
    }
  }
  shapes_.emplace_front(theta,
                        std::make_shared<DesignedShapes>(design_ ? design_->CalcShapes(theta) : DesignedShapes{}));
  if (shapes_.size() > kCachedShapes) shapes_.pop_back();
  return shapes_.front().second;
}

std::string SceneSource::FindFault(const VectorXd& theta) {
  for (const auto& [name, shape] : *GetShapes(theta)) {
    if (!shape.fault.empty()) return shape.fault;
  }
  return {};
}

SceneModel SceneSource::BuildInitialModel() {
  return BuildModel(scene_, *GetShapes(design_ ? design_->initial_theta() : VectorXd()), meshes_, paths_);
}

BuiltScene SceneSource::Build(const VectorXd& theta, const std::vector<double>& variation) {
  BuiltScene built;
  built.scene = Scene(scene_);  // of a copied variant GCC 12 warns that it is uninitialized; not of a moved one
  ApplyVariation(built.scene, variation);
  PerturbScene(&built.scene);
  built.moved = Scene(built.scene);
  if (design_) design_->MoveAttachments(theta, &built.moved);
  built.shapes = GetShapes(theta);
  built.model = BuildModel(built.moved, *built.shapes, meshes_, paths_);
  built.signals = std::make_unique<SignalSet>(built.scene, built.moved, built.model, *built.shapes);
  return built;
}

}  // namespace knap
