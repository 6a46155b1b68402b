#include <Eigen/Geometry>

#include "sim/contact/contact_work.h"
#include "sim/math/check.h"
#include "sim/math/spatial.h"

namespace knap {

using Eigen::Vector3d;

namespace {

// Cotangents of one touch under bar_F · (wrench on B about So) + bar_bristle · bristle; nu's are returned, those of the
// bristles at the step's start added.
Vector6d PullBackTouch(const Vector6d& bar_F, const Bristle& bar_bristle, Touch* touch,
                       std::vector<Bristle>* bar_previous) {
  Vector6d bar_nu = Vector6d::Zero();
  Bristle bar = Bristle::Zero();
  touch->law.PullBack(bar_F, bar_bristle, &touch->bar, &bar_nu, &bar);
  if (touch->previous >= 0) (*bar_previous)[touch->previous] += bar;
  return bar_nu;
}

}  // namespace

ContactModel::Cotangents ContactModel::MakeCotangents(int num_bodies) const {
  Cotangents out;
  out.bodies.resize(num_bodies);
  out.grips.resize(grips_.size());
  for (const ContactPair& contact : contacts_) {
    std::array<Eigen::Matrix3Xd, 2>& vertices = out.vertices.emplace_back();
    for (std::size_t i = 0; i < 2; ++i) {
      const auto* mesh = std::get_if<MeshGeometry>(&contact.shapes[i]);
      vertices[i].setZero(3, mesh != nullptr && mesh->IsDesigned() ? mesh->mesh->vertex_count() : 0);
    }
  }
  return out;
}

void ContactModel::PullBackOutcome(const std::vector<Bristle>& bar_bristles, const std::vector<Vector3d>& bar_forces,
                                   const Dynamics& dynamics, Cotangents* out) {
  KNAP_CHECK(bar_bristles.size() == bristles_.z.size(), "{} cotangents of {} bristles", bar_bristles.size(),
             bristles_.z.size());
  std::size_t next = 0;
  for (std::size_t s = 0; s < work_->sides.size(); ++s) {
    const ContactSide& side = work_->sides[s];
    SideState& state = work_->states[s];
    const bool has_bristle = contacts_[side.pair].material.stick_distance > 0.0;
    const Vector3d bar_f_W = bar_forces.empty() ? Vector3d(Vector3d::Zero()) : bar_forces[side.pair];
    if (state.num_touches == 0 || !(has_bristle || !bar_f_W.isZero(0.0))) continue;
    // f_W = ±R_WS F, F the force on B.
    const double sign = contacts_[side.pair].bodies[0] == side.body ? 1.0 : -1.0;
    Vector6d bar_F = Vector6d::Zero();
    bar_F.tail<3>() = sign * (dynamics.kinematics()[side.field_body].X_WB.R.transpose() * bar_f_W);
    Vector6d bar_e = Vector6d::Zero();
    Vector6d bar_nu = Vector6d::Zero();
    for (int k = 0; k < state.num_touches; ++k) {
      Touch& touch = state.touches[k];
      bar_nu +=
          PullBackTouch(bar_F, has_bristle ? bar_bristles[next++] : Bristle(Bristle::Zero()), &touch, &out->previous);
      bar_e += state.at.jacobians[touch.cell].transpose() * touch.bar.Pack();
    }
    const Pose X_BS = state.wrench.motion().X_BS();
    bar_e += CrossForce(state.wrench.motion().V_B_S, bar_nu);
    BodyCotangent& B = out->bodies[side.body];
    BodyCotangent& S = out->bodies[side.field_body];
    B.eta += ShiftWrench(X_BS, bar_e);
    B.V += ShiftWrench(X_BS, bar_nu);
    S.eta -= bar_e;
    S.V -= bar_nu;
    S.eta.head<3>() += Vector3d(state.wrench.F().tail<3>()).cross(Vector3d(bar_F.tail<3>()));
  }
}

void ContactModel::PullBackWrenches(const std::vector<Vector6d>& bar_wrench, const Dynamics& dynamics,
                                    Cotangents* out) {
  PullBackGrips(grips_, bar_wrench, dynamics, &out->grips);
  std::vector<PatchCotangent> bar;
  for (std::size_t s = 0; s < work_->sides.size(); ++s) {
    const ContactSide& side = work_->sides[s];
    SideState& state = work_->states[s];
    const bool has_bristle = contacts_[side.pair].material.stick_distance > 0.0;
    if (state.num_touches == 0 || !(has_bristle || side.depends_on_design())) continue;
    const RelativeMotion& motion = state.wrench.motion();
    const Vector6d bar_F = ShiftTwist(motion.X_BS(), bar_wrench[side.body]) - bar_wrench[side.field_body];
    bar.assign(static_cast<std::size_t>(side.num_cells()), PatchCotangent{});
    for (int k = 0; k < state.num_touches; ++k) {
      Touch& touch = state.touches[k];
      PullBackTouch(bar_F, Bristle::Zero(), &touch, &out->previous);
      bar[touch.cell] = touch.bar;
    }
    if (!side.depends_on_design()) continue;
    std::array<Eigen::Matrix3Xd, 2>& vertices = out->vertices[side.pair];
    PullBackVertices(side, state.at, bar, &vertices[side.shape], &vertices[1 - side.shape]);
  }
}

}  // namespace knap
