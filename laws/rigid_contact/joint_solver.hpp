// SPDX-License-Identifier: Apache-2.0
// The joints of a step.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "broad_phase.hpp"
#include "joint.hpp"

namespace vesper::rigid {

/** Sets of bodies that are connected by joints (union-find). */
class Assemblies {
 public:
  void Reset(uint64_t bodies) {
    parent_.resize(bodies);
    for (uint32_t i = 0; i < bodies; ++i) parent_[i] = i;
  }
  /** Returns the body that represents the set of this body. */
  uint32_t Find(uint32_t body) {
    while (parent_[body] != body) body = parent_[body] = parent_[parent_[body]];
    return body;
  }
  void Join(uint32_t a, uint32_t b) {
    const uint32_t first = Find(a), second = Find(b);
    parent_[std::max(first, second)] = std::min(first, second);
  }

 private:
  std::vector<uint32_t> parent_;  // one per body
};

/** All joints of a step, solved in the order of their rows. */
template <class Real>
class JointSolver {
 public:
  using Motions = std::vector<Motion<Real>>;

  void Reset(uint64_t bodies) {
    has_rotors_ = false;
    joints_.clear();
    rows_.clear();
    pairs_.clear();
    assemblies_.Reset(bodies);
  }
  void Add(const Joint<Real>& joint, uint64_t row) {
    if (joint.a != kImmovable && joint.b != kImmovable) assemblies_.Join(joint.a, joint.b);
    has_rotors_ = has_rotors_ || joint.HasRotor();
    joints_.push_back(joint);
    rows_.push_back(row);
    pairs_.push_back({std::min(joint.row_a, joint.row_b), std::max(joint.row_a, joint.row_b)});
  }
  /** Prepares AreJoined; call after the last Add. */
  void Sort() { std::sort(pairs_.begin(), pairs_.end()); }

  /** Returns whether a joint connects two bodies, the smaller row first. */
  bool AreJoined(const Pair& pair) const {
    return std::binary_search(pairs_.begin(), pairs_.end(), pair);
  }
  size_t count() const { return joints_.size(); }
  /** Returns the row of the index-th joint of this step in the columns of joints. */
  uint64_t row(size_t joint) const { return rows_[joint]; }
  const Joint<Real>& operator[](size_t joint) const { return joints_[joint]; }

  /** Computes directions and errors of all joints; `pose(row)` returns the pose of a body. */
  template <class PoseOf>
  void Refresh(const Motions& motions, PoseOf&& pose) {
    for (Joint<Real>& joint : joints_) {
      joint.Refresh(pose(joint.row_a), pose(joint.row_b), Get(motions, joint.a),
                    Get(motions, joint.b));
    }
  }

  /** Applies the impulses of the last step as a first guess. For each set of joined bodies, scales
   *  them by the factor, at most 1, that gives the least kinetic energy. The reason is that the
   *  exact impulses minimise this energy. After an impact, the impulses of the last step could add
   *  energy that the few sweeps of the solver do not remove. The impulses of springs, rotors and
   *  servos do not minimise the energy. Therefore they are applied before, and not scaled. */
  void WarmStart(Motions& motions, const SolverStep<Real>& step) {
    before_.resize(joints_.size());
    work_.assign(motions.size(), {});
    for (Joint<Real>& joint : joints_) {
      joint.Start(double{step.dt});
      Act(motions, joint, [&](auto& a, auto& b) { joint.ApplyLoads(a, b); });
    }
    for (size_t k = 0; k < joints_.size(); ++k) before_[k] = Work(joints_[k], motions);
    for (Joint<Real>& joint : joints_) {
      Act(motions, joint, [&](auto& a, auto& b) { joint.ApplyStart(a, b); });
    }
    for (size_t k = 0; k < joints_.size(); ++k) {
      auto& [first, second] = work_[assemblies_.Find(joints_[k].MovableRow())];
      first += before_[k];
      second += Work(joints_[k], motions) - before_[k];
    }
    for (Joint<Real>& joint : joints_) {
      const auto& [first, second] = work_[assemblies_.Find(joint.MovableRow())];
      if (-first >= second) continue;
      const double part = second > 0 ? std::max(0.0, -first / second) : 0;
      Act(motions, joint, [&](auto& a, auto& b) { joint.Reduce(part, a, b); });
    }
  }

  /** Solves the joints several times, alternately forwards and backwards. If all sweeps had the
   *  same direction, a chain that starts with the impulses of the last step could oscillate. */
  void Solve(Motions& motions, const SolverStep<Real>& step, bool push) {
    const size_t count = joints_.size();
    const size_t sweeps = has_rotors_ && !push ? kRotorSweeps : kSweeps;
    for (size_t k = 0; k < 2 * sweeps * count; ++k) {
      const size_t in_sweep = k % count;
      Joint<Real>& joint = joints_[k / count % 2 == 0 ? in_sweep : count - 1 - in_sweep];
      Act(motions, joint, [&](auto& a, auto& b) { joint.Solve(a, b, step, push); });
    }
  }

 private:
  // Number of forward and backward sweeps over the joints in each half of a substep.
  static constexpr size_t kSweeps = 4;
  // Number of such sweeps in the second half of a substep, if there are rotors. A rotor that has
  // more inertia than the bodies slows the convergence. The velocities that correct position errors
  // must be removed completely.
  static constexpr size_t kRotorSweeps = 24;

  static Motion<Real> Get(const Motions& motions, uint32_t body) {
    return body == kImmovable ? Motion<Real>{} : motions[body];
  }
  static double Work(const Joint<Real>& joint, const Motions& motions) {
    return joint.Work(Get(motions, joint.a), Get(motions, joint.b));
  }
  template <class Action>
  static void Act(Motions& motions, const Joint<Real>& joint, Action&& action) {
    Motion<Real> still_a, still_b;
    action(joint.a == kImmovable ? still_a : motions[joint.a],
           joint.b == kImmovable ? still_b : motions[joint.b]);
  }

  bool has_rotors_ = false;
  std::vector<Joint<Real>> joints_;
  std::vector<uint64_t> rows_;                   // one per joint
  std::vector<Pair> pairs_;                      // (joints) in ascending order
  std::vector<double> before_;                   // (joints) Joint::Work before the guess [J]
  std::vector<std::pair<double, double>> work_;  // (bodies) of a set: sum of Joint::Work, its
                                                 // change by the guess [J]
  Assemblies assemblies_;
};

}  // namespace vesper::rigid
