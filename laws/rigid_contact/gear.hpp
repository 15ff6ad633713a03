// SPDX-License-Identifier: Apache-2.0
// Gears between two joints as constraints on the velocities of up to four bodies.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "joint.hpp"

namespace vesper::rigid {

/** A gear during a step. It keeps the angle or travel of the first joint at `ratio` times that of
 *  the second joint, plus an offset. Each of the two joints is a hinge or a slider. The units
 * depend on the two joints: rad for hinges, m for sliders. */
template <class Real>
class Gear {
 public:
  using Motions = std::vector<Motion<Real>>;

  size_t first = 0, second = 0;  // indices of the joints in their solver
  double ratio = 1, offset = 0;  // [unit of the first per unit of the second], [unit of the first]
  std::array<double, 2> places{};  // angles or travels of the two joints, with whole turns

  /** Returns whether a gear can connect this joint. */
  static bool Connects(const Joint<Real>& joint) { return joint.IsHinge() || joint.IsSlider(); }

  /** Computes directions, effective mass and error for the present poses. */
  void Refresh(const Joint<Real>& of_first, const Joint<Real>& of_second, const Motions& motions) {
    Set(0, of_first, 1);
    Set(2, of_second, -ratio);
    places[0] = Follow(places[0], of_first);
    places[1] = Follow(places[1], of_second);
    error_ = places[0] - ratio * places[1] - offset;
    double response = 0;
    for (const Part& on : parts_) {
      if (on.body == kImmovable) continue;
      const Motion<Real>& motion = motions[on.body];
      for (const Part& part : parts_) {  // a body may belong to both joints
        if (part.body != on.body) continue;
        response += Dot(on.along, part.along) * double{motion.inverse_mass} +
                    Dot(on.turn, Wide(motion.inverse_inertia * Narrow<Real>(part.turn)));
      }
    }
    mass_ = response > 0 ? 1 / response : 0;
  }

  /** Sets the impulse of the last step as a first guess for this step [N m s], [N s]. */
  void StartWith(double impulse) { impulse_ = impulse; }
  /** Applies the first guess. */
  void ApplyStart(Motions& motions) const { Apply(impulse_, motions); }
  /** Returns the product of the first guess and the relative speed [J]. */
  double Work(const Motions& motions) const { return impulse_ * Speed(motions); }
  /** Scales the first guess by a factor below 1, and corrects the motions accordingly. */
  void Reduce(double part, Motions& motions) {
    Apply(impulse_ * (part - 1), motions);
    impulse_ *= part;
  }

  /** Changes the impulse so that the two joints move as the ratio says. With `push`, also corrects
   *  the error of their places. */
  void Solve(Motions& motions, const SolverStep<Real>& step, bool push) {
    const double limit = double{step.push_speed};
    const double undo =
        push ? std::clamp(kUndone / double{step.substep} * error_, -limit, limit) : 0;
    const double change = -mass_ * (Speed(motions) + undo);
    impulse_ += change;
    Apply(change, motions);
  }

  /** Returns the impulse of this step along or about the axis of the first joint, on its second
   *  body [N s], [N m s]. The impulse on the second joint is -ratio times this impulse. */
  double impulse() const { return impulse_; }

 private:
  // Fraction of an error that a substep corrects.
  static constexpr double kUndone = 0.5;

  /** A body of one of the joints, and the impulse on it per impulse of the gear. */
  struct Part {
    uint32_t body = kImmovable;
    Vector along, turn;  // linear and angular impulse
  };

  void Set(size_t at, const Joint<Real>& joint, double factor) {
    const Vector axis = joint.axis() * factor;
    if (joint.IsHinge()) {
      parts_[at] = {joint.a, {}, axis * -1.0};
      parts_[at + 1] = {joint.b, {}, axis};
    } else {
      parts_[at] = {joint.a, axis * -1.0, Cross(joint.arm_a(), axis) * -1.0};
      parts_[at + 1] = {joint.b, axis, Cross(joint.arm_b(), axis)};
    }
  }

  /** Returns the present angle with the whole turns of the place before, or the travel. */
  static double Follow(double before, const Joint<Real>& joint) {
    if (!joint.IsHinge()) return joint.travel();
    constexpr double kTurn = 2 * 3.14159265358979323846;
    const double change = joint.angle() - before;
    return before + change - kTurn * std::floor(change / kTurn + 0.5);
  }

  double Speed(const Motions& motions) const {
    double speed = 0;
    for (const Part& part : parts_) {
      if (part.body == kImmovable) continue;
      const Motion<Real>& motion = motions[part.body];
      speed += Dot(part.along, Wide(motion.velocity)) + Dot(part.turn, Wide(motion.spin));
    }
    return speed;
  }

  void Apply(double impulse, Motions& motions) const {
    for (const Part& part : parts_) {
      if (part.body == kImmovable) continue;
      Motion<Real>& motion = motions[part.body];
      motion.velocity += Narrow<Real>(part.along * impulse) * motion.inverse_mass;
      motion.spin += motion.inverse_inertia * Narrow<Real>(part.turn * impulse);
    }
  }

  std::array<Part, 4> parts_;  // first and second body of the first joint, then of the second
  double impulse_ = 0, mass_ = 0, error_ = 0;
};

}  // namespace vesper::rigid
