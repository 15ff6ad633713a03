// SPDX-License-Identifier: Apache-2.0
#include "test_kit.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

namespace vesper::test {

Bodies::Bodies(size_t count)
    : mass(count),
      position(3 * count),
      velocity(3 * count),
      acceleration(3 * count),
      force(3 * count),
      applied(3 * count),
      orientation(4 * count) {
  for (size_t i = 0; i < count; ++i) {
    const auto x = static_cast<double>(i);
    mass[i] = 1 + x;
    for (size_t c = 0; c < 3; ++c) position[3 * i + c] = x * static_cast<double>(c + 1);
    velocity[3 * i] = 1;
    velocity[3 * i + 2] = x;
  }
}

vesper_engine_config TestConfig(const EngineOptions& options) {
  vesper_engine_config config;
  vesper_engine_config_init(&config);
  config.validate = options.validate ? 1 : 0;
  config.threads = options.threads;
  config.deferred = options.deferred ? 1 : 0;
  config.touches = options.touches ? 1 : 0;
  config.limit_values = options.limit_values ? 1 : 0;
  config.law_path = VESPER_TEST_LAWS;
  config.probe_timeout_ms = options.probe_timeout_ms;
  return config;
}

TestEngine::TestEngine(const EngineOptions& options)
    : log_(std::make_unique<std::vector<std::string>>()) {
  vesper_engine_config config = TestConfig(options);
  config.log = [](void* user, uint32_t, const char* message) {
    static_cast<std::vector<std::string>*>(user)->push_back(message);
  };
  config.log_user = log_.get();
  vesper_engine* engine = nullptr;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_create(&config, vesper_prototype_standard(options.prototype), &engine,
                                error);
  }));
  engine_.reset(engine);
}

vesper_error TestEngine::Add(const char* name, std::vector<double>& values, uint32_t components) {
  return Try([&](vesper_error* error) {
    const uint64_t rows = values.size() / components;
    return vesper_provider_add_physical_property(provider(), name, values.data(), rows, nullptr,
                                                 rows, error);
  });
}

vesper_error TestEngine::Rebind(const char* name, std::vector<double>& values,
                                uint32_t components) {
  return Try([&](vesper_error* error) {
    const uint64_t rows = values.size() / components;
    return vesper_provider_rebind_physical_property(provider(), name, values.data(), rows, nullptr,
                                                    rows, error);
  });
}

void TestEngine::AddBodies(Bodies& bodies) {
  EXPECT_OK(Add("mass", bodies.mass, 1));
  EXPECT_OK(Add("position", bodies.position, 3));
  EXPECT_OK(Add("velocity", bodies.velocity, 3));
  EXPECT_OK(Add("acceleration", bodies.acceleration, 3));
  EXPECT_OK(Add("externalForce", bodies.force, 3));
  EXPECT_OK(Add("orientation", bodies.orientation, 4));
}

vesper_error TestEngine::TryLoad(const std::string& library, Parameters parameters) {
  std::vector<vesper_parameter> values;
  for (const auto& [name, value] : parameters) {
    values.push_back({sizeof(vesper_parameter), 0, name, value});
  }
  return Try([&](vesper_error* error) {
    return vesper_engine_load_physics_law(get(), library.c_str(), values.data(),
                                          static_cast<uint32_t>(values.size()), &loaded_, error);
  });
}

vesper_library_id TestEngine::Load(const std::string& library, Parameters parameters) {
  EXPECT_OK(TryLoad(library, parameters));
  return loaded_;
}

vesper_error TestEngine::Unload(vesper_library_id library) {
  return Try(
      [&](vesper_error* error) { return vesper_engine_unload_physics_law(get(), library, error); });
}

vesper_error TestEngine::Advance(double dt, uint32_t steps) {
  return Try([&](vesper_error* error) { return vesper_engine_advance(get(), dt, steps, error); });
}

vesper_error TestEngine::Synchronize(std::initializer_list<const char*> names) {
  return Try([&](vesper_error* error) {
    return vesper_engine_synchronize(get(), names.begin(), static_cast<uint32_t>(names.size()),
                                     error);
  });
}

vesper_error TestEngine::SynchronizeAll() {
  return Try(
      [&](vesper_error* error) { return vesper_engine_synchronize(get(), nullptr, 0, error); });
}

uint64_t TestEngine::StateHash() {
  uint64_t hash = 0;
  EXPECT_OK(
      Try([&](vesper_error* error) { return vesper_engine_state_hash(get(), &hash, error); }));
  return hash;
}

vesper_law_info TestEngine::LawInfo(vesper_library_id library, uint32_t index) {
  vesper_law_info info{};
  info.struct_size = sizeof info;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_law_info(get(), library, index, &info, error);
  }));
  return info;
}

std::string TestLawPath(const std::string& name) {
  return std::string(VESPER_TEST_LAWS) + "/libvesper_law_" + name + ".so";
}

std::vector<char> ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file.good()) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

void WriteFile(const std::string& path, const std::vector<char>& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  ASSERT_TRUE(file.good()) << path;
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = std::filesystem::temp_directory_path() / "vesper-test-XXXXXX";
  EXPECT_NE(mkdtemp(pattern.data()), nullptr);
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() { std::filesystem::remove_all(path_); }

}  // namespace vesper::test
