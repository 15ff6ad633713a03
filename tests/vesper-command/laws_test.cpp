// SPDX-License-Identifier: Apache-2.0
// `vesper laws` over folders with good and broken libraries.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace vesper {
namespace {

const std::string kLaws = VESPER_LAW_PATH;
const std::string kSpring = kLaws + "/libvesper_law_hooke_spring.so";

TEST(LawsTest, ListsEveryDeclarationOfALaw) {
  const Folder folder;
  std::filesystem::copy(kSpring, folder / "libvesper_law_hooke_spring.so");
  const Outcome outcome = RunVesper({"laws", folder / "", "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto libraries = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(libraries.size(), 1u);
  EXPECT_EQ(libraries[0].at("library"), "hooke_spring");
  ASSERT_EQ(libraries[0].at("laws").size(), 1u);  // one line for both precisions
  const auto& law = libraries[0].at("laws")[0];
  EXPECT_EQ(law.at("phase"), "force");
  EXPECT_EQ(law.at("potentialEnergy"), true);
  const auto property = [&](const std::string& name) {
    return *std::ranges::find_if(law.at("properties"),
                                 [&](const auto& p) { return p.at("name") == name; });
  };
  EXPECT_EQ(property("endpoints").at("type"), "u32 x 2");
  EXPECT_EQ(property("hookeConstant").at("unit"), "N/m");
  EXPECT_EQ(property("position").at("access"), "read");
  EXPECT_EQ(property("externalForce").at("access"), "accumulate");
  EXPECT_EQ(property("dampingConstant").at("optional"), true);
  EXPECT_EQ(property("length").at("kind"), "spring");
}

TEST(LawsTest, TextNamesLawsPropertiesAndUnits) {
  const Outcome outcome = RunVesper({"laws", kLaws});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  for (const char* part : {"newton_motion 1.", "integrate, stages: 1", "body.velocity", "real x 3",
                           "[m/s]", "read-write", "write, optional", "claims: translation"}) {
    EXPECT_NE(outcome.output.find(part), std::string::npos) << part << "\n" << outcome.output;
  }
}

TEST(LawsTest, BrokenLibraryIsListedWithItsReasonAndEndsWith4) {
  const Folder folder;
  std::filesystem::copy(kSpring, folder / "libvesper_law_hooke_spring.so");
  folder.Write("libvesper_law_broken.so", ReadText(kSpring).substr(0, 5000));
  const Outcome outcome = RunVesper({"laws", folder / "", "--json"});
  EXPECT_EQ(outcome.exit_code, 4);
  const auto libraries = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(libraries.size(), 2u);
  EXPECT_NE(libraries[0].at("error").get<std::string>().find("LIBRARY_LOAD_FAILED"),
            std::string::npos);
  EXPECT_EQ(libraries[1].at("library"), "hooke_spring");
}

TEST(LawsTest, MissingFolderEndsWith1) {
  const Outcome outcome = RunVesper({"laws", "/nowhere/at/all"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.errors, "vesper: /nowhere/at/all: no such folder\n");
}

}  // namespace
}  // namespace vesper
