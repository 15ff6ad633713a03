// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numbers>
#include <numeric>
#include <random>

#include "scene.hpp"

namespace vesper {
namespace {

template <class Real>
class HookeSpringTest : public ::testing::Test {};
TYPED_TEST_SUITE(HookeSpringTest, Precisions);

/// A body of 4 kg on a spring of 100 N/m and 2 m, tied to a fixed point: omega = 5 rad/s.
template <class Real>
struct Oscillator {
  explicit Oscillator(double strain, Real damping = 0) : engine(Make(strain, damping)) {
    engine.LoadPhysicsLaw("hooke_spring");
    engine.LoadPhysicsLaw("newton_motion");
  }
  double Strain() const { return double{scene.position[3]} - 2; }
  double Energy() const { return scene.KineticEnergy() + 0.5 * 100 * Strain() * Strain(); }

  Scene<Real> scene;
  PhysicsEngine engine;

 private:
  PhysicsEngine Make(double strain, Real damping) {
    scene.AddBody(0, {0, 0, 0});
    scene.AddBody(4, {static_cast<Real>(2 + strain), 0, 0});
    scene.AddSpring(0, 1, 2, 100, damping);
    return scene.MakeEngine();
  }
};

// Semi-implicit Euler advances the oscillator by theta per step, where 2 sin(theta / 2) = omega dt:
// x(n) = x cos((n + 1/2) theta) / cos(theta / 2).
TYPED_TEST(HookeSpringTest, OscillationMatchesTheClosedFormOfTheScheme) {
  Oscillator<TypeParam> oscillator(0.5);
  const double dt = 0.01, theta = 2 * std::asin(5 * dt / 2);
  for (int n = 1; n <= 500; ++n) {
    oscillator.engine.Advance(dt);
    const double exact = 0.5 * std::cos((n + 0.5) * theta) / std::cos(theta / 2);
    ASSERT_NEAR(oscillator.Strain(), exact, Rounding<TypeParam>(2.5 * n)) << "step " << n;
  }
}

TYPED_TEST(HookeSpringTest, PeriodMatchesClosedForm) {
  Oscillator<TypeParam> oscillator(0.5);
  const double dt = 1.0 / 1024;
  double before = oscillator.Strain(), first = 0, last = 0;
  int falls = 0;  // passes through the rest length, from long to short
  for (int n = 1; falls < 5; ++n) {
    oscillator.engine.Advance(dt);
    const double strain = oscillator.Strain();
    if (before > 0 && strain <= 0) {
      last = (n - strain / (strain - before)) * dt;
      if (falls++ == 0) first = last;
    }
    before = strain;
    ASSERT_LT(n, 10000) << "it does not oscillate";
  }
  EXPECT_NEAR((last - first) / 4, 2 * std::numbers::pi / 5, 1e-5);
}

// The decrement is delta = 2 pi zeta / sqrt(1 - zeta^2), with zeta = c / (2 sqrt(k m)) = 0.05.
TYPED_TEST(HookeSpringTest, DampedOscillationHasTheLogarithmicDecrementOfClosedForm) {
  Oscillator<TypeParam> oscillator(0.5, 2);
  const double zeta = 0.05, dt = 1.0 / 4096;
  const double expected = 2 * std::numbers::pi * zeta / std::sqrt(1 - zeta * zeta);
  std::vector<double> peaks;
  double earlier = 0, before = oscillator.Strain();
  for (int n = 1; peaks.size() < 4; ++n) {
    oscillator.engine.Advance(dt, 16);
    const double strain = oscillator.Strain();
    if (n > 1 && before > earlier && before >= strain) peaks.push_back(before);
    earlier = before;
    before = strain;
    ASSERT_LT(n, 10000) << "it does not oscillate";
  }
  EXPECT_NEAR(std::log(peaks.front() / peaks.back()) / 3, expected, 2e-3 * expected);
}

// The map v' = v - (k x + c v) dt / m, x' = x + v' dt contracts areas by 1 - c dt / m per step.
TYPED_TEST(HookeSpringTest, DampingShrinksPhaseSpaceAsTheSchemeSays) {
  const double dt = 0.01, c = 2;
  Oscillator<TypeParam> a(0.5, TypeParam(c)), b(0.0, TypeParam(c));
  b.scene.velocity[3] = 2.5;
  const auto area = [&] {
    return a.Strain() * double{b.scene.velocity[3]} - b.Strain() * double{a.scene.velocity[3]};
  };
  const double before = area();
  a.engine.Advance(dt, 100);
  b.engine.Advance(dt, 100);
  EXPECT_NEAR(area() / before, std::pow(1 - c * dt / 4, 100), Rounding<TypeParam>(1000));
}

TYPED_TEST(HookeSpringTest, EnergyOfTheUndampedSpringStaysBounded) {
  Oscillator<TypeParam> oscillator(0.5);
  const double dt = 0.01, before = oscillator.Energy();
  double worst = 0;
  for (int n = 0; n < 2000; ++n) {  // 160 periods
    oscillator.engine.Advance(dt, 10);
    worst = std::max(worst, std::abs(oscillator.Energy() - before));
  }
  // The scheme conserves E - (omega dt / 2) omega x v m, so E oscillates by about omega dt / 2.
  EXPECT_LT(worst, 1.1 * before * 5 * dt / 2);
}

TYPED_TEST(HookeSpringTest, HangingMassComesToRestAtTheStaticExtension) {
  Oscillator<TypeParam> oscillator(0.0, 40);  // critically damped
  oscillator.scene.gravity = {10, 0, 0};
  oscillator.engine.LoadPhysicsLaw("gravity_field");
  oscillator.engine.Advance(0.01, 1000);
  EXPECT_NEAR(oscillator.Strain(), 4 * 10 / 100.0, Rounding<TypeParam>(50));
  EXPECT_NEAR(oscillator.scene.velocity[3], 0, Rounding<TypeParam>(50));
}

TYPED_TEST(HookeSpringTest, MomentumAndAngularMomentumAreConserved) {
  const uint32_t seed = 20;
  auto scene = RandomNetwork<TypeParam>(40, seed);
  scene.mass[0] = 2;
  double scale = 0;
  for (const TypeParam m : scene.mass) scale += 10 * double{m};  // speeds reach about 10 m/s
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("hooke_spring");
  engine.LoadPhysicsLaw("newton_motion");
  const Vec3<double> momentum = scene.Momentum(), angular = scene.AngularMomentum();
  const auto start = scene.position;
  engine.Advance(1.0 / 240, 480);
  EXPECT_NE(scene.position, start);
  EXPECT_LT(Length(scene.Momentum() - momentum), Rounding<TypeParam>(100 * scale));
  EXPECT_LT(Length(scene.AngularMomentum() - angular), Rounding<TypeParam>(100 * scale * 10));
}

TYPED_TEST(HookeSpringTest, MassZeroNeverMovesHoweverHardItIsPulled) {
  Oscillator<TypeParam> oscillator(100);
  oscillator.engine.Advance(0.01, 100);
  EXPECT_EQ(oscillator.scene.At(oscillator.scene.position, 0), Vec3<TypeParam>{});
  EXPECT_EQ(oscillator.scene.At(oscillator.scene.velocity, 0), Vec3<TypeParam>{});
}

TYPED_TEST(HookeSpringTest, CoincidentEndsExertNoForce) {
  Scene<TypeParam> scene;
  scene.AddBody(1, {1, 2, 3});
  scene.AddBody(1, {1, 2, 3}, {5, 0, 0});
  scene.AddSpring(0, 1, 2, 100, 3);
  scene.AddSpring(1, 1, 2, 100, 3);
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("hooke_spring");
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, std::vector<TypeParam>(6, 0));
}

TYPED_TEST(HookeSpringTest, NearlyCoincidentEndsPushApartWithFullForce) {
  const double distance = 1e-15, push = 100 * (2 - distance);
  Scene<TypeParam> scene;
  scene.AddBody(1, {0, 0, 0});
  scene.AddBody(1, {0, static_cast<TypeParam>(distance), 0});
  scene.AddSpring(0, 1, 2, 100);
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("hooke_spring");
  engine.Advance(0.01);
  EXPECT_NEAR(scene.external_force[1], -push, Rounding<TypeParam>(3 * push));
  EXPECT_NEAR(scene.external_force[4], push, Rounding<TypeParam>(3 * push));
}

TYPED_TEST(HookeSpringTest, DampingActsAlongTheSpringOnly) {
  Scene<TypeParam> scene;
  scene.AddBody(1, {0, 0, 0});
  scene.AddBody(1, {2, 0, 0}, {0, 7, 0});  // sideways
  scene.AddBody(1, {2, 5, 0}, {1, 0, 0});
  scene.AddBody(1, {4, 5, 0}, {0, 0, 0});  // closing at 1 m/s
  scene.AddSpring(0, 1, 2, 100, 3);
  scene.AddSpring(2, 3, 2, 100, 3);
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("hooke_spring");
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{0, 0, 0, 0, 0, 0, -3, 0, 0, 3, 0, 0}));
}

