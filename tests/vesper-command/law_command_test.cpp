// SPDX-License-Identifier: Apache-2.0
// `vesper law` on right and wrong texts.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "program.hpp"

namespace vesper {
namespace {

const std::string kDragText = VESPER_TEXTS "/drag/drag.law";

std::string WrongText(const Folder& folder) {
  return folder.Write("wrong.law", "law wrong\n  each body:\n    force += velocity\n");
}

TEST(LawCommandTest, CheckPrintsDeclarationsOrProblems) {
  const Folder folder;
  const Outcome right = RunVesper({"law", "check", kDragText});
  EXPECT_EQ(right.exit_code, 0) << right.errors;
  EXPECT_NE(right.output.find("claims: translation rotation"), std::string::npos) << right.output;
  const Outcome wrong = RunVesper({"law", "check", WrongText(folder)});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_NE(wrong.errors.find("wrong.law:3:14: 'velocity' is a vector in m/s"), std::string::npos)
      << wrong.errors;
  const Outcome json = RunVesper({"law", "check", folder / "wrong.law", "--json"});
  EXPECT_EQ(json.exit_code, 1);
  EXPECT_NE(nlohmann::json::parse(json.output).at("problems"), "");
}

TEST(LawCommandTest, ToCppWritesALawToTheOutputOrAFile) {
  const Folder folder;
  const Outcome printed = RunVesper({"law", "to-cpp", kDragText});
  EXPECT_EQ(printed.exit_code, 0) << printed.errors;
  EXPECT_NE(printed.output.find("VESPER_LAW_LIBRARY(\"drag\", Drag)\n"), std::string::npos);
  const std::string file = folder / "drag.cpp";
  const Outcome written = RunVesper({"law", "to-cpp", kDragText, "--output", file});
  EXPECT_EQ(written.exit_code, 0) << written.errors;
  EXPECT_EQ(written.output, "");
  EXPECT_EQ(ReadText(file), printed.output);
  const Outcome lost = RunVesper({"law", "to-cpp", kDragText, "--output", folder / "no/drag.cpp"});
  EXPECT_EQ(lost.exit_code, 1);
  EXPECT_NE(lost.errors.find("no/drag.cpp: cannot be written: No such file"), std::string::npos)
      << lost.errors;
}

TEST(LawCommandTest, ToCppRefusesWhatCheckRefuses) {
  const Folder folder;
  const std::string file = WrongText(folder);
  const Outcome refused = RunVesper({"law", "to-cpp", file});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_EQ(refused.output, "");
  EXPECT_EQ(refused.errors, RunVesper({"law", "check", file}).errors);
  EXPECT_EQ(RunVesper({"law", "to-cpp", folder / "missing.law"}).exit_code, 2);
  EXPECT_EQ(RunVesper({"law"}).exit_code, 2);
}

}  // namespace
}  // namespace vesper
