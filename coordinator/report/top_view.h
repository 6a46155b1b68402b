// What a picture of a rollout from above shows, in metres and seconds, before it becomes ink.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/learning/problem.h"
#include "coordinator/report/silhouette.h"
#include "sim/rollout/rollout.h"

namespace knap {

struct TracedPath {
  std::vector<Eigen::Vector2d> points;  // right, up [m]
  bool success = false;
};

// One design at work. Coordinates: right along the opening, up across it.
struct TopView {
  std::vector<TracedPath> paths;
  Outline tool_at_contact;
  std::vector<Outline> tool_between;  // at equal times between the two
  Outline tool_at_end;
};

// The watched opening and body, when DrawPicture can show the scene.
std::optional<Opening> FindShownOpening(const Scene& scene);

// Simulates theta on these variations. `opening` is FindShownOpening's.
TopView TraceTopView(RolloutModel& model, const std::vector<double>& theta,
                     const std::vector<std::vector<double>>& variations, const Opening& opening);

// Where the body may start: the rectangle of the uniform draws of its start position; empty when it is no such draw in
// both directions.
Eigen::AlignedBox2d FindStartBox(const Scene& scene, const VariationSpec& variations, const Opening& opening);

// Radius of the watched body [m]; 0 when it is no sphere.
double FindBodyRadius(const Scene& scene, const std::string& body);

}  // namespace knap