TYPED_TEST(HookeSpringTest, WithoutADampingPropertySpringsAreUndamped) {
  Scene<TypeParam> scene;
  scene.AddBody(1, {0, 0, 0});
  scene.AddBody(1, {3, 0, 0}, {7, 0, 0});
  scene.AddSpring(0, 1, 2, 100, 3);
  PhysicsEngine engine = scene.MakeEngine();
  engine.PropertyProvider().RemovePhysicalProperty("dampingConstant");
  engine.LoadPhysicsLaw("hooke_spring");
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{100, 0, 0, -100, 0, 0}));
}

TYPED_TEST(HookeSpringTest, SpringsThatShareABodyAddUp) {
  Scene<TypeParam> scene;
  scene.AddBody(1, {0, 0, 0});
  scene.AddBody(1, {3, 0, 0});
  scene.AddBody(1, {0, 4, 0});
  scene.AddSpring(1, 0, 2, 10);
  scene.AddSpring(0, 2, 2, 10);
  scene.AddSpring(0, 1, 2, 1);
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("hooke_spring");
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{11, 20, 0, -11, 0, 0, 0, -20, 0}));
}

/// Returns a chain of 5000 bodies with springs of different lengths, in order or shuffled.
template <class Real>
Scene<Real> Chain(bool shuffled) {
  const uint32_t bodies = 5000;
  Scene<Real> scene;
  for (uint32_t i = 0; i < bodies; ++i) {
    scene.AddBody(1, {Real(i), Real(i % 7), 0}, {0, Real(i % 5), 0});
  }
  std::vector<uint32_t> order(bodies - 1);
  std::iota(order.begin(), order.end(), 0);
  if (shuffled) std::shuffle(order.begin(), order.end(), std::mt19937(11));
  for (const uint32_t i : order) {
    const uint32_t end = i % 2;  // every other spring has swapped ends
    scene.AddSpring(i + end, i + 1 - end, Real(1 + i % 3), Real(100 + i), Real(i % 4));
  }
  return scene;
}

