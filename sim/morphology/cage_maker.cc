#include "sim/morphology/cage_maker.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <stdexcept>
#include <utility>

#include "sim/morphology/cage_fit.h"

namespace knap {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};
constexpr double kLeast = 0.6, kMost = 1.5, kOffset = 0.3;

double RoundToFourDigits(double metres) {
  return std::strtod(fmt::format("{:.4g}", 1e3 * metres).c_str(), nullptr) / 1e3;
}

class Maker {
 public:
  Maker(const TriangleMesh& mesh, const CageOptions& options)
      : mesh_(mesh), options_(options), a_(options.axis), b_(a_ == 0 ? 1 : 0), c_(a_ == 2 ? 1 : 2) {
    const Eigen::AlignedBox3d box = CalcBoundingBox(mesh);
    low_ = box.min()[a_];
    high_ = box.max()[a_];
  }

  MadeCage Make() {
    for (int i = 0; i < options_.stations; ++i) AddStation(i);
    AddTriangles();
    AddGroups();
    AddParameters();
    return std::move(out_);
  }

 private:
  double span() const { return (high_ - low_) / (options_.stations - 1); }
  Vector2d Flatten(const Vector3d& p) const { return {p[b_], p[c_]}; }

  // The rectangle around what the mesh has between two places along the axis.
  AlignedBox2d FindOutline(double from, double until) const {
    AlignedBox2d box;
    for (const Vector3d& v : mesh_.vertices) {
      if (v[a_] >= from && v[a_] <= until) box.extend(Flatten(v));
    }
    for (const Vector3i& t : mesh_.triangles) {
      for (int k = 0; k < 3; ++k) {
        const Vector3d& p = mesh_.vertices[t[k]];
        const Vector3d& q = mesh_.vertices[t[(k + 1) % 3]];
        for (const double cut : {from, until}) {
          if ((p[a_] - cut) * (q[a_] - cut) >= 0.0) continue;
          box.extend(Flatten(p + (cut - p[a_]) / (q[a_] - p[a_]) * (q - p)));
        }
      }
    }
    return box;
  }

  void AddStation(int i) {
    // The ends of the cage lie beyond the mesh's, its other stations at equal distances of the mesh.
    double along = low_ + i * span();
    if (i == 0) along = low_ - options_.margin;
    if (i == options_.stations - 1) along = high_ + options_.margin;
    const bool is_fitted = options_.shape == CageShape::kFitted;
    const AlignedBox2d outline =
        is_fitted ? FindOutline(std::max(low_, low_ + (i - 1) * span()), std::min(high_, low_ + (i + 1) * span()))
                  : FindOutline(low_, high_);
    outlines_.push_back(outline);
    const std::vector<Vector2d> ring = options_.shape == CageShape::kPrism ? MakeOctagon() : MakeRectangle(outline);
    sides_ = static_cast<int>(ring.size());
    for (const Vector2d& at : ring) {
      Vector3d p;
      p[a_] = along;
      p[b_] = at.x();
      p[c_] = at.y();
      out_.cage.vertices.push_back(p);
    }
  }

