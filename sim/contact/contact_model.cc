#include "sim/contact/contact_model.h"

#include <algorithm>
#include <utility>

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

ContactModel::ContactModel(std::vector<ContactPair> contacts, std::vector<GripSpring> grips)
    : contacts_(std::move(contacts)), grips_(std::move(grips)), reports_(contacts_.size()) {
  sides_ = MakeSides(contacts_);
  near_.reserve(sides_.size());
  patches_.resize(sides_.size());
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

bool ContactModel::Rolls(const PointSide& side) const {
  return side.rolling_radius > 0.0 && contacts_[side.pair].material.rolling_resistance > 0.0;
}

void ContactModel::AddWrenches(Dynamics* dynamics) {
  for (ContactReport& report : reports_) report = ContactReport{};
  bristles_.Clear();
  num_touches_ = 0;
  for (int s = 0; s < static_cast<int>(sides_.size()); ++s) AddSide(s, dynamics);
  AddGripWrenches(grips_, dynamics);
}

void ContactModel::AddSide(int s, Dynamics* dynamics) {
  const PointSide& side = sides_[s];
  const ContactMaterial& material = contacts_[side.pair].material;
  const std::vector<Vector3d>& points = side.points();
  const BodyKinematics& B = dynamics->kinematics()[side.point_body];
  const BodyKinematics& S = dynamics->kinematics()[side.surface_body];
  Patch& patch = patches_[s];
  patch.begin = num_touches_;
  patch.end = num_touches_;
  if (!near_[s].MayTouch(B.X_WB, S.X_WB)) return;
  const RelativeMotion motion = RelativeMotion::Make(B.X_WB, B.V, S.X_WB, S.V);
  const Vector3d w = motion.nu.head<3>();
  const Vector3d v0 = motion.nu.tail<3>();
  patch.wrench = PairWrench(motion);
  auto bristle = std::lower_bound(previous_.id.begin(), previous_.id.end(), side.first_id);
  for (const int i : near_[s].FindPoints(side, motion.X_SB)) {
    if (num_touches_ == static_cast<int>(touches_.size())) touches_.resize(2 * touches_.size() + 8);
    Touch& touch = touches_[num_touches_];
    touch.c = motion.X_SB * points[i];
    if (!CalcElasticPoint(side, &near_[s], i, touch.c, &touch.integrals, &touch.elastic)) continue;
    ++num_touches_;
    touch.point = i;
    touch.a = touch.c + touch.elastic.l;
    touch.u = v0 + w.cross(touch.a);
    touch.z.setZero();
    touch.previous = -1;
    while (bristle != previous_.id.end() && *bristle < side.first_id + i) ++bristle;
    if (bristle != previous_.id.end() && *bristle == side.first_id + i) {
      touch.previous = static_cast<int>(bristle - previous_.id.begin());
      touch.z = previous_.z[touch.previous];
    }
    const ElasticPoint& e = touch.elastic;
    touch.force = CalcPointForce(material, e.N, e.N_light, e.n, touch.u, touch.z, h_, nullptr);
    Vector3d m = Vector3d::Zero();
    if (Rolls(side)) m = CalcRollingMoment(material, side.rolling_radius, touch.force.N, e.n, w).m;
    patch.wrench.AddForce(touch.a, touch.force.f, m);
    if (material.stick_distance > 0.0) {
      bristles_.id.push_back(side.first_id + i);
      bristles_.z.push_back(touch.force.bristle);
    }
  }
  patch.end = num_touches_;
  if (patch.begin == patch.end) return;
  patch.wrench.AddTo(side.point_body, side.surface_body, dynamics);
  ContactReport& report = reports_[side.pair];
  report.active = true;
  const int first = contacts_[side.pair].bodies[0];
  const double sign = first == side.point_body ? 1.0 : -1.0;
  const Vector3d f_W = sign * (S.X_WB.R * patch.wrench.F().tail<3>());
  report.f_W += f_W;
  report.m_W +=
      sign * (S.X_WB.R * patch.wrench.F().head<3>()) + (S.X_WB.p - dynamics->kinematics()[first].X_WB.p).cross(f_W);
}

void ContactModel::AddDerivatives(ContactDerivatives derivatives, Dynamics* dynamics) {
  AddGripDerivatives(grips_, derivatives, dynamics);
  for (int s = 0; s < static_cast<int>(sides_.size()); ++s) {
    const PointSide& side = sides_[s];
    const ContactMaterial& material = contacts_[side.pair].material;
    Patch& patch = patches_[s];
    if (patch.begin == patch.end) continue;
    const Vector3d w = patch.wrench.motion().nu.head<3>();
    const Matrix3d cross_w = Skew(w);
    for (int k = patch.begin; k < patch.end; ++k) {
      Touch& t = touches_[k];
      t.bar = ElasticCotangent{};
      CalcElasticDerivatives(side, t.point, t.c, t.integrals, &t.elastic);
      const ElasticPoint& e = t.elastic;
      CalcPointForce(material, e.N, e.N_light, e.n, t.u, t.z, h_, &t.jacobian);
      const Matrix3d da_dc = Matrix3d::Identity() + e.dl_dc;
      const Matrix3d du_dc = cross_w * da_dc;
      const Matrix3d df_dc =
          t.jacobian.df_dNe * e.dN_dc.transpose() + t.jacobian.df_dn * e.dn_dc + t.jacobian.df_du * du_dc;
      patch.wrench.AddJacobian(t.c, t.a, t.force.f, da_dc, df_dc, t.jacobian.df_du);
      if (!Rolls(side)) continue;
      const RollingMoment rolling = CalcRollingMoment(material, side.rolling_radius, t.force.N, e.n, w);
      const Vector3d dN_dc =
          t.jacobian.dN_dNe * e.dN_dc + e.dn_dc.transpose() * t.jacobian.dN_dn + du_dc.transpose() * t.jacobian.dN_du;
      patch.wrench.AddMomentJacobian(t.c, t.a, rolling.dm_dN * dN_dc.transpose() + rolling.dm_dn * e.dn_dc,
                                     rolling.dm_dN * t.jacobian.dN_du.transpose(), rolling.dm_dw);
    }
    patch.wrench.AddDerivativesTo(side.point_body, side.surface_body, derivatives, dynamics);
  }
}

}  // namespace knap
