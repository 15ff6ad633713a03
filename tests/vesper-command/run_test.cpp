// SPDX-License-Identifier: Apache-2.0
// `vesper run` on the sample scenes, against closed forms and invariants.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "program.hpp"

namespace vesper {
namespace {

const std::string kScenes = VESPER_SCENES;
const std::string kSpiderweb = VESPER_WORLDS "/spiderweb";

/// Numbers of a CSV file: by column name, one per line.
using Table = std::map<std::string, std::vector<double>>;

Table ReadCsv(const std::string& path) {
  std::istringstream text(ReadText(path));
  std::vector<std::string> names;
  Table table;
  for (std::string line; std::getline(text, line);) {
    std::istringstream cells(line);
    size_t column = 0;
    const bool is_header = names.empty();
    for (std::string cell; std::getline(cells, cell, ','); ++column) {
      if (is_header) {
        names.push_back(cell);
      } else {
        table[names.at(column)].push_back(std::stod(cell));
      }
    }
  }
  return table;
}

Table CsvOf(const std::string& scene, uint64_t frames, uint64_t every) {
  const Folder folder;
  const Outcome outcome = RunScene(scene, {"--frames", std::to_string(frames), "--every",
                                           std::to_string(every), "--csv", folder / "out.csv"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  return ReadCsv(folder / "out.csv");
}

TEST(RunTest, SceneOfTheDocumentationRuns) {
  const std::string page = ReadText(VESPER_DOCS "/vesper-command.md");
  const std::string fence = "```scene\n";
  const size_t begin = page.find(fence) + fence.size();
  ASSERT_GT(begin, fence.size());
  const Folder folder;
  const Outcome outcome = RunScene(
      folder.Write("s.vesper", page.substr(begin, page.find("```", begin) - begin)),
      {"--frames", "2", "--every", "2", "--csv", folder / "s.csv", "--png", folder / "%d.png"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("2 frames, 20 steps, t = 0.02 s"), std::string::npos)
      << outcome.output;
  EXPECT_EQ(ReadCsv(folder / "s.csv").at("velocity.y").size(), 6u);
  EXPECT_GT(ReadText(folder / "2.png").size(), 0u);
}

// Semi-implicit Euler: y(n) = n v dt - n (n + 1)/2 g dt^2.
TEST(RunTest, ProjectilesFollowTheClosedFormOfTheScheme) {
  const Table t = CsvOf(kScenes + "/projectile.vesper", 200, 50);
  ASSERT_EQ(t.at("frame").size(), 5u * 3);
  for (size_t i = 0; i < t.at("frame").size(); ++i) {
    const double n = t.at("frame")[i] * 10, dt = 1e-3;
    const double angle = (30 + 15 * t.at("row")[i]) * M_PI / 180;
    EXPECT_NEAR(t.at("time")[i], n * dt, 1e-12);
    EXPECT_NEAR(t.at("position.x")[i], 20 * std::cos(angle) * n * dt, 1e-9);
    EXPECT_NEAR(t.at("position.y")[i],
                20 * std::sin(angle) * n * dt - 9.81 * n * (n + 1) / 2 * dt * dt, 1e-9);
    EXPECT_EQ(t.at("position.z")[i], 0);
  }
}

TEST(RunTest, OrbitKeepsMomentumAndTheSpringsPlane) {
  const Table t = CsvOf(kScenes + "/spring-orbit.vesper", 600, 60);
  const auto &vx = t.at("velocity.x"), &vy = t.at("velocity.y");
  ASSERT_EQ(vx.size(), 11u * 2);
  for (size_t i = 0; i < vx.size(); i += 2) {
    EXPECT_NEAR(1000 * vx[i] + vx[i + 1], 0, 1e-8);
    EXPECT_NEAR(1000 * vy[i] + vy[i + 1], 3000, 1e-8);
    EXPECT_EQ(t.at("position.z")[i + 1], 0);
  }
  EXPECT_GT(std::abs(vx.back()), 1);  // the light one does move
}

TEST(RunTest, WebHangsFromItsRimAndKeepsItsMirrorSymmetry) {
  std::string text = ReadText(kSpiderweb + "/spiderweb.vesper");
  const std::string pulled = "at 0: position (0.5 ";
  const size_t at = text.find(pulled);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, pulled.size(), "at 0: position (0 ");
  const Folder folder;
  const Table t = CsvOf(folder.Write("s.vesper", text), 240, 240);
  const auto &x = t.at("position.x"), &y = t.at("position.y");
  const size_t rows = 129, end = rows;  // the second of two frames
  ASSERT_EQ(x.size(), 2 * rows);
  for (size_t i = 113; i < rows; ++i) {
    EXPECT_EQ(x[end + i], x[i]);
    EXPECT_EQ(y[end + i], y[i]);
  }
  EXPECT_LT(y[end], -0.003);
  EXPECT_NEAR(x[end], 0, 1e-9);  // both sides pull equally
}

// Another test compares the same numbers with world.yaml, which REVE runs.
TEST(RunTest, SpiderIsWhereTheWorldOfTheSameNamePutsIt) {
  const auto expected = nlohmann::json::parse(ReadText(kSpiderweb + "/expected.json"));
  const uint64_t frames = 60 * expected.at("seconds").get<uint64_t>();
  const Table t = CsvOf(kSpiderweb + "/spiderweb.vesper", frames, frames);
  const auto spider = expected.at("positions").at(0);
  ASSERT_EQ(spider.at("item"), "spider");
  for (const int axis : {0, 1, 2}) {
    EXPECT_NEAR(t.at(std::string("position.") + "xyz"[axis]).at(129), spider.at("at").at(axis),
                spider.at("within"));
  }
}

TEST(RunTest, SameBitsForAnyNumberOfThreadsAndInValidateMode) {
  const auto hash = [](const std::vector<std::string>& options) {
    std::vector<std::string> all{"--frames", "30", "--json"};
    all.insert(all.end(), options.begin(), options.end());
    const Outcome outcome = RunScene(kSpiderweb + "/spiderweb.vesper", all);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return nlohmann::json::parse(outcome.output).at("stateHash").get<std::string>();
  };
  const std::string one = hash({});
  EXPECT_EQ(hash({"--threads", "2"}), one);
  EXPECT_EQ(hash({"--threads", "8"}), one);
  EXPECT_EQ(hash({"--validate"}), one);
}

TEST(RunTest, JsonSaysWhatWasDone) {
  const Outcome outcome = RunScene(kScenes + "/projectile.vesper", {"--frames", "7", "--json"});
  const auto report = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(report.at("frames"), 7);
  EXPECT_EQ(report.at("steps"), 70);
  EXPECT_NEAR(report.at("time").get<double>(), 0.07, 1e-15);
  ASSERT_EQ(report.at("laws").size(), 2u);
  EXPECT_EQ(report.at("laws")[0].at("law"), "gravity_field");
  EXPECT_EQ(report.at("laws")[0].at("calls"), 70);
}

TEST(RunTest, LedgerFindsTheLawThatBreaksMomentum) {
  const Folder folder;
  const std::string scene = folder.Write("s.vesper",
                                         "scene 1\n"
                                         "dt 1/100\n"
                                         "law hooke_spring\n"
                                         "law broken_momentum\n"
                                         "law newton_motion\n"
                                         "rows body 2\n"
                                         "mass all 1\n"
                                         "position (0 0 0) (1 0 0)\n"
                                         "velocity all (0 1 0)\n"
                                         "rows spring 1\n"
                                         "endpoints (0 1)\n"
                                         "length 0.5\n"
                                         "hookeConstant 10\n");
  const Outcome outcome = RunScene(scene, {"--laws", TESTED_LAWS, "--ledger", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto ledger = nlohmann::json::parse(outcome.output).at("ledger");
  ASSERT_EQ(ledger.size(), 4u);
  EXPECT_EQ(ledger[3].at("line"), "total");
  for (const auto& line : ledger) {
    const double momentum = std::abs(line.at("momentum")[0].get<double>()) +
                            std::abs(line.at("momentum")[1].get<double>()) +
                            std::abs(line.at("momentum")[2].get<double>());
    const bool wrong = line.value("law", "") == "broken" || line.value("line", "") == "total";
    EXPECT_EQ(momentum > 1e-9, wrong) << line;
  }
  const Outcome table = RunScene(scene, {"--laws", TESTED_LAWS, "--ledger"});
  std::istringstream lines(table.output.substr(table.output.find("\n  ledger ")));
  std::string marked;
  for (std::string line; std::getline(lines, line);) {
    const size_t momentum_ends = line.find(')');
    if (momentum_ends != std::string::npos && line.compare(momentum_ends, 3, ") *") == 0) {
      marked += line.substr(2, line.find(' ', 2) - 2);
    }
  }
  EXPECT_EQ(marked, "broken") << table.output;
}

/// Returns the block of code of a page that begins with these words.
std::string BlockOf(const std::string& page, const std::string& first_words) {
  const size_t begin = page.find("```\n" + first_words) + 4;
  return page.substr(begin, page.find("```", begin) - begin);
}

TEST(RunTest, TableOfThePageOnTheLedgerIsWhatItsSceneGives) {
  const std::string page = ReadText(VESPER_DOCS "/ledger.md");
  const Folder folder;
  const std::string scene = folder.Write("pendulum.vesper", BlockOf(page, "scene 1"));
  const Outcome outcome = RunScene(scene, {"--frames", "100", "--ledger"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.output.substr(outcome.output.find("  ledger ")), BlockOf(page, "  ledger "));
}

TEST(RunTest, WrongUsageEndsWith2) {
  EXPECT_EQ(RunVesper({}).exit_code, 2);
  EXPECT_EQ(RunVesper({"run"}).exit_code, 2);
  EXPECT_EQ(RunVesper({"run", "x", "--every", "0"}).exit_code, 2);
  EXPECT_EQ(RunVesper({"fly"}).exit_code, 2);
  EXPECT_EQ(RunVesper({"run", "--help"}).exit_code, 0);
}

TEST(RunTest, InvalidSceneEndsWith3AndNamesThePlace) {
  const Folder folder;
  const std::string scene = folder.Write("s.vesper", "scene 1\ndt 1\nrows bodi 1\n");
  const Outcome outcome = RunScene(scene, {});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(outcome.errors, "vesper: " + scene + ":3:6: 'bodi' is no kind; did you mean 'body'?\n");
}

TEST(RunTest, TextOfASceneCannotCommandTheTerminal) {
  const Folder folder;
  const std::string scene = folder.Write("s.vesper", "scene 1\ndt 1\nrows \"\x1b[2J\u202e\" 1\n");
  const Outcome outcome = RunScene(scene, {});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_NE(outcome.errors.find(":3:6: '\\u{1b}[2J\\u{202e}' is no kind"), std::string::npos)
      << outcome.errors;
}

TEST(RunTest, MissingSceneEndsWith3) {
  const Outcome outcome = RunScene("nowhere.vesper", {});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(outcome.errors, "vesper: nowhere.vesper: No such file or directory\n");
}

TEST(RunTest, UnknownLawEndsWith4AtItsLine) {
  const Folder folder;
  const std::string scene = folder.Write("s.vesper", "scene 1\ndt 1\nlaw newton_motoin\n");
  const Outcome outcome = RunScene(scene, {});
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_NE(outcome.errors.find(scene + ":3:5: newton_motoin: "), std::string::npos)
      << outcome.errors;
}

TEST(RunTest, LibraryThatASceneNamesByItsPathIsOpenedOnlyWithTrust) {
  const Folder folder;
  std::filesystem::copy(TESTED_LAWS "/libvesper_law_broken_crash.so", folder / "own.so");
  const std::string scene = folder.Write(
      "s.vesper", "scene 1\ndt 1\nlaw ./own.so\nrows body 1\nmass 1\nposition (0 0 0)\n");
  const Outcome refused = RunScene(scene, {});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_EQ(refused.output, "");
  EXPECT_NE(refused.errors.find(scene + ":3:5: './own.so' is a path; "), std::string::npos)
      << refused.errors;
  EXPECT_NE(refused.errors.find("--trust"), std::string::npos) << refused.errors;
  const Outcome trusted = RunScene(scene, {"--trust", "--frames", "0", "--json"});
  EXPECT_EQ(trusted.exit_code, 0) << trusted.errors;
  EXPECT_EQ(nlohmann::json::parse(trusted.output).at("laws")[0].at("library"), "broken_crash");
}

TEST(RunTest, FileOutsideTheFolderOfASceneIsReadOnlyWithTrust) {
  const Folder folder;
  std::filesystem::create_directory(folder / "scene");
  folder.Write("secret.csv", "hunter2\n");
  const std::string scene =
      folder.Write("scene/s.vesper", "scene 1\ndt 1\nrows body from ../secret.csv\n");
  const Outcome refused = RunScene(scene, {});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_NE(refused.errors.find(scene + ":3:16: '../secret.csv' is a path with '..'; "),
            std::string::npos)
      << refused.errors;
  EXPECT_EQ(refused.errors.find("hunter2"), std::string::npos) << refused.errors;
  const Outcome trusted = RunScene(scene, {"--trust"});
  EXPECT_EQ(trusted.exit_code, 3);
  EXPECT_NE(trusted.errors.find("'hunter2' is no property of body"), std::string::npos)
      << trusted.errors;
}

TEST(RunTest, SceneWithoutAPropertyThatALawNeedsEndsWith3AndNamesIt) {
  const Folder folder;
  const Outcome outcome = RunScene(
      folder.Write("s.vesper", "scene 1\ndt 1\nlaw newton_motion\nrows body 1\nmass 1\n"), {});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_NE(outcome.errors.find("velocity"), std::string::npos) << outcome.errors;
}

TEST(RunTest, ReferenceOutOfRangeIsRefusedAtItsLine) {
  const Folder folder;
  const std::string scene = folder.Write(
      "s.vesper",
      "scene 1\ndt 1\nlaw hooke_spring\nrows body 1\nposition all (0 0 0)\nvelocity all (0 0 0)\n"
      "rows spring 1\nendpoints (0 1)\nlength 1\nhookeConstant 1\n");
  const Outcome outcome = RunScene(scene, {});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_NE(outcome.errors.find(scene + ":8:1: "), std::string::npos) << outcome.errors;
}

TEST(RunTest, ValueBelowItsMinimumIsRefusedAtItsLine) {
  const Folder folder;
  const std::string scene = folder.Write("s.vesper",
                                         "scene 1\ndt 1\nlaw newton_motion\nrows body 2\n"
                                         "mass 1 -2\nposition all (0 0 0)\nvelocity all (0 0 0)\n");
  const Outcome outcome = RunScene(scene, {});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_NE(outcome.errors.find(":5:1: INVALID_ARGUMENT: property mass, row 1: is -2, expected "
                                "0 or more [kg]"),
            std::string::npos)
      << outcome.errors;
}

TEST(RunTest, LawThatBreaksDownEndsWith1AndNamesFrameLawAndProperty) {
  const Folder folder;
  const Outcome outcome =
      RunScene(folder.Write("s.vesper",
                            "scene 1\ndt 1\nlaw gravity_field\nlaw newton_motion\nrows world 1\n"
                            "gravity (0 1e308 0)\nrows body 1\nmass 1\n"
                            "position (0 0 0)\nvelocity (0 0 0)\n"),
               {});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.errors.find(": frame 2: LAW_MISBEHAVED: "), std::string::npos)
      << outcome.errors;
  EXPECT_NE(outcome.errors.find("newton_motion"), std::string::npos) << outcome.errors;
}

TEST(RunTest, LawThatBreaksDownOnADeviceIsNamedByTheReportThatAsksForItsValues) {
  const Folder folder;
  const std::string scene = folder.Write(
      "s.vesper",
      "scene 1\ndt 1\nlaw opencl_nbody\nrows world 1\ngravitationalConstant 1\nrows body 2\n"
      "mass 1e200 1e200\nposition (0 0 0) (1 0 0)\nvelocity all (0 0 0)\n");
  const Outcome outcome = RunScene(scene, {"--frames", "3"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(
      outcome.errors.find(scene + ": frame 3: LAW_MISBEHAVED: law opencl_gravitation: property "
                                  "externalForce, row 0"),
      std::string::npos)
      << outcome.errors;
}

TEST(RunTest, CsvOfTwoKindsIsRefused) {
  const Folder folder;
  const Outcome outcome =
      RunScene(folder.Write("s.vesper",
                            "scene 1\ndt 1\nrows body 1\nmass 1\nrows spring 1\nlength 1\n"
                            "csv mass length\n"),
               {"--csv", folder / "x.csv"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_NE(outcome.errors.find("properties of body and of spring"), std::string::npos);
}

TEST(RunTest, CsvReplacesNoOtherFile) {
  const Folder folder;
  const std::string other = folder.Write("store.db", "SQLite format 3");
  const Outcome outcome = RunScene(kScenes + "/projectile.vesper", {"--csv", other});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.errors.find("store.db: exists, and this command has not written it"),
            std::string::npos)
      << outcome.errors;
  EXPECT_EQ(ReadText(other), "SQLite format 3");
}

TEST(RunTest, CsvThatCannotBeWrittenEndsWith1) {
  const Outcome outcome =
      RunScene(kScenes + "/projectile.vesper", {"--csv", "/nowhere/at/all.csv"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.errors, "vesper: /nowhere/at/all.csv: cannot be written\n");
}

TEST(RunTest, SigtermEndsARunInTheMiddleOfALongFrame) {
  const Folder folder;
  const std::string scene =
      folder.Write("s.vesper",
                   "scene 1\ndt 1e-9\nsteps 1000000000\nlaw newton_motion\nrows body 1\nmass 1\n"
                   "position (0 0 0)\nvelocity (0 0 0)\n");
  // The signal must arrive when the frame has begun, which may take long on a busy machine.
  Outcome outcome;
  bool cut = false;
  for (const char* seconds : {"1", "5", "30", "60"}) {
    outcome =
        RunProgram("/usr/bin/timeout", {"--preserve-status", "--kill-after=600", seconds,
                                        VESPER_COMMAND, "run", scene, "--laws", VESPER_LAW_PATH});
    cut = outcome.errors.find("cut short in the middle of a frame") != std::string::npos;
    if (outcome.exit_code == 143 && cut) break;
  }
  EXPECT_EQ(outcome.exit_code, 143) << outcome.errors;
  EXPECT_TRUE(cut) << outcome.errors;
}

}  // namespace
}  // namespace vesper
