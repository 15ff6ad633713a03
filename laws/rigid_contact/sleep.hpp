// SPDX-License-Identifier: Apache-2.0
// Bodies at rest that the law does not solve until something changes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <vector>

#include "broad_phase.hpp"
#include "digest.hpp"
#include "joint_solver.hpp"
#include "parts.hpp"
#include "vesper/law.hpp"

namespace vesper::rigid {

/** Returns the digest of a joint, without its loads of the last step. */
inline uint64_t DigestOf(const JointSettings& joint) {
  Digest digest;
  digest.Add(uint64_t(joint.type)).Add(joint.anchor_a).Add(joint.anchor_b).Add(joint.axis);
  digest.Add(joint.rest);
  const AxisSettings& loads = joint.loads;
  for (const double number :
       {joint.angle_low, joint.angle_high, joint.travel_low, joint.travel_high, joint.motor_speed,
        joint.motor_torque, joint.drive_speed, joint.drive_force, loads.stiffness, loads.rest,
        loads.damping, loads.friction, loads.rotor, loads.place, loads.servo_stiffness,
        loads.servo_damping, joint.ball_damping, joint.breaking_force}) {
    digest.Add(number);
  }
  if (joint.type == JointType::kSixAxis) {
    const SixAxisSettings& six = joint.six;
    for (const Vector& limits :
         {six.offset_least, six.offset_greatest, six.turn_least, six.turn_greatest}) {
      digest.Add(limits);
    }
    for (const double number :
         {six.offset_stiffness, six.offset_damping, six.turn_stiffness, six.turn_damping}) {
      digest.Add(number);
    }
  }
  return digest.value();
}

/** Returns whether a motor or drive moves a joint. Such bodies do not rest, even if they are
 *  slow. */
inline bool IsDriven(const JointSettings& joint) {
  return (joint.motor_torque > 0 && joint.motor_speed != 0) ||
         (joint.drive_force > 0 && joint.drive_speed != 0);
}

/** The columns of sleep. */
template <class Real>
struct SleepColumns {
  /** 1 if the body sleeps; number of steps at rest; digest of the body and of its surroundings (low
   *  half, high half). */
  Scratch<std::array<uint32_t, 4>> state{"sleepState", "body", units::one};
  /** Force [N] and torque [N m] on the body when it fell asleep. For a part of a body: its place
   *  [m] and the vector of its quaternion, both relative to the body. */
  Scratch<std::array<Real, 6>> loads{"sleepLoads", "body", units::one};
  OptionalWrite<int32_t> asleep{"asleep", "body", units::one};

  auto Properties() { return std::tie(state, loads, asleep); }
};

/** Times and speeds of sleep. */
struct SleepLimits {
  double time;   // time at rest after which bodies sleep [s]; 0: never
  double speed;  // speed below which a body is at rest [m/s]

  bool IsOn() const { return time > 0; }
  /** Returns the acceleration [m/s^2] by a change of forces that wakes a body. In the time `time`,
   *  it would cause this fraction of the speed `speed`. */
  double Push() const { return 0.1 * speed / time; }
};

/** Decides in each step which bodies sleep. Bodies sleep and wake in islands: sets of bodies that
 *  contacts, joints and gears connect. The state is in the columns only, so a run continues with
 *  the same bits after a rollback and in another process.
 *
 *  `Law` provides the data of the bodies in the present step. */
template <class Real>
class Sleep {
 public:
  using Vector3 = Vec3<Real>;
  using Columns = SleepColumns<Real>;

  /** Returns whether a body sleeps in this step. */
  bool Rests(uint32_t body) const { return !bodies_.empty() && bodies_[body].rests; }

