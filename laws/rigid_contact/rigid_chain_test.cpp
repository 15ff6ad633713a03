// SPDX-License-Identifier: Apache-2.0
// A chain of ten links with the masses 1 kg and 10 kg in turn, beside its equations of motion.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "rigid_scene.hpp"

namespace vesper {
namespace {

using rigid::JointType;
using rigid::Quaternion;
using Vector = Vec3<double>;

constexpr double kG = 9.81;
constexpr int kLinks = 10;

/// A planar pendulum of thin rods of 1 m in minimal coordinates: the angles of the rods from the x
/// axis. Its equations follow from Lagrange's function. With the Runge-Kutta method of fourth
/// order, the joints have no error.
class MultiPendulum {
 public:
  using Angles = std::array<double, kLinks>;

  Angles angles{}, rates{};

  explicit MultiPendulum(const Angles& masses) : masses_(masses) {
    double below = 0;  // mass of the links after link i
    for (int i = kLinks - 1; i >= 0; --i) {
      weight_[i] = masses_[i] / 2 + below;
      inertia_[i] = masses_[i] / 3 + below;
      below += masses_[i];
    }
  }

  /// Returns the second derivatives of the angles. The equation of link i is
  ///   sum over j of a_ij (cos(p_i - p_j) p_j'' + sin(p_i - p_j) p_j'^2) = -g w_i cos(p_i)
  /// with a_ij = w_max(i,j) for i != j, and a_ii = m_i / 3 + the mass below.
  Angles Accelerations(const Angles& at, const Angles& rate) const {
    double m[kLinks][kLinks + 1];
    for (int i = 0; i < kLinks; ++i) {
      m[i][kLinks] = -kG * weight_[i] * std::cos(at[i]);
      for (int j = 0; j < kLinks; ++j) {
        const double a = i == j ? inertia_[i] : weight_[std::max(i, j)];
        m[i][j] = a * std::cos(at[i] - at[j]);
        m[i][kLinks] -= a * std::sin(at[i] - at[j]) * rate[j] * rate[j];
      }
    }
    for (int i = 0; i < kLinks; ++i) {  // the matrix is positive definite: no pivots are needed
      for (int k = i + 1; k < kLinks; ++k) {
        const double factor = m[k][i] / m[i][i];
        for (int j = i; j <= kLinks; ++j) m[k][j] -= factor * m[i][j];
      }
    }
    Angles result;
    for (int i = kLinks - 1; i >= 0; --i) {
      result[i] = m[i][kLinks];
      for (int j = i + 1; j < kLinks; ++j) result[i] -= m[i][j] * result[j];
      result[i] /= m[i][i];
    }
    return result;
  }

  void Advance(double dt) {
    const auto plus = [](const Angles& x, const Angles& y, double f) {
      Angles sum = x;
      for (int i = 0; i < kLinks; ++i) sum[i] += f * y[i];
      return sum;
    };
    const Angles a1 = Accelerations(angles, rates);
    const Angles v2 = plus(rates, a1, dt / 2);
    const Angles a2 = Accelerations(plus(angles, rates, dt / 2), v2);
    const Angles v3 = plus(rates, a2, dt / 2);
    const Angles a3 = Accelerations(plus(angles, v2, dt / 2), v3);
    const Angles v4 = plus(rates, a3, dt);
    const Angles a4 = Accelerations(plus(angles, v3, dt), v4);
    for (int i = 0; i < kLinks; ++i) {
      angles[i] += dt / 6 * (rates[i] + 2 * v2[i] + 2 * v3[i] + v4[i]);
      rates[i] += dt / 6 * (a1[i] + 2 * a2[i] + 2 * a3[i] + a4[i]);
    }
  }

  /// Returns the place of the end of a link [m].
  Vector End(int link) const {
    Vector at;
    for (int i = 0; i <= link; ++i) at += Along(i);
    return at;
  }
  Vector Along(int link) const { return {std::cos(angles[link]), std::sin(angles[link]), 0}; }

  /// Returns the energy [J], 0 for a horizontal chain at rest.
  double Energy() const {
    double sum = 0;
    for (int i = 0; i < kLinks; ++i) {
      sum += kG * weight_[i] * std::sin(angles[i]);
      for (int j = 0; j < kLinks; ++j) {
        sum += 0.5 * (i == j ? inertia_[i] : weight_[std::max(i, j)]) *
               std::cos(angles[i] - angles[j]) * rates[i] * rates[j];
      }
    }
    return sum;
  }