// The order has no effect, because a body between two springs sums two forces, and a + b equals b +
// a.
TYPED_TEST(HookeSpringTest, OrderOfTheSpringsOfAChainChangesNoBit) {
  auto chain = Chain<TypeParam>(false), shuffled = Chain<TypeParam>(true);
  for (auto* scene : {&chain, &shuffled}) {
    PhysicsEngine engine = scene->MakeEngine(2);
    engine.LoadPhysicsLaw("hooke_spring");
    engine.LoadPhysicsLaw("newton_motion");
    engine.Advance(1e-3, 10);
  }
  EXPECT_EQ(chain.external_force, shuffled.external_force);
  EXPECT_EQ(chain.position, shuffled.position);
}

TYPED_TEST(HookeSpringTest, BitsDoNotDependOnTheNumberOfThreads) {
  for (const auto& start : {Chain<TypeParam>(false), RandomNetwork<TypeParam>(9000, 12)}) {
    auto reference = start;
    for (const uint32_t threads : {1u, 2u, 8u}) {
      SCOPED_TRACE(std::to_string(start.mass.size()) + " bodies, " + std::to_string(threads) +
                   " threads");
      auto scene = start;
      PhysicsEngine engine = scene.MakeEngine(threads, false);
      engine.LoadPhysicsLaw("hooke_spring");
      engine.LoadPhysicsLaw("newton_motion");
      engine.Advance(1e-3, 20);
      if (threads == 1) reference = scene;
      EXPECT_EQ(scene.external_force, reference.external_force);
      EXPECT_EQ(scene.position, reference.position);
    }
  }
}

