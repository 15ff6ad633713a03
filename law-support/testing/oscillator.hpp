// SPDX-License-Identifier: Apache-2.0
// A body on a spring with the angular frequency 5 rad/s, with which tests measure integrators.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "scene.hpp"

namespace vesper {

/// A body of 4 kg, 0.5 m beyond the rest length of a spring of 100 N/m tied to a fixed point. It
/// oscillates about x = 0, where positions have the smallest rounding errors.
template <class Real>
struct Oscillator {
  explicit Oscillator(const std::string& integrator, Real damping = 0) : engine(Make(damping)) {
    engine.LoadPhysicsLaw("hooke_spring");
    engine.LoadPhysicsLaw(integrator);
  }

  double Strain() const { return double{scene.position[3]}; }
  double Energy() const { return scene.KineticEnergy() + 0.5 * 100 * Strain() * Strain(); }
  /// Returns the spring's strain [m] at a time, for the motion without damping.
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

/// Returns the maximum rounding error of the strain [m] after `steps` steps. Each step rounds a
/// position of 0.5 m, a velocity of 2.5 m/s (from a strain of 0.5 m), and a length of 2.5 m. The
/// force of this length acts for dt^2 only; dt is at most 0.1 s.
template <class Real>
double LargestRounding(uint32_t steps) {
  return Rounding<Real>(steps);
}

/// Returns the maximum rounding error of the energy, relative to that of a strain of 0.5 m.
template <class Real>
double LargestRoundingOfEnergy(uint32_t steps) {
  return 2 * LargestRounding<Real>(steps) / 0.5;
}

/// Returns numbers of steps for which the integrator's own error exceeds rounding errors.
template <class Real>
std::vector<uint32_t> StepsAboveRounding(std::vector<uint32_t> in_f32,
                                         std::vector<uint32_t> in_f64) {
  return std::is_same_v<Real, float> ? in_f32 : in_f64;
}

/// Returns the error of the strain after one second that is divided into `steps` steps.
template <class Real>
double ErrorAfterOneSecond(const std::string& integrator, uint32_t steps) {
  Oscillator<Real> oscillator(integrator);
  oscillator.engine.Advance(1.0 / steps, steps);
  return std::abs(oscillator.Strain() - Oscillator<Real>::ExactStrain(1));
}

struct Convergence {
  double order;     // power of dt with which the error decreases
  double rounding;  // maximum effect of rounding on the order
};

/// Measures the order of an integrator. Compares the errors with `steps` steps per second and with
/// twice as many steps.
template <class Real>
Convergence MeasureConvergence(const std::string& integrator, uint32_t steps) {
  const double coarse = ErrorAfterOneSecond<Real>(integrator, steps);
  const double fine = ErrorAfterOneSecond<Real>(integrator, 2 * steps);
  return {std::log2(coarse / fine),
          (LargestRounding<Real>(steps) / coarse + LargestRounding<Real>(2 * steps) / fine) /
              std::log(2)};
}

/// Returns the largest deviation of the energy from its initial value, relative to that value.
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
