// barnes_hut_gravitation through the engine, one step for each line of its input; see barnes_hut.py.
//   barnes_hut_bench FOLDER_OF_LAWS PRECISION THETA SOFTENING POSITIONS ACCELERATIONS
// POSITIONS: (bodies x 3) doubles [m]; each body weighs 1/bodies kg, G = 1. Answers with the step's
// seconds on the wall and of processor time; at the end of its input writes (bodies x 3) doubles.
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "side_by_side.hpp"
#include "vesper/vesper.hpp"

namespace {

std::vector<double> ReadDoubles(const char* path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const auto* values = reinterpret_cast<const double*>(bytes.data());
  return {values, values + bytes.size() / sizeof(double)};
}

template <class Real>
void Serve(char** arguments) {
  const std::vector<double> points = ReadDoubles(arguments[5]);
  const size_t bodies = points.size() / 3;
  std::vector<Real> position(points.begin(), points.end()), force(points.size()),
      mass(bodies, static_cast<Real>(1.0 / static_cast<double>(bodies))), constant{1},
      softening{static_cast<Real>(std::atof(arguments[4]))};
  vesper::PhysicsEngine engine(sizeof(Real) == 8 ? "si-f64" : "si-f32",
                               {.threads = 2, .law_path = arguments[1]});
  auto provider = engine.PropertyProvider();
  provider.AddPhysicalProperty("mass", mass);
  provider.AddPhysicalProperty("position", position);
  provider.AddPhysicalProperty("externalForce", force);
  provider.AddPhysicalProperty("gravitationalConstant", constant);
  provider.AddPhysicalProperty("softening", softening);
  engine.LoadPhysicsLaw("barnes_hut_gravitation", {{"theta", std::atof(arguments[3])}});
  for (std::string line; std::getline(std::cin, line);) {
    const bench::Clock start = bench::Clock::Now();
    engine.Advance(1);
    const bench::Clock end = bench::Clock::Now();
    std::cout << end.wall - start.wall << ' ' << end.processor - start.processor << std::endl;
  }
  std::vector<double> accelerations(force.begin(), force.end());
  for (double& a : accelerations) a *= static_cast<double>(bodies);
  std::ofstream(arguments[6], std::ios::binary)
      .write(reinterpret_cast<const char*>(accelerations.data()),
             static_cast<std::streamsize>(accelerations.size() * sizeof(double)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) {
    std::cerr << "usage: barnes_hut_bench FOLDER_OF_LAWS f32|f64 THETA SOFTENING POSITIONS "
                 "ACCELERATIONS\n";
    return 2;
  }
  if (std::string(argv[2]) == "f32") {
    Serve<float>(argv);
  } else {
    Serve<double>(argv);
  }
}
