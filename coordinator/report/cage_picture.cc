#include "coordinator/report/cage_picture.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "coordinator/report/svg_ink.h"
#include "sim/morphology/cage_design.h"

namespace knap {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kPanelWidth = 240.0, kPanelHeight = 190.0, kHeader = 64.0, kGap = 14.0;
constexpr std::size_t kColumns = 4;
constexpr std::size_t kMostEdges = 250;  // of the mesh
constexpr double kBend = 20.0 * M_PI / 180.0;
constexpr const char* kLowerColour = "#0969da";
constexpr const char* kUpperColour = "#bc4c00";
constexpr const char* kCageColour = "#d0d7de";

using Edge = std::array<int, 2>;

// Those at which the mesh bends, the sharpest ones where there are too many. A mesh that bends nowhere much: all.
std::vector<Edge> ListEdges(const TriangleMesh& mesh) {
  std::map<Edge, std::vector<Vector3d>> normals;
  for (const Vector3i& t : mesh.triangles) {
    const Vector3d& a = mesh.vertices[t[0]];
    const Vector3d n = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).stableNormalized();
    for (int k = 0; k < 3; ++k) {
      const int p = t[k];
      const int q = t[(k + 1) % 3];
      normals[{std::min(p, q), std::max(p, q)}].push_back(n);
    }
  }
  std::vector<std::pair<double, Edge>> edges;  // by their angle, the largest first
  for (const auto& [edge, sides] : normals) {
    edges.emplace_back(-std::acos(std::clamp(sides.front().dot(sides.back()), -1.0, 1.0)), edge);
  }
  std::sort(edges.begin(), edges.end());
  if (edges.size() > kMostEdges) edges.resize(kMostEdges);
  const auto flat = std::find_if(edges.begin(), edges.end(), [](const auto& e) { return e.first > -kBend; });
  if (flat != edges.begin()) edges.erase(flat, edges.end());
  std::vector<Edge> out;
  for (const auto& [angle, edge] : edges) out.push_back(edge);
  return out;
}

// Seen from in front, from the right and from above, without perspective.
Vector2d Project(const Vector3d& p) {
  const double cos30 = std::cos(M_PI / 6.0);
  return {cos30 * (p.x() + p.y() * 0.6), 0.5 * (p.x() * 0.6 - p.y()) - p.z()};
}

// What one panel shows.
struct View {
  double scale = 1.0;
  Vector2d middle, center;  // of the drawing, and of the panel on paper

  Vector2d Place(const Vector3d& p) const { return center + scale * (Project(p) - middle); }

  std::string Draw(const TriangleMesh& mesh, const std::vector<Edge>& edges, const char* colour, double width) const {
    std::vector<InkLine> lines;
    for (const Edge& edge : edges) {
      lines.push_back({Place(mesh.vertices[static_cast<std::size_t>(edge[0])]),
                       Place(mesh.vertices[static_cast<std::size_t>(edge[1])])});
    }
    return DrawLines(lines, colour, width);
  }
};

}  // namespace

std::string DrawCage(const MadeCage& made, const TriangleMesh& mesh, const std::string& title) {
  const Eigen::VectorXd initial = made.GetInitialTheta();
  const CageDesign design(mesh, made.cage, initial, made.ListMoves());
  const std::size_t count = made.parameters.size();
  std::vector<std::array<TriangleMesh, 2>> at_bounds;
  Eigen::AlignedBox2d paper;
  const auto extend = [&paper](const TriangleMesh& of) {
    for (const Vector3d& v : of.vertices) paper.extend(Project(v));
  };
  extend(made.cage);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<TriangleMesh, 2> both;
    for (std::size_t k = 0; k < 2; ++k) {
      Eigen::VectorXd theta = initial;
      theta(static_cast<Eigen::Index>(i)) = k == 0 ? made.parameters[i].lower : made.parameters[i].upper;
      both[k] = design.CalcMesh(theta);
      extend(both[k]);
    }
    at_bounds.push_back(std::move(both));
  }
  View view;
  view.scale = std::min((kPanelWidth - 2 * kGap) / paper.sizes().x(), (kPanelHeight - 4 * kGap) / paper.sizes().y());
  view.middle = paper.center();
  const std::vector<Edge> edges = ListEdges(mesh);
  const std::vector<Edge> cage_edges = ListEdges(made.cage);
  const std::size_t rows = (count + kColumns - 1) / kColumns;
  std::string out = BeginSvg(kColumns * kPanelWidth + 2 * kGap, kHeader + static_cast<double>(rows) * kPanelHeight);
  out += DrawText({kGap, 26}, 18, "start", kInk, title, "bold");
  out += DrawText({kGap, 48}, 13, "start", kFaint, "each parameter alone: at its lower bound");
  out += DrawText({kGap + 262, 48}, 13, "start", kLowerColour, "blue", "bold");
  out += DrawText({kGap + 300, 48}, 13, "start", kFaint, "and at its upper bound");
  out += DrawText({kGap + 446, 48}, 13, "start", kUpperColour, "orange", "bold");
  for (std::size_t i = 0; i < count; ++i) {
    const CageParameter& parameter = made.parameters[i];
    const Vector2d corner(kGap + static_cast<double>(i % kColumns) * kPanelWidth,
                          kHeader + static_cast<double>(i / kColumns) * kPanelHeight);
    view.center = corner + Vector2d(0.5 * kPanelWidth - kGap, 0.5 * kPanelHeight + kGap);
    out += DrawText(corner + Vector2d(0, 14), 13, "start", kInk, parameter.name, "bold");
    out += DrawText(corner + Vector2d(0, 30), 11, "start", kFaint,
                    fmt::format("{:.4g} mm, from {:.4g} to {:.4g}", 1e3 * parameter.initial, 1e3 * parameter.lower,
                                1e3 * parameter.upper));
    out += view.Draw(made.cage, cage_edges, kCageColour, 1.0) + view.Draw(mesh, edges, kFaint, 0.6) +
           view.Draw(at_bounds[i][0], edges, kLowerColour, 1.0) + view.Draw(at_bounds[i][1], edges, kUpperColour, 1.0);
  }
  return out + "</svg>\n";
}

}  // namespace knap
