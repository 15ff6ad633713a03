// SPDX-License-Identifier: Apache-2.0
// `vesper test`: good laws pass, and for each promise there is a law that breaks it and fails.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace vesper {
namespace {

std::string TestedLaw(const std::string& name) {
  return std::string(TESTED_LAWS) + "/libvesper_law_" + name + ".so";
}

std::string BrokenLaw(const std::string& fault) { return TestedLaw("broken_" + fault); }

/// Returns the notes of all checks with that verdict. A key is "check" or "check f64".
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
                      Fault{"energy_step", "energy f64", "but the energy changes by "},
                      Fault{"no_energy", "energy f64", "but the energy changes by "},
                      Fault{"leak", "reload f64", "leaves open files"},
                      Fault{"repeat", "repeat f64", "has other bits in a second run"},
                      Fault{"rollback", "rollback f32", "has other bits after a rollback"},
                      Fault{"mass_0", "mass-0 f64", "with bodies of mass 0"},
                      Fault{"output", "output f64", "writes to standard error: 'a line'"},
                      Fault{"coincident", "coincident f64", "with two bodies at one place: "},
                      Fault{"rounding", "modes f32", "Advance leaves another rounding mode"},
                      Fault{"grows", "memory f64", "bytes more in each step"},
                      Fault{"impulse", "step-length f64",
                            "in a step of dt / 2; the engine multiplies forces by dt"},
                      Fault{"misspelt", "names f64", "did you mean 'charge'?"},
                      Fault{"moves_all", "mass-0 f64", "moves the body of mass 0 in row 0"},
                      Fault{"motion", "convergence f64", "expected at least order 1"}));

/// The text of a law in Python that adds forces; `body` is the lines of its function.
std::string PythonLaw(const std::string& body, const std::string& before = "",
                      const std::string& claims = "") {
  return "import numpy\nimport vesper\n" + before + "\n@vesper.law(phase=\"force\", claims=(" +
         claims +
         "))\ndef wrong(\n"
         "    position: vesper.Read(\"body\", \"m\"),\n"
         "    velocity: vesper.Read(\"body\", \"m/s\"),\n"
         "    mass: vesper.Read(\"body\", \"kg\"),\n"
         "    force: vesper.Accumulate(\"body\", \"N\"),\n"
         "):\n    \"Breaks one promise.\"\n    " +
         body + "\n";
}

struct PythonFault {
  const char* name;
  std::string text;
  const char* check;  // that fails, in both precisions
  const char* note;   // part of its reason
};
void PrintTo(const PythonFault& fault, std::ostream* out) { *out << fault.name; }

class PythonKitFaultTest : public ::testing::TestWithParam<PythonFault> {};

TEST_P(PythonKitFaultTest, LawInPythonThatBreaksAPromiseFailsItsCheck) {
  const auto& [name, text, check, note] = GetParam();
  const Folder folder;
  const Outcome outcome =
      RunVesper({"test", folder.Write("wrong.py", text), "--only", check, "--json"});
  EXPECT_EQ(outcome.exit_code, 1) << outcome.errors;
  const auto report = nlohmann::json::parse(outcome.output);
  const auto failed = Verdicts(report, "FAIL");
  const std::string first = failed.empty() ? "" : failed.begin()->first;
  ASSERT_EQ(first.substr(0, std::string(check).size()), check) << outcome.output;
  for (const auto& [_, reason] : failed) {
    EXPECT_NE(reason.find(note), std::string::npos) << reason;
  }
}

std::string NameOfFault(const ::testing::TestParamInfo<PythonFault>& info) {
  return info.param.name;
}

