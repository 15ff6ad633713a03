// A body on a spring, which integrators are measured by: omega = 5 rad/s.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "scene.hpp"

namespace vesper {

/// A body of 4 kg, 0.5 m beyond the rest length of a spring of 100 N/m tied to a fixed point.
template <class Real>
struct Oscillator {
  explicit Oscillator(const std::string& integrator, Real damping = 0)
      : engine(Make(damping)) {
    engine.LoadPhysicsLaw("hooke_spring");
    engine.LoadPhysicsLaw(integrator);
  }

  double Strain() const { return double{scene.position[3]} - 2; }
  double Energy() const { return scene.KineticEnergy() + 0.5 * 100 * Strain() * Strain(); }
  /// Of the undamped motion.
  static double ExactStrain(double time) { return 0.5 * std::cos(5 * time); }

  Scene<Real> scene;
  PhysicsEngine engine;

 private:
  PhysicsEngine Make(Real damping) {
    scene.AddBody(0, {0, 0, 0});
    scene.AddBody(4, {2.5, 0, 0});
    scene.AddSpring(0, 1, 2, 100, damping);
    return scene.MakeEngine();
  }
};

/// Error of the strain after one second in so many steps.
inline double ErrorAfterOneSecond(const std::string& integrator, uint32_t steps) {
  Oscillator<double> oscillator(integrator);
  oscillator.engine.Advance(1.0 / steps, steps);
  return std::abs(oscillator.Strain() - Oscillator<double>::ExactStrain(1));
}

/// The power of dt that the error falls with, from `steps` to twice as many.
inline double OrderOfConvergence(const std::string& integrator, uint32_t steps) {
  return std::log2(ErrorAfterOneSecond(integrator, steps) /
                   ErrorAfterOneSecond(integrator, 2 * steps));
}

/// Largest distance of the energy from that of the beginning, relative to it.
inline double LargestEnergyError(const std::string& integrator, double dt, uint32_t steps) {
  Oscillator<double> oscillator(integrator);
  const double begin = oscillator.Energy();
  double largest = 0;
  for (uint32_t n = 0; n < steps; ++n) {
    oscillator.engine.Advance(dt);
    largest = std::max(largest, std::abs(oscillator.Energy() / begin - 1));
  }
  return largest;
}

}  // namespace vesper