 private:
  Angles masses_, weight_, inertia_;
};

MultiPendulum::Angles Masses() {
  MultiPendulum::Angles masses;
  for (int i = 0; i < kLinks; ++i) masses[i] = i % 2 == 0 ? 1 : 10;
  return masses;
}

/// Returns the chain of a pendulum, with hinges, in the pose and with the rates of the pendulum.
template <class Real>
RigidScene<Real> Chain(const MultiPendulum& pendulum, const MultiPendulum::Angles& rates) {
  RigidScene<Real> scene;
  scene.gravity = {0, Real(-kG), 0};
  scene.AddBox({0.1, 0.1, 0.1}, 0, {0, 0, 0});
  const auto masses = Masses();
  Vector from, speed;
  for (int i = 0; i < kLinks; ++i) {
    const Vector half = pendulum.Along(i) * 0.5;
    const Vector across = Cross(Vector{0, 0, rates[i]}, half);
    const double turn = pendulum.angles[i] / 2;
    const uint32_t link = scene.Add(rigid::ShapeCode::kNone, {}, masses[i], from + half,
                                    speed + across, {{0, 0, std::sin(turn)}, std::cos(turn)});
    scene.spin[3 * link + 2] = Real(rates[i]);
    for (int k = 0; k < 3; ++k) {
      scene.inertia[3 * link + k] = Real(masses[i] / (k == 0 ? 600 : 12));
    }
    scene.Join(JointType::kHinge, link - 1, link, from, {0, 0, 1});
    from += half * 2.0;
    speed += across * 2.0;
  }
  return scene;
}

/// Returns the place of the end of a link [m].
template <class Real>
Vector EndOf(const RigidScene<Real>& scene, uint32_t link) {
  return scene.Position(link + 1) + scene.Rotation(link + 1).Rotate({0.5, 0, 0});
}

/// Returns the greatest distance of the two ends that a joint of the chain joins [m].
template <class Real>
double Gap(const RigidScene<Real>& scene) {
  double gap = 0;
  Vector end;
  for (uint32_t link = 0; link < kLinks; ++link) {
    const Vector begin = scene.Position(link + 1) - scene.Rotation(link + 1).Rotate({0.5, 0, 0});
    gap = std::max(gap, Length(begin - end));
    end = EndOf(scene, link);
  }
  return gap;
}

// The reference program of this test keeps the energy. A single one of its links swings as a rod.
TEST(MultiPendulum, KeepsItsEnergyAndSwingsAsARod) {
  MultiPendulum pendulum(Masses());
  for (int i = 1; i <= 20000; ++i) {
    pendulum.Advance(1e-4);
    if (i % 2000 == 0) {
      EXPECT_NEAR(pendulum.Energy(), 0, 1e-6) << i * 1e-4;
    }
  }
  MultiPendulum::Angles rod{1, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  for (int i = 1; i < kLinks; ++i) rod[i] = 1e-12;
  MultiPendulum single(rod);
  single.angles[0] = -1.57079632679489662 + 1e-3;
  const double wave = std::sqrt(1.5 * kG);
  for (int i = 1; i <= 20000; ++i) single.Advance(1e-4);
  EXPECT_NEAR(single.angles[0] + 1.57079632679489662, 1e-3 * std::cos(2 * wave), 1e-8);
}

/// Returns the greatest distance [m] between the ends of the links of the law and of the equations
/// in three seconds from rest, in which the chain falls, swings through and whips.
double Deviation(uint32_t rate) {
  const double dt = 1.0 / rate;
  MultiPendulum pendulum(Masses());
  // The velocities of the law belong to the middle of a step. The chain therefore starts with the
  // velocities that its equations give for half a step before the start.
  MultiPendulum::Angles rates = pendulum.Accelerations(pendulum.angles, pendulum.rates);
  for (double& one : rates) one *= -dt / 2;
  auto scene = Chain<double>(pendulum, rates);
  PhysicsEngine engine = scene.MakeRigidEngine({{"substeps", 8}});
  double worst = 0;
  for (uint32_t i = 1; i <= 3 * rate; ++i) {
    engine.Advance(dt);
    pendulum.Advance(dt);
    for (uint32_t link = 0; link < kLinks; ++link) {
      worst = std::max(worst, Length(EndOf(scene, link) - pendulum.End(int(link))));
    }
  }
  // The chain has passed its lowest position, where its end is 10 m below the hook.
  EXPECT_LT(pendulum.End(kLinks - 1).x, -1);
  return worst;
}

TEST(RigidChain, FollowsItsEquationsWithinATenThousandthOfALink) {
  const double coarse = Deviation(1920), fine = Deviation(3840);
  EXPECT_LT(coarse, 1e-4);
  EXPECT_LT(fine, coarse / 3) << "the error is of second order in the length of a step";
}

// VESPER_CHAIN_SECONDS=60 tests a minute.
TEST(RigidChain, JointsStayTogetherWithinATenThousandthOfALink) {
  const char* given = std::getenv("VESPER_CHAIN_SECONDS");
  const int seconds = given == nullptr ? 5 : std::atoi(given);
  auto scene = Chain<double>(MultiPendulum(Masses()), {});
  PhysicsEngine engine = scene.MakeRigidEngine({{"substeps", 8}});
  double gap = 0;
  for (int i = 0; i < seconds * 60; ++i) {
    engine.Advance(1.0 / 1920, 32);
    gap = std::max(gap, Gap(scene));
  }
  EXPECT_LT(gap, 1e-4);
}

}  // namespace
}  // namespace vesper
