// SPDX-License-Identifier: Apache-2.0
// Templates of the files of a new law, with placeholders @NAME@ and @CLASS@.
#pragma once

namespace vesper::cli {

inline constexpr const char* kLawSource = R"(#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Bodies that a thread takes at once.
constexpr uint64_t kGrain = 8192;

/** Linear drag: F = -c v. Put your own equation here. */
template <class Real>
struct @CLASS@ {
  static constexpr auto kName = "@NAME@", kVersion = "1.0.0";
  static constexpr auto kDoc = "Linear drag, F = -c v.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kTranslation | kRotation;

  Parameter drag{"drag", "Force per speed.", units::kilogram_per_second, 1, 0, 1e6};

  Read<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Parameters() { return std::tie(drag); }
  auto Properties() { return std::tie(velocity, force); }

  void Advance(const Step& step) {
    const auto c = Real(drag);
    step.ParallelFor(force.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) force[i] -= velocity[i] * c;
    });
  }
};

}  // namespace

VESPER_LAW_LIBRARY("@NAME@", @CLASS@)
)";

inline constexpr const char* kLawTest =
    R"(// Compares the law with its closed form, in an engine of its own: @NAME@_test LIBRARY
#include <cstdio>
#include <vector>

#include "vesper/vesper.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::vector<double> velocity{1, -2, 4}, force(3);
  vesper::PhysicsEngine engine("si-f64", {.validate = true});
  engine.PropertyProvider().AddPhysicalProperty("velocity", velocity);
  engine.PropertyProvider().AddPhysicalProperty("externalForce", force);
  engine.LoadPhysicsLaw(argv[1], {{"drag", 0.5}});
  engine.Advance(0.01);
  const std::vector<double> expected{-0.5, 1, -2};
  std::printf("force %g %g %g N, expected %g %g %g N\n", force[0], force[1], force[2], expected[0],
              expected[1], expected[2]);
  return force == expected ? 0 : 1;
}
)";

inline constexpr const char* kLawCMake = R"(cmake_minimum_required(VERSION 3.25)
project(@NAME@ LANGUAGES CXX)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo)
endif()
enable_testing()

# Where it is not found by itself: -DVesper_DIR=<build or installation of Vesper>
find_package(Vesper 1.0 REQUIRED)
vesper_add_law(@NAME@ @NAME@.cpp)

add_executable(@NAME@_test @NAME@_test.cpp)
target_compile_features(@NAME@_test PRIVATE cxx_std_20)
target_link_libraries(@NAME@_test PRIVATE Vesper::vesper)

add_test(NAME @NAME@ COMMAND @NAME@_test $<TARGET_FILE:vesper_law_@NAME@>)
# What every law promises, and what this one claims.
add_test(NAME promises COMMAND Vesper::command test $<TARGET_FILE:vesper_law_@NAME@>)
)";

inline constexpr const char* kLawReadme =
    R"(# @NAME@

Slows every body down.

## Equation

    F = -c v

## Properties

| property | access | unit |
|---|---|---|
| body `velocity` | read | m/s |
| body `externalForce` | accumulate | N |

## Parameters

| parameter | default | range | unit |
|---|---|---|---|
| `drag` c | 1 | 0 to 1e6 | kg/s |

## Mass 0

)"
    "The law does not look at the mass: it exerts its force on immovable bodies too, and the "
    "integrator does not move them.\n"
    R"(
## Limits

Real air drags with the square of the speed; this holds for slow motion in a viscous fluid.

## Build and test

    cmake -S . -B build && cmake --build build && ctest --test-dir build --output-on-failure
)";

}  // namespace vesper::cli
