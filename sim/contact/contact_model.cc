#include "sim/contact/contact_model.h"

#include <algorithm>
#include <utility>

#include "sim/math/check.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

ContactModel::ContactModel(std::vector<ContactPair> contacts)
    : contacts_(std::move(contacts)), reports_(contacts_.size()) {
  sides_ = MakeSides(contacts_);
  near_.reserve(sides_.size());
  bar_samples_.resize(sides_.size());
  for (const PointSide& side : sides_) near_.emplace_back(side);
  for (const ContactPair& contact : contacts_) {
    has_bristles_ = has_bristles_ || contact.material.stick_distance > 0.0;
  }
}

void ContactModel::BeginStep(double h, const Bristles& previous) {
  h_ = h;
  previous_.id.assign(previous.id.begin(), previous.id.end());
  previous_.z.assign(previous.z.begin(), previous.z.end());
}

RelativeMotion ContactModel::CalcMotion(const Dynamics& dynamics, const PointSide& side) const {
  const BodyKinematics& B = dynamics.kinematics()[side.point_body];
  const BodyKinematics& S = dynamics.kinematics()[side.surface_body];
  return RelativeMotion::Make(B.X_WB, B.V, S.X_WB, S.V);
}

template <class Visit>
void ContactModel::VisitTouches(int s, const RelativeMotion& motion, bool want_jacobian, const Visit& visit) {
  const PointSide& side = sides_[s];
  const ContactMaterial& material = contacts_[side.pair].material;
  const std::vector<Vector3d>& points = side.points();
  const Vector3d w = motion.nu.head<3>();
  const Vector3d v0 = motion.nu.tail<3>();
  auto bristle = std::lower_bound(previous_.id.begin(), previous_.id.end(), side.first_id);
  Touch touch;
  for (const int i : near_[s].FindPoints(side, motion.X_SB)) {
    touch.c = motion.X_SB * points[i];
    if (!CalcElasticPoint(side, &near_[s], i, touch.c, want_jacobian, &touch.elastic)) continue;
    touch.a = touch.c + touch.elastic.l;
    touch.u = v0 + w.cross(touch.a);
    touch.previous = -1;
    Vector3d z = Vector3d::Zero();
    while (bristle != previous_.id.end() && *bristle < side.first_id + i) ++bristle;
    if (bristle != previous_.id.end() && *bristle == side.first_id + i) {
      touch.previous = static_cast<int>(bristle - previous_.id.begin());
      z = previous_.z[touch.previous];
    }
    touch.force = CalcPointForce(material, touch.elastic.N, touch.elastic.N_light, touch.elastic.n, touch.u, z, h_,
                                 want_jacobian ? &touch.jacobian : nullptr);
    visit(i, touch);
  }
}

void ContactModel::AddWrenches(Dynamics* dynamics, ContactDerivatives derivatives) {
  const bool want_jacobian = derivatives != ContactDerivatives::kNone;
  for (ContactReport& report : reports_) report = ContactReport{};
  bristles_.Clear();
  for (int s = 0; s < static_cast<int>(sides_.size()); ++s) {
    const PointSide& side = sides_[s];
    const ContactMaterial& material = contacts_[side.pair].material;
    const RelativeMotion motion = CalcMotion(*dynamics, side);
    const Vector3d w = motion.nu.head<3>();
    const Matrix3d cross_w = Skew(w);
    PairWrench wrench(motion);
    bool active = false;
    VisitTouches(s, motion, want_jacobian, [&](int i, const Touch& t) {
      active = true;
      Vector3d m = Vector3d::Zero();
      RollingMoment rolling;
      const bool rolls = side.rolling_radius > 0.0 && material.rolling_resistance > 0.0;
      if (rolls) {
        rolling = CalcRollingMoment(material, side.rolling_radius, t.force.N, t.elastic.n, w);
        m = rolling.m;
      }
      wrench.AddForce(t.a, t.force.f, m);
      if (material.stick_distance > 0.0) {
        bristles_.id.push_back(side.first_id + i);
        bristles_.z.push_back(t.force.bristle);
      }
      if (!want_jacobian) return;
      const Matrix3d da_dc = Matrix3d::Identity() + t.elastic.dl_dc;
      const Matrix3d du_dc = cross_w * da_dc;
      const Matrix3d df_dc = t.jacobian.df_dNe * t.elastic.dN_dc.transpose() + t.jacobian.df_dn * t.elastic.dn_dc +
                             t.jacobian.df_du * du_dc;
      wrench.AddJacobian(t.c, t.a, t.force.f, da_dc, df_dc, t.jacobian.df_du);
      if (!rolls) return;
      const Vector3d dN_dc = t.jacobian.dN_dNe * t.elastic.dN_dc + t.elastic.dn_dc.transpose() * t.jacobian.dN_dn +
                             du_dc.transpose() * t.jacobian.dN_du;
      wrench.AddMomentJacobian(t.c, t.a, rolling.dm_dN * dN_dc.transpose() + rolling.dm_dn * t.elastic.dn_dc,
                               rolling.dm_dN * t.jacobian.dN_du.transpose(), rolling.dm_dw);
    });
    if (!active) continue;
    wrench.AddTo(side.point_body, side.surface_body, derivatives, dynamics);
    ContactReport& report = reports_[side.pair];
    report.active = true;
    const int first = contacts_[side.pair].bodies[0];
    const Pose& X_WS = dynamics->kinematics()[side.surface_body].X_WB;
    const double sign = first == side.point_body ? 1.0 : -1.0;
    const Vector3d f_W = sign * (X_WS.R * wrench.F().tail<3>());
    report.f_W += f_W;
    report.m_W += sign * (X_WS.R * wrench.F().head<3>()) +
                  (X_WS.p - dynamics->kinematics()[first].X_WB.p).cross(f_W);
  }
}

