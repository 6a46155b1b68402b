#include "tests/sim/dynamics/mujoco_reference.h"

#include <cstring>
#include <sstream>
#include <stdexcept>
#include <string>

#include "sim/math/so3.h"

namespace knap::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

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
    if (!body.M.isZero(0.0)) WriteInertia(body.M);
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

  void WriteInertia(const Matrix6d& M) {
    const double m = M(3, 3);
    const Vector3d c = Vector3d(M(2, 4), M(0, 5), M(1, 3)) / m;
    const Matrix3d I = M.topLeftCorner<3, 3>() - m * Skew(c) * Skew(c).transpose();
    out_ << "<inertial pos='" << c.transpose() << "' mass='" << m << "' fullinertia='" << I(0, 0) << " " << I(1, 1)
         << " " << I(2, 2) << " " << I(0, 1) << " " << I(0, 2) << " " << I(1, 2) << "'/>";
  }

  const Tree& tree_;
  std::ostringstream out_;
  bool slides_ = false;
};

}  // namespace

using Eigen::VectorXd;

MujocoReference::MujocoReference(const Tree& tree) : tree_(tree) {
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
  if (model_->nq != tree.nq() || model_->nv != tree.nv()) throw std::runtime_error("other coordinates:\n" + text);
}

void MujocoReference::Set(const VectorXd& q, const VectorXd& v, const VectorXd& effort) {
  Copy(q, data_->qpos, true);
  VectorXd::Map(data_->qvel, v.size()) = v;
  SetEffort(effort);
}

void MujocoReference::SetEffort(const VectorXd& effort) { VectorXd::Map(data_->qfrc_applied, effort.size()) = effort; }

VectorXd MujocoReference::CalcAcceleration() {
  mj_forward(model_.get(), data_.get());
  return VectorXd::Map(data_->qacc, model_->nv);
}

void MujocoReference::Run(double step, int steps) {
  model_->opt.timestep = step;
  for (int n = 0; n < steps; ++n) mj_step(model_.get(), data_.get());
}

VectorXd MujocoReference::q() const {
  VectorXd out(tree_.nq());
  Copy(VectorXd::Map(data_->qpos, model_->nq), out.data(), false);
  return out;
}

VectorXd MujocoReference::v() const { return VectorXd::Map(data_->qvel, model_->nv); }

// Quaternions are x, y, z, w with us and w, x, y, z there.
void MujocoReference::Copy(const VectorXd& from, double* to, bool ours) const {
  VectorXd::Map(to, from.size()) = from;
  for (const TreeBody& body : tree_.bodies()) {
    if (body.joint != JointType::kBall) continue;
    for (int k = 0; k < 4; ++k) {
      const int there = (k + 1) % 4;
      to[body.q_start + (ours ? there : k)] = from(body.q_start + (ours ? k : there));
    }
  }
}

}  // namespace knap::test
