#include "sim/contact/contact_model.h"
#include "sim/math/check.h"

namespace knap {

using Eigen::Vector3d;

ContactModel::Cotangents ContactModel::MakeCotangents(int num_bodies) const {
  Cotangents out;
  out.bodies.resize(num_bodies);
  out.grips.resize(grips_.size());
  for (const ContactPair& contact : contacts_) {
    Eigen::Index count = 0;
    for (const ContactGeometry& shape : contact.shapes) {
      if (const auto* mesh = std::get_if<MeshGeometry>(&shape)) count = mesh->mesh->vertex_count();
    }
    out.vertices.push_back(Eigen::Matrix3Xd::Zero(3, count));
  }
  return out;
}

void ContactModel::PullBackTouch(int s, const Vector6d& bar_F, const Vector3d& bar_bristle, Touch* touch,
                                 Vector6d* bar_e, Vector6d* bar_nu, Cotangents* out) {
  const PointSide& side = sides_[s];
  const RelativeMotion& motion = patches_[s].wrench.motion();
  const Touch& t = *touch;
  const PointForceJacobian& j = t.jacobian;
  const Vector3d w = motion.nu.head<3>();
  const Vector3d bar_M = bar_F.head<3>();
  const Vector3d bar_f = bar_F.tail<3>() + bar_M.cross(t.a);
  Vector3d bar_a = t.force.f.cross(bar_M);
  double bar_N = j.df_dNe.dot(bar_f);
  Vector3d bar_n = j.df_dn.transpose() * bar_f + j.dq_dn.transpose() * bar_bristle;
  Vector3d bar_u = j.df_du.transpose() * bar_f + j.dq_du.transpose() * bar_bristle;
  Vector3d bar_w = Vector3d::Zero();
  if (Rolls(side)) {
    const RollingMoment rolling =
        CalcRollingMoment(contacts_[side.pair].material, side.rolling_radius, t.force.N, t.elastic.n, w);
    const double bar_total = rolling.dm_dN.dot(bar_M);
    bar_N += j.dN_dNe * bar_total;
    bar_n += j.dN_dn * bar_total + rolling.dm_dn.transpose() * bar_M;
    bar_u += j.dN_du * bar_total;
    bar_w += rolling.dm_dw.transpose() * bar_M;
  }
  if (t.previous >= 0) {
    out->previous[t.previous] += j.df_dz.transpose() * bar_f + j.dq_dz.transpose() * bar_bristle;
  }
  // A point's force and the force below which its bristle fades both grow with the area, so q does not see it.
  const double bar_N_by_force = bar_N;
  bar_N += j.dq_dNe.dot(bar_bristle);
  bar_w += t.a.cross(bar_u);
  bar_a += bar_u.cross(w);
  const Vector3d bar_l = bar_a;
  const Vector3d bar_c =
      bar_a + bar_N * t.elastic.dN_dc + t.elastic.dn_dc.transpose() * bar_n + t.elastic.dl_dc.transpose() * bar_l;
  if (bar_e != nullptr) {
    bar_e->head<3>() += t.c.cross(bar_c);
    bar_e->tail<3>() += bar_c;
    bar_nu->head<3>() += bar_w;
    bar_nu->tail<3>() += bar_u;
  }
  touch->bar.N += bar_N;
  touch->bar.n += bar_n;
  touch->bar.l += bar_l;
  if (side.point_mesh) {
    SampleCotangents& samples = bar_samples_[s];
    if (samples.areas.size() == 0) {
      const auto count = static_cast<Eigen::Index>(side.points().size());
      samples.positions.setZero(3, count);
      samples.areas.setZero(count);
    }
    samples.positions.col(t.point) += motion.X_SB.R.transpose() * bar_c;
    samples.areas(t.point) += bar_N_by_force * t.elastic.N / side.areas()[t.point];
  }
}

void ContactModel::PullBackBristles(const std::vector<Vector3d>& bar_bristles, Cotangents* out) {
  KNAP_CHECK(bar_bristles.size() == bristles_.z.size(), "{} cotangents of {} bristles", bar_bristles.size(),
             bristles_.z.size());
  std::size_t next = 0;
  for (int s = 0; s < static_cast<int>(sides_.size()); ++s) {
    const PointSide& side = sides_[s];
    const Patch& patch = patches_[s];
    if (!(contacts_[side.pair].material.stick_distance > 0.0) || patch.begin == patch.end) continue;
    Vector6d bar_e = Vector6d::Zero();
    Vector6d bar_nu = Vector6d::Zero();
    for (int k = patch.begin; k < patch.end; ++k) {
      PullBackTouch(s, Vector6d::Zero(), bar_bristles[next++], &touches_[k], &bar_e, &bar_nu, out);
    }
    const Pose X_BS = patch.wrench.motion().X_BS();
    bar_e += CrossForce(patch.wrench.motion().V_B_S, bar_nu);
    BodyCotangent& B = out->bodies[side.point_body];
    BodyCotangent& S = out->bodies[side.surface_body];
    B.eta += ShiftWrench(X_BS, bar_e);
    B.V += ShiftWrench(X_BS, bar_nu);
    S.eta -= bar_e;
    S.V -= bar_nu;
  }
}

void ContactModel::PullBackWrenches(const std::vector<Vector6d>& bar_wrench, const Dynamics& dynamics,
                                    Cotangents* out) {
  PullBackGrips(grips_, bar_wrench, dynamics, &out->grips);
  for (int s = 0; s < static_cast<int>(sides_.size()); ++s) {
    const PointSide& side = sides_[s];
    const Patch& patch = patches_[s];
    const bool has_bristle = contacts_[side.pair].material.stick_distance > 0.0;
    if (!(has_bristle || side.surface_mesh || side.point_mesh)) continue;
    const Vector6d bar_F =
        ShiftTwist(patch.wrench.motion().X_BS(), bar_wrench[side.point_body]) - bar_wrench[side.surface_body];
    for (int k = patch.begin; k < patch.end; ++k) {
      Touch& t = touches_[k];
      PullBackTouch(s, bar_F, Vector3d::Zero(), &t, nullptr, nullptr, out);
      if (!side.surface_mesh) continue;
      PullBackSurfaceMesh(side, &near_[s], t.point, t.c, t.integrals, t.bar, &out->vertices[side.pair]);
    }
  }
}

void ContactModel::FinishVertices(Cotangents* out) {
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    SampleCotangents& samples = bar_samples_[s];
    if (samples.areas.size() == 0) continue;
    sides_[s].point_mesh->PullBackSamples(samples.positions, samples.areas, &out->vertices[sides_[s].pair]);
    samples = SampleCotangents{};
  }
}

}  // namespace knap
