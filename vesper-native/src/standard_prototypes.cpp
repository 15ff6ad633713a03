// SPDX-License-Identifier: Apache-2.0
// The standard prototypes of the engine: the same properties in two precisions.
#include <cstring>
#include <iterator>

#include "vesper/engine.h"

namespace vesper {
namespace {

constexpr vesper_unit kNewtonMetreSecond = VESPER_UNIT_INIT(2, 1, -1, 0, 0, 0, 0, 1.0, "N*m*s");
constexpr vesper_access kAccumulator = VESPER_READ | VESPER_ACCUMULATE;

constexpr vesper_property_descriptor Describe(vesper_scalar_type type, uint32_t components,
                                              const char* kind, const char* name, vesper_unit unit,
                                              vesper_access access, const char* doc,
                                              const char* initial_from = nullptr) {
  return {sizeof(vesper_property_descriptor),
          type,
          name,
          kind,
          components,
          access,
          unit,
          nullptr,
          initial_from,
          doc,
          0,
          0,
          0};
}

/// Returns the descriptor of a property whose minimum is 0. By default, laws only read it.
constexpr vesper_property_descriptor NotNegative(vesper_scalar_type type, uint32_t components,
                                                 const char* kind, const char* name,
                                                 vesper_unit unit, const char* doc,
                                                 vesper_access access = VESPER_READ) {
  vesper_property_descriptor property = Describe(type, components, kind, name, unit, access, doc);
  property.has_minimum = 1;
  return property;
}

constexpr vesper_property_descriptor Refer(uint32_t components, const char* kind, const char* name,
                                           const char* refers_to, const char* doc) {
  return {sizeof(vesper_property_descriptor),
          VESPER_U32,
          name,
          kind,
          components,
          VESPER_READ,
          VESPER_UNIT_ONE,
          refers_to,
          nullptr,
          doc,
          0,
          0,
          0};
}

template <vesper_scalar_type real>
constexpr vesper_property_descriptor kProperties[] = {
    NotNegative(real, 1, "body", "mass", VESPER_UNIT_KILOGRAM, "Mass; 0 means immovable."),
    Describe(real, 1, "body", "charge", VESPER_UNIT_COULOMB, VESPER_READ, "Electric charge."),
    Describe(real, 3, "body", "position", VESPER_UNIT_METRE, VESPER_READ_WRITE,
             "Centre of mass in the world frame."),
    Describe(real, 3, "body", "velocity", VESPER_UNIT_METRE_PER_SECOND, VESPER_READ_WRITE,
             "Velocity of the centre of mass."),
    Describe(real, 3, "body", "acceleration", VESPER_UNIT_METRE_PER_SECOND_SQUARED, VESPER_WRITE,
             "Acceleration of the last step."),
    Describe(real, 3, "body", "externalForce", VESPER_UNIT_NEWTON, kAccumulator,
             "Sum of all forces of the stage.", "appliedForce"),
    Describe(real, 3, "body", "appliedForce", VESPER_UNIT_NEWTON, VESPER_READ,
             "Force that the client applies, constant over a call of advance."),
    NotNegative(real, 1, "body", "radius", VESPER_UNIT_METRE,
                "Radius of the body taken as a ball."),
    Describe(real, 4, "body", "orientation", VESPER_UNIT_ONE, VESPER_READ_WRITE,
             "Unit quaternion xyzw, body frame to world frame."),
    Describe(real, 3, "body", "angularVelocity", VESPER_UNIT_RADIAN_PER_SECOND, VESPER_READ_WRITE,
             "Angular velocity in the world frame."),
    NotNegative(real, 3, "body", "inertia", VESPER_UNIT_KILOGRAM_METRE_SQUARED,
                "Principal moments of inertia in the body frame."),
    Describe(real, 3, "body", "torque", VESPER_UNIT_NEWTON_METRE, kAccumulator,
             "Sum of all torques of the stage about the centre of mass."),
    Describe(real, 1, "body", "dragCoefficient", VESPER_UNIT_KILOGRAM_PER_METRE, VESPER_READ,
             "Force of quadratic drag per squared speed."),
    Describe(real, 1, "body", "linearDragCoefficient", VESPER_UNIT_KILOGRAM_PER_SECOND, VESPER_READ,
             "Force of linear drag per speed."),
    Describe(VESPER_I32, 1, "body", "shape", VESPER_UNIT_ONE, VESPER_READ,
             "Code of the shape: 0 none, 1 sphere, 2 box, 3 plane, 4 mesh, 5 capsule, 6 cylinder, "
             "7 ellipsoid."),
    NotNegative(VESPER_F64, 3, "body", "size", VESPER_UNIT_METRE,
                "Extent of the shape along the own axes of the body.", VESPER_READ_WRITE),
    Describe(VESPER_I32, 1, "body", "carrier", VESPER_UNIT_ONE, VESPER_READ,
             "Row of the body that carries this one along; -1 for none."),

    Describe(real, 3, "scenery", "sceneryPosition", VESPER_UNIT_METRE, VESPER_READ,
             "Place of an item without physics."),
    Describe(real, 4, "scenery", "sceneryOrientation", VESPER_UNIT_ONE, VESPER_READ,
             "Unit quaternion xyzw of an item without physics."),
    Describe(VESPER_I32, 1, "scenery", "sceneryShape", VESPER_UNIT_ONE, VESPER_READ,
             "Code of its shape, like shape."),
    Describe(VESPER_F64, 3, "scenery", "scenerySize", VESPER_UNIT_METRE, VESPER_READ,
             "Extent of its shape, like size."),
    Describe(VESPER_I32, 1, "scenery", "sceneryCarrier", VESPER_UNIT_ONE, VESPER_READ,
             "Row of the body that carries it along; -1 for none."),

    Refer(2, "spring", "endpoints", "body", "Rows of the two bodies it joins."),
    NotNegative(real, 1, "spring", "length", VESPER_UNIT_METRE, "Rest length."),
    Describe(real, 1, "spring", "hookeConstant", VESPER_UNIT_NEWTON_PER_METRE, VESPER_READ,
             "Force per elongation."),
    Describe(real, 1, "spring", "dampingConstant", VESPER_UNIT_NEWTON_SECOND_PER_METRE, VESPER_READ,
             "Force per speed of elongation."),

    Refer(3, "surface", "vertices", "body", "Rows of the three bodies that span the triangle."),
    NotNegative(real, 1, "surface", "hardness", VESPER_UNIT_NEWTON_PER_METRE,
                "Contact force per depth of penetration."),
    NotNegative(real, 1, "surface", "surfaceDamping", VESPER_UNIT_NEWTON_SECOND_PER_METRE,
                "Contact force per speed of penetration."),
    NotNegative(real, 1, "surface", "frictionCoefficient", VESPER_UNIT_ONE,
                "Friction force per normal force."),

    Refer(2, "joint", "joined", "body", "Rows of the two bodies it joins."),
    Describe(VESPER_I32, 1, "joint", "jointType", VESPER_UNIT_ONE, VESPER_READ,
             "1 fixed, 2 ball, 3 hinge, 4 slider, 5 distance, 6 rope."),
    Describe(real, 3, "joint", "anchor", VESPER_UNIT_METRE, VESPER_READ,
             "Place of the joint in the frame of the first body."),
    Describe(real, 3, "joint", "axis", VESPER_UNIT_ONE, VESPER_READ,
             "Axis of a hinge or slider in the frame of the first body."),
    Describe(real, 2, "joint", "angleLimits", VESPER_UNIT_ONE, VESPER_READ,
             "Least and greatest angle of a hinge; none if they are equal."),
    Describe(real, 2, "joint", "travelLimits", VESPER_UNIT_METRE, VESPER_READ,
             "Least and greatest travel of a slider, none if equal; or length of a distance."),
    Describe(real, 1, "joint", "motorSpeed", VESPER_UNIT_RADIAN_PER_SECOND, VESPER_READ,
             "Speed of the motor of a hinge."),
    NotNegative(real, 1, "joint", "motorTorque", VESPER_UNIT_NEWTON_METRE,
                "Greatest torque of the motor of a hinge."),
    Describe(real, 1, "joint", "driveSpeed", VESPER_UNIT_METRE_PER_SECOND, VESPER_READ,
             "Speed of the drive of a slider."),
    NotNegative(real, 1, "joint", "driveForce", VESPER_UNIT_NEWTON,
                "Greatest force of the drive of a slider."),
    NotNegative(real, 1, "joint", "breakingForce", VESPER_UNIT_NEWTON,
                "Force above which the joint breaks; 0: it does not."),
    Describe(real, 3, "joint", "otherAnchor", VESPER_UNIT_METRE, VESPER_READ_WRITE,
             "Place of the joint in the frame of the second body."),
    Describe(real, 4, "joint", "otherTurn", VESPER_UNIT_ONE, VESPER_READ_WRITE,
             "Rotation of the second body in the frame of the first one at rest; 0: as it is."),
    Describe(real, 3, "joint", "jointForce", VESPER_UNIT_NEWTON, VESPER_READ_WRITE,
             "Force on the second body in the last step."),
    Describe(real, 3, "joint", "jointTorque", VESPER_UNIT_NEWTON_METRE, VESPER_READ_WRITE,
             "Torque on the second body in the last step."),
    Describe(real, 1, "joint", "jointAngle", VESPER_UNIT_ONE, VESPER_READ_WRITE,
             "Angle of a hinge."),
    Describe(real, 1, "joint", "jointTravel", VESPER_UNIT_METRE, VESPER_READ_WRITE,
             "Travel of a slider, or length of a distance."),
    Describe(VESPER_I32, 1, "joint", "broken", VESPER_UNIT_ONE, VESPER_READ_WRITE,
             "1 if the joint is broken."),

    Describe(real, 1, "world", "gravitationalConstant", VESPER_UNIT_GRAVITATIONAL_CONSTANT,
             VESPER_READ, "Constant of Newton's law of gravitation."),
    Describe(real, 3, "world", "gravity", VESPER_UNIT_METRE_PER_SECOND_SQUARED, VESPER_READ,
             "Uniform gravitational field."),
    NotNegative(real, 1, "world", "softening", VESPER_UNIT_METRE,
                "Length below which gravitation is softened."),
    Describe(real, 1, "world", "coulombConstant", VESPER_UNIT_COULOMB_CONSTANT, VESPER_READ,
             "Constant of Coulomb's law."),
    Describe(real, 3, "world", "electricField", VESPER_UNIT_VOLT_PER_METRE, VESPER_READ,
             "Uniform electric field."),
    Describe(real, 3, "world", "magneticField", VESPER_UNIT_TESLA, VESPER_READ,
             "Uniform magnetic flux density."),
    Describe(VESPER_FIELD, 3, "world", "forceField", VESPER_UNIT_NEWTON, VESPER_READ,
             "Force on any body at a place."),

    NotNegative(real, 1, "body", "rollingFriction", VESPER_UNIT_METRE,
                "Torque against rolling per normal force."),
    Describe(VESPER_I32, 1, "body", "touchLayer", VESPER_UNIT_ONE, VESPER_READ,
             "Layer of contacts, from 0 to 31."),
    Describe(VESPER_I32, 1, "body", "passesLayers", VESPER_UNIT_ONE, VESPER_READ,
             "Layers whose bodies this one passes through, as bits."),
    Describe(VESPER_I32, 1, "body", "touchSensor", VESPER_UNIT_ONE, VESPER_READ,
             "1: counts what touches it, and exerts no force."),
    Describe(VESPER_I32, 1, "body", "partOfBody", VESPER_UNIT_ONE, VESPER_READ,
             "1: collides as a part of the body that carries it."),
    Describe(VESPER_I32, 1, "body", "touchCount", VESPER_UNIT_ONE, VESPER_READ_WRITE,
             "Number of shapes that touch this one."),
    Describe(VESPER_I32, 1, "body", "meshForm", VESPER_UNIT_ONE, VESPER_READ,
             "Row of its mesh in the kind meshForm; -1 for none."),
    Describe(VESPER_I32, 1, "scenery", "sceneryMeshForm", VESPER_UNIT_ONE, VESPER_READ,
             "Row of its mesh, like meshForm."),
    Describe(VESPER_I32, 10, "meshForm", "meshRanges", VESPER_UNIT_ONE, VESPER_READ,
             "First row and number of rows of: corners of the convex hull, corners of its core, "
             "faces of the hull, vertices, triangles."),
    Describe(VESPER_F64, 3, "meshPoint", "meshPoints", VESPER_UNIT_METRE, VESPER_READ,
             "Corners and vertices in the axes of the item."),
    Describe(VESPER_I32, 1, "meshNumber", "meshIndices", VESPER_UNIT_ONE, VESPER_READ,
             "Faces: number of corners, then the corners; triangles: three vertices each."),

    NotNegative(real, 1, "joint", "angleDamping", kNewtonMetreSecond,
                "Torque of a hinge or ball against its rotation, per angular speed."),
    NotNegative(real, 1, "joint", "travelDamping", VESPER_UNIT_NEWTON_SECOND_PER_METRE,
                "Force of a slider against its motion, per speed."),
    NotNegative(real, 1, "joint", "angleFriction", VESPER_UNIT_NEWTON_METRE,
                "Torque of the dry friction of a hinge."),
    NotNegative(real, 1, "joint", "travelFriction", VESPER_UNIT_NEWTON,
                "Force of the dry friction of a slider."),
    NotNegative(real, 1, "joint", "angleStiffness", VESPER_UNIT_NEWTON_METRE,
                "Torque of a hinge towards restAngle, per angle."),
    NotNegative(real, 1, "joint", "travelStiffness", VESPER_UNIT_NEWTON_PER_METRE,
                "Force of a slider towards restTravel, per travel."),
    Describe(real, 1, "joint", "restAngle", VESPER_UNIT_ONE, VESPER_READ,
             "Angle at which the spring of a hinge exerts no torque."),
    Describe(real, 1, "joint", "restTravel", VESPER_UNIT_METRE, VESPER_READ,
             "Travel at which the spring of a slider exerts no force."),
    NotNegative(real, 1, "joint", "rotorInertia", VESPER_UNIT_KILOGRAM_METRE_SQUARED,
                "Moment of inertia that a hinge adds about its axis."),
    NotNegative(real, 1, "joint", "rotorMass", VESPER_UNIT_KILOGRAM,
                "Mass that a slider adds along its axis."),
    Describe(real, 1, "joint", "angleSpeed", VESPER_UNIT_RADIAN_PER_SECOND, VESPER_READ_WRITE,
             "Speed of the angle of a hinge."),
    Describe(real, 1, "joint", "travelSpeed", VESPER_UNIT_METRE_PER_SECOND, VESPER_READ_WRITE,
             "Speed of the travel of a slider, or of the length of a distance."),
    Describe(real, 1, "joint", "motorAngle", VESPER_UNIT_ONE, VESPER_READ,
             "Angle to which the motor of a hinge moves, with a stiffness."),
    NotNegative(real, 1, "joint", "motorStiffness", VESPER_UNIT_NEWTON_METRE,
                "Torque of the motor of a hinge per angle to motorAngle."),
    NotNegative(real, 1, "joint", "motorDamping", kNewtonMetreSecond,
                "Torque of the motor of a hinge per difference to motorSpeed."),
    Describe(real, 1, "joint", "driveTravel", VESPER_UNIT_METRE, VESPER_READ,
             "Travel to which the drive of a slider moves, with a stiffness."),
    NotNegative(real, 1, "joint", "driveStiffness", VESPER_UNIT_NEWTON_PER_METRE,
                "Force of the drive of a slider per travel to driveTravel."),
    NotNegative(real, 1, "joint", "driveDamping", VESPER_UNIT_NEWTON_SECOND_PER_METRE,
                "Force of the drive of a slider per difference to driveSpeed."),

    Describe(real, 3, "body", "specificForce", VESPER_UNIT_METRE_PER_SECOND_SQUARED, VESPER_READ,
             "Mean acceleration of the last frame minus gravity, in the axes of the body."),
    Describe(real, 3, "body", "angularRate", VESPER_UNIT_RADIAN_PER_SECOND, VESPER_READ,
             "Angular velocity in the axes of the body."),
    Describe(real, 3, "body", "contactForce", VESPER_UNIT_NEWTON, kAccumulator,
             "Sum of the forces of the stage that laws of phase FORCE exert at contacts."),
    Describe(real, 3, "body", "reactionForce", VESPER_UNIT_NEWTON, VESPER_READ_WRITE,
             "Mean force of the last step that a law of phase INTEGRATE exerts at contacts."),

    Describe(VESPER_I32, 1, "body", "substance", VESPER_UNIT_ONE, VESPER_READ,
             "Code of its substance; 0 for none."),
    Describe(VESPER_I32, 2, "substancePair", "substances", VESPER_UNIT_ONE, VESPER_READ,
             "Codes of the two substances of a pair; 0 for any substance."),
    NotNegative(real, 1, "substancePair", "pairFriction", VESPER_UNIT_ONE,
                "Friction of the pair; 0: not set."),
    NotNegative(real, 1, "substancePair", "pairRestitution", VESPER_UNIT_ONE,
                "Restitution of the pair; 0: not set."),

    NotNegative(real, 1, "joint", "ropeLength", VESPER_UNIT_METRE,
                "Greatest distance of the anchors of a rope."),
    Refer(2, "gear", "geared", "joint", "Rows of the two joints it couples."),
    Describe(real, 1, "gear", "gearRatio", VESPER_UNIT_ONE, VESPER_READ,
             "Angle or travel of the first joint per that of the second one."),
    Describe(real, 1, "gear", "offsetAngle", VESPER_UNIT_ONE, VESPER_READ,
             "Angle of the first joint, a hinge, where the second one is at 0."),
    Describe(real, 1, "gear", "offsetTravel", VESPER_UNIT_METRE, VESPER_READ,
             "Travel of the first joint, a slider, where the second one is at 0."),
    Describe(real, 1, "gear", "gearTorque", VESPER_UNIT_NEWTON_METRE, VESPER_READ_WRITE,
             "Torque on the first joint, a hinge, in the last step."),
    Describe(real, 1, "gear", "gearForce", VESPER_UNIT_NEWTON, VESPER_READ_WRITE,
             "Force on the first joint, a slider, in the last step."),
    Describe(real, 2, "gear", "gearPlaces", VESPER_UNIT_ONE, VESPER_READ_WRITE,
             "Angles or travels of the two joints, with whole turns."),

    Describe(VESPER_I32, 1, "body", "asleep", VESPER_UNIT_ONE, VESPER_READ_WRITE,
             "1 while it rests and a law of phase INTEGRATE does not move it."),

    NotNegative(real, 1, "body", "spinFriction", VESPER_UNIT_METRE,
                "Torque against spin about the normal of a contact, per normal force."),
    NotNegative(real, 1, "substancePair", "pairRollingFriction", VESPER_UNIT_METRE,
                "Torque against rolling per normal force; 0: not set."),
    NotNegative(real, 1, "substancePair", "pairSpinFriction", VESPER_UNIT_METRE,
                "Torque against spin per normal force; 0: not set."),

    Describe(real, 3, "joint", "offsetLeast", VESPER_UNIT_METRE, VESPER_READ,
             "Least offsets of a six-axis joint, in the axes of the first body."),
    Describe(real, 3, "joint", "offsetGreatest", VESPER_UNIT_METRE, VESPER_READ,
             "Greatest offsets of a six-axis joint; below the least: no limit."),
    Describe(real, 3, "joint", "turnLeast", VESPER_UNIT_ONE, VESPER_READ,
             "Least angles of a six-axis joint about the axes of the first body."),
    Describe(real, 3, "joint", "turnGreatest", VESPER_UNIT_ONE, VESPER_READ,
             "Greatest angles of a six-axis joint; below the least: no limit."),
};

template <vesper_scalar_type real>
constexpr vesper_prototype Standard(const char* name) {
  return {sizeof(vesper_prototype),
          real,
          name,
          VESPER_UNIT_SECOND,
          static_cast<uint32_t>(std::size(kProperties<real>)),
          0,
          kProperties<real>};
}

constexpr vesper_prototype kStandardPrototypes[] = {
    Standard<VESPER_F64>("si-f64"),
    Standard<VESPER_F32>("si-f32"),
};

}  // namespace
}  // namespace vesper

const vesper_prototype* vesper_prototype_standard(const char* name) noexcept {
  if (name == nullptr) return nullptr;
  for (const vesper_prototype& prototype : vesper::kStandardPrototypes) {
    if (std::strcmp(prototype.name, name) == 0) return &prototype;
  }
  return nullptr;
}