  /** Begins a step: reads which bodies sleep, and wakes those whose surroundings or values have
   *  changed, with their islands. Call it when the boxes and joints of the step are known. */
  template <class Law>
  void Wake(const Law& law, const Columns& columns, const SleepLimits& limits, const Step& step) {
    limits_ = limits;
    bodies_.clear();
    has_tired_ = false;
    if (!limits.IsOn()) return ClearAll(law, columns);
    if (!Start(law, columns, step.dt)) return bodies_.clear();
    DigestAll(law, step);
    SumSurroundings(law);
    for (uint32_t i = 0; i < law.rows(); ++i) {
      if (!bodies_[i].rests) continue;
      bodies_[i].wakes = TotalOf(i) != StoredTotal(columns, i) || IsPushed(law, columns, i);
    }
    for (const Part& part : law.parts().all()) {
      Body& body = bodies_[part.body];
      if (body.rests && IsMoved(part, columns.loads[part.row])) body.wakes = true;
    }
    for (const Pair& pair : law.pairs()) {
      const uint32_t a = law.BodyOfShape(pair.a), b = law.BodyOfShape(pair.b);
      if (a >= law.rows() || b >= law.rows() || !law.Movable(a) || !law.Movable(b)) continue;
      if (bodies_[a].rests == bodies_[b].rests) continue;
      Body& body = bodies_[bodies_[a].rests ? a : b];
      body.wakes = body.wakes || law.Touches(pair);
    }
    WakeIslands(law, columns);
  }

  /** Lets islands sleep in which all bodies have been at rest for long enough. Call it when the
   *  contacts of the step are known. */
  template <class Law, class Contacts>
  void FallAsleep(const Law& law, const Columns& columns, const Contacts& contacts) {
    if (!has_tired_) return;
    islands_.Reset(law.rows());
    held_.assign(law.rows(), 0);
    awake_.assign(law.rows(), 0);
    const auto join = [&](uint32_t a, uint32_t b) {
      if (a != kImmovable && b != kImmovable) return islands_.Join(a, b);
      const uint32_t body = a != kImmovable ? a : b;
      if (body != kImmovable) held_[body] = 1;
    };
    for (const auto& contact : contacts) join(contact.a, contact.b);
    ForEachJoined(law, join);
    for (uint32_t i = 0; i < law.rows(); ++i) {
      if (law.Movable(i) && !bodies_[i].rests && !bodies_[i].is_tired) awake_[i] = 1;
    }
    for (size_t k = 0; k < law.joints().count(); ++k) {
      const auto& joint = law.joints()[k];
      if (IsDriven(joint.settings)) awake_[joint.MovableRow()] = 1;
    }
    for (auto* flags : {&held_, &awake_}) {
      for (uint32_t i = 0; i < law.rows(); ++i) {
        if ((*flags)[i] != 0) (*flags)[islands_.Find(i)] = 1;
      }
    }
    bool any = false;
    for (uint32_t i = 0; i < law.rows(); ++i) {
      const uint32_t island = islands_.Find(i);
      if (!bodies_[i].is_tired || held_[island] == 0 || awake_[island] != 0) continue;
      bodies_[i].rests = any = true;
      columns.state[i][0] = 1;
      const Vector3 force = law.ForceOn(i), torque = law.TorqueOn(i);
      columns.loads[i] = {force.x, force.y, force.z, torque.x, torque.y, torque.z};
    }
    if (!any) return;
    for (const Part& part : law.parts().all()) {
      if (!bodies_[part.body].rests || !bodies_[part.body].is_tired) continue;
      const Vector3 at = Narrow<Real>(part.offset), turn = Narrow<Real>(part.turn.v);
      columns.loads[part.row] = {at.x, at.y, at.z, turn.x, turn.y, turn.z};
    }
    SumSurroundings(law);
    for (uint32_t i = 0; i < law.rows(); ++i) {
      if (!bodies_[i].rests) continue;
      const uint64_t total = TotalOf(i);
      columns.state[i][2] = uint32_t(total);
      columns.state[i][3] = uint32_t(total >> 32);
    }
  }

  /** Ends a step: counts the steps at rest of the bodies that do not sleep. `speed(i)` returns the
   *  speed of the fastest point of a body [m/s]. */
  template <class Law, class Speed>
  void Count(const Law& law, const Columns& columns, Speed&& speed) const {
    for (uint32_t i = 0; limits_.IsOn() && i < law.rows(); ++i) {
      if (!law.Movable(i) || Rests(i)) continue;
      uint32_t& steps = columns.state[i][1];
      steps = !(speed(i) < limits_.speed) ? 0 : steps == UINT32_MAX ? steps : steps + 1;
    }
    if (!columns.asleep.present()) return;
    for (uint32_t i = 0; i < law.rows(); ++i) columns.asleep[i] = Rests(law.BodyOfShape(i));
  }