const PythonFault kPythonFaults[] = {
    {"ReadColumn", PythonLaw("mass[:] = 1"), "guard-pages",
     "on 0 rows, wrong: wrong.py:12: ValueError: assignment destination is read-only"},
    {"ReadColumnByAddress",
     PythonLaw("ctypes.memset(mass.ctypes.data, 1, mass.nbytes)", "import ctypes\n"), "guard-pages",
     "writes to 'mass', which it declares as READ"},
    {"BehindTheLastRow",
     PythonLaw("ctypes.memset(force.ctypes.data, 0, force.nbytes + 8)", "import ctypes\n"),
     "guard-pages", "behind the last row of 'externalForce'"},
    {"OneRow", PythonLaw("force[0] += 1"), "rows", "on 0 rows: "},
    {"Random", PythonLaw("force += numpy.random.random(force.shape)"), "repeat",
     "'externalForce' has other bits in a second run of the same world"},
    {"Clock", PythonLaw("force += time.perf_counter_ns() % 2 ** 20", "import time\n"), "repeat",
     "'externalForce' has other bits"},
    {"Global", PythonLaw("global calls; calls += 1; force += calls", "calls = 0\n"), "rollback",
     "'externalForce' has other bits after a rollback by 3 steps"},
    {"ListOfTheModule", PythonLaw("kept.append(1); force += len(kept)", "kept = []\n"), "rollback",
     "SCRATCH memory"},
    {"DivisionByMass", PythonLaw("force += 1 / mass[:, None]"), "mass-0",
     "with bodies of mass 0: "},
    {"Print", PythonLaw("print('row', len(mass))"), "output",
     "writes to standard output: 'row 101'"},
    {"PrintWhenOpened", PythonLaw("force += 0", "print('hello')\n"), "output",
     "writes to standard output: 'hello'"},
    {"Warning", PythonLaw("numpy.log(-mass)"), "output", "writes to standard error: "},
    {"NotANumber", PythonLaw("force += numpy.nan_to_num(position)"), "not-a-number",
     "NaN in 'position' changes 'externalForce' without an error"},
    {"Momentum", PythonLaw("force += mass[:, None]", "", "\"momentum\""), "momentum",
     "forces sum to "},
    {"Translation", PythonLaw("force += position", "", "\"translation\""), "translation",
     "'externalForce' differs in row 0"},
    {"Rotation", PythonLaw("force += mass[:, None] * (1, 0, 0)", "", "\"rotation\""), "rotation",
     "'externalForce' differs in row 0"},
    {"Thread",
     PythonLaw("threading.Thread(target=time.sleep, args=(9,), daemon=True).start()",
               "import threading, time\n"),
     "reload", "leaves threads"},
    {"File", PythonLaw("kept.append(open('/dev/null'))", "kept = []\n"), "reload",
     "leaves open files"},
    {"NoDocumentation",
     "import vesper\n@vesper.law(phase='force')\ndef wrong(force: vesper.Accumulate('body', "
     "'N')):\n    force += 1\n",
     "table", "'wrong' has no doc"},
    {"OtherName",
     "import vesper\n@vesper.law(phase='force')\ndef right(force: vesper.Accumulate('body', "
     "'N')):\n    'Pushes.'\n    force += 1\n",
     "table", "calls itself 'right'; expected the name in its file's, right.py"},
    {"End", PythonLaw("os._exit(7)", "import os\n"), "rows",
     "the law ended the process with exit code 7"},
    {"Crash", PythonLaw("ctypes.memset(8, 0, 8)", "import ctypes\n"), "rows",
     "the law crashed: Segmentation fault"},
};

INSTANTIATE_TEST_SUITE_P(Faults, PythonKitFaultTest, ::testing::ValuesIn(kPythonFaults),
                         NameOfFault);

