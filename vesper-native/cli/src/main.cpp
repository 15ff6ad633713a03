// SPDX-License-Identifier: Apache-2.0
// vesper: the command line of the engine.
#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <string>

#include "exit_code.hpp"
#include "folders.hpp"
#include "law_command.hpp"
#include "law_runs.hpp"
#include "laws_command.hpp"
#include "new_law_command.hpp"
#include "run_command.hpp"
#include "test_command.hpp"
#include "vesper/vesper.hpp"
#include "visible.hpp"

namespace {

using namespace vesper::cli;

constexpr auto kFooter =
    "Results go to standard output, messages to standard error.\n"
    "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 invalid scene, 4 a law or the renderer "
    "could not be loaded.";

void AddRun(CLI::App& app, int& code) {
  auto* command = app.add_subcommand("run", "Applies the laws of a scene, frame by frame.");
  auto options = std::make_shared<RunOptions>();
  options->law_folders = DefaultLawFolders();
  command->add_option("SCENE", options->scene, "The scene's file")->required();
  command->add_option("--frames", options->frames, "Frames to run")->capture_default_str();
  command->add_option("--every", options->every, "Interval of written frames")
      ->check(CLI::Range(uint64_t{1}, UINT64_MAX))
      ->capture_default_str();
  command->add_option("--csv", options->csv, "Write properties to this file, frame 0 first");
  command
      ->add_option_function<std::string>(
          "--png",
          [options](const std::string& pattern) {
            try {
              options->png.emplace(pattern);
            } catch (const std::invalid_argument& error) {
              throw CLI::ValidationError("--png", error.what());
            }
          },
          "Draw pictures into files with the frame's number, such as frame-%04d.png")
      ->type_name("PATTERN");
  command->add_option("--laws", options->law_folders, "Folder with law libraries; may be repeated")
      ->capture_default_str();
  command->add_option("--threads", options->threads, "Threads")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_flag("--validate", options->validate, "Check laws against their declarations");
  command->add_flag("--ledger", options->ledger,
                    "Report how much each law changed momentum, angular momentum and energy");
  command->add_flag("--trust", options->trusted,
                    "Let the scene open law libraries by path, and read files outside its folder");
  command->add_flag("--json", options->json, "Print the report as one JSON document");
  command->callback([options, &code] { code = Run(*options); });
}

void AddLaws(CLI::App& app, int& code) {
  auto* command = app.add_subcommand(
      "laws", "Lists the laws in folders: versions, properties, units, access, parameters.");
  auto options = std::make_shared<LawsOptions>();
  options->folders = DefaultLawFolders();
  command->add_option("FOLDER", options->folders, "Folders with law libraries")
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print the list as one JSON document");
  command->callback([options, &code] { code = ListLaws(*options); });
}

void AddTest(CLI::App& app, int& code) {
  auto* command = app.add_subcommand(
      "test", "Checks laws, compiled, as text or in Python, against the rules and their claims.");
  auto options = std::make_shared<TestOptions>();
  command->add_option("FILE", options->libraries, "Files of laws: .so, .law or .py")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--only", options->only, "Run only these checks, such as threads,rows")
      ->type_name("CHECK,...")
      ->delimiter(',')
      ->check(CLI::IsMember(CheckNames()));
  command->add_option("--python", options->python, "Virtual environment of laws in Python")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  command
      ->add_option("--prototype", options->prototype,
                   "Prototype file with the properties of the world that the laws use")
      ->type_name("FILE")
      ->check(CLI::ExistingFile);
  command->add_flag("--json", options->json, "Print the report as one JSON document");
  command->callback([options, &code] { code = TestLaws(*options); });
}

/// Adds a command on the file of a law as text.
CLI::App* AddLawCommand(CLI::App& law, const char* name, const char* purpose,
                        const std::shared_ptr<LawOptions>& options) {
  auto* command = law.add_subcommand(name, purpose);
  command->add_option("FILE", options->file, "The law's file, such as wind.law")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--prototype", options->prototype, "Properties to check it against")
      ->check(CLI::IsMember({"si-f64", "si-f32"}))
      ->capture_default_str();
  return command;
}

void AddLawRun(CLI::App& law, int& code) {
  auto* command = law.add_subcommand(
      "run", "Runs a small scene with a law, and prints how energy and momentum change.");
  auto options = std::make_shared<LawRunOptions>();
  command->add_option("FILE", options->file, "The law's file, such as wind.law")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--parameter", options->parameters, "NAME=VALUE in SI units; may be repeated")
      ->type_name("NAME=VALUE");
  command
      ->add_option("--set", options->properties,
                   "Value of a property, also of the law's own; may be repeated")
      ->type_name("NAME=VALUE");
  command->add_option("--seconds", options->seconds, "Time to run [s]")
      ->check(CLI::Range(1e-6, 1e6))
      ->capture_default_str();
  command->add_option("--dt", options->dt, "Length of a step [s]")
      ->check(CLI::Range(1e-9, 10.0))
      ->capture_default_str();
  command->add_option("--bodies", options->bodies, "Bodies of the scene")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  command->add_option("--rows", options->rows, "Times at which energy and momentum are reported")
      ->check(CLI::Range(2, 10000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print the result as one JSON document");
  command->callback([options, &code] { code = RunLaw(*options); });
}

void AddLawPlot(CLI::App& law, int& code) {
  auto* command = law.add_subcommand(
      "plot", "Prints force and energy of a law over the distance, the speed or the place.");
  auto options = std::make_shared<LawPlotOptions>();
  command->add_option("FILE", options->file, "The law's file, such as wind.law")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--parameter", options->parameters, "NAME=VALUE in SI units; may be repeated")
      ->type_name("NAME=VALUE");
  command
      ->add_option("--set", options->properties,
                   "Value of a property, also of the law's own; may be repeated")
      ->type_name("NAME=VALUE");
  command->add_option("--over", options->over, "Default: what the force depends on")
      ->check(CLI::IsMember({"distance", "speed", "place"}));
  command->add_option("--from", options->from, "First value [m or m/s]");
  command->add_option("--to", options->to, "Last value [m or m/s]");
  command->add_option("--points", options->points, "Number of values")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print all values as one JSON document");
  command->callback([options, &code] { code = PlotLaw(*options); });
}

void AddLaw(CLI::App& app, int& code) {
  auto* law = app.add_subcommand("law", "Works on laws as text.");
  law->require_subcommand(1);
  auto options = std::make_shared<LawOptions>();
  AddLawRun(*law, code);
  AddLawPlot(*law, code);
  auto* to_cpp = AddLawCommand(
      *law, "to-cpp", "Writes a law as text as a C++ law that gives the same results.", options);
  to_cpp->add_option("--output", options->output, "File for the source; default: standard output");
  to_cpp->callback([options, &code] { code = LawToCpp(*options); });
  auto* check =
      AddLawCommand(*law, "check", "Checks a law as text: names, units, grammar.", options);
  check->add_flag("--json", options->json, "Print the result as one JSON document");
  check->callback([options, &code] { code = CheckLaw(*options); });
}

void AddNewLaw(CLI::App& app, int& code) {
  auto* command =
      app.add_subcommand("new-law", "Writes a folder with a law that builds and passes its tests.");
  auto options = std::make_shared<NewLawOptions>();
  command->add_option("NAME", options->name, "Name of the law, in snake_case")->required();
  command->add_option("--dir", options->folder, "Parent of the new folder NAME")
      ->capture_default_str();
  command->callback([options, &code] { code = WriteNewLaw(*options); });
}

/// Returns the exit code of a command that has printed its results. Returns another code if the
/// output was lost.
int CodeAfterPrinting(int code) {
  errno = 0;
  std::cout.flush();
  const bool printed = std::fflush(stdout) == 0 && std::cout.good();
  if (printed) {
    return code;
  }
  std::cerr << "vesper: standard output could not be written"
            << (errno == 0 ? "" : std::string(": ") + std::strerror(errno))
            << "; results are lost\n";
  return code == kDone ? kFailed : code;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("The Vesper physics engine on the command line.", "vesper");
  app.footer(kFooter);
  app.require_subcommand(1);
  app.set_version_flag("--version", vesper_build_info());
  int code = kDone;
  AddRun(app, code);
  AddLaws(app, code);
  AddTest(app, code);
  AddLaw(app, code);
  AddNewLaw(app, code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return CodeAfterPrinting(app.exit(error) == 0 ? kDone : kWrongUsage);
  } catch (const std::exception& error) {
    std::cerr << "vesper: " << Visible(error.what()) << "\n";
    return kFailed;
  }
  return CodeAfterPrinting(code);
}
