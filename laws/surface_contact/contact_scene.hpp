// SPDX-License-Identifier: Apache-2.0
// Scenes with surfaces: ground, and icosahedra of springs.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "scene.hpp"

namespace vesper {

/// Of a regular icosahedron whose corners lie at distance 1 from its centre.
template <class Real>
inline const Real kHalfEdge = static_cast<Real>(std::sqrt((5 - std::sqrt(5.0)) / 10));
template <class Real>
inline const Real kMidsphere = static_cast<Real>(std::sqrt((5 + std::sqrt(5.0)) / 10));
template <class Real>
inline const Real kInsphere = static_cast<Real>(std::sqrt((5 + 2 * std::sqrt(5.0)) / 15));

struct Material {
  double hardness;  // [N/m]
  double damping;   // [N s/m]
  double friction;  // [1]
};

/// Of an icosahedron: 12 equal masses, 30 equal springs.
struct Frame {
  double mass;     // of a corner [kg]
  double hooke;    // [N/m]
  double damping;  // [N s/m]
};

/// Rows of bodies that follow one another.
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

  /// A triangle of 346 m in the plane y = 0, facing up, of three immovable masses.
  void AddGround(const Material& material) {
    const uint32_t a = this->AddBody(0, {-173, 0, -100});
    this->AddBody(0, {0, 0, 200});
    this->AddBody(0, {173, 0, -100});
    AddSurface({a, a + 1, a + 2}, material);
  }

  /// Gravity as on a slope that falls along +x.
  void Tilt(double angle, double g) {
    this->gravity = {static_cast<Real>(g * std::sin(angle)),
                     static_cast<Real>(-g * std::cos(angle)), 0};
  }

  /// Corners at distance 1 from the centre.
  Rows AddIcosahedron(Vec3<Real> centre, Vec3<Real> speed, const Frame& frame,
                      const Material& material) {
    const auto corners = Corners();
    return Add(corners, centre, speed, frame, material);
  }

  /// On y = 0 with a face, whose middle is below the origin and whose one edge lies along z at
  /// x = kHalfEdge / sqrt(3).
  Rows AddIcosahedronOnFace(const Frame& frame, const Material& material) {
    auto corners = Corners();
    const auto [a, b, c] = Faces()[0];
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

  /// How far a point is behind the nearest of the 20 planes of the icosahedron at the origin.
  double DepthInIcosahedron(Vec3<Real> p) const {
    const auto corners = Corners();
    double depth = 2;
    for (const auto& [a, b, c] : Faces()) {
      const auto normal = Unit(corners[a] + corners[b] + corners[c]);
      depth = std::min(depth, kInsphere<double> - Dot(normal, this->Wide(p)));
    }
    return depth;
  }

  /// In validate mode; see Scene::MakeEngine.
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

  /// Kinetic, of springs and of weight, and of points behind y = 0 [J].
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
    const double s = kHalfEdge<double>, l = kMidsphere<double>;
    return {{{-s, l, 0},
             {s, l, 0},
             {-s, -l, 0},
             {s, -l, 0},
             {0, -s, l},
             {0, s, l},
             {0, -s, -l},
             {0, s, -l},
             {l, 0, -s},
             {l, 0, s},
             {-l, 0, -s},
             {-l, 0, s}}};
  }

  /// Counter-clockwise seen from outside.
  static std::array<std::array<uint32_t, 3>, 20> Faces() {
    return {{{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
             {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
             {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
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
    for (const auto& face : Faces()) {
      for (int i = 0; i < 3; ++i) {
        const uint32_t a = face[i], b = face[(i + 1) % 3];
        if (a > b) continue;  // its other face adds it
        this->AddSpring(first + a, first + b, 2 * kHalfEdge<Real>, static_cast<Real>(frame.hooke),
                        static_cast<Real>(frame.damping));
      }
      AddSurface({first + face[0], first + face[1], first + face[2]}, material);
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
