// SPDX-License-Identifier: Apache-2.0
// An engine with bodies, for tests. Uses the C interface only.
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "vesper/engine.h"

namespace vesper::test {

/// Runs `call(vesper_error*)`. Returns its error, or an error with status OK.
template <class Call>
vesper_error Try(Call&& call) {
  vesper_error error{};
  const vesper_status status = call(&error);
  EXPECT_EQ(status, error.status) << error.message;
  return error;
}

#define EXPECT_OK(expression)                                                \
  do {                                                                       \
    const vesper_error result = (expression);                                \
    EXPECT_STREQ(vesper_status_name(result.status), "OK") << result.message; \
  } while (false)

/// Expects a status, and a message that contains `text`.
#define EXPECT_REFUSED(expected, text, expression)                                          \
  do {                                                                                      \
    const vesper_error result = (expression);                                               \
    EXPECT_STREQ(vesper_status_name(result.status), #expected) << result.message;           \
    EXPECT_NE(std::string(result.message).find(text), std::string::npos) << result.message; \
  } while (false)

/// The columns that the test laws use. Row i: mass 1 + i, position (i, 2i, 3i), velocity (1, 0, i).
struct Bodies {
  explicit Bodies(size_t count);

  std::vector<double> mass, position, velocity, acceleration, force, applied, orientation;
};

struct EngineOptions {
  bool validate = false;
  uint32_t threads = 1;
  const char* prototype = "si-f64";
  uint32_t probe_timeout_ms = 20000;
  bool deferred = false;
  bool touches = false;
  bool limit_values = false;
};

using Parameters = std::initializer_list<std::pair<const char*, double>>;

class TestEngine {
 public:
  explicit TestEngine(const EngineOptions& options = {});

  vesper_engine* get() const { return engine_.get(); }
  vesper_provider* provider() const { return vesper_engine_property_provider(get()); }

  vesper_error Add(const char* name, std::vector<double>& values, uint32_t components);
  vesper_error Rebind(const char* name, std::vector<double>& values, uint32_t components);
  /// Registers mass, position, velocity, acceleration, externalForce and orientation.
  void AddBodies(Bodies& bodies);
  /// Loads `library`, a bare name that is searched among the test laws, and returns the error.
  vesper_error TryLoad(const std::string& library, Parameters parameters = {});
  /// Loads a library; fails the test if this fails.
  vesper_library_id Load(const std::string& library, Parameters parameters = {});
  vesper_error Unload(vesper_library_id library);
  vesper_error Advance(double dt, uint32_t steps);
  vesper_error Synchronize(std::initializer_list<const char*> names);
  vesper_error SynchronizeAll();
  uint64_t StateHash();
  vesper_law_info LawInfo(vesper_library_id library, uint32_t index = 0);

  /// Returns the lines that engine and laws logged.
  const std::vector<std::string>& log() const { return *log_; }

 private:
  struct Destroy {
    void operator()(vesper_engine* engine) const { vesper_engine_destroy(engine); }
  };

  std::unique_ptr<std::vector<std::string>> log_;
  std::unique_ptr<vesper_engine, Destroy> engine_;
  vesper_library_id loaded_ = 0;
};

/// Returns a config whose law path contains the test laws.
vesper_engine_config TestConfig(const EngineOptions& options = {});
std::string TestLawPath(const std::string& name);
std::vector<char> ReadFile(const std::string& path);
void WriteFile(const std::string& path, const std::vector<char>& bytes);

/// A temporary folder that is removed after the test.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// Runs each test twice: with laws in place, and in validate mode.
class BothModes : public testing::TestWithParam<bool> {
 protected:
  EngineOptions Options() const { return {.validate = GetParam()}; }
};
inline std::string ModeName(const testing::TestParamInfo<bool>& info) {
  return info.param ? "Validate" : "InPlace";
}
#define IN_BOTH_MODES(fixture) \
  INSTANTIATE_TEST_SUITE_P(Modes, fixture, testing::Bool(), vesper::test::ModeName)

}  // namespace vesper::test
