// One rollout's world in Bullet, made afresh for each: nothing of one rollout survives into the next.
//
// Of the scene's bodies those with a free joint and the links of ropes are rigid bodies of Bullet's, with their masses
// and inertias; all others are kinematic and go where their motions say. Links hang together by point-to-point
// constraints. A grip is a constraint too: the held point is tied to a body of its own without extent, of mass m = h (k
// h + c), which begins each step with the velocity
//
//   v_S − k d/(k h + c)        v_S of the holder's matter at the held point, d, k, c as in grip.h (k the secant
//   stiffness)
//
// so that the impulse −h (k (d + h u) + c u) of the implicit step acts, solved together with all other constraints.
//
// Contacts are Bullet's own, between the pairs that the scene names alone; each point has the pair's friction, in a
// cone (cone_solver.h), and rebound (contact_law.h). Bullet closes the gap of a point within the step that would reach
// it, and takes the gap off the rebound; the coefficient that it is given makes up for that. Its own rolling friction
// brakes about two fixed axes of the contact's plane, by up to 1.41 times as much and not along the way; so before each
// step the torque impulse
//
//   −c_r r J w_t/|w_t|      J the normal impulse of the step before, w_t as in patch_law.h; no more than stops w_t
//
// acts on the two bodies of a ball's contact.
#pragma once

#include <memory>
#include <string>

#include "sim/rollout/built_scene.h"
#include "sim/transfer/body_track.h"
#include "sim/transfer/bullet_shapes.h"

namespace knap {

struct BulletOptions {
  double step = 5e-4;   // h [s]
  int iterations = 60;  // of the sequential impulse solver
};

class BulletWorld {
 public:
  // The scene is one that check_transfer.h does not refuse; `built` must outlive the world.
  BulletWorld(const BuiltScene& built, const MeshPieces& pieces, const BulletOptions& options);
  ~BulletWorld();
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  void Step();  // by h
  // Adds the state reached to the history.
  void Record(double time, BodyHistory* history);

  // The deepest contact so far: as a share of half the thinner body's width, the largest force of one contact [N], and
  // the scene's contact that it belongs to; −1: none.
  double penetration() const;
  int deepest_contact() const;
  double largest_force() const;
  int contact_onsets() const;

 private:
  class Contents;
  std::unique_ptr<Contents> contents_;
};

}  // namespace knap
