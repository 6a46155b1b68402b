// The dynamics of mechanisms against MuJoCo 2.2.2: accelerations at random states, short trajectories at tiny
// steps.
//
// Each tree is written as MuJoCo's XML. A ball's rates are in the moving frame in both, quaternions start with w there;
// a translation followed by a ball becomes three slides and a ball of one body, since MuJoCo refuses massless bodies.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>

#include "sim/integrators/simulate.h"
#include "tests/sim/dynamics/mechanisms.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

class XmlWriter {
 public:
  explicit XmlWriter(const Tree& tree) : tree_(tree) {
    out_.precision(17);
    const Vector3d& g = tree.gravity;
    out_ << "<mujoco><compiler angle='radian' inertiafromgeom='false' boundmass='0' boundinertia='0'/>"
         << "<option integrator='RK4' gravity='" << g.transpose() << "'/><worldbody>";
    WriteChildren(-1);
    out_ << "</worldbody></mujoco>";
  }
  std::string text() const { return out_.str(); }

 private:
  void WriteChildren(int parent) {
    for (int i = 0; i < tree_.size(); ++i) {
      if (tree_.bodies()[i].parent == parent) WriteBody(i);
    }
  }

  void WriteBody(int i) {
    const TreeBody& body = tree_.bodies()[i];
    if (body.joint == JointType::kTranslation && body.M.isZero(0.0)) {
      // Its coordinates become slides of its only child, whose placement is the identity.
      slides_ = true;
      WriteChildren(i);
      return;
    }
    const Eigen::Quaterniond q(body.X_PF.R);
    out_ << "<body pos='" << body.X_PF.p.transpose() << "' quat='" << q.w() << " " << q.vec().transpose() << "'>";
    const double m = body.M(3, 3);
    const Vector3d c = Vector3d(body.M(2, 4), body.M(0, 5), body.M(1, 3)) / m;
    const Matrix3d I = body.M.topLeftCorner<3, 3>() - m * Skew(c) * Skew(c).transpose();
    out_ << "<inertial pos='" << c.transpose() << "' mass='" << m << "' fullinertia='" << I(0, 0) << " " << I(1, 1)
         << " " << I(2, 2) << " " << I(0, 1) << " " << I(0, 2) << " " << I(1, 2) << "'/>";
    if (slides_) {
      for (const char* axis : {"1 0 0", "0 1 0", "0 0 1"}) out_ << "<joint type='slide' axis='" << axis << "'/>";
      slides_ = false;
    }
    const auto joint = [&](const char* type) {
      out_ << "<joint type='" << type << "' axis='" << body.axis.transpose() << "' damping='" << body.law.damping
           << "'/>";
    };
    if (body.joint == JointType::kRevolute) joint("hinge");
    if (body.joint == JointType::kPrismatic) joint("slide");
    if (body.joint == JointType::kBall) joint("ball");
    WriteChildren(i);
    out_ << "</body>";
  }

  const Tree& tree_;
  std::ostringstream out_;
  bool slides_ = false;
};

// MuJoCo's model of a tree, and its state in our coordinates.
class Reference {
 public:
  explicit Reference(const Tree& tree) : tree_(tree) {
    const std::string text = XmlWriter(tree).text();
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), "model.xml", static_cast<int>(text.size()));
    std::memcpy(files->filedata[mj_findFileVFS(files.get(), "model.xml")], text.data(), text.size());
    char error[1000] = "";
    model_.reset(mj_loadXML("model.xml", files.get(), error, sizeof error));
    mj_deleteVFS(files.get());
    if (!model_) throw std::runtime_error(std::string(error) + "\n" + text);
    data_.reset(mj_makeData(model_.get()));
    EXPECT_EQ(model_->nq, tree.nq());
    EXPECT_EQ(model_->nv, tree.nv());
  }

  void Set(const VectorXd& q, const VectorXd& v, const VectorXd& effort) {
    Copy(q, data_->qpos, true);
    VectorXd::Map(data_->qvel, v.size()) = v;
    VectorXd::Map(data_->qfrc_applied, v.size()) = effort;
  }
  VectorXd CalcAcceleration() {
    mj_forward(model_.get(), data_.get());
    return VectorXd::Map(data_->qacc, model_->nv);
  }
  void Run(double step, int steps) {
    model_->opt.timestep = step;
    for (int n = 0; n < steps; ++n) mj_step(model_.get(), data_.get());
  }
  VectorXd q() const {
    VectorXd out(tree_.nq());
    Copy(VectorXd::Map(data_->qpos, model_->nq), out.data(), false);
    return out;
  }
  VectorXd v() const { return VectorXd::Map(data_->qvel, model_->nv); }

 private:
  struct Deleter {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  // Quaternions are x, y, z, w with us and w, x, y, z there.
  void Copy(const VectorXd& from, double* to, bool ours) const {
    VectorXd::Map(to, from.size()) = from;
    for (const TreeBody& body : tree_.bodies()) {
      if (body.joint != JointType::kBall) continue;
      for (int k = 0; k < 4; ++k) {
        const int there = (k + 1) % 4;
        to[body.q_start + (ours ? there : k)] = from(body.q_start + (ours ? k : there));
      }
    }
  }

  const Tree& tree_;
  std::unique_ptr<mjModel, Deleter> model_;
  std::unique_ptr<mjData, Deleter> data_;
};

