#include "sim/contact/point_side.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace knap {
namespace {

// How far a ball may move before its triangles are looked up again, as a share of its radius: more asks the tree less
// often, less leaves fewer triangles to try. Spheres are large beside triangles and roll; balls at corners are small,
// meet few and fly.
constexpr double kMarginOfSphere = 0.05;
constexpr double kMarginOfBall = 2.0;
constexpr double kLargestMargin = 16.0;

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
  const auto enclose = [](const AlignedBox3d& box) {
    return Ball{box.center(), (1.0 + 1e-9) * 0.5 * box.diagonal().norm()};
  };
  AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(p);
  points_ball_ = enclose(box);
  if (side.surface_mesh) {
    AlignedBox3d surface;
    for (const TriangleFrame& frame : side.surface_mesh->frames()) {
      for (const Vector3d& v : frame.v) surface.extend(v);
    }
    surface_ball_ = enclose(surface);
    surface_ball_.radius += side.rho;
  } else if (side.law == PointSide::Law::kField) {
    surface_ball_ = {side.field.center(), (1.0 + 1e-9) * side.field.reach().norm()};
  } else {
    surface_ball_.radius = std::numeric_limits<double>::infinity();
  }
  looks_up_ = side.law == PointSide::Law::kField && points.size() > 1;
  points_.reserve(points.size());
  if (looks_up_) {
    if (side.point_mesh) found_.reserve(points.size());
    const Vector3d& reach = side.field.reach();
    if (std::isinf(reach.x())) {
      for (const Vector3d& p : points) extent_ = std::max(extent_, p.norm());
      margin_ = 0.05 * extent_;
    } else {
      least_margin_ = 0.5 * reach.minCoeff();
    }
  } else {
    for (int i = 0; i < static_cast<int>(points.size()); ++i) points_.push_back(i);
  }
  if (side.surface_mesh) {
    found_.reserve(side.surface_mesh->triangles().size());
    triangles_.resize(points.size());
    for (NearTriangles& near : triangles_) near.triangles.reserve(64);
  }
}

bool NearPoints::MayTouch(const Pose& X_WB, const Pose& X_WS) const {
  const double reach = points_ball_.radius + surface_ball_.radius;
  return std::isinf(reach) || (X_WB * points_ball_.center - X_WS * surface_ball_.center).squaredNorm() <= reach * reach;
}

const std::vector<int>& NearPoints::FindPoints(const PointSide& side, const Pose& X_SB) {
  if (!looks_up_) return side.surface_mesh && points_.size() > 1 && IsClear(side, X_SB) ? none_ : points_;
  const bool infinite = std::isinf(side.field.reach().x());
  // Places of B as seen from S move by no more than this since the list was made (or of S from B, likewise).
  const Pose X_BS{X_SB.R.transpose(), -(X_SB.R.transpose() * X_SB.p)};
  const Vector3d& center = side.field.center();
  const Vector3d moved =
      infinite ? Vector3d(X_SB.p + X_BS_.R.transpose() * X_BS_.p) : Vector3d(X_BS * center - X_BS_ * center);
  if (valid_ && moved.norm() + (X_BS.R - X_BS_.R).norm() * extent_ < margin_) return points_;
  X_BS_ = X_BS;
  const std::vector<Vector3d>& points = side.points();
  if (infinite) {
    valid_ = true;
    points_.clear();
    const double highest = side.rho + margin_;
    for (int i = 0; i < static_cast<int>(points.size()); ++i) {
      if ((X_SB * points[i]).z() < highest) points_.push_back(i);
    }
    return points_;
  }
  margin_ = valid_ && points_.empty() ? std::min(2.0 * margin_, side.field.reach().norm()) : least_margin_;
  valid_ = true;
  CollectPoints(side, X_SB, X_BS);
  if (!points_.empty() && margin_ > least_margin_) {
    margin_ = least_margin_;
    CollectPoints(side, X_SB, X_BS);
  }
  extent_ = side.field.reach().norm() + margin_;
  return points_;
}

void NearPoints::CollectPoints(const PointSide& side, const Pose& X_SB, const Pose& X_BS) {
  points_.clear();
  const std::vector<Vector3d>& points = side.points();
  const Vector3d& center = side.field.center();
  const Vector3d reach = side.field.reach().array() + margin_;
  const auto keep_if_near = [&](int i) {
    const Vector3d x = (X_SB * points[i] - center).cwiseAbs();
    if ((x.array() <= reach.array()).all()) points_.push_back(i);
  };
  if (!side.point_mesh) {
    for (int i = 0; i < static_cast<int>(points.size()); ++i) keep_if_near(i);
    return;
  }
  const Vector3d half = X_BS.R.cwiseAbs() * reach;
  const Vector3d middle = X_BS * center;
  side.point_mesh->sample_bvh().FindTriangles(AlignedBox3d(middle - half, middle + half), &found_);
  for (const int i : found_) keep_if_near(i);
}

bool NearPoints::IsClear(const PointSide& side, const Pose& X_SB) {
  const Vector3d p = X_SB * points_ball_.center;
  if ((p - clear_at_).norm() < clear_margin_) return clear_;
  clear_margin_ = clear_ ? std::min(2.0 * clear_margin_, points_ball_.radius + side.rho) : side.rho;
  clear_at_ = p;
  const Vector3d reach = Vector3d::Constant(points_ball_.radius + side.rho + clear_margin_);
  side.surface_mesh->bvh().FindTriangles(AlignedBox3d(p - reach, p + reach), &found_);
  clear_ = found_.empty();
  if (!clear_) clear_margin_ = side.rho;
  return clear_;
}

const std::vector<int>& NearPoints::FindTriangles(const PointSide& side, int i, const Vector3d& c) {
  NearTriangles& near = triangles_[i];
  const Vector3d reach = Vector3d::Constant(side.rho);
  const AlignedBox3d ball(c - reach, c + reach);
  if (near.box.contains(ball)) return near.triangles;
  const auto ask = [&](double margin, std::vector<int>* triangles) {
    near.margin = margin;
    near.box = AlignedBox3d(ball.min() - Vector3d::Constant(margin), ball.max() + Vector3d::Constant(margin));
    side.surface_mesh->bvh().FindTriangles(near.box, triangles);
  };
  if (near.margin > 0.0 && near.triangles.empty()) {
    ask(std::min(2.0 * near.margin, kLargestMargin * side.rho), &found_);
    if (found_.empty()) return near.triangles;
  }
  const double margin = (side.law == PointSide::Law::kBallOnMesh ? kMarginOfBall : kMarginOfSphere) * side.rho;
  ask(margin, &near.triangles);
  // The box's corners hold many that no ball in it reaches.
  const double farthest = side.rho + std::sqrt(3.0) * margin;
  const std::vector<TriangleFrame>& frames = side.surface_mesh->frames();
  std::erase_if(near.triangles, [&](int t) { return !MayReach(frames[t], c, farthest); });
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
