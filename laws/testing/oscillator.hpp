// SPDX-License-Identifier: Apache-2.0
// A body on a spring, which integrators are measured by: omega = 5 rad/s.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "scene.hpp"

namespace vesper {

/// A body of 4 kg, 0.5 m beyond the rest length of a spring of 100 N/m tied to a fixed point. It
/// swings about x = 0, where positions round least.
template <class Real>
struct Oscillator {
  explicit Oscillator(const std::string& integrator, Real damping = 0) : engine(Make(damping)) {
    engine.LoadPhysicsLaw("hooke_spring");
    engine.LoadPhysicsLaw(integrator);
  }

  double Strain() const { return double{scene.position[3]}; }
  double Energy() const { return scene.KineticEnergy() + 0.5 * 100 * Strain() * Strain(); }
  /// Of the undamped motion.
  static double ExactStrain(double time) { return 0.5 * std::cos(5 * time); }

  Scene<Real> scene;
  PhysicsEngine engine;

 private:
  PhysicsEngine Make(Real damping) {
    scene.AddBody(0, {-2, 0, 0});
    scene.AddBody(4, {0.5, 0, 0});
    scene.AddSpring(0, 1, 2, 100, damping);
    return scene.MakeEngine();
  }
};

/// What roundings add to the strain in so many steps, at most [m]: in each of them of a position of
/// 0.5 m, of a velocity of 2.5 m/s, which a strain of 0.5 m makes, and of a length of 2.5 m, whose
/// force acts for dt^2 only; dt is 0.1 s or less.
template <class Real>
double LargestRounding(uint32_t steps) {
  return Rounding<Real>(steps);
}

/// The same of the energy, relative to that of a strain of 0.5 m.
template <class Real>
double LargestRoundingOfEnergy(uint32_t steps) {
  return 2 * LargestRounding<Real>(steps) / 0.5;
}

/// Numbers of steps of which an integrator's own error is above roundings.
template <class Real>
std::vector<uint32_t> StepsAboveRounding(std::vector<uint32_t> in_f32,
                                         std::vector<uint32_t> in_f64) {
  return std::is_same_v<Real, float> ? in_f32 : in_f64;
}

/// Error of the strain after one second in so many steps.
template <class Real>
double ErrorAfterOneSecond(const std::string& integrator, uint32_t steps) {
  Oscillator<Real> oscillator(integrator);
  oscillator.engine.Advance(1.0 / steps, steps);
  return std::abs(oscillator.Strain() - Oscillator<Real>::ExactStrain(1));
}

struct Convergence {
  double order;     // the power of dt that the error falls with
  double rounding;  // how far roundings may have moved it
};

/// From so many steps of one second to twice as many.
template <class Real>
Convergence MeasureConvergence(const std::string& integrator, uint32_t steps) {
  const double coarse = ErrorAfterOneSecond<Real>(integrator, steps);
  const double fine = ErrorAfterOneSecond<Real>(integrator, 2 * steps);
  return {std::log2(coarse / fine),
          (LargestRounding<Real>(steps) / coarse + LargestRounding<Real>(2 * steps) / fine) /
              std::log(2)};
}

/// Largest distance of the energy from that of the beginning, relative to it.
template <class Real>
double LargestEnergyError(const std::string& integrator, double dt, uint32_t steps) {
  Oscillator<Real> oscillator(integrator);
  const double begin = oscillator.Energy();
  double largest = 0;
  for (uint32_t n = 0; n < steps; ++n) {
    oscillator.engine.Advance(dt);
    largest = std::max(largest, std::abs(oscillator.Energy() / begin - 1));
  }
  return largest;
}

}  // namespace vesper
