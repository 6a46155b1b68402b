#include "sim/transfer/bullet_world.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btSimulationIslandManager.h>
#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "sim/multibody/dynamics.h"
#include "sim/scenarios/check_rules.h"
#include "sim/transfer/bullet_units.h"
#include "sim/transfer/cone_solver.h"
#include "sim/transfer/contact_law.h"
#include "sim/transfer/soft_links.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kNoBody = -1;  // of what is none of the tree's
// Slower than gravity makes anything within so many steps, what touches rests and does not rebound.
constexpr double kRestingSteps = 4.0;

// Of two bodies that may touch.
struct PairLaw {
  const Contact* contact = nullptr;
  int number = 0;               // in the scene
  double rolling_radius = 0.0;  // [m]
  double half_width = 0.0;      // of the thinner body [m]
  double depth = 0.0;           // the deepest since the last state [m]
  bool bears = false;           // at the last step
};
using PairLaws = std::map<std::pair<int, int>, PairLaw>;

std::pair<int, int> GetPair(const btCollisionObject* a, const btCollisionObject* b) {
  return std::minmax(a->getUserIndex(), b->getUserIndex());
}

class PairFilter final : public btOverlapFilterCallback {
 public:
  explicit PairFilter(const PairLaws* laws) : laws_(laws) {}
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    return laws_->contains(GetPair(static_cast<const btCollisionObject*>(a->m_clientObject),
                                   static_cast<const btCollisionObject*>(b->m_clientObject)));
  }

 private:
  const PairLaws* laws_;
};

// Gives every point of contact its pair's law as soon as Bullet has found it.
class PairDispatcher final : public btCollisionDispatcher {
 public:
  PairDispatcher(btCollisionConfiguration* configuration, const PairLaws* laws, double resting_speed)
      : btCollisionDispatcher(configuration), laws_(laws), resting_speed_(resting_speed) {
    setNearCallback(&Near);
  }

 private:
  static void Near(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
    defaultNearCallback(pair, dispatcher, info);
    if (pair.m_algorithm == nullptr) return;
    btManifoldArray manifolds;
    pair.m_algorithm->getAllContactManifolds(manifolds);
    for (int i = 0; i < manifolds.size(); ++i) {
      static_cast<PairDispatcher&>(dispatcher).SetLaw(info.m_timeStep, manifolds[i]);
    }
  }

  void SetLaw(double h, btPersistentManifold* manifold) const {
    const auto* a = btRigidBody::upcast(manifold->getBody0());
    const auto* b = btRigidBody::upcast(manifold->getBody1());
    const PairLaw& law = laws_->at(GetPair(a, b));
    for (int i = 0; i < manifold->getNumContacts(); ++i) {
      btManifoldPoint& point = manifold->getContactPoint(i);
      point.m_combinedFriction = law.contact->friction;
      point.m_combinedRollingFriction = 0.0;  // BrakeRolling
      point.m_combinedSpinningFriction = 0.0;
      const btVector3 u = a->getVelocityInLocalPoint(point.getPositionWorldOnA() - a->getCenterOfMassPosition()) -
                          b->getVelocityInLocalPoint(point.getPositionWorldOnB() - b->getCenterOfMassPosition());
      const double speed = -u.dot(point.m_normalWorldOnB);
      const double gap = std::max(0.0, point.getDistance());
      point.m_combinedRestitution = 0.0;
      if (speed <= resting_speed_ || gap >= speed * h) continue;
      point.m_combinedRestitution = CalcRebound(law.contact->damping, speed / kUnitsPerMetre) + gap / (speed * h);
    }
  }

  const PairLaws* laws_;
  double resting_speed_;
};

// A rigid body of Bullet's for one of the tree's. P: centre of mass, principal axes.
struct Member {
  int index = kNoBody;
  Pose X_BP;
  bool is_free = false;
  BulletShape shape;
  std::unique_ptr<btRigidBody> body;
};

struct GripTie {
  const GripSpring* spring = nullptr;
  std::unique_ptr<btRigidBody> knot;
  std::unique_ptr<btPoint2PointConstraint> tie;
};

struct PrincipalInertia {
  double mass = 0.0;
  Vector3d moments = Vector3d::Zero();
  Pose X_BP;
};