  std::vector<Vector2d> MakeRectangle(const AlignedBox2d& outline) const {
    const Vector2d low = outline.min().array() - options_.margin;
    const Vector2d high = outline.max().array() + options_.margin;
    return {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  }

  // The corners of eight lines that touch the mesh from outside, moved outwards by the margin: each two meet at 45
  // degrees, and no two corners are nearer to one another than 0.8 margins.
  std::vector<Vector2d> MakeOctagon() const {
    std::array<Vector2d, 8> normal;
    std::array<double, 8> distance;
    for (std::size_t k = 0; k < 8; ++k) {
      const double angle = 0.25 * M_PI * static_cast<double>(k);
      normal[k] = {std::cos(angle), std::sin(angle)};
      distance[k] = -1e300;
      for (const Vector3d& v : mesh_.vertices) distance[k] = std::max(distance[k], normal[k].dot(Flatten(v)));
      distance[k] += options_.margin;
    }
    std::vector<Vector2d> ring;
    for (std::size_t k = 0; k < 8; ++k) {
      Eigen::Matrix2d lines;
      lines << normal[k].transpose(), normal[(k + 1) % 8].transpose();
      ring.emplace_back(lines.inverse() * Vector2d(distance[k], distance[(k + 1) % 8]));
    }
    return ring;
  }

  void AddTriangles() {
    std::vector<Vector3i>& triangles = out_.cage.triangles;
    const int n = sides_;
    const int last = (options_.stations - 1) * n;
    for (int k = 1; k + 1 < n; ++k) {
      triangles.emplace_back(0, k + 1, k);
      triangles.emplace_back(last, last + k, last + k + 1);
    }
    for (int first = 0; first < last; first += n) {
      for (int k = 0; k < n; ++k) {
        const int next = (k + 1) % n;
        triangles.emplace_back(first + k, first + next, first + n + next);
        triangles.emplace_back(first + k, first + n + next, first + n + k);
      }
    }
    if (CalcSignedVolume(out_.cage) > 0.0) return;
    for (Vector3i& t : triangles) std::swap(t[1], t[2]);
  }

  // Of each station: all, then the halves on either side of its middle along b and along c.
  void AddGroups() {
    for (int i = 0; i < options_.stations; ++i) {
      const std::string name = fmt::format("station_{}", i + 1);
      CageGroup all{name, {}};
      for (int k = 0; k < sides_; ++k) all.vertices.push_back(i * sides_ + k);
      out_.groups.push_back(all);
      const Vector2d middle = outlines_[static_cast<std::size_t>(i)].center();
      for (int side = 0; side < 4; ++side) {
        const int axis = side < 2 ? b_ : c_;
        const bool is_high = side % 2 == 1;
        CageGroup half{
            fmt::format("{}_{}_{}", name, is_high ? "high" : "low", kAxisNames[static_cast<std::size_t>(axis)]), {}};
        for (const int v : all.vertices) {
          const double at = out_.cage.vertices[static_cast<std::size_t>(v)][axis];
          if ((at > middle[side < 2 ? 0 : 1]) == is_high) half.vertices.push_back(v);
        }
        out_.groups.push_back(half);
      }
    }
  }

  void AddParameters() {
    const int n = options_.stations;
    const auto station = [](int i) { return 5 * i; };
    const auto bound = [this](const std::string& name, double measure) -> CageParameter& {
      // Where the mesh ends in a point there is nothing but the margins.
      const double value = std::max(measure, 2.0 * options_.margin);
      return out_.parameters.emplace_back(CageParameter{
          name, RoundToFourDigits(value), RoundToFourDigits(kLeast * value), RoundToFourDigits(kMost * value), {}});
    };
    for (int i = 0; i + 1 < n; ++i) {
      CageParameter& length = bound(fmt::format("length_{}", i + 1), span());
      for (int j = i + 1; j < n; ++j) length.moves.push_back({station(j), Vector3d::Unit(a_)});
    }
    for (const bool is_width : {true, false}) {
      const int axis = is_width ? b_ : c_;
      for (int i = 0; i < n; ++i) {
        const Vector2d size = outlines_[static_cast<std::size_t>(i)].sizes();
        CageParameter& across =
            bound(fmt::format("{}_{}", is_width ? "width" : "height", i + 1), size[is_width ? 0 : 1]);
        const int low = station(i) + (is_width ? 1 : 3);
        across.moves = {{low, -0.5 * Vector3d::Unit(axis)}, {low + 1, 0.5 * Vector3d::Unit(axis)}};
      }
    }
    for (int i = 0; i < n; ++i) {
      for (const int axis : {b_, c_}) {
        const double reach = RoundToFourDigits(kOffset * span());
        out_.parameters.push_back({fmt::format("offset_{}_{}", i + 1, kAxisNames[static_cast<std::size_t>(axis)]),
                                   0.0,
                                   -reach,
                                   reach,
                                   {{station(i), Vector3d::Unit(axis)}}});
      }
    }
  }

  const TriangleMesh& mesh_;
  const CageOptions options_;
  const int a_, b_, c_;
  double low_ = 0.0, high_ = 0.0;
  int sides_ = 0;
  std::vector<AlignedBox2d> outlines_;
  MadeCage out_;
};

}  // namespace

std::vector<VertexMove> MadeCage::ListMoves() const {
  std::vector<VertexMove> moves;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    for (const CageParameter::Move& move : parameters[i].moves) {
      for (const int v : groups[static_cast<std::size_t>(move.group)].vertices) {
        moves.push_back({static_cast<int>(i), v, move.direction});
      }
    }
  }
  return moves;
}

Eigen::VectorXd MadeCage::GetInitialTheta() const {
  Eigen::VectorXd theta(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) theta(static_cast<Eigen::Index>(i)) = parameters[i].initial;
  return theta;
}

double CalcUsualMargin(const TriangleMesh& mesh) { return 0.01 * CalcBoundingBox(mesh).diagonal().norm(); }

MadeCage MakeCage(const TriangleMesh& mesh, const CageOptions& options) {
  if (options.stations < 2) throw std::invalid_argument("a cage has two stations or more");
  if (!(options.margin > 0.0)) throw std::invalid_argument("the cage's margin must be more than 0");
  MadeCage made = Maker(mesh, options).Make();
  const std::string misfit = DescribeMisfit(mesh, made.cage);
  if (!misfit.empty()) throw std::invalid_argument(misfit);
  return made;
}

}  // namespace knap
