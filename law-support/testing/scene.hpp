// SPDX-License-Identifier: Apache-2.0
// Point masses and springs for the tests of laws, in the columns of a standard prototype.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <type_traits>
#include <vector>

#include "vesper/law.hpp"
#include "vesper/vesper.hpp"

namespace vesper {

template <class Real>
struct Scene {
  // body
  std::vector<Real> mass;            // (bodies) [kg]
  std::vector<Real> position;        // (bodies x 3) [m]
  std::vector<Real> velocity;        // (bodies x 3) [m/s]
  std::vector<Real> applied_force;   // (bodies x 3) [N]
  std::vector<Real> external_force;  // (bodies x 3) [N]
  // spring
  std::vector<uint32_t> endpoints;     // (springs x 2), rows of bodies
  std::vector<Real> length;            // (springs) [m]
  std::vector<Real> hooke_constant;    // (springs) [N/m]
  std::vector<Real> damping_constant;  // (springs) [N s/m]
  // world
  std::vector<Real> gravity = {0, 0, 0};  // (1 x 3) [m/s^2]
  // Receives the lines that laws write to the log; none if empty.
  std::function<void(uint32_t, const char*)> log;

  uint32_t AddBody(Real m, Vec3<Real> at, Vec3<Real> moving = {}) {
    mass.push_back(m);
    position.insert(position.end(), {at.x, at.y, at.z});
    velocity.insert(velocity.end(), {moving.x, moving.y, moving.z});
    applied_force.insert(applied_force.end(), {0, 0, 0});
    external_force.insert(external_force.end(), {0, 0, 0});
    return static_cast<uint32_t>(mass.size() - 1);
  }

  void AddSpring(uint32_t a, uint32_t b, Real rest, Real k, Real damping = 0) {
    endpoints.insert(endpoints.end(), {a, b});
    length.push_back(rest);
    hooke_constant.push_back(k);
    damping_constant.push_back(damping);
  }

  /// Creates an engine over this scene's columns, which must not grow or move from now on.
  PhysicsEngine MakeEngine(uint32_t threads = 1, bool validate = true, bool deferred = false) {
    PhysicsEngine engine(std::is_same_v<Real, double> ? "si-f64" : "si-f32",
                         {.threads = threads,
                          .validate = validate,
                          .law_path = VESPER_LAW_PATH,
                          .deferred = deferred,
                          .log = log});
    PhysicalPropertyProvider provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass);
    provider.AddPhysicalProperty("position", position);
    provider.AddPhysicalProperty("velocity", velocity);
    provider.AddPhysicalProperty("appliedForce", applied_force);
    provider.AddPhysicalProperty("externalForce", external_force);
    provider.AddPhysicalProperty("endpoints", endpoints);
    provider.AddPhysicalProperty("length", length);
    provider.AddPhysicalProperty("hookeConstant", hooke_constant);
    provider.AddPhysicalProperty("dampingConstant", damping_constant);
    provider.AddPhysicalProperty("gravity", gravity);
    return engine;
  }

  Vec3<Real> At(const std::vector<Real>& column, uint64_t row) const {
    return {column[3 * row], column[3 * row + 1], column[3 * row + 2]};
  }

  double KineticEnergy() const {
    double energy = 0;
    for (uint64_t i = 0; i < mass.size(); ++i) {
      const Vec3<Real> v = At(velocity, i);
      energy += 0.5 * double{mass[i]} * double{Dot(v, v)};
    }
    return energy;
  }

  Vec3<double> Momentum() const {
    Vec3<double> sum;
    for (uint64_t i = 0; i < mass.size(); ++i) sum += Wide(At(velocity, i)) * double{mass[i]};
    return sum;
  }

  Vec3<double> AngularMomentum() const {
    Vec3<double> sum;
    for (uint64_t i = 0; i < mass.size(); ++i) {
      sum += Cross(Wide(At(position, i)), Wide(At(velocity, i)) * double{mass[i]});
    }
    return sum;
  }

  static Vec3<double> Wide(Vec3<Real> v) { return {double{v.x}, double{v.y}, double{v.z}}; }
};

/// Returns a scene of `bodies` bodies in a box of 20 m. A spring connects each body to the next
/// body, and another spring connects it to a random body. All bodies except the first have mass.
template <class Real>
Scene<Real> RandomNetwork(uint32_t bodies, uint32_t seed) {
  std::mt19937 random(seed);
  const auto draw = [&](double low, double high) {
    return static_cast<Real>(low + (high - low) * random() / 4294967296.0);
  };
  const auto vector = [&](double size) {
    return Vec3<Real>{draw(-size, size), draw(-size, size), draw(-size, size)};
  };
  Scene<Real> scene;
  for (uint32_t i = 0; i < bodies; ++i) {
    scene.AddBody(i == 0 ? 0 : draw(1, 5), vector(10), vector(3));
  }
  for (uint32_t i = 1; i < bodies; ++i) {
    const uint32_t other = random() % bodies;
    scene.AddSpring(i - 1, i, draw(1, 10), draw(1, 100), draw(0, 2));
    if (other != i) scene.AddSpring(i, other, draw(1, 10), draw(1, 100), draw(0, 2));
  }
  return scene;
}

/// Returns the rounding error of one operation on numbers of the magnitude `size`.
template <class Real>
double Rounding(double size) {
  return size * static_cast<double>(std::numeric_limits<Real>::epsilon());
}

using Precisions = ::testing::Types<float, double>;

}  // namespace vesper
