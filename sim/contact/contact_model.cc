#include "sim/contact/contact_model.h"

#include <utility>

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

using Matrix6x9 = Eigen::Matrix<double, 6, 9>;

// Force and moment of one contact in S, with d(f, m)/d(c, u, w).
struct Total {
  bool active = false;
  Vector3d f = Vector3d::Zero();
  Vector3d m = Vector3d::Zero();
  Matrix6x9 jacobian = Matrix6x9::Zero();

  void Add(const PatchForce& patch, const SphereTriangleJacobian* geometry) {
    active = true;
    f += patch.f;
    m += patch.m;
    if (geometry == nullptr) return;
    jacobian.leftCols<3>() +=
        patch.jacobian.col(0) * geometry->dW_dc + patch.jacobian.middleCols<3>(1) * geometry->dg_dc;
    jacobian.rightCols<6>() += patch.jacobian.rightCols<6>();
  }
};

}  // namespace

ContactMesh::ContactMesh(const TriangleMesh& mesh)
    : triangles_(mesh.triangles),
      vertex_count_(static_cast<int>(mesh.vertices.size())),
      bvh_(std::make_unique<TriangleBvh>(mesh)) {
  frames_.reserve(mesh.triangles.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    frames_.push_back(TriangleFrame::Make(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
  }
}

ContactModel::ContactModel(std::vector<SphereContact> contacts)
    : contacts_(std::move(contacts)), reports_(contacts_.size()), candidates_(contacts_.size()) {
  for (Candidates& c : candidates_) c.triangles.reserve(256);
}

ContactModel::RelativeMotion ContactModel::CalcRelativeMotion(const Dynamics& dynamics,
                                                              const SphereContact& contact) const {
  const BodyKinematics& B = dynamics.kinematics()[contact.sphere_body];
  const BodyKinematics& S = dynamics.kinematics()[contact.surface_body];
  RelativeMotion out;
  out.R_SB = S.X_WB.R.transpose() * B.X_WB.R;
  out.c = S.X_WB.ApplyInverse(B.X_WB * contact.p_BC);
  out.v_C_B = B.V.tail<3>() + B.V.head<3>().cross(contact.p_BC);
  out.u = out.R_SB * out.v_C_B - S.V.tail<3>() - S.V.head<3>().cross(out.c);
  out.w = out.R_SB * B.V.head<3>() - S.V.head<3>();
  return out;
}

const std::vector<int>& ContactModel::FindCandidates(int index, const Vector3d& c) {
  const SphereContact& contact = contacts_[index];
  Candidates& cache = candidates_[index];
  const Vector3d reach = Vector3d::Constant(contact.radius);
  const Eigen::AlignedBox3d sphere(c - reach, c + reach);
  if (!cache.box.contains(sphere)) {
    const Vector3d margin = Vector3d::Constant(0.25 * contact.radius);
    cache.box = Eigen::AlignedBox3d(sphere.min() - margin, sphere.max() + margin);
    contact.mesh->bvh().FindTriangles(cache.box, &cache.triangles);
  }
  return cache.triangles;
}

void ContactModel::AddWrenches(Dynamics* dynamics, bool want_jacobian) {
  for (std::size_t index = 0; index < contacts_.size(); ++index) {
    const SphereContact& contact = contacts_[index];
    const RelativeMotion motion = CalcRelativeMotion(*dynamics, contact);
    Total total;
    double sum_W = 0.0;
    Vector3d sum_g = Vector3d::Zero();
    SphereTriangleJacobian sum_geometry{Eigen::RowVector3d::Zero(), Matrix3d::Zero()};
    const auto add = [&](const SphereTriangleIntegrals& integrals, const Vector3d& n) {
      sum_W += integrals.W;
      sum_g += integrals.g;
      if (!want_jacobian) return;
      const SphereTriangleJacobian geometry = CalcSphereTriangleJacobian(integrals, n);
      sum_geometry.dW_dc += geometry.dW_dc;
      sum_geometry.dg_dc += geometry.dg_dc;
    };
    if (contact.mesh) {
      for (const int t : FindCandidates(static_cast<int>(index), motion.c)) {
        const TriangleFrame& frame = contact.mesh->frames()[t];
        const SphereTriangleIntegrals integrals = CalcSphereTriangle(frame, motion.c, contact.radius);
        if (integrals.active) add(integrals, frame.n);
      }
    } else {
      const SphereTriangleIntegrals integrals = CalcSpherePlane(Vector3d::UnitZ(), motion.c.z(), contact.radius);
      if (integrals.active) add(integrals, Vector3d::UnitZ());
    }
    if (sum_W > 0.0) {
      total.Add(CalcPatchForce(contact.material, contact.radius, sum_W, sum_g, motion.u, motion.w, want_jacobian),
                want_jacobian ? &sum_geometry : nullptr);
    }
    ContactReport& report = reports_[index];
    report = ContactReport{};
    if (!total.active) continue;
    const BodyKinematics& S = dynamics->kinematics()[contact.surface_body];
    report = {true, S.X_WB.R * total.f, S.X_WB.R * total.m};

    const Vector3d f_B = motion.R_SB.transpose() * total.f;
    const Vector3d m_B = motion.R_SB.transpose() * total.m;
    ExternalWrench& wrench = dynamics->external()[contact.sphere_body];
    wrench.F.head<3>() += m_B + contact.p_BC.cross(f_B);
    wrench.F.tail<3>() += f_B;
    wrench.moment_scale += (contact.radius + contact.p_BC.norm()) * f_B.norm();
    if (!want_jacobian) continue;

    // (c, u, w) in the perturbation (phi, epsilon) of the pose and (dw, dv) of the twist, all in B.
    const Vector3d& w_B = dynamics->kinematics()[contact.sphere_body].V.head<3>();
    Eigen::Matrix<double, 9, 6> by_pose;
    by_pose.block<3, 3>(0, 0) = -motion.R_SB * Skew(contact.p_BC);
    by_pose.block<3, 3>(0, 3) = motion.R_SB;
    by_pose.middleRows<3>(3) = -Skew(S.V.head<3>()) * by_pose.topRows<3>();
    by_pose.block<3, 3>(3, 0) -= motion.R_SB * Skew(motion.v_C_B);
    by_pose.bottomRows<3>().setZero();
    by_pose.block<3, 3>(6, 0) = -motion.R_SB * Skew(w_B);
    Eigen::Matrix<double, 6, 6> by_twist;  // of (u, w) alone
    by_twist.block<3, 3>(0, 0) = by_pose.block<3, 3>(0, 0);
    by_twist.block<3, 3>(0, 3) = motion.R_SB;
    by_twist.block<3, 3>(3, 0) = motion.R_SB;
    by_twist.block<3, 3>(3, 3).setZero();

    const auto add_rotated = [&](const Matrix6d& d_fm, bool pose, Matrix6d* target) {
      // Rows (f, m) in S → (moment about Bo, force) in B; a turn of B turns the components too.
      Eigen::Matrix<double, 3, 6> df = motion.R_SB.transpose() * d_fm.topRows<3>();
      Eigen::Matrix<double, 3, 6> dm = motion.R_SB.transpose() * d_fm.bottomRows<3>();
      if (pose) {
        df.leftCols<3>() += Skew(f_B);
        dm.leftCols<3>() += Skew(m_B);
      }
      target->topRows<3>() += dm + Skew(contact.p_BC) * df;
      target->bottomRows<3>() += df;
    };
    add_rotated(total.jacobian * by_pose, true, &wrench.dF_deta);
    add_rotated(total.jacobian.rightCols<6>() * by_twist, false, &wrench.dF_dV);
  }
}

void ContactModel::PullBackVertices(const Dynamics& dynamics, const std::vector<Vector6d>& bar_wrench,
                                    std::vector<Eigen::Matrix3Xd>* bar_vertices) {
  for (std::size_t index = 0; index < contacts_.size(); ++index) {
    const SphereContact& contact = contacts_[index];
    if (!contact.mesh || !reports_[index].active) continue;
    const RelativeMotion motion = CalcRelativeMotion(dynamics, contact);
    const Vector6d& bar = bar_wrench[contact.sphere_body];
    Vector6d bar_fm;  // of (f, m) in S
    bar_fm.head<3>() = motion.R_SB * (bar.tail<3>() + bar.head<3>().cross(contact.p_BC));
    bar_fm.tail<3>() = motion.R_SB * bar.head<3>();
    Eigen::Matrix3Xd& target = (*bar_vertices)[index];
    double W = 0.0;
    Vector3d g = Vector3d::Zero();
    const std::vector<int>& candidates = FindCandidates(static_cast<int>(index), motion.c);
    for (const int t : candidates) {
      const SphereTriangleIntegrals integrals =
          CalcSphereTriangle(contact.mesh->frames()[t], motion.c, contact.radius);
      W += integrals.W;
      g += integrals.g;
    }
    const PatchForce patch = CalcPatchForce(contact.material, contact.radius, W, g, motion.u, motion.w, true);
    const Eigen::Vector4d bar_Wg = patch.jacobian.leftCols<4>().transpose() * bar_fm;
    for (const int t : candidates) {
      const TriangleFrame& frame = contact.mesh->frames()[t];
      const SphereTriangleIntegrals integrals = CalcSphereTriangle(frame, motion.c, contact.radius);
      if (!integrals.active) continue;
      const std::array<Vector3d, 3> bar_v =
          PullBackSphereTriangle(frame, integrals, motion.c, contact.radius, bar_Wg(0), bar_Wg.tail<3>());
      for (int k = 0; k < 3; ++k) target.col(contact.mesh->triangles()[t][k]) += bar_v[k];
    }
  }
}

}  // namespace knap
