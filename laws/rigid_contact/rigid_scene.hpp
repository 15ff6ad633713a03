// SPDX-License-Identifier: Apache-2.0
// Rigid bodies and scenery for the tests of rigid_contact, in the columns of a standard prototype.
#pragma once

#include "rigid/rotation.hpp"
#include "scene.hpp"
#include "shape.hpp"

namespace vesper {

template <class Real>
struct RigidScene : Scene<Real> {
  using Code = rigid::ShapeCode;
  using Vector = Vec3<double>;

  std::vector<int32_t> shape;                          // (bodies)
  std::vector<double> size;                            // (bodies x 3) [m]
  std::vector<Real> orientation, spin, torque, inertia;  // (bodies x 4), (bodies x 3)
  std::vector<int32_t> scenery_shape;                  // (scenery)
  std::vector<double> scenery_size;                    // (scenery x 3) [m]
  std::vector<Real> scenery_position, scenery_orientation;

  uint32_t Add(Code code, Vector extent, double mass, Vector at, Vector moving = {},
               rigid::Quaternion q = {}) {
    shape.push_back(static_cast<int32_t>(code));
    size.insert(size.end(), {extent.x, extent.y, extent.z});
    Append(orientation, q.Stored<Real>());
    for (auto* column : {&spin, &torque, &inertia}) column->insert(column->end(), {0, 0, 0});
    return this->AddBody(Real(mass), rigid::Narrow<Real>(at), rigid::Narrow<Real>(moving));
  }
  uint32_t AddBall(double radius, double mass, Vector at, Vector moving = {}) {
    return Add(Code::kSphere, {2 * radius, 2 * radius, 2 * radius}, mass, at, moving);
  }
  uint32_t AddBox(Vector extent, double mass, Vector at, Vector moving = {},
                  rigid::Quaternion q = {}) {
    return Add(Code::kBox, extent, mass, at, moving, q);
  }
  void AddScenery(Code code, Vector extent, Vector at, rigid::Quaternion q = {}) {
    scenery_shape.push_back(static_cast<int32_t>(code));
    scenery_size.insert(scenery_size.end(), {extent.x, extent.y, extent.z});
    scenery_position.insert(scenery_position.end(), {Real(at.x), Real(at.y), Real(at.z)});
    Append(scenery_orientation, q.Stored<Real>());
  }
  /// Adds a box whose top is at y = 0.
  void AddGround() { AddScenery(Code::kBox, {1000, 2, 1000}, {0, -1, 0}); }

  /// Creates an engine over this scene with gravity_field and rigid_contact.
  PhysicsEngine MakeRigidEngine(const std::vector<ParameterValue>& parameters = {},
                                uint32_t threads = 1) {
    PhysicsEngine engine = this->MakeEngine(threads);
    PhysicalPropertyProvider provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("shape", shape);
    provider.AddPhysicalProperty("size", size);
    provider.AddPhysicalProperty("orientation", orientation);
    provider.AddPhysicalProperty("angularVelocity", spin);
    provider.AddPhysicalProperty("torque", torque);
    provider.AddPhysicalProperty("inertia", inertia);
    if (!scenery_shape.empty()) {
      provider.AddPhysicalProperty("sceneryShape", scenery_shape);
      provider.AddPhysicalProperty("scenerySize", scenery_size);
      provider.AddPhysicalProperty("sceneryPosition", scenery_position);
      provider.AddPhysicalProperty("sceneryOrientation", scenery_orientation);
    }
    engine.LoadPhysicsLaw("gravity_field");
    engine.LoadPhysicsLaw("rigid_contact", parameters);
    return engine;
  }

  Vector Position(uint32_t i) const { return this->Wide(this->At(this->position, i)); }
  Vector Velocity(uint32_t i) const { return this->Wide(this->At(this->velocity, i)); }
  Vector Spin(uint32_t i) const { return this->Wide(this->At(spin, i)); }
  rigid::Quaternion Rotation(uint32_t i) const {
    return {{orientation[4 * i], orientation[4 * i + 1], orientation[4 * i + 2]},
            orientation[4 * i + 3]};
  }
  /// Returns the principal moments of a body: those given, or those of its shape.
  Vector Moments(uint32_t i) const {
    const Vector given = this->Wide(this->At(inertia, i));
    if (!(given == Vector{})) return given;
    return rigid::Shape::Of(shape[i], {size[3 * i], size[3 * i + 1], size[3 * i + 2]}, {}, {})
        .Moments(this->mass[i]);
  }
  /// Returns the angular momentum of a body about its centre.
  Vector OwnMomentum(uint32_t i) const {
    const rigid::Quaternion q = Rotation(i).Normalised();
    const Vector own = q.Inverse().Rotate(Spin(i)), m = Moments(i);
    return q.Rotate({own.x * m.x, own.y * m.y, own.z * m.z});
  }
  Vector TotalAngularMomentum() const {
    Vector sum = this->AngularMomentum();
    for (uint32_t i = 0; i < this->mass.size(); ++i) sum += OwnMomentum(i);
    return sum;
  }
  double TotalKineticEnergy() const {
    double sum = this->KineticEnergy();
    for (uint32_t i = 0; i < this->mass.size(); ++i) sum += Dot(OwnMomentum(i), Spin(i)) / 2;
    return sum;
  }
  /// Returns the energy in the field of gravity.
  double HeightEnergy() const {
    double sum = 0;
    for (uint32_t i = 0; i < this->mass.size(); ++i) {
      sum -= this->mass[i] * Dot(this->Wide(this->At(this->gravity, 0)), Position(i));
    }
    return sum;
  }

 private:
  template <size_t n>
  static void Append(std::vector<Real>& column, const std::array<Real, n>& row) {
    column.insert(column.end(), row.begin(), row.end());
  }
};

}  // namespace vesper
