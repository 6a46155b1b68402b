#include "sim/contact/contact_model.h"

#include <algorithm>
#include <utility>

#include "sim/contact/contact_work.h"

namespace knap {

using Eigen::Vector3d;

namespace {

// A bristle begins to fade where its patch is lighter than the smaller body laid flat to this depth [m].
constexpr double kLightDepth = 1e-9;

}  // namespace

ContactModel::ContactModel(std::vector<ContactPair> contacts, std::vector<GripSpring> grips)
    : contacts_(std::move(contacts)),
      grips_(std::move(grips)),
      reports_(contacts_.size()),
      work_(std::make_unique<Work>()) {
  work_->sides = MakeSides(contacts_);
  work_->states.resize(work_->sides.size());
  work_->near.reserve(work_->sides.size());
  for (std::size_t s = 0; s < work_->sides.size(); ++s) {
    work_->near.emplace_back(work_->sides[s]);
    const auto cells = static_cast<std::size_t>(work_->sides[s].num_cells());
    work_->states[s].at.patches.resize(cells);
    work_->states[s].at.jacobians.resize(cells);
    work_->states[s].touches.resize(cells);
  }
  for (const ContactPair& contact : contacts_) {
    has_bristles_ = has_bristles_ || contact.material.stick_distance > 0.0;
  }
}

ContactModel::~ContactModel() = default;

void ContactModel::BeginStep(double h, const Bristles& previous) {
  work_->h = h;
  work_->previous.id.assign(previous.id.begin(), previous.id.end());
  work_->previous.z.assign(previous.z.begin(), previous.z.end());
}

void ContactModel::AddWrenches(Dynamics* dynamics) {
  for (ContactReport& report : reports_) report = ContactReport{};
  bristles_.Clear();
  work_->bearing.assign(reports_.size(), 0.0);
  for (std::size_t s = 0; s < work_->sides.size(); ++s) AddSide(s, dynamics);
  for (std::size_t i = 0; i < reports_.size(); ++i) {
    if (work_->bearing[i] > 0.0) reports_[i].p_W /= work_->bearing[i];
  }
  AddGripWrenches(grips_, dynamics);
}

void ContactModel::AddSide(std::size_t s, Dynamics* dynamics) {
  const ContactSide& side = work_->sides[s];
  const ContactMaterial& material = contacts_[side.pair].material;
  const BodyKinematics& B = dynamics->kinematics()[side.body];
  const BodyKinematics& S = dynamics->kinematics()[side.field_body];
  SideState& state = work_->states[s];
  state.num_touches = 0;
  state.depth_share = 0.0;
  const RelativeMotion motion = RelativeMotion::Make(B.X_WB, B.V, S.X_WB, S.V);
  state.X_SB = motion.X_SB;
  if (!work_->near[s].MayTouch(B.X_WB, S.X_WB)) return;
  CalcPatches(side, &work_->near[s], motion.X_SB, &state.at);
  state.wrench = PairWrench(motion);
  PatchLawInput input;
  input.material = &material;
  input.rolling_radius = side.rolling_radius;
  input.N_light = side.modulus * side.size * side.size * kLightDepth;
  input.h = work_->h;
  input.nu = motion.nu;
  ContactReport& report = reports_[side.pair];
  for (int cell = 0; cell < side.num_cells(); ++cell) {
    const PatchIntegrals& patch = state.at.patches[cell];
    if (!patch.active()) continue;
    Touch& touch = state.touches[state.num_touches];
    touch.cell = cell;
    touch.previous = -1;
    input.bristle.setZero();
    const int id = side.first_id + cell;
    const auto bristle = std::lower_bound(work_->previous.id.begin(), work_->previous.id.end(), id);
    if (bristle != work_->previous.id.end() && *bristle == id) {
      touch.previous = static_cast<int>(bristle - work_->previous.id.begin());
      input.bristle = work_->previous.z[touch.previous];
    }
    if (!touch.law.Evaluate(patch, input)) continue;
    ++state.num_touches;
    state.wrench.Add(touch.law.wrench(), touch.law.center(), side.modulus * patch.W);
    if (material.stick_distance > 0.0) {
      bristles_.id.push_back(id);
      bristles_.z.push_back(touch.law.bristle());
    }
    const double force = touch.law.wrench().tail<3>().norm();
    report.p_W += force * (S.X_WB * touch.law.center());
    work_->bearing[static_cast<std::size_t>(side.pair)] += force;
    report.depth = std::max(report.depth, patch.depth);
    state.depth_share = std::max(state.depth_share, patch.depth / side.deepest);
  }
  if (state.num_touches == 0) return;
  state.wrench.AddTo(side.body, side.field_body, dynamics);
  report.active = true;
  report.depth_share = std::max(report.depth_share, state.depth_share);
  const int first = contacts_[side.pair].bodies[0];
  const double sign = first == side.body ? 1.0 : -1.0;
  const Vector3d f_W = sign * (S.X_WB.R * state.wrench.F().tail<3>());
  report.f_W += f_W;
  report.m_W +=
      sign * (S.X_WB.R * state.wrench.F().head<3>()) + (S.X_WB.p - dynamics->kinematics()[first].X_WB.p).cross(f_W);
}

void ContactModel::AddDerivatives(ContactDerivatives derivatives, Dynamics* dynamics) {
  AddGripDerivatives(grips_, derivatives, dynamics);
  for (std::size_t s = 0; s < work_->sides.size(); ++s) {
    const ContactSide& side = work_->sides[s];
    SideState& state = work_->states[s];
    if (state.num_touches == 0) continue;
    CalcPatchJacobians(side, &state.at);
    Matrix6d De = Matrix6d::Zero();
    Matrix6d Dnu = Matrix6d::Zero();
    for (int k = 0; k < state.num_touches; ++k) {
      Touch& touch = state.touches[k];
      touch.bar = PatchCotangent{};
      for (int row = 0; row < 6; ++row) {
        PatchCotangent bar;
        Vector6d bar_nu = Vector6d::Zero();
        Bristle bar_previous = Bristle::Zero();
        touch.law.PullBack(Vector6d::Unit(row), Bristle::Zero(), &bar, &bar_nu, &bar_previous);
        De.row(row) += bar.Pack().transpose() * state.at.jacobians[touch.cell];
        Dnu.row(row) += bar_nu.transpose();
      }
    }
    state.wrench.AddDerivatives(De, Dnu);
    state.wrench.AddDerivativesTo(side.body, side.field_body, derivatives, dynamics);
  }
}

}  // namespace knap
