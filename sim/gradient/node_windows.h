// In which steps of a trajectory bodies touch down, and which of its time nodes follow them (adjoint.h).
#pragma once

#include <optional>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/state_cotangent.h"
#include "sim/integrators/touchdown.h"
#include "sim/integrators/trajectory.h"
#include "sim/multibody/dynamics.h"

namespace knap {

class NodeWindows {
 public:
  struct Window {
    int contact = 0;
    Touchdown touchdown;
  };

  // All must outlive it. `cotangents`: of the losses, whose states stay where they are unless they say otherwise.
  NodeWindows(const Trajectory& trajectory, const std::vector<StateCotangent>& cotangents, const Dynamics& dynamics,
              const ContactModel& contacts);

  // Whether state k is a node that may move: where TR-BDF2 ends and begins, and no loss looks.
  bool MayMove(int k) const;

  // For every state from the last one to 0, loaded with its contacts.
  void Look(int k);
  // Of the step that begins at the node looked at last: the first touchdown that is seen from there.
  const std::optional<Window>& window() const { return window_; }

 private:
  const Trajectory& trajectory_;
  const Dynamics& dynamics_;
  const ContactModel& contacts_;
  std::vector<bool> stays_;         // of each state: a loss looks at it
  std::vector<bool> active_after_;  // of each contact: in the step after the state looked at
  std::optional<Window> window_;
};

// The nodes of a trajectory of chosen steps, for another one to take, so that its derivative at this one is the one
// that SweepAdjoint finds with the same cotangents. Leaves the world at state 0.
TimeNodeList ListFollowingNodes(const Trajectory& trajectory, const std::vector<StateCotangent>& cotangents,
                                Dynamics* dynamics, ContactModel* contacts);

}  // namespace knap