PrincipalInertia FindPrincipalInertia(const Matrix6d& M) {
  PrincipalInertia out;
  out.mass = M(3, 3);
  const Vector3d c = Vector3d(M(2, 4), M(0, 5), M(1, 3)) / out.mass;
  const Matrix3d I = M.topLeftCorner<3, 3>() - out.mass * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(I);
  out.moments = solver.eigenvalues();
  out.X_BP = {solver.eigenvectors(), c};
  if (out.X_BP.R.determinant() < 0.0) out.X_BP.R.col(2) *= -1.0;
  return out;
}

// The radius with which a body rolls; 0 where it has no ball.
double FindRollingRadius(const Scene& scene, const std::string& name) {
  const Body* body = FindBody(scene, name);
  const Shape* ball = body == nullptr ? nullptr : FindShape<SphereShape>(*body);
  return ball == nullptr ? 0.0 : std::get<SphereShape>(ball->kind).radius;
}

}  // namespace

class BulletWorld::Contents {
 public:
  Contents(const BuiltScene& built, const MeshPieces& pieces, const BulletOptions& options)
      : built_(built),
        options_(options),
        kinematics_(built.model.tree),
        zero_(Eigen::VectorXd::Zero(built.model.tree.nv())),
        filter_(&laws_),
        dispatcher_(&configuration_, &laws_, kRestingSteps * kUnitsPerMetre * gravity().norm() * options.step),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    configuration_.setPlaneConvexMultipointIterations();
    configuration_.setConvexConvexMultipointIterations();
    broadphase_.getOverlappingPairCache()->setOverlapFilterCallback(&filter_);
    world_.getDispatchInfo().m_deterministicOverlappingPairs = true;
    world_.getSimulationIslandManager()->setSplitIslands(false);
    btContactSolverInfo& info = world_.getSolverInfo();
    info.m_numIterations = options.iterations;
    info.m_solverMode = SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS;
    info.m_splitImpulse = 1;
    info.m_splitImpulsePenetrationThreshold = 0.0;
    info.m_restitutionVelocityThreshold = 0.0;  // PairDispatcher has its own
    world_.setGravity(ToUnits(gravity()));
    moves_ = std::any_of(built.model.tree.bodies().begin(), built.model.tree.bodies().end(),
                         [](const TreeBody& body) { return body.joint == JointType::kPrescribed; });
    kinematics_.CalcKinematics(built.model.q0, built.model.v0, zero_, 0.0);
    AddBodies(pieces);
    AddLaws();
    for (Member& member : members_) world_.addRigidBody(member.body.get());
    for (const Rope& rope : built.moved.ropes) TieLinks(built.model.links.at(rope.name), rope);
    for (const GripSpring& spring : built.model.grips) AddGrip(spring);
  }

  ~Contents() {
    for (const auto& tie : ties_) world_.removeConstraint(tie.get());
    for (const GripTie& grip : grips_) {
      world_.removeConstraint(grip.tie.get());
      world_.removeRigidBody(grip.knot.get());
    }
    for (const Member& member : members_) world_.removeRigidBody(member.body.get());
  }

  void Step() {
    ++steps_;
    const double end = steps_ * options_.step;
    std::vector<Pose> before;
    for (const GripTie& grip : grips_) before.push_back(GetPose(grip.spring->holder));
    if (moves_) {
      kinematics_.CalcKinematics(built_.model.q0, built_.model.v0, zero_, end);
      for (const Member& member : members_) {
        if (!member.is_free) member.body->setWorldTransform(ToUnits(GetPose(member.index)));
      }
    }
    for (std::size_t i = 0; i < grips_.size(); ++i) PrepareGrip(before[i], end, &grips_[i]);
    for (const Rope& rope : built_.moved.ropes) DampRope(rope);
    BrakeRolling();
    world_.stepSimulation(options_.step, 0);
    LookAtContacts();
  }

  void Record(double time, BodyHistory* history) {
    BodyHistory::State state;
    for (const BodyKinematics& kin : kinematics_.kinematics()) {
      state.X_WB.push_back(kin.X_WB);
      state.V.push_back(kin.V);
    }
    for (const Member& member : members_) {
      if (!member.is_free) continue;
      const Pose X_WP = FromUnits(member.body->getWorldTransform());
      const Matrix3d R_WB = X_WP.R * member.X_BP.R.transpose();
      const Pose X_WB{R_WB, X_WP.p - R_WB * member.X_BP.p};
      const Vector3d w_B = R_WB.transpose() * FromBullet(member.body->getAngularVelocity());
      const Vector3d v_B = R_WB.transpose() * FromUnits(member.body->getLinearVelocity()) - w_B.cross(member.X_BP.p);
      const auto i = static_cast<std::size_t>(member.index);
      state.X_WB[i] = X_WB;
      state.V[i] << w_B, v_B;
    }
    history->time.push_back(time);
    history->states.push_back(std::move(state));
    for (auto& [pair, law] : laws_) {
      history->depth[pair].push_back(law.depth);
      law.depth = 0.0;
    }
  }

  double penetration = 0.0;
  int deepest_contact = -1;
  double largest_force = 0.0;
  int contact_onsets = 0;

 private:
  const Vector3d& gravity() const { return built_.model.tree.gravity; }
  const Pose& GetPose(int body) const { return kinematics_.kinematics()[static_cast<std::size_t>(body)].X_WB; }
  Member& GetMember(int index) {
    return members_[static_cast<std::size_t>(member_of_[static_cast<std::size_t>(index)])];
  }

  void AddBodies(const MeshPieces& pieces) {
    const SceneModel& model = built_.model;
    member_of_.assign(static_cast<std::size_t>(model.tree.size()), kNoBody);
    for (const Body& body : built_.moved.bodies) {
      const bool is_free = std::holds_alternative<FreeJoint>(body.joint.kind);
      AddMember(model.body_index.at(body.name), is_free,
                [&](const Pose& X_BP) { return MakeBulletShape(body, pieces, X_BP); });
    }
    for (const Rope& rope : built_.moved.ropes) {
      for (const int link : model.links.at(rope.name)) {
        AddMember(link, true, [&](const Pose& X_BP) { return MakeBulletShape(rope, X_BP); });
      }
    }
  }

  template <class MakeShape>
  void AddMember(int index, bool is_free, const MakeShape& make_shape) {
    const BodyKinematics& kin = kinematics_.kinematics()[static_cast<std::size_t>(index)];
    PrincipalInertia inertia;
    if (is_free) inertia = FindPrincipalInertia(built_.model.tree.bodies()[static_cast<std::size_t>(index)].M);
    Member member;
    member.index = index;
    member.is_free = is_free;
    member.X_BP = inertia.X_BP;
    member.shape = make_shape(inertia.X_BP);
    btCollisionShape* shape = member.shape.whole ? member.shape.whole.get() : &nothing_;
    btRigidBody::btRigidBodyConstructionInfo info(
        inertia.mass, nullptr, shape, ToBullet(Vector3d(kUnitsPerMetre * kUnitsPerMetre * inertia.moments)));
    info.m_startWorldTransform = ToUnits(kin.X_WB * inertia.X_BP);
    member.body = std::make_unique<btRigidBody>(info);
    member.body->setUserIndex(index);
    member.body->setActivationState(DISABLE_DEACTIVATION);
    if (is_free) {
      const Vector3d w_B = kin.V.head<3>();
      member.body->setAngularVelocity(ToBullet(Vector3d(kin.X_WB.R * w_B)));
      const Vector3d v_B = kin.V.tail<3>() + w_B.cross(inertia.X_BP.p);
      member.body->setLinearVelocity(ToUnits(kin.X_WB.R * v_B));
    } else {
      member.body->setCollisionFlags(member.body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    }
    member_of_[static_cast<std::size_t>(index)] = static_cast<int>(members_.size());
    members_.push_back(std::move(member));
  }

  // Of pairs that no force moves Bullet wants to know nothing.
  void AddLaws() {
    for (std::size_t i = 0; i < built_.model.contacts.size(); ++i) {
      const auto& [a, b] = built_.model.contacts[i].bodies;
      if (!GetMember(a).is_free && !GetMember(b).is_free) continue;
      const int number = built_.model.contact_of_pair[i];
      const Contact& contact = built_.moved.contacts[static_cast<std::size_t>(number)];
      PairLaw law;
      law.contact = &contact;
      law.number = number;
      law.rolling_radius = std::max(FindRollingRadius(built_.moved, contact.bodies[0]),
                                    FindRollingRadius(built_.moved, contact.bodies[1]));
      law.half_width = std::min(GetMember(a).shape.half_width, GetMember(b).shape.half_width);
      laws_.emplace(std::minmax(a, b), law);
    }
  }

  // The place of p_B in P [units].
  btVector3 FindPivot(const Member& member, const Vector3d& p_B) const {
    return ToUnits(member.X_BP.ApplyInverse(p_B));
  }

  void TieLinks(const std::vector<int>& links, const Rope& rope) {
    for (std::size_t i = 1; i < links.size(); ++i) {
      Member& a = GetMember(links[i - 1]);
      Member& b = GetMember(links[i]);
      ties_.push_back(std::make_unique<btPoint2PointConstraint>(
          *a.body, *b.body, FindPivot(a, Vector3d(rope.pitch, 0.0, 0.0)), FindPivot(b, Vector3d::Zero())));
      world_.addConstraint(ties_.back().get());
    }
  }

  void AddGrip(const GripSpring& spring) {
    GripTie grip;
    grip.spring = &spring;
    const double h = options_.step;
    const double mass = h * (spring.stiffness * h + spring.damping);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &nothing_, btVector3(mass, mass, mass));
    grip.knot = std::make_unique<btRigidBody>(info);
    grip.knot->setUserIndex(kNoBody);
    grip.knot->setActivationState(DISABLE_DEACTIVATION);
    grip.knot->setFlags(grip.knot->getFlags() | BT_DISABLE_WORLD_GRAVITY);
    world_.addRigidBody(grip.knot.get());
    Member& held = GetMember(spring.held);
    grip.tie = std::make_unique<btPoint2PointConstraint>(*held.body, *grip.knot, FindPivot(held, spring.p_BP),
                                                         btVector3(0.0, 0.0, 0.0));
    grip.tie->setEnabled(false);
    world_.addConstraint(grip.tie.get());
    grips_.push_back(std::move(grip));
  }

  // `before`: the holder at the start of the step; the kinematics have it at the end.
  void PrepareGrip(const Pose& before, double end, GripTie* grip) {
    const GripSpring& spring = *grip->spring;
    grip->tie->setEnabled(spring.ActsAt(end));
    if (!grip->tie->isEnabled()) return;
    const double h = options_.step;
    const Member& held = GetMember(spring.held);
    const Vector3d p_W = FromUnits(held.body->getWorldTransform() * FindPivot(held, spring.p_BP));
    const Vector3d carried_W = GetPose(spring.holder) * before.ApplyInverse(p_W);
    const Vector3d d_W = p_W - before * spring.p_SA;
    const double pull = spring.stiffness * d_W.norm() / spring.limit;
    const double k = spring.stiffness / std::sqrt(1.0 + pull * pull);
    const double mass = h * (k * h + spring.damping);
    const Vector3d v_W = (carried_W - p_W) / h - k / (k * h + spring.damping) * d_W;
    grip->knot->setMassProps(mass, btVector3(mass, mass, mass));
    grip->knot->setWorldTransform(btTransform(btMatrix3x3::getIdentity(), ToUnits(p_W)));
    grip->knot->setInterpolationWorldTransform(grip->knot->getWorldTransform());
    grip->knot->updateInertiaTensor();
    grip->knot->setLinearVelocity(ToUnits(v_W));
    grip->knot->setAngularVelocity(btVector3(0.0, 0.0, 0.0));
  }

  void DampRope(const Rope& rope) {
    const std::vector<int>& links = built_.model.links.at(rope.name);
    std::vector<Matrix3d> inertia;
    std::vector<Vector3d> w;
    for (const int link : links) {
      const Member& member = GetMember(link);
      inertia.push_back(FromBullet(member.body->getInvInertiaTensorWorld().inverse()));
      w.push_back(FromBullet(member.body->getAngularVelocity()));
    }
    DampJoints(options_.step * rope.joint_damping * kUnitsPerMetre * kUnitsPerMetre, inertia, &w);
    for (std::size_t i = 0; i < links.size(); ++i) GetMember(links[i]).body->setAngularVelocity(ToBullet(w[i]));
  }

  void BrakeRolling() {
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const btPersistentManifold* manifold = dispatcher_.getManifoldByIndexInternal(i);
      const PairLaw& law = laws_.at(GetPair(manifold->getBody0(), manifold->getBody1()));
      const double arm = law.contact->rolling_resistance * law.rolling_radius * kUnitsPerMetre;
      if (arm == 0.0) continue;
      btRigidBody* a = GetMember(manifold->getBody0()->getUserIndex()).body.get();
      btRigidBody* b = GetMember(manifold->getBody1()->getUserIndex()).body.get();
      for (int k = 0; k < manifold->getNumContacts(); ++k) {
        const btVector3& n = manifold->getContactPoint(k).m_normalWorldOnB;
        btVector3 w = a->getAngularVelocity() - b->getAngularVelocity();
        w -= w.dot(n) * n;
        const double rate = w.length();
        if (!(rate > 0.0)) continue;
        const btVector3 axis = w / rate;
        const double mobility = axis.dot((a->getInvInertiaTensorWorld() + b->getInvInertiaTensorWorld()) * axis);
        const double most = arm * manifold->getContactPoint(k).getAppliedImpulse();
        const btVector3 impulse = -std::min(most, rate / mobility) * axis;
        a->applyTorqueImpulse(impulse);
        b->applyTorqueImpulse(-impulse);
      }
    }
  }

  void LookAtContacts() {
    std::map<std::pair<int, int>, double> impulses;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const btPersistentManifold* manifold = dispatcher_.getManifoldByIndexInternal(i);
      const auto pair = GetPair(manifold->getBody0(), manifold->getBody1());
      PairLaw& law = laws_.at(pair);
      for (int k = 0; k < manifold->getNumContacts(); ++k) {
        const btManifoldPoint& point = manifold->getContactPoint(k);
        impulses[pair] += point.getAppliedImpulse();
        const double depth = std::max(0.0, -point.getDistance() / kUnitsPerMetre);
        law.depth = std::max({law.depth, depth, point.getAppliedImpulse() > 0.0 ? BodyHistory::kTouch : 0.0});
        if (depth <= penetration * law.half_width) continue;
        penetration = depth / law.half_width;
        deepest_contact = law.number;
      }
    }
    for (auto& [pair, law] : laws_) {
      const auto found = impulses.find(pair);
      const double impulse = found == impulses.end() ? 0.0 : found->second;
      largest_force = std::max(largest_force, impulse / options_.step / kUnitsPerMetre);
      if (impulse > 0.0 && !law.bears) ++contact_onsets;
      law.bears = impulse > 0.0;
    }
  }

  const BuiltScene& built_;
  const BulletOptions options_;
  Dynamics kinematics_;  // of what is not free
  Eigen::VectorXd zero_;
  bool moves_ = false;
  int steps_ = 0;
  PairLaws laws_;
  PairFilter filter_;
  btEmptyShape nothing_;
  std::vector<Member> members_;
  std::vector<int> member_of_;  // of each body of the tree
  btDefaultCollisionConfiguration configuration_;
  PairDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  ConeSolver solver_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<btPoint2PointConstraint>> ties_;
  std::vector<GripTie> grips_;
};

BulletWorld::BulletWorld(const BuiltScene& built, const MeshPieces& pieces, const BulletOptions& options)
    : contents_(std::make_unique<Contents>(built, pieces, options)) {}
BulletWorld::~BulletWorld() = default;

void BulletWorld::Step() { contents_->Step(); }
void BulletWorld::Record(double time, BodyHistory* history) { contents_->Record(time, history); }
double BulletWorld::penetration() const { return contents_->penetration; }
int BulletWorld::deepest_contact() const { return contents_->deepest_contact; }
double BulletWorld::largest_force() const { return contents_->largest_force; }
int BulletWorld::contact_onsets() const { return contents_->contact_onsets; }

}  // namespace knap
