// SPDX-License-Identifier: Apache-2.0
// Runs laws of gravitation in the engine, and a bare kernel, on the same bodies; see sides.py.
//   gravitation_bench FOLDER_OF_LAWS f32|f64 SOFTENING POSITIONS RESULT SIDE...
// POSITIONS: a file of (bodies x 3) doubles [m]. SIDE: "kernel", or a law with an optional
// parameter, such as "barnes_hut_gravitation theta=0.5". Each input line is "SIDE CALLS" with the
// number of a side. The program answers with the seconds per call in wall-clock and in processor
// time. At the end of its input it writes the accelerations, (sides x bodies x 3) doubles, to
// RESULT.
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "gravitation.hpp"
#include "side_by_side.hpp"
#include "vesper/vesper.hpp"

namespace {

std::vector<double> ReadDoubles(const char* path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const auto* values = reinterpret_cast<const double*>(bytes.data());
  return {values, values + bytes.size() / sizeof(double)};
}

/// An engine with a law of gravitation and newton_motion.
template <class Real>
class Law : public bench::Side {
 public:
  Law(const bench::World& world, const char* folder, const std::string& spec)
      : mass_(world.bodies(), static_cast<Real>(1.0 / static_cast<double>(world.bodies()))),
        position_(world.position.begin(), world.position.end()),
        velocity_(position_.size()),
        force_(position_.size()),
        softening_{static_cast<Real>(world.softening)},
        engine_(sizeof(Real) == 8 ? "si-f64" : "si-f32",
                {.threads = bench::kThreads, .law_path = folder}) {
    auto provider = engine_.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass_);
    provider.AddPhysicalProperty("position", position_);
    provider.AddPhysicalProperty("velocity", velocity_);
    provider.AddPhysicalProperty("externalForce", force_);
    provider.AddPhysicalProperty("gravitationalConstant", constant_);
    provider.AddPhysicalProperty("softening", softening_);
    const size_t space = spec.find(' '), equals = spec.find('=');
    if (space == std::string::npos) {
      engine_.LoadPhysicsLaw(spec);
    } else {
      engine_.LoadPhysicsLaw(spec.substr(0, space), {{spec.substr(space + 1, equals - space - 1),
                                                      std::atof(spec.c_str() + equals + 1)}});
    }
    engine_.LoadPhysicsLaw("newton_motion");
  }

  /// Runs a step that is so short that nothing moves. So all sides use the same positions.
  void Run() override { engine_.Advance(1e-12); }

  std::vector<double> Accelerations() override {
    std::vector<double> accelerations(force_.begin(), force_.end());
    for (size_t k = 0; k < accelerations.size(); ++k) {
      accelerations[k] /= static_cast<double>(mass_[k / 3]);
    }
    return accelerations;
  }

 private:
  std::vector<Real> mass_, position_, velocity_, force_, constant_ = {1}, softening_;
  vesper::PhysicsEngine engine_;
};

int Serve(int argc, char** argv) {
  const std::vector<double> position = ReadDoubles(argv[4]);
  const bench::World world{position, std::atof(argv[3])};
  const bool single = std::string(argv[2]) == "f32";
  std::vector<std::unique_ptr<bench::Side>> sides;
  for (int i = 6; i < argc; ++i) {
    if (std::string(argv[i]) == "kernel") {
      sides.push_back(MakeKernel(world, single));
    } else if (single) {
      sides.push_back(std::make_unique<Law<float>>(world, argv[1], argv[i]));
    } else {
      sides.push_back(std::make_unique<Law<double>>(world, argv[1], argv[i]));
    }
  }
  for (uint64_t side = 0, calls = 0; std::cin >> side >> calls;) {
    const bench::Clock start = bench::Clock::Now();
    for (uint64_t i = 0; i < calls; ++i) sides.at(side)->Run();
    const bench::Clock end = bench::Clock::Now();
    const auto n = static_cast<double>(calls);
    std::cout << (end.wall - start.wall) / n << ' ' << (end.processor - start.processor) / n
              << std::endl;
  }
  std::ofstream file(argv[5], std::ios::binary);
  for (const auto& side : sides) {
    const std::vector<double> result = side->Accelerations();
    file.write(reinterpret_cast<const char*>(result.data()),
               static_cast<std::streamsize>(result.size() * sizeof(double)));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 7) {
    std::cerr << "usage: gravitation_bench FOLDER_OF_LAWS f32|f64 SOFTENING POSITIONS RESULT "
                 "SIDE...\n";
    return 2;
  }
  try {
    return Serve(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "gravitation_bench: " << error.what() << '\n';
    return 1;
  }
}
