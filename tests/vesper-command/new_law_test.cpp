// SPDX-License-Identifier: Apache-2.0
// `vesper new-law`: what it writes builds outside the tree and passes its own tests.
#include <gtest/gtest.h>

#include <filesystem>

#include "program.hpp"

namespace vesper {
namespace {

Outcome RunCMake(std::vector<std::string> arguments) { return RunProgram(CMAKE, arguments); }

TEST(NewLawTest, WhatItWritesBuildsAndPassesItsTests) {
  const Folder folder;
  const Outcome written = RunVesper({"new-law", "slow_down", "--dir", folder / "laws"});
  ASSERT_EQ(written.exit_code, 0) << written.errors;
  const std::string source = folder / "laws/slow_down", build = folder / "build";
  const Outcome configured = RunCMake(
      {"-S", source, "-B", build, "-G", "Ninja", std::string("-DVesper_DIR=") + VESPER_PACKAGE});
  ASSERT_EQ(configured.exit_code, 0) << configured.errors;
  const Outcome built = RunCMake({"--build", build});
  ASSERT_EQ(built.exit_code, 0) << built.output << built.errors;
  const Outcome tested = RunProgram(CTEST, {"--test-dir", build, "--output-on-failure"});
  EXPECT_EQ(tested.exit_code, 0) << tested.output;
  EXPECT_NE(tested.output.find("100% tests passed, 0 tests failed out of 2"), std::string::npos);
  const std::string readme = ReadText(source + "/README.md");
  for (const char* section : {"Equation", "Properties", "Parameters", "Mass 0", "Limits"}) {
    EXPECT_NE(readme.find("\n## " + std::string(section) + "\n"), std::string::npos) << section;
  }
}

TEST(NewLawTest, NeverWritesOverWhatIsThere) {
  const Folder folder;
  std::filesystem::create_directory(folder / "mine");
  const Outcome outcome = RunVesper({"new-law", "mine", "--dir", folder / ""});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.errors.find("is there already; nothing was written"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder / "mine"));
}

TEST(NewLawTest, QuotesAFolderWithABlankInTheCommands) {
  const Folder folder;
  const Outcome written = RunVesper({"new-law", "mine", "--dir", folder / "sp ace"});
  ASSERT_EQ(written.exit_code, 0) << written.errors;
  const std::string source = folder / "sp ace/mine";
  EXPECT_NE(written.output.find("cmake -S '" + source + "' -B '" + source + "/build'"),
            std::string::npos)
      << written.output;
  EXPECT_NE(written.output.find("cmake --build '" + source + "/build'\n"), std::string::npos);
  EXPECT_NE(written.output.find("ctest --test-dir '" + source + "/build'\n"), std::string::npos);
}

TEST(NewLawTest, RefusesNamesThatNoLawCanHave) {
  for (const char* name : {"Drag", "2drag", "drag-law", "drag_", "a b"}) {
    EXPECT_EQ(RunVesper({"new-law", name}).exit_code, 2) << name;
  }
}

}  // namespace
}  // namespace vesper
