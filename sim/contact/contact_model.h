// All contacts of a scene: pairs of shapes on two bodies, as wrenches with derivatives; and its grips (grip.h).
//
// Each pair becomes one or two sides, a body in another's depth field (contact_side.h); each side has a patch in every
// cell of the field, and each patch one law of dissipation (patch_law.h). The elastic part is the gradient of an
// energy, C¹ in poses and in the vertices of meshes and the same for every triangulation.
//
// Between steps every patch in contact keeps a bristle (bristle.h), expressed in the frame of the field's body. Either
// body may move; where both do, cross() of the dynamics couples them.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <memory>
#include <vector>

#include "sim/contact/bristle.h"
#include "sim/contact/contact_side.h"
#include "sim/contact/grip.h"
#include "sim/contact/pair_wrench.h"
#include "sim/multibody/dynamics.h"

namespace knap {

// A share of the depth that the thinner of two bodies, or the field, has: what is deeper has gone through.
inline constexpr double kPassage = 0.5;

// What one contact did at the last evaluation, for onset counts, certificates, reports and tests.
struct ContactReport {
  bool active = false;
  Eigen::Vector3d f_W = Eigen::Vector3d::Zero();  // on the first body [N]
  Eigen::Vector3d m_W = Eigen::Vector3d::Zero();  // about the first body's origin [N m]
  // The mean of its patches' centres, each weighted with the force that its place bears; of no account without one [m].
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  double depth = 0.0;        // the largest depth of the field that was reached [m]
  double depth_share = 0.0;  // of what the thinner body, or the field, has; 1: used up
};

// The bristles that are bent, by ascending number of their patch.
struct Bristles {
  std::vector<int> id;
  std::vector<Bristle> z;  // [m]
  void Clear() {
    id.clear();
    z.clear();
  }
  int size() const { return static_cast<int>(id.size()); }
};

class ContactModel {
 public:
  // Throws as MakeSides does.
  explicit ContactModel(std::vector<ContactPair> contacts, std::vector<GripSpring> grips = {});
  ~ContactModel();

  const std::vector<ContactPair>& contacts() const { return contacts_; }
  const std::vector<GripSpring>& grips() const { return grips_; }
  bool has_bristles() const { return has_bristles_; }

  // The step that following evaluations belong to: its length and the bristles at its start.
  void BeginStep(double h, const Bristles& previous);

  // Adds the wrench of every contact, and of every grip that acts at the dynamics' time, to dynamics->external().
  void AddWrenches(Dynamics* dynamics);
  // Adds the derivatives of the wrenches added last to dynamics->external() and cross().
  void AddDerivatives(ContactDerivatives derivatives, Dynamics* dynamics);

  // Whether a step leads through a body: on the straight way of each pair from where NotePoses saw them to where
  // AddWrenches saw them last, with even speed and turn, the first contact that is deeper than kPassage on the way and
  // at neither end; -1 where there is none. Only ways longer than a quarter of the thinner body are looked at.
  int FindPassage();
  void NotePoses();

  // Of the last AddWrenches.
  const std::vector<ContactReport>& reports() const { return reports_; }
  const Bristles& bristles() const { return bristles_; }

  // Cotangents, all added: of bodies' perturbations, of the bristles at the step's start (one each), of meshes, and of
  // the points of grips.
  struct Cotangents {
    std::vector<BodyCotangent> bodies;
    std::vector<Bristle> previous;
    std::vector<std::array<Eigen::Matrix3Xd, 2>>
        vertices;  // for each contact's shapes: of a designed mesh's, else empty
    std::vector<GripCotangent> grips;
  };
  Cotangents MakeCotangents(int num_bodies) const;

  // The two of one step, in this order, after AddDerivatives.
  // Under Σ bar_bristles · bristles() + Σ_i bar_forces[i] · reports()[i].f_W: bodies and previous; vertices are left to
  // PullBackWrenches. Without `bar_forces` there are none.
  void PullBackOutcome(const std::vector<Bristle>& bar_bristles, const std::vector<Eigen::Vector3d>& bar_forces,
                       const Dynamics& dynamics, Cotangents* out);
  // Under Σ_i bar_wrench[i] · F_i: previous, vertices and grips (the bodies' part is in the dynamics' own pull-back).
  void PullBackWrenches(const std::vector<Vector6d>& bar_wrench, const Dynamics& dynamics, Cotangents* out);

 private:
  struct Work;  // contact_work.h
  void AddSide(std::size_t s, Dynamics* dynamics);
  bool LeadsThrough(std::size_t s);

  std::vector<ContactPair> contacts_;
  std::vector<GripSpring> grips_;
  std::vector<ContactReport> reports_;
  bool has_bristles_ = false;
  Bristles bristles_;
  // Apart, since most of what a source pays for this header would be for what it cannot see.
  std::unique_ptr<Work> work_;
};

}  // namespace knap
