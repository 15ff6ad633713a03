// SPDX-License-Identifier: Apache-2.0
// `vesper law` on right and wrong texts.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
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
  const Outcome wicked = RunVesper(
      {"law", "check", folder.Write("wicked.law", "law \xe2\x80\xae\xe2\x80\xa8wicked\n")});
  EXPECT_EQ(wicked.exit_code, 1);
  EXPECT_EQ(wicked.errors.find("\xe2\x80\xae"), std::string::npos) << wicked.errors;
  EXPECT_EQ(wicked.errors.find("\xe2\x80\xa8"), std::string::npos) << wicked.errors;
  const Outcome json = RunVesper({"law", "check", folder / "wrong.law", "--json"});
  EXPECT_EQ(json.exit_code, 1);
  EXPECT_NE(nlohmann::json::parse(json.output).at("problems"), "");
}

// A world may declare the kind and the property; the command knows no world.
TEST(LawCommandTest, CheckNamesTheCheckOfTheWorld) {
  const Folder folder;
  const Outcome wrong = RunVesper(
      {"law", "check",
       folder.Write("flow.law", "law flow\n  each contact from a to b:\n    a.force += 1 N\n")});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_NE(wrong.errors.find("there is no kind 'contact'"), std::string::npos) << wrong.errors;
  EXPECT_NE(wrong.errors.find(
                "\nchecked without a world, against the standard prototype si-f64; if a world "
                "declares kinds or properties for this law, check the world: reve check WORLD\n"),
            std::string::npos)
      << wrong.errors;
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
  const Outcome again = RunVesper({"law", "to-cpp", kDragText, "--output", file});
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  const std::string other = folder.Write("store.db", "SQLite format 3");
  const Outcome refused = RunVesper({"law", "to-cpp", kDragText, "--output", other});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.errors.find("store.db: exists, and this command has not written it"),
            std::string::npos)
      << refused.errors;
  EXPECT_EQ(ReadText(other), "SQLite format 3");
  const Outcome lost = RunVesper({"law", "to-cpp", kDragText, "--output", folder / "no/drag.cpp"});
  EXPECT_EQ(lost.exit_code, 1);
  EXPECT_NE(lost.errors.find("no/drag.cpp: cannot be written: No such file"), std::string::npos)
      << lost.errors;
}

// The coefficient of this drag is the law's own property. v(t) = v0 exp(-k t / m) with m = 1 kg.
TEST(LawCommandTest, RunSetsThePropertiesOfTheLawItself) {
  const Folder folder;
  const std::string law =
      folder.Write("sticky.law",
                   "law sticky\n  each body has stickiness in kg/s\n  each body:\n"
                   "    force -= stickiness velocity\n");
  const auto kinetic = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"law", "run", law, "--seconds", "1", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = RunVesper(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return nlohmann::json::parse(outcome.output).at("rows")[5].at("kinetic").get<double>();
  };
  const double free = kinetic({});
  EXPECT_NEAR(kinetic({"--set", "stickiness=0.5"}) / free, std::exp(-1.0), 1e-3);
  EXPECT_NEAR(kinetic({"--set", "stickiness=0.5", "--set", "velocity=3,0,4"}),
              27 * 12.5 * std::exp(-1.0), 0.2);
  const Outcome plot = RunVesper({"law", "plot", law, "--set", "stickiness=0.5", "--over", "speed",
                                  "--from", "0", "--to", "10", "--points", "2", "--json"});
  ASSERT_EQ(plot.exit_code, 0) << plot.errors;
  EXPECT_DOUBLE_EQ(nlohmann::json::parse(plot.output).at("points")[1][1], -5);
  const std::pair<const char*, const char*> mistakes[] = {
      {"stickiness", "--set stickiness: expected a property and its numbers"},
      {"stickiness=1,", "expected a property and its numbers"},
      {"stickiness=1,2", "--set stickiness: found 2 numbers, expected 1, in kg/s"},
      {"stickines=1", "--set stickines: the law 'sticky' and the standard properties have no such"},
      {"hookeConstant=1", "--set hookeConstant: the scene has no rows with this property"}};
  for (const auto& [given, message] : mistakes) {
    const Outcome wrong = RunVesper({"law", "run", law, "--set", given});
    EXPECT_EQ(wrong.exit_code, 2) << given;
    EXPECT_NE(wrong.errors.find(message), std::string::npos) << wrong.errors;
  }
}

