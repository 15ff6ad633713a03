// SPDX-License-Identifier: Apache-2.0
// Scenes with surfaces: ground, and icosahedra of springs.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "icosahedron.hpp"
#include "scene.hpp"

namespace vesper {

/// Half edge, midradius and inradius of a regular icosahedron whose corners are at distance 1 from
/// its centre.
template <class Real>
inline const Real kHalfEdge = static_cast<Real>(icosahedron::HalfEdge());
template <class Real>
inline const Real kMidsphere = static_cast<Real>(icosahedron::Midsphere());
template <class Real>
inline const Real kInsphere = static_cast<Real>(icosahedron::Insphere());

struct Material {
  double hardness;  // [N/m]
  double damping;   // [N s/m]
  double friction;  // [1]
};

/// Masses and springs of an icosahedron: 12 equal masses, 30 equal springs.
struct Frame {
  double mass;     // mass of a corner [kg]
  double hooke;    // [N/m]
  double damping;  // [N s/m]
};

/// A range of consecutive rows of bodies.
struct Rows {
  uint32_t first, count;
};

template <class Real>
struct ContactScene : Scene<Real> {
  std::vector<uint32_t> vertices;     // (surfaces x 3), rows of bodies
  std::vector<Real> hardness;         // (surfaces) [N/m]
  std::vector<Real> surface_damping;  // (surfaces) [N s/m]
  std::vector<Real> friction;         // (surfaces) [1]

  void AddSurface(const std::array<uint32_t, 3>& corners, const Material& material) {
    vertices.insert(vertices.end(), corners.begin(), corners.end());
    hardness.push_back(static_cast<Real>(material.hardness));
    surface_damping.push_back(static_cast<Real>(material.damping));
    friction.push_back(static_cast<Real>(material.friction));
  }

  /// Adds a triangle of 346 m in the plane y = 0, facing up, with three immovable masses.
  void AddGround(const Material& material) {
    const uint32_t a = this->AddBody(0, {-173, 0, -100});
    this->AddBody(0, {0, 0, 200});
    this->AddBody(0, {173, 0, -100});
    AddSurface({a, a + 1, a + 2}, material);
  }

  /// Rotates gravity by `angle`, so that the plane y = 0 becomes a slope that descends along +x.
  void Tilt(double angle, double g) {
    this->gravity = {static_cast<Real>(g * std::sin(angle)),
                     static_cast<Real>(-g * std::cos(angle)), 0};
  }

  /// Adds an icosahedron with corners at distance 1 from the centre.
  Rows AddIcosahedron(Vec3<Real> centre, Vec3<Real> speed, const Frame& frame,
                      const Material& material) {
    const auto corners = Corners();
    return Add(corners, centre, speed, frame, material);
  }

  /// Adds an icosahedron with a face on y = 0. The middle of the face is below the origin, and one
  /// of its edges is along z at x = kHalfEdge / sqrt(3).
  Rows AddIcosahedronOnFace(const Frame& frame, const Material& material) {
    auto corners = Corners();
    const auto [a, b, c] = icosahedron::kFaces[0];
    const auto down = Unit(corners[a] + corners[b] + corners[c]);
    const auto along = Unit(corners[b] - corners[a]);
    const auto across = Cross(along, down);
    const bool positive = Dot(across, corners[a]) > 0;
    for (auto& p : corners) {
      const double x = Dot(across, p), z = Dot(along, p);
      p = {positive ? x : -x, -Dot(down, p), positive ? z : -z};
    }
    return Add(corners, {0, kInsphere<Real>, 0}, {}, frame, material);
  }

  /// Returns how deep a point is below the nearest of the 20 face planes of the icosahedron at the
  /// origin.
  double DepthInIcosahedron(Vec3<Real> p) const {
    const auto corners = Corners();
    double depth = 2;
    for (const auto& [a, b, c] : icosahedron::kFaces) {
      const auto normal = Unit(corners[a] + corners[b] + corners[c]);
      depth = std::min(depth, kInsphere<double> - Dot(normal, this->Wide(p)));
    }
    return depth;
  }

  /// Creates an engine in validate mode; see Scene::MakeEngine.
  PhysicsEngine MakeEngine(uint32_t threads = 1) {
    PhysicsEngine engine = Scene<Real>::MakeEngine(threads);
    PhysicalPropertyProvider provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("vertices", vertices);
    provider.AddPhysicalProperty("hardness", hardness);
    provider.AddPhysicalProperty("surfaceDamping", surface_damping);
    provider.AddPhysicalProperty("frictionCoefficient", friction);
    return engine;
  }

  void LoadAllLaws(PhysicsEngine& engine) const {
    for (const char* law : {"gravity_field", "hooke_spring", "surface_contact", "newton_motion"}) {
      engine.LoadPhysicsLaw(law);
    }
  }

  Vec3<Real> Centre(Rows of) const { return Mean(this->position, of); }
  Vec3<Real> CentreVelocity(Rows of) const { return Mean(this->velocity, of); }

  /// Returns the energy [J] of motion, springs and weight, and of the contact springs of points
  /// below y = 0.
  double MechanicalEnergy() const {
    double energy = this->KineticEnergy();
    for (uint64_t s = 0; s < this->length.size(); ++s) {
      const auto a = this->At(this->position, this->endpoints[2 * s]);
      const auto b = this->At(this->position, this->endpoints[2 * s + 1]);
      const double strain = double{Length(b - a)} - double{this->length[s]};
      energy += 0.5 * double{this->hooke_constant[s]} * strain * strain;
    }
    const Vec3<Real> g{this->gravity[0], this->gravity[1], this->gravity[2]};
    for (uint64_t i = 0; i < this->mass.size(); ++i) {
      const auto p = this->At(this->position, i);
      energy -= double{this->mass[i]} * double{Dot(g, p)};
      if (this->mass[i] > 0 && this->mass[0] == 0 && p.y < 0) {
        energy += 0.5 * double{hardness[0]} * double{p.y} * double{p.y};
      }
    }
    return energy;
  }

 private:
  static Vec3<double> Unit(Vec3<double> v) { return v * (1 / Length(v)); }

  static std::array<Vec3<double>, 12> Corners() {
    std::array<Vec3<double>, 12> corners;
    std::ranges::transform(icosahedron::Corners(), corners.begin(),
                           [](const auto& p) { return Vec3<double>{p[0], p[1], p[2]}; });
    return corners;
  }

  Rows Add(const std::array<Vec3<double>, 12>& corners, Vec3<Real> centre, Vec3<Real> speed,
           const Frame& frame, const Material& material) {
    const auto first = static_cast<uint32_t>(this->mass.size());
    for (const auto& p : corners) {
      this->AddBody(static_cast<Real>(frame.mass),
                    centre + Vec3<Real>{static_cast<Real>(p.x), static_cast<Real>(p.y),
                                        static_cast<Real>(p.z)},
                    speed);
    }
    for (const auto& [a, b] : icosahedron::Edges()) {
      this->AddSpring(first + a, first + b, 2 * kHalfEdge<Real>, static_cast<Real>(frame.hooke),
                      static_cast<Real>(frame.damping));
    }
    for (const auto& [a, b, c] : icosahedron::kFaces) {
      AddSurface({first + a, first + b, first + c}, material);
    }
    return {first, 12};
  }

  Vec3<Real> Mean(const std::vector<Real>& column, Rows of) const {
    Vec3<Real> sum;
    for (uint32_t i = 0; i < of.count; ++i) sum += this->At(column, of.first + i);
    return sum * (Real(1) / static_cast<Real>(of.count));
  }
};

}  // namespace vesper
