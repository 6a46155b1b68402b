#include "sim/contact/point_side.h"

#include <cmath>
#include <limits>

namespace knap {
namespace {

// How far a ball may move before its triangles are looked up again, as a share of its radius: more asks the tree less
// often, less leaves fewer triangles to try.
constexpr double kTriangleMargin = 0.05;

}  // namespace

using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

RelativeMotion RelativeMotion::Make(const Pose& X_WB, const Vector6d& V_B, const Pose& X_WS, const Vector6d& V_S) {
  RelativeMotion out;
  out.X_SB.R = X_WS.R.transpose() * X_WB.R;
  out.X_SB.p = X_WS.ApplyInverse(X_WB.p);
  out.V_B_S.head<3>() = out.X_SB.R * V_B.head<3>();
  out.V_B_S.tail<3>() = out.X_SB.R * V_B.tail<3>() + out.X_SB.p.cross(out.V_B_S.head<3>());
  out.nu = out.V_B_S - V_S;
  return out;
}

NearPoints::NearPoints(const PointSide& side) {
  const std::vector<Vector3d>& points = side.points();
  looks_up_ = side.law == PointSide::Law::kField && points.size() > 1;
  points_.reserve(points.size());
  if (looks_up_) {
    if (side.point_mesh) found_.reserve(points.size());
    const Vector3d& reach = side.field.reach();
    if (std::isinf(reach.x())) {
      for (const Vector3d& p : points) extent_ = std::max(extent_, p.norm());
      margin_ = 0.05 * extent_;
    } else {
      margin_ = 0.25 * reach.minCoeff();
      extent_ = reach.norm() + margin_;
    }
  } else {
    for (int i = 0; i < static_cast<int>(points.size()); ++i) points_.push_back(i);
  }
  if (side.surface_mesh) {
    triangles_.resize(points.size());
    for (NearTriangles& near : triangles_) near.triangles.reserve(64);
  }
}

const std::vector<int>& NearPoints::FindPoints(const PointSide& side, const Pose& X_SB) {
  if (!looks_up_) return points_;
  const bool infinite = std::isinf(side.field.reach().x());
  // Places of B as seen from S move by no more than this since the list was made (or of S from B, likewise).
  const Pose X_BS{X_SB.R.transpose(), -(X_SB.R.transpose() * X_SB.p)};
  const Vector3d& center = side.field.center();
  const Vector3d moved =
      infinite ? Vector3d(X_SB.p + X_BS_.R.transpose() * X_BS_.p) : Vector3d(X_BS * center - X_BS_ * center);
  if (valid_ && moved.norm() + (X_BS.R - X_BS_.R).norm() * extent_ < margin_) return points_;
  X_BS_ = X_BS;
  valid_ = true;
  points_.clear();
  const std::vector<Vector3d>& points = side.points();
  if (infinite) {
    const double highest = side.rho + margin_;
    for (int i = 0; i < static_cast<int>(points.size()); ++i) {
      if ((X_SB * points[i]).z() < highest) points_.push_back(i);
    }
    return points_;
  }
  const Vector3d reach = side.field.reach().array() + margin_;
  const auto keep_if_near = [&](int i) {
    const Vector3d x = (X_SB * points[i] - center).cwiseAbs();
    if ((x.array() <= reach.array()).all()) points_.push_back(i);
  };
  if (!side.point_mesh) {
    for (int i = 0; i < static_cast<int>(points.size()); ++i) keep_if_near(i);
    return points_;
  }
  const Vector3d half = X_BS.R.cwiseAbs() * reach;
  const Vector3d middle = X_BS * center;
  side.point_mesh->sample_bvh().FindTriangles(AlignedBox3d(middle - half, middle + half), &found_);
  for (const int i : found_) keep_if_near(i);
  return points_;
}

const std::vector<int>& NearPoints::FindTriangles(const PointSide& side, int i, const Vector3d& c) {
  NearTriangles& near = triangles_[i];
  const Vector3d reach = Vector3d::Constant(side.rho);
  const AlignedBox3d ball(c - reach, c + reach);
  if (!near.box.contains(ball)) {
    const Vector3d margin = Vector3d::Constant(kTriangleMargin * side.rho);
    near.box = AlignedBox3d(ball.min() - margin, ball.max() + margin);
    side.surface_mesh->bvh().FindTriangles(near.box, &near.triangles);
    // The box's corners hold many that no ball in it reaches.
    const double farthest = side.rho + margin.norm();
    const std::vector<TriangleFrame>& frames = side.surface_mesh->frames();
    std::erase_if(near.triangles, [&](int t) { return !MayReach(frames[t], c, farthest); });
  }
  return near.triangles;
}

namespace {

void CalcOnIntegrals(const PointSide& side, int i, const MeshIntegrals& sum, ElasticPoint* out, IntegralJacobian* j) {
  if (side.law == PointSide::Law::kBallOnMesh) {
    CalcBallOnMesh(sum, side.modulus * side.areas()[i], side.rho, out, j);
  } else {
    CalcSphereOnMesh(sum, side.modulus, side.rho, out, j);
  }
}

}  // namespace

bool CalcElasticPoint(const PointSide& side, NearPoints* near, int i, const Vector3d& c, MeshIntegrals* integrals,
                      ElasticPoint* out) {
  if (side.law == PointSide::Law::kField) {
    return CalcFieldPoint(side.field, c, side.modulus * side.areas()[i], side.rho, false, out);
  }
  *integrals = MeshIntegrals{};
  if (side.law == PointSide::Law::kSphereOnPlane) {
    const SphereTriangleIntegrals plane = CalcSpherePlane(Vector3d::UnitZ(), c.z(), side.rho);
    if (plane.active) integrals->Add(plane, Vector3d::UnitZ());
  } else {
    for (const int t : near->FindTriangles(side, i, c)) {
      const TriangleFrame& frame = side.surface_mesh->frames()[t];
      if (!MayReach(frame, c, side.rho)) continue;
      const SphereTriangleIntegrals part = CalcSphereTriangle(frame, c, side.rho);
      if (part.active) integrals->Add(part, frame.n);
    }
  }
  if (!(integrals->W > 0.0) || integrals->g.isZero(0.0)) return false;
  CalcOnIntegrals(side, i, *integrals, out, nullptr);
  return true;
}

void CalcElasticDerivatives(const PointSide& side, int i, const Vector3d& c, const MeshIntegrals& integrals,
                            ElasticPoint* out) {
  if (side.law == PointSide::Law::kField) {
    CalcFieldPoint(side.field, c, side.modulus * side.areas()[i], side.rho, true, out);
    return;
  }
  IntegralJacobian jacobian;
  CalcOnIntegrals(side, i, integrals, out, &jacobian);
  ChainIntegrals(integrals, jacobian, out);
}

void PullBackSurfaceMesh(const PointSide& side, NearPoints* near, int i, const Vector3d& c,
                         const MeshIntegrals& integrals, const ElasticCotangent& bar, Eigen::Matrix3Xd* bar_vertices) {
  ElasticPoint at;
  IntegralJacobian j;
  CalcOnIntegrals(side, i, integrals, &at, &j);
  const double bar_W = j.dN_dW * bar.N + j.dl_dW.dot(bar.l);
  const Vector3d bar_g = j.dN_dg * bar.N + j.dn_dg.transpose() * bar.n + j.dl_dg.transpose() * bar.l;
  for (const int t : near->FindTriangles(side, i, c)) {
    const TriangleFrame& frame = side.surface_mesh->frames()[t];
    if (!MayReach(frame, c, side.rho)) continue;
    const SphereTriangleIntegrals part = CalcSphereTriangle(frame, c, side.rho);
    if (!part.active) continue;
    const std::array<Vector3d, 3> bar_v = PullBackSphereTriangle(frame, part, c, side.rho, bar_W, bar_g);
    for (int k = 0; k < 3; ++k) bar_vertices->col(side.surface_mesh->triangles()[t][k]) += bar_v[k];
  }
}

}  // namespace knap