// The test edits values after different numbers of steps without edits. It uses a client that
// touches its edits, and a client that does not.
TYPED_TEST(HookeSpringTest, ValuesEditedInPlaceActInTheNextStep) {
  for (const bool shuffled : {false, true}) {
    for (const bool deferred : {false, true}) {
      auto scene = Chain<TypeParam>(shuffled);
      PhysicsEngine engine = scene.MakeEngine(1, true, deferred);
      engine.LoadPhysicsLaw("hooke_spring");
      for (const uint32_t steps : {1u, 2u, 40u, 3u, 40u, 1u}) {
        engine.Advance(0.01, steps);
        auto doubled = scene.external_force;
        for (TypeParam& f : doubled) f *= 2;
        for (TypeParam& k : scene.hooke_constant) k *= 2;
        for (TypeParam& c : scene.damping_constant) c *= 2;
        if (deferred) engine.PropertyProvider().Touch({"hookeConstant", "dampingConstant"});
        engine.Advance(0.01);
        EXPECT_EQ(scene.external_force, doubled)
            << "shuffled " << shuffled << ", deferred " << deferred << ", steps " << steps;
      }
    }
  }
}

/// A network whose values a client edits, lengthens and shortens, with forces computed from the
/// equation.
template <class Real>
class EditedNetwork {
 public:
  EditedNetwork(uint32_t seed, bool shuffled, uint32_t threads, bool deferred)
      : random_(seed),
        deferred_(deferred),
        scene_(Network(seed, shuffled)),
        engine_(scene_.MakeEngine(threads, seed % 2 == 0, deferred)) {
    engine_.LoadPhysicsLaw("hooke_spring");
  }

  void EditSomething() {
    const auto spring = random_() % scene_.length.size();
    switch (random_() % 6) {
      case 0:
        scene_.length[spring] = Draw(1, 10);
        return TouchValue("length");
      case 1:
        for (Real& k : scene_.hooke_constant) k = Draw(1, 100);
        return TouchValue("hookeConstant");
      case 2:
        scene_.position[random_() % scene_.position.size()] = Draw(-10, 10);
        return TouchValue("position");
      case 3:
        scene_.endpoints[2 * spring + random_() % 2] = AnyBody();
        return Provider().Touch({"endpoints"});
      case 4:
        return ChangeSprings();
      default:
        return ChangeBodies();
    }
  }

  void ExpectForcesOfTheEquation(const std::string& where) {
    engine_.Advance(0.01);
    std::vector<Vec3<double>> sums(scene_.mass.size());
    for (uint64_t s = 0; s < scene_.length.size(); ++s) {
      const uint32_t a = scene_.endpoints[2 * s], b = scene_.endpoints[2 * s + 1];
      const auto difference = [&](const std::vector<Real>& column) {
        return scene_.Wide(scene_.At(column, b)) - scene_.Wide(scene_.At(column, a));
      };
      const Vec3<double> axis = difference(scene_.position);
      const double distance = Length(axis);
      if (distance == 0) continue;
      double pull = double{scene_.hooke_constant[s]} * (distance - double{scene_.length[s]});
      if (damped_) {
        const double speed = Dot(difference(scene_.velocity), axis) / distance;
        pull += double{scene_.damping_constant[s]} * speed;
      }
      sums[a] += axis * (pull / distance);
      sums[b] -= axis * (pull / distance);
    }
    for (uint64_t i = 0; i < sums.size(); ++i) {
      const Vec3<double> found = scene_.Wide(scene_.At(scene_.external_force, i));
      ASSERT_LT(Length(found - sums[i]), Rounding<Real>(1e5)) << "body " << i << ", " << where;
    }
  }

 private:
  static Scene<Real> Network(uint32_t seed, bool shuffled) {
    const auto network = RandomNetwork<Real>(400, seed);
    std::vector<uint32_t> order(network.length.size());
    std::iota(order.begin(), order.end(), 0);
    if (shuffled) std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    Scene<Real> scene = network;
    scene.endpoints.clear();
    for (auto* column : {&scene.length, &scene.hooke_constant, &scene.damping_constant}) {
      column->clear();
    }
    for (const uint32_t s : order) {
      scene.AddSpring(network.endpoints[2 * s], network.endpoints[2 * s + 1], network.length[s],
                      network.hooke_constant[s], network.damping_constant[s]);
    }
    return scene;
  }

