// SPDX-License-Identifier: Apache-2.0
// Tests the command line of vesper-render.
#include <gtest/gtest.h>

#include "process.hpp"
#include "session.hpp"

namespace vesper::render::test {
namespace {

TEST(Program, HelpNamesOptionsEnvironmentAndExitCodes) {
  const Outcome help = RunProgram({"--help"}, "");
  EXPECT_EQ(help.exit_code, kExitOk);
  for (const char* word : {"--samples", "--info", "--version", "LP_NUM_THREADS", "exit codes"}) {
    EXPECT_NE(help.output.find(word), std::string::npos) << word;
  }
}

TEST(Program, VersionIsOneLine) {
  const Outcome version = RunProgram({"--version"}, "");
  EXPECT_EQ(version.exit_code, kExitOk);
  EXPECT_EQ(version.output, "vesper-render 1.0.0\n");
}

TEST(Program, InfoIsJsonWithTheGraphicsLibrary) {
  const Outcome info = RunProgram({"--info"}, "");
  EXPECT_EQ(info.exit_code, kExitOk) << info.errors;
  EXPECT_EQ(info.output.front(), '{');
  EXPECT_EQ(info.output.substr(info.output.size() - 2), "}\n");
  for (const char* key : {"\"renderer\": \"", "\"gl\": \"", "\"maxSamples\": ", "\"maxSide\": "}) {
    EXPECT_NE(info.output.find(key), std::string::npos) << key;
  }
}

TEST(Program, BadArgumentsAreRefusedWithTheUsage) {
  const std::vector<std::vector<std::string>> bad{{"--sample"},
                                                  {"--samples"},
                                                  {"--samples", "17"},
                                                  {"--samples", "-1"},
                                                  {"--samples", "4x"},
                                                  {"--info", "--help"},
                                                  {"scene"}};
  for (const auto& arguments : bad) {
    const Outcome outcome = RunProgram(arguments, "");
    EXPECT_EQ(outcome.exit_code, kExitUsage) << arguments[0];
    EXPECT_NE(outcome.errors.find("usage: vesper-render"), std::string::npos);
    EXPECT_EQ(outcome.output, "");
  }
}

}  // namespace
}  // namespace vesper::render::test
