// SPDX-License-Identifier: Apache-2.0
#include "galaxy.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "generators.hpp"
#include "vesper/law.hpp"

namespace vesper::cli {
namespace {

using Vector = Vec3<double>;

// Shape of a galaxy, in units of its total mass and of the scale length of its disc.
constexpr double kDiscMass = 0.2;
constexpr double kDiscEdge = 5;
constexpr double kDiscHeight = 0.1;
constexpr double kDiscDispersion = 0.1;  // random velocity, as a fraction of the circular speed
constexpr double kHaloRadius = 1.5;      // scale radius of the Plummer sphere
constexpr double kHaloEdge = 0.99;       // fraction of the sphere's mass inside the radius at which
                                         // it is cut off

struct Body {
  Vector position, velocity;
};

class Random {
 public:
  explicit Random(uint64_t seed) : random_(seed) {}

  /// Returns a number in (0, 1).
  double Uniform() { return std::ldexp(static_cast<double>(random_() >> 11) + 0.5, -53); }
  /// Returns a normal deviate of mean 0 and deviation 1, by the method of G. Box and M. Muller.
  double Normal() {
    const double r = std::sqrt(-2 * std::log(Uniform()));
    return r * std::cos(2 * M_PI * Uniform());
  }
  Vector Normals() {
    const double x = Normal(), y = Normal();
    return {x, y, Normal()};
  }
  Vector Direction() {
    const double z = 2 * Uniform() - 1, angle = 2 * M_PI * Uniform();
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }

 private:
  std::mt19937_64 random_;
};

/// Returns the fraction of the mass of an exponential disc within radius r.
double DiscWithin(double r) { return 1 - (1 + r) * std::exp(-r); }

/// Returns the circular speed in the field of a Plummer sphere and of the disc, which is treated as
/// spherical.
double CircularSpeed(double r) {
  const double halo = (1 - kDiscMass) * r * r * std::pow(r * r + kHaloRadius * kHaloRadius, -1.5);
  return std::sqrt(halo + kDiscMass * DiscWithin(r) / r);
}

/// Returns a body of the disc in the plane z = 0, on a nearly circular orbit.
Body MakeDiscBody(Random& random) {
  const double share = random.Uniform() * DiscWithin(kDiscEdge);
  double low = 0, high = kDiscEdge;
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = (low + high) / 2;
    (DiscWithin(middle) < share ? low : high) = middle;
  }
  const double r = high, angle = 2 * M_PI * random.Uniform(), speed = CircularSpeed(r);
  return {{r * std::cos(angle), r * std::sin(angle), kDiscHeight * random.Normal()},
          Vector{-std::sin(angle), std::cos(angle), 0} * speed +
              random.Normals() * (kDiscDispersion * speed)};
}

/// Returns a body of a Plummer sphere, by S. Aarseth, M. Henon and R. Wielen, Astron. Astrophys. 37
/// (1974) 183. The mass of the sphere includes the mass of the disc.
Body MakeHaloBody(Random& random) {
  const double x = 1 / std::sqrt(std::pow(kHaloEdge * random.Uniform(), -2.0 / 3) - 1);
  double q = 0, height = 1;
  while (height > q * q * std::pow(1 - q * q, 3.5)) {
    q = random.Uniform();
    height = 0.1 * random.Uniform();
  }
  const double speed = q * std::sqrt(2 / kHaloRadius) * std::pow(1 + x * x, -0.25);
  const Vector position = random.Direction() * (kHaloRadius * x);
  return {position, random.Direction() * speed};
}

/// Applies the shortest rotation that takes the z axis to the unit vector `axis`.
Vector Turned(const Vector& v, const Vector& axis) {
  const Vector cross{-axis.y, axis.x, 0};  // cross product of the z axis and `axis`
  if (axis.z < -1 + 1e-12) return {v.x, -v.y, -v.z};
  return v * axis.z + Cross(cross, v) + cross * (Dot(cross, v) / (1 + axis.z));
}

struct Galaxy {
  double mass, radius;
  Vector at, moving, axis;
  uint64_t seed;
};

Vector ReadVector(SceneReader& reader, const char* name) {
  reader.Expect(name);
  const Value value = reader.ReadValue(std::string("'") + name + "'");
  if (value.size() != 3) reader.FailLast(std::string("expected '") + name + " (x y z)'");
  return {value[0], value[1], value[2]};
}

double ReadPositive(SceneReader& reader, const char* name) {
  reader.Expect(name);
  const double value = reader.Number(std::string("'") + name + "'");
  if (!(value > 0)) reader.FailLast(std::string("expected a ") + name + " above 0");
  return value;
}

Galaxy ReadOptions(SceneReader& reader) {
  Galaxy galaxy{};
  galaxy.mass = ReadPositive(reader, "mass");
  galaxy.radius = ReadPositive(reader, "radius");
  galaxy.at = ReadVector(reader, "at");
  galaxy.moving = ReadVector(reader, "moving");
  galaxy.axis = ReadVector(reader, "axis");
  const double length = Length(galaxy.axis);
  if (!(length > 0)) reader.FailLast("expected an axis longer than 0");
  galaxy.axis = galaxy.axis * (1 / length);
  reader.Expect("seed");
  galaxy.seed = reader.Count("the seed", 0);
  return galaxy;
}

AnyColumn& Given(SceneReader& reader, Scene& scene, const char* property) {
  const auto found = scene.columns.find(property);
  if (found == scene.columns.end()) {
    reader.FailLast(std::string("needs '") + property + "', given before");
  }
  return found->second;
}

/// Shifts positions and velocities of the bodies so that their centre of mass and total momentum
/// are 0.
void Centre(std::vector<Body>& bodies, uint64_t disc, double disc_mass, double halo_mass) {
  Body mean{};
  for (uint64_t i = 0; i < bodies.size(); ++i) {
    const double mass = i < disc ? disc_mass : halo_mass;
    mean.position += bodies[i].position * mass;
    mean.velocity += bodies[i].velocity * mass;
  }
  for (Body& body : bodies) {
    body.position -= mean.position;
    body.velocity -= mean.velocity;
  }
}

}  // namespace