// The bodies of the scene have 1 kg, so work and energies have the numbers of the formulas.
TEST(LawCommandTest, RunPrintsConservedQuantities) {
  const Outcome outcome = RunVesper({"law", "run", VESPER_TEXTS "/hooke_spring/hooke_spring.law",
                                     "--seconds", "2", "--bodies", "8", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto rows = nlohmann::json::parse(outcome.output).at("rows");
  ASSERT_EQ(rows.size(), 6u);
  const auto energy = [](const nlohmann::json& row) {
    return row.at("kinetic").get<double>() + row.at("potential").get<double>();
  };
  EXPECT_DOUBLE_EQ(rows[5].at("time"), 2);
  EXPECT_GT(std::abs(rows[5].at("kinetic").get<double>() - rows[0].at("kinetic").get<double>()), 1);
  EXPECT_NEAR(energy(rows[5]), energy(rows[0]), 1e-5 * energy(rows[0]));
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(rows[5].at("momentum")[k], rows[0].at("momentum")[k].get<double>(), 1e-12);
  }
  const Outcome fine = RunVesper({"law", "run", VESPER_TEXTS "/hooke_spring/hooke_spring.law",
                                  "--seconds", "2", "--bodies", "8", "--rows", "101", "--json"});
  ASSERT_EQ(fine.exit_code, 0) << fine.errors;
  const auto more = nlohmann::json::parse(fine.output).at("rows");
  ASSERT_EQ(more.size(), 101u);
  EXPECT_EQ(more[100], rows[5]);
  EXPECT_EQ(more[20], rows[1]);
  const Outcome short_run =
      RunVesper({"law", "run", kDragText, "--seconds", "0.003", "--rows", "50", "--json"});
  ASSERT_EQ(short_run.exit_code, 0) << short_run.errors;
  EXPECT_EQ(nlohmann::json::parse(short_run.output).at("rows").size(), 4u);  // one for each step
  const Outcome table = RunVesper({"law", "run", kDragText, "--seconds", "0.1"});
  EXPECT_EQ(table.exit_code, 0) << table.errors;
  EXPECT_NE(table.output.find("time [s]"), std::string::npos) << table.output;
  EXPECT_NE(table.output.find("reports no potential energy"), std::string::npos) << table.output;
}

TEST(LawCommandTest, RunAndPlotExecuteNoCodeOfOtherLaws) {
  const Folder folder;
  const std::string executed = folder.Write("executed", ""), pipe = executed + ".law";
  const std::string python = folder.Write("spin.py", "import os\nos.remove('" + executed + "')\n");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const char* command : {"run", "plot"}) {
    const Outcome outcome = RunVesper({"law", command, python});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.errors.find("spin.py: expected a law as text, whose name ends in .law"),
              std::string::npos)
        << outcome.errors;
    const Outcome waits = RunVesper({"law", command, pipe});
    EXPECT_EQ(waits.exit_code, 1);
    EXPECT_NE(waits.errors.find("executed.law: not a regular file"), std::string::npos)
        << waits.errors;
  }
  EXPECT_TRUE(std::filesystem::exists(executed)) << "the code of the law was executed";
}

TEST(LawCommandTest, PlotPrintsForceAndEnergy) {
  const auto plot = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"law", "plot"});
    arguments.push_back("--json");
    const Outcome outcome = RunVesper(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return nlohmann::json::parse(outcome.output);
  };
  const auto atoms = plot({VESPER_WORLDS "/gallery/laws/condensation.law", "--from", "0.9", "--to",
                           "2.2", "--points", "14", "--parameter", "epsilon=2"});
  EXPECT_EQ(atoms.at("over"), "distance");
  ASSERT_EQ(atoms.at("points").size(), 14u);
  for (const auto& point : atoms.at("points")) {
    const double r = point[0];
    const double force = 8 * (12 * std::pow(r, -13) - 6 * std::pow(r, -7));
    EXPECT_NEAR(point[1], force, 1e-12 * std::abs(force) + 1e-12) << r;
    EXPECT_NEAR(point[2], 8 * (std::pow(r, -12) - std::pow(r, -6)), 1e-11) << r;
  }
  const auto drag = plot({kDragText, "--to", "4", "--points", "3"});
  EXPECT_EQ(drag.at("over"), "speed");
  EXPECT_NEAR(drag.at("points")[2][1], -(0.1 * 4 + 0.1 * 16), 1e-12);
  const Outcome heat = RunVesper({"law", "plot", VESPER_WORLDS "/gallery/laws/heat.law"});
  EXPECT_EQ(heat.exit_code, 1);
  EXPECT_NE(heat.errors.find("heat adds no forces"), std::string::npos) << heat.errors;
  const Outcome wrong = RunVesper({"law", "plot", kDragText, "--parameter", "c"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.errors.find("--parameter c: expected a name and a number"), std::string::npos);
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