TEST(PythonKitTest, GoodLawsPassEveryCheckThatAppliesToThem) {
  const Outcome outcome =
      RunVesper({"test", std::string(LAW_SOURCES) + "/python/good.py", "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output << outcome.errors;
  const auto report = nlohmann::json::parse(outcome.output);
  const auto passed = Verdicts(report, "PASS");
  for (const char* check : {"table", "precisions", "guard-pages f32", "rows f64", "reload f32",
                            "threads f64", "repeat f64", "rollback f32", "mass-0 f64", "output f64",
                            "parameters f64", "not-a-number f32", "convergence f64", "time f64"}) {
    EXPECT_TRUE(passed.contains(check)) << check << outcome.output;
  }
  EXPECT_EQ(Verdicts(report, "skip").at("exports"), "is not a shared object");
}

struct TextFault {
  const char* name;
  std::string text;   // of wrong.law
  const char* check;  // that fails, in both precisions
  const char* note;   // part of its reason
};
void PrintTo(const TextFault& fault, std::ostream* out) { *out << fault.name; }

class TextKitFaultTest : public ::testing::TestWithParam<TextFault> {};

TEST_P(TextKitFaultTest, TextThatBreaksAPromiseFailsItsCheck) {
  const auto& [name, text, check, note] = GetParam();
  const Folder folder;
  const Outcome outcome =
      RunVesper({"test", folder.Write("wrong.law", text), "--only", check, "--json"});
  EXPECT_EQ(outcome.exit_code, 1) << outcome.errors << outcome.output;
  const auto failed = Verdicts(nlohmann::json::parse(outcome.output), "FAIL");
  ASSERT_FALSE(failed.empty());
  for (const auto& [which, reason] : failed) {
    EXPECT_TRUE(which.starts_with(check)) << which;
    EXPECT_NE(reason.find(note), std::string::npos) << reason;
  }
}

// A text cannot break the other promises: its claims follow from its formulas, and it accesses
// nothing but its columns.
const TextFault kTextFaults[] = {
    {"OtherName", "law right\n  each body:\n    force -= 1 kg/s velocity\n", "table",
     "calls itself 'right'; expected the name in its file's"},
    {"DivisionByMass", "law wrong\n  each body:\n    force.x += 1 N * (1 kg / mass)\n", "mass-0",
     "wrong.law:3:22: '(1 kg / mass)' divides by zero for row 0 of body"},
    {"MovesMassZero",
     "law wrong\n  phase integrate\n  each body:\n"
     "    velocity += force / max(mass, 1 kg) * dt\n    position += velocity dt\n",
     "mass-0", "moves the body of mass 0 in row 0"},
    {"DivisionByDistance",
     "law wrong\n  each pair of bodies, r apart:\n    attraction = 1 N*m^2 / r^2\n", "coincident",
     "with two bodies at one place: "},
    {"Impulse", "law wrong\n  each body:\n    force -= 0.1 mass velocity / dt\n", "step-length",
     "in a step of dt / 2; the engine multiplies forces by dt"},
    {"Misspelt",
     "law wrong\n  each body may have chargge in C\n  each body:\n"
     "    force += chargge * (1, 0, 0) N/C\n",
     "names", "did you mean 'charge'?"},
    {"Comparison", "law wrong\n  each body:\n    force.y += 2 N if position.y > 0 m else 1 N\n",
     "not-a-number", "no NaN in any input is ever reported"},
    {"Integrator",
     "law wrong\n  phase integrate\n  each body:\n    if mass > 0:\n"
     "      velocity += 2 force / mass * dt\n      position += velocity dt\n",
     "convergence", "expected at least order 1"},
};

INSTANTIATE_TEST_SUITE_P(Faults, TextKitFaultTest, ::testing::ValuesIn(kTextFaults),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(TextKitTest, GoodTextsPassEveryCheckThatAppliesToThem) {
  const Folder folder;
  const Outcome outcome = RunVesper(
      {"test",
       folder.Write(
           "pull.law",
           "law pull \"A spring between all bodies, and a place that they remember.\"\n"
           "  parameter k = 2 N/m, from 0 to 100 N/m\n"
           "  each body has broken in m\n"  // joints have a column of this name
           "  each pair of bodies, r apart:\n    energy = 1/2 k r^2 a.mass b.mass / 1 kg^2\n"
           "  each body: broken = |position|\n"),
       "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output << outcome.errors;
  const auto report = nlohmann::json::parse(outcome.output);
  const auto passed = Verdicts(report, "PASS");
  for (const char* check : {"table",
                            "precisions",
                            "guard-pages f32",
                            "guard-pages f64",
                            "rows f64",
                            "reload f32",
                            "threads f64",
                            "repeat f64",
                            "rollback f32",
                            "mass-0 f64",
                            "output f64",
                            "coincident f64",
                            "modes f64",
                            "memory f64",
                            "names f64",
                            "parameters f64",
                            "not-a-number f32",
                            "momentum f64",
                            "angular-momentum f64",
                            "potential-energy f64",
                            "time f64"}) {
    EXPECT_TRUE(passed.contains(check)) << check << outcome.output;
  }
  EXPECT_EQ(Verdicts(report, "skip").at("exports"), "is not a shared object");
}

class SampleTextTest : public ::testing::TestWithParam<std::string> {};

TEST_P(SampleTextTest, PassesTheKit) {
  const Outcome outcome = RunVesper({"test", GetParam(), "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output << outcome.errors;
  const auto report = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(Verdicts(report, "FAIL"), (std::map<std::string, std::string>()));
  EXPECT_TRUE(Verdicts(report, "PASS").contains("guard-pages f64")) << outcome.output;
}

/// Returns the texts of the sample worlds.
std::vector<std::string> SampleTexts() {
  std::vector<std::string> texts;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(VESPER_WORLDS)) {
    if (entry.path().extension() == ".law") texts.push_back(entry.path());
  }
  std::ranges::sort(texts);
  return texts;
}

INSTANTIATE_TEST_SUITE_P(Worlds, SampleTextTest, ::testing::ValuesIn(SampleTexts()),
                         [](const auto& info) {
                           return std::filesystem::path(info.param).stem().string();
                         });

TEST(KitTest, LawThatUsesPropertiesOfAPrototypeFileIsTested) {
  const Folder folder;
  const std::string law = folder.Write("hot.py",
                                       "import vesper\n@vesper.law(phase='force')\n"
                                       "def hot(temperature: vesper.Read('body', 'K'),\n"
                                       "        velocity: vesper.Read('body', 'm/s'),\n"
                                       "        force: vesper.Accumulate('body', 'N')):\n"
                                       "  \"Drag that grows with the temperature.\"\n"
                                       "  force -= 0.001 * temperature[:, None] * velocity\n");
  const auto file = [&](const std::string& text) { return folder.Write("hot.prototype", text); };
  const Outcome unknown = RunVesper({"test", law});
  EXPECT_EQ(unknown.exit_code, 4);
  EXPECT_NE(unknown.errors.find("body has no property 'temperature'"), std::string::npos)
      << unknown.errors;
  for (const std::string base : {"si-f64", "si-f32"}) {
    const std::string text = "# of the test\nprototype hot extends " + base +
                             "\nbody temperature: real x1 [K] read_write min 0\n";
    const Outcome known =
        RunVesper({"test", law, "--prototype", file(text), "--only", "rows,rollback", "--json"});
    EXPECT_EQ(known.exit_code, 0) << known.errors << known.output;
    EXPECT_EQ(Verdicts(nlohmann::json::parse(known.output), "PASS").size(), 4) << known.output;
  }
  const Outcome wrong =
      RunVesper({"test", law, "--prototype",
                 file("prototype hot extends si-f64\nbody t: reel x1 [K] read\n")});
  EXPECT_EQ(wrong.exit_code, 3);
  EXPECT_NE(wrong.errors.find("hot.prototype:2:9: found 'reel'"), std::string::npos)
      << wrong.errors;
  const Outcome other =
      RunVesper({"test", law, "--prototype",
                 file("prototype hot\nreal f32\ntime [s]\ncar x: real x1 [m] read\n")});
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_NE(other.errors.find("expected a prototype that extends si-f64 or si-f32"),
            std::string::npos)
      << other.errors;
}

/// Makes a virtual environment as `python3 -m venv` does, with a package of one module.
std::string MakeEnvironment(const Folder& folder, const std::string& version) {
  const std::string environment = folder / "environment";
  const Outcome made = RunProgram(
      "/usr/bin/python3", {"-m", "venv", "--without-pip", "--system-site-packages", environment});
  EXPECT_EQ(made.exit_code, 0) << made.errors;
  const Outcome place =
      RunProgram(environment + "/bin/python3",
                 {"-c", "import sysconfig; print(sysconfig.get_path('purelib'), end='')"});
  const std::string info = place.output + "/stiffness-" + version + ".dist-info";
  std::filesystem::create_directories(info);
  std::ofstream(place.output + "/stiff.py") << "K = 2.0\n";
  std::ofstream(info + "/METADATA")
      << "Metadata-Version: 2.1\nName: stiffness\nVersion: " << version << "\n";
  std::ofstream(info + "/RECORD") << "stiff.py,,\n";
  return environment;
}

TEST(PythonKitTest, LawImportsThePackagesOfTheVirtualEnvironmentThatAnOptionNames) {
  const Folder folder;
  const std::string file =
      folder.Write("wrong.py", PythonLaw("force += stiff.K", "import stiff\n"));
  const std::string environment = MakeEnvironment(folder, "1.2");
  const Outcome with = RunVesper({"test", file, "--only", "rows", "--python", environment});
  EXPECT_EQ(with.exit_code, 0) << with.output << with.errors;
  const Outcome without = RunVesper({"test", file, "--only", "rows"});
  EXPECT_EQ(without.exit_code, 4);
  EXPECT_NE(without.errors.find("wrong.py:3: ModuleNotFoundError: No module named 'stiff'; used "
                                "/usr/bin/python3 (Python 3."),
            std::string::npos)
      << without.errors;
  EXPECT_NE(without.errors.find("--python DIR"), std::string::npos) << without.errors;
  const std::string other = folder.Write("wrong.py", PythonLaw("force += 1", "import stiffer\n"));
  const Outcome missing = RunVesper({"test", other, "--python", environment});
  EXPECT_EQ(missing.exit_code, 4);
  EXPECT_NE(missing.errors.find("used " + environment + "/bin/python3 (Python 3."),
            std::string::npos)
      << missing.errors;
  EXPECT_NE(missing.errors.find("-m pip install"), std::string::npos) << missing.errors;
  const Outcome none = RunVesper({"test", file, "--python", folder / "."});
  EXPECT_EQ(none.exit_code, 4);
  std::ofstream(folder / "pyvenv.cfg") << "home = /opt/other/bin\nversion = 3.11.9\n";
  const Outcome foreign = RunVesper({"test", file, "--python", folder / "."});
  EXPECT_EQ(foreign.exit_code, 4);
  EXPECT_NE(foreign.errors.find("is one of /opt/other/bin, expected "), std::string::npos)
      << foreign.errors;
  EXPECT_NE(none.errors.find("is no virtual environment, expected a virtual environment of "),
            std::string::npos)
      << none.errors;
}

/// Replaces Numba, which compiles a function for the types of its first arguments.
constexpr const char* kCompiler = R"(
def njit(function):
    compiled = set()

    def call(*arguments):
        types = tuple((a.dtype.char, a.ndim, a.flags.writeable) for a in arguments)
        if len(arguments[0]) == 1:
            compiled.add(types)
        elif types not in compiled:
            raise RuntimeError("compiled in a frame")
        return function(*arguments)

    return call
)";

TEST(PythonKitTest, LawOfNumbaIsCompiledBeforeItsFirstFrame) {
  const Folder folder;
  const std::string environment = MakeEnvironment(folder, "1.2");
  std::string packages;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(environment)) {
    if (entry.path().filename() == "stiff.py") packages = entry.path().parent_path();
  }
  std::ofstream(packages + "/numba.py") << kCompiler;
  const std::string kernel = "\n@numba.njit\ndef add(force, position):\n    force -= position\n";
  const std::string named =
      folder.Write("wrong.py", PythonLaw("add(force, position)", "import numba\n" + kernel));
  const std::vector<std::string> options{"--only", "repeat", "--python", environment};
  std::vector<std::string> arguments{"test", named};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const Outcome outcome = RunVesper(arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output << outcome.errors;
  // Without the import, nothing shows that the function must be compiled.
  folder.Write("wrong.py",
               PythonLaw("add(force, position)", "numba = __import__('numba')\n" + kernel));
  const Outcome hidden = RunVesper(arguments);
  EXPECT_NE(hidden.output.find("RuntimeError: compiled in a frame"), std::string::npos)
      << hidden.output;
}

TEST(PythonKitTest, LawThatCannotBeLoadedEndsWith4AndNamesItsLine) {
  const Folder folder;
  const std::string file = folder.Write("wrong.py", PythonLaw("force += 1") + "x = (\n");
  const Outcome outcome = RunVesper({"test", file});
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_NE(outcome.errors.find("wrong.py:13:"), std::string::npos) << outcome.errors;
  std::string other = PythonLaw("force += 1");
  other.replace(other.find("m/s"), 3, "N*s");
  const Outcome unit = RunVesper({"test", folder.Write("wrong.py", other), "--json"});
  EXPECT_EQ(unit.exit_code, 4);
  EXPECT_NE(unit.errors.find("wrong.py:7: the unit of 'velocity' is m/s, the annotation says N*s"),
            std::string::npos)
      << unit.errors;
}

TEST(KitTest, LawThatWritesWhatItMayOnlyReadIsCaughtByItsPage) {
  const Outcome outcome =
      RunVesper({"test", BrokenLaw("writes_read"), "--only", "guard-pages,rows", "--json"});
  EXPECT_EQ(outcome.exit_code, 1);
  const auto failed = Verdicts(nlohmann::json::parse(outcome.output), "FAIL");
  ASSERT_TRUE(failed.contains("guard-pages f64"));
  EXPECT_EQ(failed.at("guard-pages f64"),
            "on 1 rows, broken: writes to 'mass', which it declares as READ");
  EXPECT_TRUE(failed.contains("rows f64"));  // validate mode finds it, too
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
  const Outcome outcome = RunVesper({"test", BrokenLaw("crash"), "--only", "rows,speed"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.errors.find("speed not in {exports,imports,"), std::string::npos)
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
