// SPDX-License-Identifier: Apache-2.0
// Compares laws as text with the compiled laws of the same name, in turn, on one thread. Compares a
// law over all pairs with a plain loop. Measures the time from a text to the first step that uses
// it. Prints tables. With LAW, ROWS and PRECISION, prints the time of one law as text per row or
// pair [ns].
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "vesper/vesper.hpp"

namespace {

using namespace vesper;

/// Returns the processor time of this thread, which excludes other programs.
double Now() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

template <class Real>
struct World {
  std::vector<Real> mass, position, velocity, applied, force, linear, quadratic, charge;
  std::vector<Real> length, stiffness, damping;
  std::vector<uint32_t> ends;
  std::vector<Real> gravity{Real(0.1), Real(-9.81), 0}, electric{1, 2, 3}, magnetic{3, 2, 1};
  std::vector<Real> gravitation{1}, softening{Real(0.05)};

  explicit World(uint64_t bodies) {
    std::mt19937 random(1);
    const auto draw = [&](double low, double high) {
      return static_cast<Real>(low + (high - low) * (static_cast<double>(random()) / 4294967296.0));
    };
    for (uint64_t i = 0; i < bodies; ++i) {
      mass.push_back(draw(0.5, 2));
      linear.push_back(draw(0, 1));
      quadratic.push_back(draw(0, 1));
      charge.push_back(draw(-1, 1));
      for (int k = 0; k < 3; ++k) {
        position.push_back(draw(-20, 20));
        velocity.push_back(draw(-1, 1));
        applied.push_back(0);
        force.push_back(0);
      }
      ends.push_back(static_cast<uint32_t>(i));
      ends.push_back(static_cast<uint32_t>((i + 1) % bodies));
      length.push_back(draw(0.1, 1));
      stiffness.push_back(draw(1, 5));
      damping.push_back(draw(0, 1));
    }
  }

  PhysicsEngine Engine(const std::string& law_path) {
    PhysicsEngine engine(sizeof(Real) == 8 ? "si-f64" : "si-f32", {.law_path = law_path});
    PhysicalPropertyProvider provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass);
    provider.AddPhysicalProperty("position", position);
    provider.AddPhysicalProperty("velocity", velocity);
    provider.AddPhysicalProperty("appliedForce", applied);
    provider.AddPhysicalProperty("externalForce", force);
    provider.AddPhysicalProperty("linearDragCoefficient", linear);
    provider.AddPhysicalProperty("dragCoefficient", quadratic);
    provider.AddPhysicalProperty("charge", charge);
    provider.AddPhysicalProperty("endpoints", ends);
    provider.AddPhysicalProperty("length", length);
    provider.AddPhysicalProperty("hookeConstant", stiffness);
    provider.AddPhysicalProperty("dampingConstant", damping);
    provider.AddPhysicalProperty("gravity", gravity);
    provider.AddPhysicalProperty("electricField", electric);
    provider.AddPhysicalProperty("magneticField", magnetic);
    provider.AddPhysicalProperty("gravitationalConstant", gravitation);
    provider.AddPhysicalProperty("softening", softening);
    return engine;
  }
};

/// The loop that a programmer would usually write: two nested loops over rows, with each pair once.
template <class Real>
[[gnu::noinline]] void PlainLoop(World<Real>& world) {
  const size_t n = world.mass.size();
  const Real soft2 = world.softening[0] * world.softening[0], g = world.gravitation[0];
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = i + 1; j < n; ++j) {
      Real d[3], r2 = soft2;
      for (int k = 0; k < 3; ++k) {
        d[k] = world.position[3 * j + k] - world.position[3 * i + k];
        r2 += d[k] * d[k];
      }
      const Real strength = g * world.mass[i] * world.mass[j] / (r2 * std::sqrt(r2));
      for (int k = 0; k < 3; ++k) {
        world.force[3 * i + k] += strength * d[k];
        world.force[3 * j + k] -= strength * d[k];
      }
    }
  }
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

template <class A, class B>
void Compare(const std::string& name, uint64_t rows, const char* precision, const char* beside,
             int rounds, double work, A&& a, B&& b) {
  std::vector<double> text, other;
  for (int round = 0; round < rounds; ++round) {
    double start = Now();
    a();
    text.push_back(Now() - start);
    start = Now();
    b();
    other.push_back(Now() - start);
  }
  const double ours = Median(text), theirs = Median(other);
  std::printf("| %s | %llu | %s | %s | %.2f | %.2f | %.2f |\n", name.c_str(),
              static_cast<unsigned long long>(rows), precision, beside, ours / work * 1e9,
              theirs / work * 1e9, theirs / ours);
}

constexpr const char* kLaws[] = {"gravity_field", "drag",          "lorentz_field",
                                 "hooke_spring",  "newton_motion", "velocity_verlet"};