// The residual is affine in vdot: its columns are the mass matrix.
VectorXd SolveAcceleration(Dynamics* dynamics, const VectorXd& q, const VectorXd& v) {
  const int nv = dynamics->tree().nv();
  const auto residual = [&](const VectorXd& vdot) {
    VectorXd r(nv);
    VectorXd magnitude(nv);
    dynamics->CalcKinematics(q, v, vdot, 0.0);
    dynamics->CalcResidual(0.0, &r, &magnitude);
    return r;
  };
  const VectorXd r0 = residual(VectorXd::Zero(nv));
  MatrixXd M(nv, nv);
  for (int k = 0; k < nv; ++k) M.col(k) = residual(VectorXd::Unit(nv, k)) - r0;
  return M.ldlt().solve(-r0);
}

Tree MakeFreeChain() {
  const Tree hung = test::MakeChain(15, 2e-5);
  Tree tree;
  TreeBody slide;
  slide.joint = JointType::kTranslation;
  tree.AddBody(slide);
  for (TreeBody body : hung.bodies()) {
    ++body.parent;
    // The first link hangs from nothing.
    if (body.parent == 0) body.law.damping = 0.0;
    tree.AddBody(body);
  }
  return tree;
}

struct Mechanism {
  const char* name;
  Tree tree;
  double rate;      // of the random rates
  double duration;  // of the trajectory [s]
};

class MujocoTest : public testing::TestWithParam<int> {
 protected:
  static Mechanism Make(int which) {
    if (which == 0) return {"chain", MakeFreeChain(), 3.0, 0.05};
    return {"finger", test::MakeFinger(), 2.0, 0.2};
  }
};

TEST_P(MujocoTest, AccelerationsAgreeAtRandomStates) {
  const Mechanism mechanism = Make(GetParam());
  const Tree& tree = mechanism.tree;
  Dynamics dynamics(tree);
  Reference reference(tree);
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto random = [&](Eigen::Index n, double scale) {
    return VectorXd(scale * VectorXd::NullaryExpr(n, [&] { return uniform(generator); }));
  };
  for (int sample = 0; sample < 20; ++sample) {
    VectorXd q(tree.nq());
    tree.AddIncrement(tree.MakeDefaultPositions(), random(tree.nv(), 1.0), &q);
    const VectorXd v = random(tree.nv(), mechanism.rate);
    dynamics.controls() = random(tree.num_controls(), 1.0);
    VectorXd effort = VectorXd::Zero(tree.nv());
    for (int a = 0; a < tree.num_controls(); ++a) {
      const Actuator& actuator = tree.actuators()[a];
      effort(tree.bodies()[actuator.body].v_start) = actuator.effort_limit * dynamics.controls()(a);
    }
    reference.Set(q, v, effort);
    const VectorXd theirs = reference.CalcAcceleration();
    const VectorXd ours = SolveAcceleration(&dynamics, q, v);
    EXPECT_GT(theirs.norm(), 1.0);
    // Two factorisations of a mass matrix whose condition is about 1e6.
    EXPECT_LT((ours - theirs).norm(), 1e-8 * theirs.norm()) << mechanism.name << " " << sample;
  }
}

TEST_P(MujocoTest, ShortTrajectoriesAgreeAtTinySteps) {
  const Mechanism mechanism = Make(GetParam());
  const Tree& tree = mechanism.tree;
  Dynamics dynamics(tree);
  ContactModel none({});
  Reference reference(tree);
  VectorXd start(tree.nv());
  VectorXd v0(tree.nv());
  for (int k = 0; k < tree.nv(); ++k) {
    start(k) = 0.4 * std::sin(1.0 + k);
    v0(k) = mechanism.rate * std::cos(2.0 * k);
  }
  VectorXd q0(tree.nq());
  tree.AddIncrement(tree.MakeDefaultPositions(), start, &q0);
  reference.Set(q0, v0, VectorXd::Zero(tree.nv()));
  reference.Run(1e-5, static_cast<int>(std::lround(mechanism.duration / 1e-5)));
  double previous = 0.0;
  for (const double step : {2e-4, 1e-4, 5e-5}) {
    SimulationOptions options;
    options.step = step;
    options.steps = static_cast<int>(std::lround(mechanism.duration / step));
    options.newton_tolerance = 1e-13;
    const Trajectory t = Simulator(&dynamics, &none).Run(q0, v0, options);
    ASSERT_TRUE(t.certificate.converged);
    const int last = t.size() - 1;
    const double error = (t.q(last) - reference.q()).norm() + mechanism.duration * (t.v(last) - reference.v()).norm();
    if (previous > 0.0) {
      EXPECT_NEAR(std::log2(previous / error), 2.0, 0.25) << mechanism.name << " " << step;
    }
    previous = error;
  }
  const double moved = (reference.q() - q0).norm();
  EXPECT_GT(moved, 0.1);
  EXPECT_LT(previous, 1e-3 * moved);
}

INSTANTIATE_TEST_SUITE_P(ChainAndFinger, MujocoTest, testing::Values(0, 1));

}  // namespace
}  // namespace knap
