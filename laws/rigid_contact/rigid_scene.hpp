// SPDX-License-Identifier: Apache-2.0
// Rigid bodies and scenery for the tests of rigid_contact, in the columns of a standard prototype.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "hull_by_search.hpp"
#include "joint.hpp"
#include "rigid/rotation.hpp"
#include "scene.hpp"
#include "shape.hpp"

namespace vesper {

template <class Real>
struct RigidScene : Scene<Real> {
  using Code = rigid::ShapeCode;
  using Vector = Vec3<double>;

  std::vector<int32_t> shape;                            // (bodies)
  std::vector<double> size;                              // (bodies x 3) [m]
  std::vector<Real> orientation, spin, torque, inertia;  // (bodies x 4), (bodies x 3)
  std::vector<Real> reaction;   // (bodies x 3) [N], empty unless a test measures it
  std::vector<int32_t> asleep;  // (bodies), empty unless a test reads it
  std::string law = "rigid_contact";
  std::vector<int32_t> mesh_form, carrier, part, layer, passes, sensor, touch_count;  // (bodies)
  std::vector<Real> rolling, spinning;                                                // (bodies)
  bool has_parts = false, has_layers = false, has_rolling = false, has_spinning = false;
  // substances; each column is empty unless a test uses it
  std::vector<int32_t> substance, substances;         // (bodies), (rows x 2)
  std::vector<Real> pair_friction, pair_restitution;  // (rows)
  std::vector<Real> pair_rolling, pair_spinning;      // (rows)
  // meshes
  std::vector<int32_t> mesh_ranges;        // (meshes x 10)
  std::vector<double> mesh_points;         // (points x 3) [m]
  std::vector<int32_t> mesh_indices;       // (indices)
  std::vector<int32_t> scenery_mesh_form;  // (scenery)
  // joint
  std::vector<uint32_t> joined;                                // (joints x 2)
  std::vector<int32_t> joint_type, broken;                     // (joints)
  std::vector<Real> anchor, axis;                              // (joints x 3)
  std::vector<Real> angle_limits, travel_limits;               // (joints x 2)
  std::vector<Real> motor_speed, motor_torque;                 // (joints)
  std::vector<Real> drive_speed, drive_force, breaking_force;  // (joints)
  std::vector<Real> other_anchor, other_turn, joint_force, joint_torque;
  std::vector<Real> joint_angle, joint_travel;           // (joints)
  std::map<std::string, std::vector<Real>> joint_loads;  // (joints) by property
  // gear
  std::vector<uint32_t> geared;                               // (gears x 2)
  std::vector<Real> gear_ratio, offset_angle, offset_travel;  // (gears)
  std::vector<Real> gear_torque, gear_force;                  // (gears) [N m], [N]
  std::vector<Real> gear_places;                              // (gears x 2)
  // scenery
  std::vector<int32_t> scenery_shape;  // (scenery)
  std::vector<double> scenery_size;    // (scenery x 3) [m]
  std::vector<Real> scenery_position, scenery_orientation;