constexpr uint64_t kRows = 100000;

struct Folders {
  std::string compiled;
  std::string sources;
};

template <class Real>
PhysicsEngine EngineOf(World<Real>& world, const Folders& folders, const std::string& law,
                       bool text) {
  PhysicsEngine engine = world.Engine(folders.compiled);
  engine.LoadPhysicsLaw(text ? folders.sources + "/" + law + "/" + law + ".law" : law);
  engine.Advance(1e-6, 2);
  return engine;
}

double Pairs(uint64_t rows) {
  return static_cast<double>(rows) * static_cast<double>(rows - 1) / 2;
}

template <class Real>
void Measure(const Folders& folders, int rounds) {
  const char* precision = sizeof(Real) == 8 ? "f64" : "f32";
  for (const char* law : kLaws) {
    World<Real> a(kRows), b(kRows);
    PhysicsEngine text = EngineOf(a, folders, law, true), other = EngineOf(b, folders, law, false);
    Compare(
        law, kRows, precision, "compiled law", rounds, 4.0 * kRows, [&] { text.Advance(1e-6, 4); },
        [&] { other.Advance(1e-6, 4); });
  }
  for (const uint64_t rows : {1536, 16384}) {
    World<Real> a(rows), b(rows), c(rows);
    const int fewer = rows > 2000 ? std::max(1, rounds / 10) : rounds;
    PhysicsEngine text = EngineOf(a, folders, "newton_gravitation", true);
    PhysicsEngine other = EngineOf(b, folders, "newton_gravitation", false);
    Compare(
        "newton_gravitation", rows, precision, "compiled law", fewer, Pairs(rows),
        [&] { text.Advance(1e-6); }, [&] { other.Advance(1e-6); });
    Compare(
        "newton_gravitation", rows, precision, "plain loop, -O3 -march=native", fewer, Pairs(rows),
        [&] { text.Advance(1e-6); }, [&] { PlainLoop(c); });
  }
}

/// Prints the time from the text to the end of the first step that uses it, for 64 rows.
void MeasureLoading(const Folders& folders, int rounds) {
  World<double> world(64);
  PhysicsEngine engine = world.Engine(folders.compiled);
  engine.Advance(1e-6);
  std::printf("\n| law | from text to first step [ms] | slowest [ms] |\n|---|---:|---:|\n");
  for (const char* law : {"gravity_field", "drag", "lorentz_field", "hooke_spring", "newton_motion",
                          "velocity_verlet", "newton_gravitation"}) {
    const std::string path = folders.sources + "/" + law + "/" + law + ".law";
    std::vector<double> times;
    for (int round = 0; round < rounds; ++round) {
      const double start = Now();
      const vesper_library_id id = engine.LoadPhysicsLaw(path);
      engine.Advance(1e-6);
      times.push_back(Now() - start);
      engine.UnloadPhysicsLaw(id);
    }
    std::printf("| %s | %.2f | %.2f |\n", law, 1e3 * Median(times),
                1e3 * *std::max_element(times.begin(), times.end()));
  }
}

template <class Real>
void MeasureOne(const Folders& folders, const std::string& law, uint64_t rows, int rounds) {
  World<Real> world(rows);
  PhysicsEngine engine = EngineOf(world, folders, law, true);
  const bool pairs = law == "newton_gravitation";
  const int steps = pairs ? 1 : 4;
  std::vector<double> times;
  for (int round = 0; round < rounds; ++round) {
    const double start = Now();
    engine.Advance(1e-6, static_cast<uint32_t>(steps));
    times.push_back(Now() - start);
  }
  const double work = pairs ? Pairs(rows) : steps * static_cast<double>(rows);
  std::printf("%.4f\n", 1e9 * Median(times) / work);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4 && argc != 7) {
    std::fprintf(stderr, "usage: text_bench COMPILED-LAWS LAW-SOURCES ROUNDS [LAW ROWS f32|f64]\n");
    return 2;
  }
  const Folders folders{argv[1], argv[2]};
  const int rounds = std::atoi(argv[3]);
  if (argc == 7) {
    const auto rows = static_cast<uint64_t>(std::atoll(argv[5]));
    if (std::string(argv[6]) == "f64") {
      MeasureOne<double>(folders, argv[4], rows, rounds);
    } else {
      MeasureOne<float>(folders, argv[4], rows, rounds);
    }
    return 0;
  }
  std::printf("%s\n\n", vesper_build_info());
  std::printf(
      "| law | rows | | beside | text [ns per row or pair] | other [ns] | times as fast |\n");
  std::printf("|---|---:|---|---|---:|---:|---:|\n");
  Measure<double>(folders, rounds);
  Measure<float>(folders, rounds);
  MeasureLoading(folders, rounds);
  return 0;
}