 private:
  struct Body {
    bool rests = false;     // it sleeps in this step
    bool wakes = false;     // it slept until this step
    bool is_tired = false;  // it has been slow for long enough
    uint64_t own = 0;       // digest of the body and its parts
    uint64_t around = 0;    // sum of the digests of what surrounds it
  };

  static uint64_t StoredTotal(const Columns& columns, uint32_t i) {
    return uint64_t{columns.state[i][3]} << 32 | columns.state[i][2];
  }
  uint64_t TotalOf(uint32_t i) const {
    return Digest().Add(bodies_[i].own).Add(bodies_[i].around).value();
  }

  template <class Law>
  static void ClearAll(const Law& law, const Columns& columns) {
    for (uint64_t i = 0; i < law.rows(); ++i) {
      if (columns.state[i][0] != 0 || columns.state[i][1] != 0) columns.state[i] = {};
    }
  }

  /** Reads the columns; returns whether a body sleeps or could fall asleep. */
  template <class Law>
  bool Start(const Law& law, const Columns& columns, double dt) {
    bodies_.assign(law.rows(), {});
    bool any = false;
    for (uint32_t i = 0; i < law.rows(); ++i) {
      auto& state = columns.state[i];
      if (!law.Movable(i)) {
        state = {};
        continue;
      }
      bodies_[i].rests = state[0] != 0;
      bodies_[i].is_tired = state[0] == 0 && state[1] * dt >= limits_.time;
      has_tired_ = has_tired_ || bodies_[i].is_tired;
      any = any || bodies_[i].rests || bodies_[i].is_tired;
    }
    return any;
  }

  /** Returns whether the values of a shape count in digests. */
  template <class Law>
  bool IsStill(const Law& law, uint32_t shape) const {
    const uint32_t body = law.BodyOfShape(shape);
    return body >= law.rows() || !law.Movable(body) || bodies_[body].rests ||
           bodies_[body].is_tired;
  }