ContactModel::Cotangents ContactModel::MakeCotangents(int num_bodies) const {
  Cotangents out;
  out.bodies.resize(num_bodies);
  for (const ContactPair& contact : contacts_) {
    Eigen::Index count = 0;
    for (const ContactGeometry& shape : contact.shapes) {
      if (const auto* mesh = std::get_if<MeshGeometry>(&shape)) count = mesh->mesh->vertex_count();
    }
    out.vertices.push_back(Eigen::Matrix3Xd::Zero(3, count));
  }
  return out;
}

void ContactModel::PullBackTouch(int s, const RelativeMotion& motion, int i, const Touch& t, const Vector6d& bar_F,
                                 const Vector3d& bar_bristle, Vector6d* bar_e, Vector6d* bar_nu, Cotangents* out) {
  const PointSide& side = sides_[s];
  const ContactPair& contact = contacts_[side.pair];
  const PointForceJacobian& j = t.jacobian;
  const Vector3d w = motion.nu.head<3>();
  const Vector3d bar_M = bar_F.head<3>();
  const Vector3d bar_f = bar_F.tail<3>() + bar_M.cross(t.a);
  Vector3d bar_a = t.force.f.cross(bar_M);
  double bar_N = j.df_dNe.dot(bar_f);
  Vector3d bar_n = j.df_dn.transpose() * bar_f + j.dq_dn.transpose() * bar_bristle;
  Vector3d bar_u = j.df_du.transpose() * bar_f + j.dq_du.transpose() * bar_bristle;
  Vector3d bar_w = Vector3d::Zero();
  if (side.rolling_radius > 0.0 && contact.material.rolling_resistance > 0.0) {
    const RollingMoment rolling =
        CalcRollingMoment(contact.material, side.rolling_radius, t.force.N, t.elastic.n, w);
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
  const Vector3d bar_c = bar_a + bar_N * t.elastic.dN_dc + t.elastic.dn_dc.transpose() * bar_n +
                         t.elastic.dl_dc.transpose() * bar_l;
  if (bar_e != nullptr) {
    bar_e->head<3>() += t.c.cross(bar_c);
    bar_e->tail<3>() += bar_c;
    bar_nu->head<3>() += bar_w;
    bar_nu->tail<3>() += bar_u;
  }
  if (side.surface_mesh) {
    PullBackSurfaceMesh(side, &near_[s], i, t.c, bar_N, bar_n, bar_l, &out->vertices[side.pair]);
  }
  if (side.point_mesh) {
    SampleCotangents& samples = bar_samples_[s];
    if (samples.areas.size() == 0) {
      const auto count = static_cast<Eigen::Index>(side.points().size());
      samples.positions.setZero(3, count);
      samples.areas.setZero(count);
    }
    samples.positions.col(i) += motion.X_SB.R.transpose() * bar_c;
    samples.areas(i) += bar_N_by_force * t.elastic.N / side.areas()[i];
  }
}

void ContactModel::PullBackBristles(const Dynamics& dynamics, const std::vector<Vector3d>& bar_bristles,
                                    Cotangents* out) {
  KNAP_CHECK(bar_bristles.size() == bristles_.z.size(), "{} cotangents of {} bristles", bar_bristles.size(),
             bristles_.z.size());
  std::size_t next = 0;
  for (int s = 0; s < static_cast<int>(sides_.size()); ++s) {
    const PointSide& side = sides_[s];
    if (!(contacts_[side.pair].material.stick_distance > 0.0)) continue;
    const RelativeMotion motion = CalcMotion(dynamics, side);
    Vector6d bar_e = Vector6d::Zero();
    Vector6d bar_nu = Vector6d::Zero();
    VisitTouches(s, motion, true, [&](int i, const Touch& touch) {
      KNAP_CHECK(next < bristles_.id.size() && bristles_.id[next] == side.first_id + i, "bristle of another state");
      PullBackTouch(s, motion, i, touch, Vector6d::Zero(), bar_bristles[next++], &bar_e, &bar_nu, out);
    });
    const Pose X_BS{motion.X_SB.R.transpose(), -(motion.X_SB.R.transpose() * motion.X_SB.p)};
    bar_e += CrossForce(motion.V_B_S, bar_nu);
    BodyCotangent& B = out->bodies[side.point_body];
    BodyCotangent& S = out->bodies[side.surface_body];
    B.eta += ShiftWrench(X_BS, bar_e);
    B.V += ShiftWrench(X_BS, bar_nu);
    S.eta -= bar_e;
    S.V -= bar_nu;
  }
}

void ContactModel::PullBackWrenches(const Dynamics& dynamics, const std::vector<Vector6d>& bar_wrench,
                                    Cotangents* out) {
  for (int s = 0; s < static_cast<int>(sides_.size()); ++s) {
    const PointSide& side = sides_[s];
    const bool has_bristle = contacts_[side.pair].material.stick_distance > 0.0;
    if (!reports_[side.pair].active || !(has_bristle || side.surface_mesh || side.point_mesh)) continue;
    const RelativeMotion motion = CalcMotion(dynamics, side);
    const Pose X_BS{motion.X_SB.R.transpose(), -(motion.X_SB.R.transpose() * motion.X_SB.p)};
    const Vector6d bar_F = ShiftTwist(X_BS, bar_wrench[side.point_body]) - bar_wrench[side.surface_body];
    VisitTouches(s, motion, true, [&](int i, const Touch& touch) {
      PullBackTouch(s, motion, i, touch, bar_F, Vector3d::Zero(), nullptr, nullptr, out);
    });
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
