// SPDX-License-Identifier: Apache-2.0
// The joints of a step.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "broad_phase.hpp"
#include "gear.hpp"
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

/** All joints and gears of a step, solved in the order of their rows, the joints first. */
template <class Real>
class JointSolver {
 public:
  using Motions = std::vector<Motion<Real>>;

  void Reset(uint64_t bodies) {
    has_rotors_ = false;
    rests_.clear();
    gear_rests_.clear();
    joints_.clear();
    rows_.clear();
    gears_.clear();
    gear_rows_.clear();
    pairs_.clear();
    assemblies_.Reset(bodies);
  }
  void Add(const Joint<Real>& joint, uint64_t row) {
    if (joint.a != kImmovable && joint.b != kImmovable) assemblies_.Join(joint.a, joint.b);
    has_rotors_ = has_rotors_ || joint.HasRotor();
    joints_.push_back(joint);
    rows_.push_back(row);
    rests_.push_back(0);
    pairs_.push_back({std::min(joint.row_a, joint.row_b), std::max(joint.row_a, joint.row_b)});
  }
  /** Adds a gear between two of the joints; call after the last Add. */
  void AddGear(const Gear<Real>& gear, uint64_t row) {
    const Joint<Real>&first = joints_[gear.first], &second = joints_[gear.second];
    const uint32_t representative = first.a != kImmovable ? first.a : first.b;
    for (const uint32_t body : {second.a, second.b}) {
      if (body != kImmovable) assemblies_.Join(representative, body);
    }
    gears_.push_back(gear);
    gear_rows_.push_back(row);
    gear_rests_.push_back(0);
  }
  /** Excludes joints and gears of bodies that sleep from the solution. `rests(body)` returns
   * whether a movable body sleeps. */
  template <class Rests>
  void LetRest(Rests&& rests) {
    for (size_t k = 0; k < joints_.size(); ++k) rests_[k] = rests(joints_[k].MovableRow());
    for (size_t k = 0; k < gears_.size(); ++k) gear_rests_[k] = rests(MovableRow(gears_[k]));
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
  /** Returns the index of the joint with this row, or count() if it does not act in this step. */
  size_t Find(uint64_t row) const {
    const auto found = std::lower_bound(rows_.begin(), rows_.end(), row);
    return found != rows_.end() && *found == row ? size_t(found - rows_.begin()) : count();
  }
  /** Return whether the bodies of a joint or gear sleep in this step. */
  bool Rests(size_t joint) const { return rests_[joint] != 0; }
  bool GearRests(size_t gear) const { return gear_rests_[gear] != 0; }
  const std::vector<Gear<Real>>& gears() const { return gears_; }
  /** Returns the row of the index-th gear of this step in the columns of gears. */
  uint64_t gear_row(size_t gear) const { return gear_rows_[gear]; }

  /** Computes directions and errors of all joints and gears; `pose(row)` returns the pose of a
   *  body. */
  template <class PoseOf>
  void Refresh(const Motions& motions, PoseOf&& pose) {
    ForEachJoint([&](Joint<Real>& joint) {
      joint.Refresh(pose(joint.row_a), pose(joint.row_b), Get(motions, joint.a),
                    Get(motions, joint.b));
    });
    ForEachGear([&](Gear<Real>& gear) {
      gear.Refresh(joints_[gear.first], joints_[gear.second], motions);
    });
  }

  /** Applies the impulses of the last step as a first guess. For each set of joined bodies, scales
   *  them by the factor, at most 1, that gives the least kinetic energy. The reason is that the
   *  exact impulses minimise this energy. After an impact, the impulses of the last step could add
   *  energy that the few sweeps of the solver do not remove. The impulses of springs, rotors and
   *  servos do not minimise the energy. Therefore they are applied before, and not scaled. */
  void WarmStart(Motions& motions, const SolverStep<Real>& step) {
    const size_t count = joints_.size();
    before_.resize(count + gears_.size());
    work_.assign(motions.size(), {});
    ForEachJoint([&](Joint<Real>& joint) {
      joint.Start(double{step.dt});
      Act(motions, joint, [&](auto& a, auto& b) { joint.ApplyLoads(a, b); });
    });
    for (size_t k = 0; k < count; ++k) {
      if (!Rests(k)) before_[k] = Work(joints_[k], motions);
    }
    for (size_t k = 0; k < gears_.size(); ++k) {
      if (!GearRests(k)) before_[count + k] = gears_[k].Work(motions);
    }
    ForEachJoint([&](Joint<Real>& joint) {
      Act(motions, joint, [&](auto& a, auto& b) { joint.ApplyStart(a, b); });
    });
    ForEachGear([&](Gear<Real>& gear) { gear.ApplyStart(motions); });
    const auto add = [&](uint32_t body, double before, double after) {
      auto& [first, second] = work_[assemblies_.Find(body)];
      first += before;
      second += after - before;
    };
    for (size_t k = 0; k < count; ++k) {
      if (Rests(k)) continue;
      add(joints_[k].MovableRow(), before_[k], Work(joints_[k], motions));
    }
    for (size_t k = 0; k < gears_.size(); ++k) {
      if (GearRests(k)) continue;
      add(MovableRow(gears_[k]), before_[count + k], gears_[k].Work(motions));
    }
    const auto reduce = [&](uint32_t body, auto&& action) {
      const auto& [first, second] = work_[assemblies_.Find(body)];
      if (-first >= second) return;
      action(second > 0 ? std::max(0.0, -first / second) : 0);
    };
    ForEachJoint([&](Joint<Real>& joint) {
      reduce(joint.MovableRow(), [&](double part) {
        Act(motions, joint, [&](auto& a, auto& b) { joint.Reduce(part, a, b); });
      });
    });
    ForEachGear([&](Gear<Real>& gear) {
      reduce(MovableRow(gear), [&](double part) { gear.Reduce(part, motions); });
    });
  }

  /** Solves the joints and gears several times, alternately forwards and backwards. If all sweeps
   * had the same direction, a chain that starts with the impulses of the last step could oscillate.
   */
  void Solve(Motions& motions, const SolverStep<Real>& step, bool push) {
    const size_t count = joints_.size() + gears_.size();
    const bool converges_slowly = has_rotors_ || !gears_.empty();
    const size_t sweeps = converges_slowly && !push ? kRotorSweeps : kSweeps;
    for (size_t k = 0; k < 2 * sweeps * count; ++k) {
      const size_t in_sweep = k % count;
      const size_t at = k / count % 2 == 0 ? in_sweep : count - 1 - in_sweep;
      if (at >= joints_.size()) {
        const size_t gear = at - joints_.size();
        if (!GearRests(gear)) gears_[gear].Solve(motions, step, push);
        continue;
      }
      if (Rests(at)) continue;
      Joint<Real>& joint = joints_[at];
      Act(motions, joint, [&](auto& a, auto& b) { joint.Solve(a, b, step, push); });
    }
  }

 private:
  // Number of forward and backward sweeps over the joints in each half of a substep.
  static constexpr size_t kSweeps = 4;
  // Number of such sweeps in the second half of a substep, if there are rotors or gears. A rotor or
  // a geared body that has more inertia than the other bodies slows the convergence. The velocities
  // that correct position errors must be removed completely.
  static constexpr size_t kRotorSweeps = 24;

  /** Call action(joint) or action(gear) for those whose bodies do not sleep. */
  template <class Action>
  void ForEachJoint(Action&& action) {
    for (size_t k = 0; k < joints_.size(); ++k) {
      if (!Rests(k)) action(joints_[k]);
    }
  }
  template <class Action>
  void ForEachGear(Action&& action) {
    for (size_t k = 0; k < gears_.size(); ++k) {
      if (!GearRests(k)) action(gears_[k]);
    }
  }
  static Motion<Real> Get(const Motions& motions, uint32_t body) {
    return body == kImmovable ? Motion<Real>{} : motions[body];
  }
  static double Work(const Joint<Real>& joint, const Motions& motions) {
    return joint.Work(Get(motions, joint.a), Get(motions, joint.b));
  }
  /** Returns a movable body of a gear. */
  uint32_t MovableRow(const Gear<Real>& gear) const { return joints_[gear.first].MovableRow(); }
  template <class Action>
  static void Act(Motions& motions, const Joint<Real>& joint, Action&& action) {
    Motion<Real> still_a, still_b;
    action(joint.a == kImmovable ? still_a : motions[joint.a],
           joint.b == kImmovable ? still_b : motions[joint.b]);
  }

  bool has_rotors_ = false;
  std::vector<Joint<Real>> joints_;
  std::vector<uint64_t> rows_;               // one per joint
  std::vector<uint8_t> rests_, gear_rests_;  // (joints), (gears) 1 if its bodies sleep
  std::vector<Gear<Real>> gears_;
  std::vector<uint64_t> gear_rows_;              // one per gear
  std::vector<Pair> pairs_;                      // (joints) in ascending order
  std::vector<double> before_;                   // (joints, gears) Work before the guess [J]
  std::vector<std::pair<double, double>> work_;  // (bodies) of a set: sum of Work, its change by
                                                 // the guess [J]
  Assemblies assemblies_;
};

}  // namespace vesper::rigid