  PhysicalPropertyProvider Provider() { return engine_.PropertyProvider(); }
  Real Draw(double low, double high) {
    return static_cast<Real>(low + (high - low) * random_() / 4294967296.0);
  }
  uint32_t AnyBody() { return static_cast<uint32_t>(random_() % scene_.mass.size()); }
  /// Touches a value if the client promised to touch its edits.
  void TouchValue(const char* name) {
    if (deferred_) Provider().Touch({name});
  }

  void ChangeSprings() {
    if (random_() % 2 == 0) {
      scene_.AddSpring(AnyBody(), AnyBody(), Draw(1, 10), Draw(1, 100), Draw(0, 2));
    } else {
      scene_.endpoints.resize(scene_.endpoints.size() - 2);
      for (auto* column : {&scene_.length, &scene_.hooke_constant, &scene_.damping_constant}) {
        column->pop_back();
      }
    }
    Provider().RebindPhysicalProperty("endpoints", scene_.endpoints);
    Provider().RebindPhysicalProperty("length", scene_.length);
    Provider().RebindPhysicalProperty("hookeConstant", scene_.hooke_constant);
    if (damped_) Provider().RemovePhysicalProperty("dampingConstant");
    damped_ = random_() % 3 > 0;
    if (damped_) Provider().AddPhysicalProperty("dampingConstant", scene_.damping_constant);
  }

  void ChangeBodies() {
    scene_.AddBody(1, {Draw(-10, 10), Draw(-10, 10), Draw(-10, 10)}, {Draw(-3, 3), 0, 0});
    Provider().RebindPhysicalProperty("mass", scene_.mass);
    Provider().RebindPhysicalProperty("position", scene_.position);
    Provider().RebindPhysicalProperty("velocity", scene_.velocity);
    Provider().RebindPhysicalProperty("appliedForce", scene_.applied_force);
    Provider().RebindPhysicalProperty("externalForce", scene_.external_force);
  }

  std::mt19937 random_;
  bool deferred_, damped_ = true;
  Scene<Real> scene_;
  PhysicsEngine engine_;
};

TYPED_TEST(HookeSpringTest, RandomEditsActAsTheEquationSays) {
  for (uint32_t seed = 40; seed < 48; ++seed) {
    const bool shuffled = seed % 4 < 2, deferred = seed < 44;
    EditedNetwork<TypeParam> network(seed, shuffled, 1 + seed % 3, deferred);
    for (int edit = 0; edit < 60; ++edit) {
      const std::string where = "edit " + std::to_string(edit) + ", seed " + std::to_string(seed);
      ASSERT_NO_FATAL_FAILURE(network.ExpectForcesOfTheEquation(where));
      network.EditSomething();
    }
  }
}

TYPED_TEST(HookeSpringTest, EditedEndpointsActOnceTouched) {
  Scene<TypeParam> scene;
  scene.AddBody(1, {0, 0, 0});
  scene.AddBody(1, {3, 0, 0});
  scene.AddBody(1, {0, 4, 0});
  scene.AddSpring(0, 1, 2, 10);
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("hooke_spring");
  engine.Advance(0.01);
  scene.endpoints = {2, 0};
  engine.PropertyProvider().Touch({"endpoints"});
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{0, 20, 0, 0, 0, 0, 0, -20, 0}));
}

TYPED_TEST(HookeSpringTest, BodiesThatLoseTheirLastSpringAreLeftAlone) {
  Scene<TypeParam> scene;
  for (int i = 0; i < 5000; ++i) scene.AddBody(1, {static_cast<TypeParam>(3 * i), 0, 0});
  scene.AddSpring(0, 1, 2, 10);
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("hooke_spring");
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force[0], 10);
  scene.endpoints.clear();
  for (auto* column : {&scene.length, &scene.hooke_constant, &scene.damping_constant}) {
    column->clear();
  }
  PhysicalPropertyProvider provider = engine.PropertyProvider();
  provider.RebindPhysicalProperty("endpoints", scene.endpoints);
  provider.RebindPhysicalProperty("length", scene.length);
  provider.RebindPhysicalProperty("hookeConstant", scene.hooke_constant);
  provider.RebindPhysicalProperty("dampingConstant", scene.damping_constant);
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, std::vector<TypeParam>(3 * 5000));
}

}  // namespace
}  // namespace vesper