  uint32_t Add(Code code, Vector extent, double mass, Vector at, Vector moving = {},
               rigid::Quaternion q = {}) {
    shape.push_back(static_cast<int32_t>(code));
    size.insert(size.end(), {extent.x, extent.y, extent.z});
    Append(orientation, q.Stored<Real>());
    for (auto* column : {&spin, &torque, &inertia}) column->insert(column->end(), {0, 0, 0});
    for (auto* column : {&mesh_form, &carrier}) column->push_back(-1);
    for (auto* column : {&part, &layer, &passes, &sensor, &touch_count}) column->push_back(0);
    for (auto* column : {&rolling, &spinning}) column->push_back(0);
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
    scenery_mesh_form.push_back(-1);
  }
  /// Adds a mesh and its hull; returns the row of the mesh.
  int32_t AddForm(const std::vector<Vector>& vertices, const std::vector<int32_t>& triangles,
                  const HullBySearch* hull) {
    const auto range = [&](auto&& rows, size_t now) {
      mesh_ranges.insert(mesh_ranges.end(), {int32_t(now), int32_t(rows.size())});
    };
    const auto add_points = [&](const std::vector<Vector>& points) {
      range(points, mesh_points.size() / 3);
      for (const Vector& p : points) mesh_points.insert(mesh_points.end(), {p.x, p.y, p.z});
    };
    std::vector<int32_t> faces;
    for (size_t i = 0; hull != nullptr && i < hull->faces.size(); ++i) {
      faces.push_back(int32_t(hull->faces[i].size()));
      faces.insert(faces.end(), hull->faces[i].begin(), hull->faces[i].end());
    }
    const auto add_indices = [&](const std::vector<int32_t>& indices) {
      range(indices, mesh_indices.size());
      mesh_indices.insert(mesh_indices.end(), indices.begin(), indices.end());
    };
    add_points(hull == nullptr ? std::vector<Vector>{} : hull->corners);
    add_points(hull == nullptr ? std::vector<Vector>{} : hull->core);
    add_indices(faces);
    add_points(vertices);
    add_indices(triangles);
    return int32_t(mesh_ranges.size() / 10) - 1;
  }
  /// Adds a body that is the hull of these points.
  uint32_t AddHull(const std::vector<Vector>& points, double mass, Vector at, Vector moving = {},
                   rigid::Quaternion q = {}) {
    const HullBySearch hull(points);
    const int32_t form = AddForm(points, hull.Triangles(), &hull);
    const uint32_t body = Add(Code::kMesh, {1, 1, 1}, mass, at, moving, q);
    mesh_form[body] = form;
    return body;
  }
  /// Adds an immovable surface of triangles.
  void AddSurface(const std::vector<Vector>& vertices, const std::vector<int32_t>& triangles,
                  Vector at = {}, rigid::Quaternion q = {}) {
    AddScenery(Code::kMesh, {1, 1, 1}, at, q);
    scenery_mesh_form.back() = AddForm(vertices, triangles, nullptr);
  }
  /// Adds a square floor of cells x cells squares, each of two triangles. height(x, z) returns the
  /// height of the floor.
  template <class Height>
  void AddTerrain(int cells, double side, Height&& height) {
    std::vector<Vector> vertices;
    std::vector<int32_t> triangles;
    for (int j = 0; j <= cells; ++j) {
      for (int i = 0; i <= cells; ++i) {
        const double x = side * (double(i) / cells - 0.5), z = side * (double(j) / cells - 0.5);
        vertices.push_back({x, height(x, z), z});
        if (i == cells || j == cells) continue;
        const int32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
        triangles.insert(triangles.end(), {a, c, b, b, c, d});
      }
    }
    AddSurface(vertices, triangles);
  }
  /// Makes the body `row` a part of the body `to`. A part has mass 0.
  void Attach(uint32_t row, uint32_t to) {
    carrier[row] = int32_t(to);
    part[row] = 1;
    has_parts = true;
  }
  /// Adds the values of a substance, with b = 0, or of a pair of substances.
  void AddSubstances(int32_t a, int32_t b, double friction, double restitution) {
    substances.insert(substances.end(), {a, b});
    pair_friction.push_back(Real(friction));
    pair_restitution.push_back(Real(restitution));
  }
  /// Adds a box whose top is at y = 0.
  void AddGround() { AddScenery(Code::kBox, {1000, 2, 1000}, {0, -1, 0}); }

  /// Joins two bodies at `at`, a point of the world, about the axis `about` of the world.
  uint32_t Join(rigid::JointType type, uint32_t a, uint32_t b, Vector at,
                Vector about = {0, 1, 0}) {
    joined.insert(joined.end(), {a, b});
    joint_type.push_back(static_cast<int32_t>(type));
    broken.push_back(0);
    const rigid::Quaternion inverse = Rotation(a).Normalised().Inverse();
    const Vector in_a = inverse.Rotate(at - Position(a)), axis_in_a = inverse.Rotate(about);
    anchor.insert(anchor.end(), {Real(in_a.x), Real(in_a.y), Real(in_a.z)});
    axis.insert(axis.end(), {Real(axis_in_a.x), Real(axis_in_a.y), Real(axis_in_a.z)});
    for (auto* pair : {&angle_limits, &travel_limits}) pair->insert(pair->end(), {0, 0});
    for (auto* one : {&motor_speed, &motor_torque, &drive_speed, &drive_force, &breaking_force,
                      &joint_angle, &joint_travel}) {
      one->push_back(0);
    }
    for (auto* three : {&other_anchor, &joint_force, &joint_torque}) {
      three->insert(three->end(), {0, 0, 0});
    }
    other_turn.insert(other_turn.end(), {0, 0, 0, 0});
    return static_cast<uint32_t>(joint_type.size() - 1);
  }

