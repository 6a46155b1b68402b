#include "sim/geometry/mass_properties.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Volume, first and second moments about the reference point.
struct Moments {
  double V = 0.0;
  Vector3d h = Vector3d::Zero();
  Matrix3d C = Matrix3d::Zero();
};

}  // namespace

Matrix3d MassProperties::CalcCentralInertia() const {
  const Vector3d c = CalcCenter();
  return inertia - mass * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose());
}

MassProperties CalcMassProperties(const TriangleMesh& mesh, double density) {
  const Vector3d o = CalcBoundingBox(mesh).center();
  Moments sum;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    const Vector3d a = mesh.vertices[triangle[0]] - o;
    const Vector3d b = mesh.vertices[triangle[1]] - o;
    const Vector3d c = mesh.vertices[triangle[2]] - o;
    const double D = a.dot(b.cross(c));
    const Vector3d s = a + b + c;
    sum.V += D / 6.0;
    sum.h += D / 24.0 * s;
    sum.C += D / 120.0 * (s * s.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  }
  const Matrix3d C = sum.C + o * sum.h.transpose() + sum.h * o.transpose() + sum.V * o * o.transpose();
  return {density * sum.V, density * (sum.h + sum.V * o), density * (C.trace() * Matrix3d::Identity() - C)};
}

Eigen::Matrix3Xd PullBackMassProperties(const TriangleMesh& mesh, double density, const MassProperties& bar) {
  const Vector3d o = CalcBoundingBox(mesh).center();
  const Matrix3d symmetric = 0.5 * (bar.inertia + bar.inertia.transpose());
  const Matrix3d bar_C = density * (symmetric.trace() * Matrix3d::Identity() - symmetric);
  const Vector3d bar_h = density * bar.first_moment + 2.0 * bar_C * o;
  const double bar_V = density * (bar.mass + bar.first_moment.dot(o)) + o.dot(bar_C * o);
  Eigen::Matrix3Xd out = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(mesh.vertices.size()));
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    const Vector3d a = mesh.vertices[triangle[0]] - o;
    const Vector3d b = mesh.vertices[triangle[1]] - o;
    const Vector3d c = mesh.vertices[triangle[2]] - o;
    const double D = a.dot(b.cross(c));
    const Vector3d s = a + b + c;
    // The tetrahedron contributes D · share.
    const double share = bar_V / 6.0 + bar_h.dot(s) / 24.0 +
                         (s.dot(bar_C * s) + a.dot(bar_C * a) + b.dot(bar_C * b) + c.dot(bar_C * c)) / 120.0;
    out.col(triangle[0]) += share * b.cross(c) + D * (bar_h / 24.0 + bar_C * (s + a) / 60.0);
    out.col(triangle[1]) += share * c.cross(a) + D * (bar_h / 24.0 + bar_C * (s + b) / 60.0);
    out.col(triangle[2]) += share * a.cross(b) + D * (bar_h / 24.0 + bar_C * (s + c) / 60.0);
  }
  return out;
}

}  // namespace knap