void ReadGalaxy(SceneReader& reader, Scene& scene) {
  AnyColumn &mass = Given(reader, scene, "mass"), &position = Given(reader, scene, "position"),
            &velocity = Given(reader, scene, "velocity");
  const double g = Given(reader, scene, "gravitationalConstant").Get(0);
  const std::vector<uint64_t> rows = reader.RowNumbers(mass.rows(), "body");
  if (rows.size() < 2) reader.FailLast("expected the numbers of at least 2 rows");
  reader.Expect(":");
  reader.RefuseUnit("a galaxy is made of several quantities, each in its property's unit");
  const Galaxy galaxy = ReadOptions(reader);
  const double speed = std::sqrt(g * galaxy.mass / galaxy.radius);

  const uint64_t disc = rows.size() / 2;
  const double disc_mass = kDiscMass / static_cast<double>(disc);
  const double halo_mass = (1 - kDiscMass) / static_cast<double>(rows.size() - disc);
  Random random(galaxy.seed);
  std::vector<Body> bodies;
  for (uint64_t i = 0; i < rows.size(); ++i) {
    bodies.push_back(i < disc ? MakeDiscBody(random) : MakeHaloBody(random));
  }
  Centre(bodies, disc, disc_mass, halo_mass);
  for (uint64_t i = 0; i < rows.size(); ++i) {
    const Vector x = Turned(bodies[i].position, galaxy.axis) * galaxy.radius + galaxy.at;
    const Vector v = Turned(bodies[i].velocity, galaxy.axis) * speed + galaxy.moving;
    SetRow(reader, mass, rows[i], {galaxy.mass * (i < disc ? disc_mass : halo_mass)});
    SetRow(reader, position, rows[i], {x.x, x.y, x.z});
    SetRow(reader, velocity, rows[i], {v.x, v.y, v.z});
  }
}

}  // namespace vesper::cli
