// SPDX-License-Identifier: Apache-2.0
// `vesper test`: good laws pass, and for each promise there is a law that breaks it and fails.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace vesper {
namespace {

std::string TestedLaw(const std::string& name) {
  return std::string(TESTED_LAWS) + "/libvesper_law_" + name + ".so";
}

std::string BrokenLaw(const std::string& fault) { return TestedLaw("broken_" + fault); }

/// Checks with that verdict, "check" or "check f64", and their notes.
std::map<std::string, std::string> Verdicts(const nlohmann::json& report, const char* verdict) {
  std::map<std::string, std::string> found;
  for (const auto& check : report.at(0).at("checks")) {
    if (check.at("verdict") != verdict) continue;
    const std::string precision = check.at("precision");
    found[check.at("check").get<std::string>() + (precision.empty() ? "" : " " + precision)] =
        check.at("note");
  }
  return found;
}

struct Fault {
  const char* name;
  const char* check;  // that fails
  const char* note;   // part of its reason
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class KitFaultTest : public ::testing::TestWithParam<Fault> {};

TEST_P(KitFaultTest, LawThatBreaksAPromiseFailsItsCheck) {
  const auto& [name, check, note] = GetParam();
  const std::string check_name(check, std::string_view(check).find(' '));
  const Outcome outcome = RunVesper({"test", BrokenLaw(name), "--only", check_name, "--json"});
  EXPECT_EQ(outcome.exit_code, 1) << outcome.errors;
  const auto report = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(report.at(0).at("checks").size(), 2);  // in both precisions
  const auto failed = Verdicts(report, "FAIL");
  ASSERT_TRUE(failed.contains(check)) << outcome.output;
  EXPECT_NE(failed.at(check).find(note), std::string::npos) << failed.at(check);
}

INSTANTIATE_TEST_SUITE_P(
    Faults, KitFaultTest,
    ::testing::Values(Fault{"behind", "guard-pages f64", "behind the last row of 'position'"},
                      Fault{"before", "guard-pages f32", "before the first row of 'position'"},
                      Fault{"threads", "threads f64", "'externalForce' has other bits on "},
                      Fault{"not_a_number", "not-a-number f64",
                            "NaN in 'position' changes 'externalForce' without an error"},
                      Fault{"momentum", "momentum f64", "forces sum to "},
                      Fault{"angular_momentum", "angular-momentum f32", "moments sum to "},
                      Fault{"translation", "translation f64", "'externalForce' differs in row 0"},
                      Fault{"rotation", "rotation f32", "'externalForce' differs in row 0"},
                      Fault{"place", "translation f64", "'externalForce' differs in row 0"},
                      Fault{"energy", "potential-energy f64", "but the energy falls by"},
                      Fault{"leak", "reload f64", "leaves open files"},
                      Fault{"motion", "convergence f64", "expected at least order 1"}));

TEST(KitTest, LawThatWritesWhatItMayOnlyReadIsCaughtByItsPage) {
  const Outcome outcome =
      RunVesper({"test", BrokenLaw("writes_read"), "--only", "guard-pages,rows", "--json"});
  EXPECT_EQ(outcome.exit_code, 1);
  const auto failed = Verdicts(nlohmann::json::parse(outcome.output), "FAIL");
  ASSERT_TRUE(failed.contains("guard-pages f64"));
  EXPECT_EQ(failed.at("guard-pages f64"),
            "on 1 rows, broken: writes to 'mass', which it declares as READ");
  EXPECT_TRUE(failed.contains("rows f64"));  // validate mode sees it too
}

TEST(KitTest, CrashFailsEachCheckThatRunsTheLawAndEndsNothingElse) {
  const Outcome outcome = RunVesper({"test", BrokenLaw("crash"), "--json"});
  EXPECT_EQ(outcome.exit_code, 1);
  const auto report = nlohmann::json::parse(outcome.output);
  const auto failed = Verdicts(report, "FAIL");
  EXPECT_EQ(failed.at("rows f64"), "the law crashed: Aborted");
  EXPECT_TRUE(Verdicts(report, "PASS").contains("exports"));
}

TEST(KitTest, LawThatEndsTheProcessFails) {
  const Outcome outcome = RunVesper({"test", BrokenLaw("exit"), "--json"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(Verdicts(nlohmann::json::parse(outcome.output), "FAIL").at("rows f64"),
            "the law ended the process with exit code 7");
}

TEST(KitTest, GoodLawsPassAndTheReportSaysSo) {
  const std::string laws = VESPER_LAW_PATH;
  const Outcome outcome = RunVesper(
      {"test", laws + "/libvesper_law_newton_motion.so", laws + "/libvesper_law_hooke_spring.so"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  for (const char* part : {"PASS  guard-pages", "newton_motion order 1.0", " 0 failed, ",
                           "hooke_spring", "ns per row"}) {
    EXPECT_NE(outcome.output.find(part), std::string::npos) << part;
  }
}

TEST(KitTest, LawsOfFieldsAreHeldToTheirWordOnAFieldThatMovesWithTheWorld) {
  const Outcome outcome = RunVesper({"test", TestedLaw("windblown"), "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  const auto passed = Verdicts(nlohmann::json::parse(outcome.output), "PASS");
  for (const char* check : {"guard-pages f64", "rows f32", "translation f64", "translation f32",
                            "rotation f64", "rotation f32", "not-a-number f64"}) {
    EXPECT_TRUE(passed.contains(check)) << check;
  }
}

TEST(KitTest, FieldThatTheLibraryBringsIsTheOneThatItsLawsRead) {
  const Outcome outcome = RunVesper({"test", TestedLaw("gusty")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
}

TEST(KitTest, LibraryThatExportsMoreIsTold) {
  const Outcome outcome = RunVesper({"test", BrokenLaw("exports"), "--only", "exports", "--json"});
  EXPECT_EQ(outcome.exit_code, 1);
  const auto failed = Verdicts(nlohmann::json::parse(outcome.output), "FAIL");
  ASSERT_TRUE(failed.contains("exports"));
  EXPECT_NE(failed.at("exports").find("also exports 'also_exported'"), std::string::npos);
}

TEST(KitTest, UnknownCheckIsRefusedWithTheNamesOfAll) {
  const Outcome outcome = RunVesper({"test", BrokenLaw("crash"), "--only", "rows,memory"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.errors.find("memory not in {exports,imports,"), std::string::npos)
      << outcome.errors;
}

TEST(KitTest, BrokenFileEndsWith4) {
  const Folder folder;
  const Outcome outcome =
      RunVesper({"test", folder.Write("libvesper_law_x.so", "this is no library")});
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_NE(outcome.errors.find("libvesper_law_x.so"), std::string::npos) << outcome.errors;
}

TEST(KitTest, MissingFileEndsWith2) { EXPECT_EQ(RunVesper({"test", "/nowhere.so"}).exit_code, 2); }

}  // namespace
}  // namespace vesper
