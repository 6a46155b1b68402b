// A tree as MuJoCo 2.2.2 sees it.
//
// The tree is written as MuJoCo's XML. A ball's rates are in the moving frame in both, quaternions start with w there;
// a translation followed by a ball becomes three slides and a ball of one body, since MuJoCo refuses massless bodies.
// Dampings go along; springs, limits and actuators do not.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <memory>

#include "sim/multibody/tree.h"

namespace knap::test {

class MujocoReference {
 public:
  // `tree` must live on.
  explicit MujocoReference(const Tree& tree);

  // State and generalised forces, in our coordinates.
  void Set(const Eigen::VectorXd& q, const Eigen::VectorXd& v, const Eigen::VectorXd& effort);
  void SetEffort(const Eigen::VectorXd& effort);
  Eigen::VectorXd CalcAcceleration();
  void Run(double step, int steps);  // RK4
  Eigen::VectorXd q() const;
  Eigen::VectorXd v() const;

 private:
  struct Deleter {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  void Copy(const Eigen::VectorXd& from, double* to, bool ours) const;

  const Tree& tree_;
  std::unique_ptr<mjModel, Deleter> model_;
  std::unique_ptr<mjData, Deleter> data_;
};

}  // namespace knap::test
