// A simulated trajectory, recorded so that an adjoint can run back over it.
//
// Records stand in blocks of kStepsPerBlock whole steps. Where all blocks together would take more memory than is
// allowed, those used longest ago are dropped and simulated again when they are asked for, to the same bits, from the
// state before the block, which is always kept. One sweep over all states, in either direction, then costs one more
// simulation, and memory grows by a state a block and by what a step needs for its time and formula, some 60 bytes.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <functional>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/bristle_history.h"
#include "sim/integrators/control_sequence.h"
#include "sim/integrators/simulation_certificate.h"
#include "sim/integrators/step_control.h"
#include "sim/integrators/step_formula.h"
#include "sim/integrators/touchdown.h"

namespace knap {

inline constexpr int kStepsPerBlock = 256;

// Where a step ends, and how another trajectory that takes the same steps follows its own touchdowns: what `contact`
// says begins in the step from here, at `touchdown` as its approach shows it here. By as much as this time differs
// there, this node and those after it, up to the next one that says so, lie later; but only those that may move.
struct TimeNode {
  double time = 0.0;  // [s]
  bool moves = false;
  int contact = -1;  // -1: none
  Approach approach{};
  double touchdown = 0.0;  // [s]
};

struct TimeNodeList {
  TimeNode start;                           // at time 0
  std::vector<std::vector<TimeNode>> ends;  // for every whole step, of the steps within it
};

// States 0…K and the records that lead from each to the next; substeps and stages within a step are states too. Views
// of a state hold until states of three other blocks have been looked at.
class Trajectory {
 public:
  // What a step to the state after this one depends on.
  struct Seed {
    double time = 0.0;
    StepFormula formula;
    Eigen::VectorXd q, v, xi, vdot;
    Eigen::VectorXd v_before;  // of the state before; empty for state 0
    BristleState bristles;
    StepChoice choice;
  };
  // The states that a block's whole steps lead to from the seed under the controls, behind the seed's own one or two.
  using Replay = std::function<Trajectory(const Seed& seed, int first_step, const ControlSequence& controls)>;

  Trajectory(int nq, int nv) : nq_(nq), nv_(nv), blocks_(1) {}

  int size() const { return static_cast<int>(times_.size()); }
  double time(int k) const { return times_[k]; }
  Eigen::Map<const Eigen::VectorXd> q(int k) const { return View(&Block::q, k, nq_); }
  Eigen::Map<const Eigen::VectorXd> v(int k) const { return View(&Block::v, k, nv_); }
  // xi(k), vdot(k) and formula(k) belong to the solve from k−1 to k; zero for k = 0.
  Eigen::Map<const Eigen::VectorXd> xi(int k) const { return View(&Block::xi, k, nv_); }
  Eigen::Map<const Eigen::VectorXd> vdot(int k) const { return View(&Block::vdot, k, nv_); }
  // The bristles of the contacts at state k.
  void GetBristles(int k, BristleState* out) const;
  const StepFormula& formula(int k) const { return formulas_[k]; }
  // The state at the end of whole step n (0: the start), n ≤ whole_steps().
  int state_of_step(int n) const { return state_of_step_[n]; }
  int whole_steps() const { return static_cast<int>(state_of_step_.size()) - 1; }
  TimeNodeList ListNodes() const;  // none of which moves
  // When each contact was last active [s]; minus infinity where it never was.
  const std::vector<double>& last_touched() const { return last_touched_; }
  // Blocks that were simulated again so far.
  long replays() const { return replays_; }

  SimulationCertificate certificate;
  ControlSequence controls;  // that acted, those that a feedback law set included

 private:
  friend class Simulator;
  struct Block {
    int first = 0;  // state
    int end = 0;    // one behind the last
    bool present = true;
    mutable long used = 0;
    Seed seed;  // of all but the first block
    std::vector<double> q, v, xi, vdot;
    BristleState bristles;  // of all states, one after the other
    std::vector<int> bristle_start{0};
  };

  void Reserve(int states);
  void Append(double time, const StepFormula& formula, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
              const Eigen::VectorXd& xi, const Eigen::VectorXd& vdot, const BristleState& bristles);
  // The last states, which belong to one block, so that `size` are left.
  void CutBackTo(int size);
  Seed MakeSeed() const;  // of the last state
  // What is appended from here on belongs to whole steps of a new block.
  void BeginBlock();
  bool OutgrowsMemory() const;
  void DropBlocks() const;
  std::size_t CountBytes() const;
  const Block& GetBlock(int k) const;
  void Restore(Block* block) const;
  Eigen::Map<const Eigen::VectorXd> View(std::vector<double> Block::*numbers, int k, int n) const {
    const Block& block = GetBlock(k);
    return {(block.*numbers).data() + static_cast<std::ptrdiff_t>(k - block.first) * n, n};
  }

  int nq_;
  int nv_;
  std::vector<double> times_;
  std::vector<StepFormula> formulas_;
  std::vector<int> state_of_step_;
  std::vector<double> last_touched_;
  StepChoice choice_;  // for what follows the last state
  mutable std::vector<Block> blocks_;
  mutable std::size_t recent_ = 0;  // block
  mutable long clock_ = 0;
  mutable long replays_ = 0;
  std::size_t memory_ = 0;  // bytes of all blocks that may be present; needs replay_
  Replay replay_;
};

}  // namespace knap