  /** Computes the digests and bounds of all shapes that are immovable or belong to bodies that
   * sleep or could fall asleep. A body that falls asleep stops, so its velocity does not count. */
  template <class Law>
  void DigestAll(const Law& law, const Step& step) {
    digests_.assign(law.shape_count(), 0);
    bounds_.resize(law.shape_count());
    step.ParallelFor(digests_.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        const auto shape = uint32_t(i);
        if (!IsStill(law, shape)) continue;
        digests_[i] = law.DigestOfShape(shape, shape < law.rows() && bodies_[shape].rests);
        bounds_[i] = law.StillBounds(shape);
      }
    });
    for (uint32_t i = 0; i < law.rows(); ++i) bodies_[i].own = digests_[i];
    for (const Part& part : law.parts().all()) bodies_[part.body].own += digests_[part.row];
    const uint64_t common = law.DigestOfSettings();
    for (Body& body : bodies_) body.own += common;
  }

  /** Adds up the digests of the surroundings of all bodies that sleep: of the shapes that may touch
   *  them, and of their joints. The sums do not depend on the order of the rows. */
  template <class Law>
  void SumSurroundings(const Law& law) {
    for (Body& body : bodies_) body.around = 0;
    const auto rests = [&](uint32_t body) { return body < law.rows() && bodies_[body].rests; };
    const auto digest = [&](uint32_t shape, uint32_t body) -> uint64_t {
      if (body < law.rows() && law.Movable(body))
        return bodies_[body].rests ? bodies_[body].own : 0;
      return digests_[shape] + (body == shape ? 0 : digests_[body]);  // the digest of a part lacks
                                                                      // the pose of its body
    };
    for (const Pair& pair : law.pairs()) {
      const uint32_t a = law.BodyOfShape(pair.a), b = law.BodyOfShape(pair.b);
      if (!rests(a) && !rests(b)) continue;
      if (!IsStill(law, pair.a) || !IsStill(law, pair.b)) continue;
      if (!bounds_[pair.a].Overlaps(bounds_[pair.b])) continue;
      if (rests(a)) bodies_[a].around += digest(pair.b, b);
      if (rests(b)) bodies_[b].around += digest(pair.a, a);
    }
    for (size_t k = 0; k < law.joints().count(); ++k) {
      const auto& joint = law.joints()[k];
      const uint64_t of_joint = DigestOf(joint.settings);
      const auto add = [&](uint32_t body, uint32_t other_row, uint32_t other) {
        if (!rests(body)) return;
        bodies_[body].around += of_joint + (other == kImmovable ? digests_[other_row] : 0);
      };
      add(joint.a, joint.row_b, joint.b);
      add(joint.b, joint.row_a, joint.a);
    }
    for (const Gear<Real>& gear : law.joints().gears()) {
      const uint32_t body = law.joints()[gear.first].MovableRow();
      if (rests(body)) {
        bodies_[body].around += Digest().Add(gear.ratio).Add(gear.offset).value();
      }
    }
  }

  /** Returns whether the forces of other laws differ from those when the body fell asleep. */
  template <class Law>
  bool IsPushed(const Law& law, const Columns& columns, uint32_t i) const {
    const auto& loads = columns.loads[i];
    const Vector3 force = law.ForceOn(i) - Vector3{loads[0], loads[1], loads[2]};
    const Vector3 torque = law.TorqueOn(i) - Vector3{loads[3], loads[4], loads[5]};
    return !(law.AccelerationBy(i, force, torque) <= limits_.Push());
  }

  static bool IsMoved(const Part& part, const std::array<Real, 6>& loads) {
    // Fraction of the size of the body. The place of a part in the world has rounding errors.
    constexpr double kMoved = 1e-3;
    const Vector at{double{loads[0]}, double{loads[1]}, double{loads[2]}};
    const Vector turn{double{loads[3]}, double{loads[4]}, double{loads[5]}};
    const double reach = Length(part.offset) + part.shape.Bound();
    const double turned =
        std::min(Length(part.turn.v - turn), Length(part.turn.v + turn));  // q and -q are equal
    return !(Length(part.offset - at) <= kMoved * reach && turned <= kMoved);
  }

  template <class Law>
  void WakeIslands(const Law& law, const Columns& columns) {
    bool any = false;
    for (const Body& body : bodies_) any = any || body.wakes;
    if (!any) return;
    islands_.Reset(law.rows());
    const auto join = [&](uint32_t a, uint32_t b) {
      if (a < law.rows() && b < law.rows() && bodies_[a].rests && bodies_[b].rests) {
        islands_.Join(a, b);
      }
    };
    for (const Pair& pair : law.pairs()) join(law.BodyOfShape(pair.a), law.BodyOfShape(pair.b));
    ForEachJoined(law, join);
    for (uint32_t i = 0; i < law.rows(); ++i) {
      if (bodies_[i].wakes) bodies_[islands_.Find(i)].wakes = true;
    }
    for (uint32_t i = 0; i < law.rows(); ++i) {
      if (!bodies_[i].rests || !bodies_[islands_.Find(i)].wakes) continue;
      bodies_[i].wakes = true;
      columns.state[i] = {};
    }
    for (Body& body : bodies_) {
      if (body.wakes) body.rests = false;
    }
  }

  /** Calls action(a, b) for all pairs of bodies that a joint or gear connects; a or b may be
   *  kImmovable. */
  template <class Law, class Action>
  static void ForEachJoined(const Law& law, Action&& action) {
    const auto& joints = law.joints();
    for (size_t k = 0; k < joints.count(); ++k) action(joints[k].a, joints[k].b);
    for (const Gear<Real>& gear : joints.gears()) {
      action(joints[gear.first].MovableRow(), joints[gear.second].MovableRow());
    }
  }

  static constexpr uint64_t kGrain = 256;

  SleepLimits limits_{};
  bool has_tired_ = false;
  std::vector<Body> bodies_;       // one per row; empty while no body sleeps or could fall asleep
  std::vector<uint64_t> digests_;  // one per shape; 0 for shapes that move
  std::vector<Bounds> bounds_;     // one per shape; only those of shapes that do not move are known
  Assemblies islands_;
  std::vector<uint8_t> held_;   // (bodies) 1 if its island touches an immovable shape
  std::vector<uint8_t> awake_;  // (bodies) 1 if a body of its island does not rest
};

}  // namespace vesper::rigid
