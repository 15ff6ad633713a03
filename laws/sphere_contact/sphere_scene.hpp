// SPDX-License-Identifier: Apache-2.0
// Scenes of rolling balls, for the tests of sphere_contact.
#pragma once

#include <algorithm>
#include <map>
#include <string>

#include "scene.hpp"

namespace vesper {

template <class Real>
struct SphereScene : Scene<Real> {
  std::vector<Real> radius;       // (bodies) [m]
  std::vector<Real> inertia;      // (bodies x 3) [kg m^2]
  std::vector<Real> spin;         // (bodies x 3) [rad/s]
  std::vector<Real> orientation;  // (bodies x 4)
  std::vector<Real> torque;       // (bodies x 3) [N m]
  std::vector<Real> contact;      // (bodies x 3) [N], empty unless a test measures it

  /// Adds a solid ball.
  void AddSphere(Real m, Real r, Vec3<Real> at, Vec3<Real> moving = {}, Vec3<Real> turning = {}) {
    this->AddBody(m, at, moving);
    radius.push_back(r);
    const Real moment = Real(0.4) * m * r * r;
    inertia.insert(inertia.end(), {moment, moment, moment});
    spin.insert(spin.end(), {turning.x, turning.y, turning.z});
    orientation.insert(orientation.end(), {0, 0, 0, 1});
    torque.insert(torque.end(), {0, 0, 0});
  }

  /// Creates an engine with gravity, the contact law, and laws for linear and angular motion.
  PhysicsEngine MakeSphereEngine(const std::map<std::string, double>& parameters = {},
                                 uint32_t threads = 1, bool validate = true) {
    PhysicsEngine engine = this->MakeEngine(threads, validate);
    PhysicalPropertyProvider provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("radius", radius);
    provider.AddPhysicalProperty("inertia", inertia);
    provider.AddPhysicalProperty("angularVelocity", spin);
    provider.AddPhysicalProperty("orientation", orientation);
    provider.AddPhysicalProperty("torque", torque);
    if (!contact.empty()) provider.AddPhysicalProperty("contactForce", contact);
    for (const char* law : {"gravity_field", "newton_motion", "angular_motion"}) {
      engine.LoadPhysicsLaw(law);
    }
    std::vector<ParameterValue> values;
    for (const auto& [name, value] : parameters) values.push_back({name, value});
    engine.LoadPhysicsLaw("sphere_contact", values);
    return engine;
  }

  Vec3<double> TotalAngularMomentum() const {
    Vec3<double> sum = this->AngularMomentum();
    for (size_t i = 0; i < radius.size(); ++i) {
      sum += this->Wide(this->At(spin, i)) * double{inertia[3 * i]};
    }
    return sum;
  }

  double SpinEnergy() const {
    double energy = 0;
    for (size_t i = 0; i < radius.size(); ++i) {
      const auto w = this->Wide(this->At(spin, i));
      energy += 0.5 * double{inertia[3 * i]} * Dot(w, w);
    }
    return energy;
  }

  double LargestForce() const {
    double largest = 0;
    for (const Real f : this->external_force) largest = std::max(largest, std::abs(double{f}));
    return largest;
  }

  /// Returns the energy [J] that contact springs of this stiffness store in all overlapping
  /// spheres.
  double ElasticEnergy(double stiffness) const {
    double energy = 0;
    ForPairs(this->position, [&](size_t, size_t, const Vec3<double>&, double depth) {
      energy += 0.5 * stiffness * depth * depth;
    });
    return energy;
  }

  /// Returns the largest overlap [m] of two spheres, at least one of them movable.
  double LargestOverlap() const {
    double largest = 0;
    ForPairs(this->position, [&](size_t, size_t, const Vec3<double>&, double depth) {
      largest = std::max(largest, depth);
    });
    return largest;
  }

  /// Returns the forces (bodies x 3) [N] of contact springs between all spheres that overlap at the
  /// positions `at`.
  std::vector<double> ElasticForces(const std::vector<Real>& at, double stiffness) const {
    std::vector<double> forces(at.size());
    ForPairs(at, [&](size_t i, size_t j, const Vec3<double>& normal, double depth) {
      const double push[] = {normal.x, normal.y, normal.z};
      for (size_t c = 0; c < 3; ++c) {
        forces[3 * i + c] -= push[c] * stiffness * depth;
        forces[3 * j + c] += push[c] * stiffness * depth;
      }
    });
    return forces;
  }

 private:
  template <class Visit>
  void ForPairs(const std::vector<Real>& at, const Visit& visit) const {
    for (size_t i = 0; i < radius.size(); ++i) {
      for (size_t j = i + 1; j < radius.size(); ++j) {
        const bool immovable = this->mass[i] == 0 && this->mass[j] == 0;
        if (radius[i] == 0 || radius[j] == 0 || immovable) continue;
        const auto way = this->Wide(this->At(at, j)) - this->Wide(this->At(at, i));
        const double distance = Length(way);
        const double depth = double{radius[i]} + double{radius[j]} - distance;
        if (depth > 0) visit(i, j, way * (1 / distance), depth);
      }
    }
  }
};

/// Returns balls of 1 to 3 kg and 0.3 to 0.6 m in a box of 4 m, with random velocities and
/// rotations.
template <class Real>
SphereScene<Real> RandomSpheres(uint32_t count, uint32_t seed) {
  std::mt19937 random(seed);
  const auto draw = [&](double low, double high) {
    return static_cast<Real>(low + (high - low) * random() / 4294967296.0);
  };
  const auto vector = [&](double size) {
    const Real x = draw(-size, size), y = draw(-size, size);
    return Vec3<Real>{x, y, draw(-size, size)};
  };
  SphereScene<Real> scene;
  for (uint32_t i = 0; i < count; ++i) {
    const Real mass = draw(1, 3), radius = draw(0.3, 0.6);
    const Vec3<Real> at = vector(2), moving = vector(2);
    scene.AddSphere(mass, radius, at, moving, vector(5));
  }
  return scene;
}

}  // namespace vesper