  /// Connects two joints: place of the first = ratio * place of the second.
  uint32_t AddGear(uint32_t first, uint32_t second, double ratio) {
    geared.insert(geared.end(), {first, second});
    gear_ratio.push_back(Real(ratio));
    for (auto* one : {&offset_angle, &offset_travel, &gear_torque, &gear_force}) one->push_back(0);
    gear_places.insert(gear_places.end(), {0, 0});
    return static_cast<uint32_t>(gear_ratio.size() - 1);
  }

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
    if (!mesh_ranges.empty()) {
      provider.AddPhysicalProperty("meshForm", mesh_form);
      provider.AddPhysicalProperty("meshRanges", mesh_ranges);
      provider.AddPhysicalProperty("meshPoints", mesh_points);
      provider.AddPhysicalProperty("meshIndices", mesh_indices);
      if (!scenery_shape.empty()) {
        provider.AddPhysicalProperty("sceneryMeshForm", scenery_mesh_form);
      }
    }
    if (has_parts) {
      provider.AddPhysicalProperty("carrier", carrier);
      provider.AddPhysicalProperty("partOfBody", part);
    }
    if (has_layers) {
      provider.AddPhysicalProperty("touchLayer", layer);
      provider.AddPhysicalProperty("passesLayers", passes);
      provider.AddPhysicalProperty("touchSensor", sensor);
      provider.AddPhysicalProperty("touchCount", touch_count);
    }
    if (!substance.empty()) provider.AddPhysicalProperty("substance", substance);
    if (!substances.empty()) {
      provider.AddPhysicalProperty("substances", substances);
      provider.AddPhysicalProperty("pairFriction", pair_friction);
      provider.AddPhysicalProperty("pairRestitution", pair_restitution);
    }
    if (!pair_rolling.empty()) provider.AddPhysicalProperty("pairRollingFriction", pair_rolling);
    if (!pair_spinning.empty()) provider.AddPhysicalProperty("pairSpinFriction", pair_spinning);
    if (has_rolling) provider.AddPhysicalProperty("rollingFriction", rolling);
    if (has_spinning) provider.AddPhysicalProperty("spinFriction", spinning);
    if (!scenery_shape.empty()) {
      provider.AddPhysicalProperty("sceneryShape", scenery_shape);
      provider.AddPhysicalProperty("scenerySize", scenery_size);
      provider.AddPhysicalProperty("sceneryPosition", scenery_position);
      provider.AddPhysicalProperty("sceneryOrientation", scenery_orientation);
    }
    if (!joint_type.empty()) {
      provider.AddPhysicalProperty("joined", joined);
      provider.AddPhysicalProperty("jointType", joint_type);
      provider.AddPhysicalProperty("broken", broken);
      provider.AddPhysicalProperty("anchor", anchor);
      provider.AddPhysicalProperty("axis", axis);
      provider.AddPhysicalProperty("angleLimits", angle_limits);
      provider.AddPhysicalProperty("travelLimits", travel_limits);
      provider.AddPhysicalProperty("motorSpeed", motor_speed);
      provider.AddPhysicalProperty("motorTorque", motor_torque);
      provider.AddPhysicalProperty("driveSpeed", drive_speed);
      provider.AddPhysicalProperty("driveForce", drive_force);
      provider.AddPhysicalProperty("breakingForce", breaking_force);
      provider.AddPhysicalProperty("otherAnchor", other_anchor);
      provider.AddPhysicalProperty("otherTurn", other_turn);
      provider.AddPhysicalProperty("jointForce", joint_force);
      provider.AddPhysicalProperty("jointTorque", joint_torque);
      provider.AddPhysicalProperty("jointAngle", joint_angle);
      provider.AddPhysicalProperty("jointTravel", joint_travel);
      for (auto& [name, column] : joint_loads) provider.AddPhysicalProperty(name, column);
    }
    if (!geared.empty()) {
      provider.AddPhysicalProperty("geared", geared);
      provider.AddPhysicalProperty("gearRatio", gear_ratio);
      provider.AddPhysicalProperty("offsetAngle", offset_angle);
      provider.AddPhysicalProperty("offsetTravel", offset_travel);
      provider.AddPhysicalProperty("gearTorque", gear_torque);
      provider.AddPhysicalProperty("gearForce", gear_force);
      provider.AddPhysicalProperty("gearPlaces", gear_places);
    }
    if (!asleep.empty()) provider.AddPhysicalProperty("asleep", asleep);
    if (!reaction.empty()) provider.AddPhysicalProperty("reactionForce", reaction);
    engine.LoadPhysicsLaw("gravity_field");
    engine.LoadPhysicsLaw(law, parameters);
    return engine;
  }

  Vector Position(uint32_t i) const { return this->Wide(this->At(this->position, i)); }
  Vector Velocity(uint32_t i) const { return this->Wide(this->At(this->velocity, i)); }
  Vector Spin(uint32_t i) const { return this->Wide(this->At(spin, i)); }
  rigid::Quaternion Rotation(uint32_t i) const {
    return {{orientation[4 * i], orientation[4 * i + 1], orientation[4 * i + 2]},
            orientation[4 * i + 3]};
  }
  /// Returns the principal moments of inertia of a body: the given moments, or those of its shape.
  Vector Moments(uint32_t i) const {
    const Vector given = this->Wide(this->At(inertia, i));
    if (!(given == Vector{})) return given;
    return rigid::Shape::Of(shape[i], {size[3 * i], size[3 * i + 1], size[3 * i + 2]}, {}, {})
        .Moments(this->mass[i]);
  }
  /// Returns the angular momentum of a body about its centre of mass.
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
  /// Returns the potential energy in the field of gravity [J].
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
