// SPDX-License-Identifier: Apache-2.0
#include "run_command.hpp"

#include <unistd.h>

#include <cinttypes>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "csv.hpp"
#include "exit_code.hpp"
#include "folders.hpp"
#include "ledger_report.hpp"
#include "picture.hpp"
#include "scene.hpp"
#include "text_table.hpp"
#include "vesper/vesper.hpp"
#include "visible.hpp"

namespace vesper::cli {
namespace {

constexpr unsigned kFramePatience = 2;  // maximum time to end the current frame after a signal [s]
constexpr int kFirstSignal = 128;       // an exit code of this and more stands for a signal

volatile std::sig_atomic_t interrupted = 0;  // the signal, or 0

void OnSignal(int number) {
  interrupted = number;
  alarm(kFramePatience);
}

void OnAlarm(int) {
  constexpr char kMessage[] =
      "vesper: the run was cut short in the middle of a frame, which did not end within 2 s; files"
      " that it writes may be incomplete\n";
  const ssize_t written = write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
  static_cast<void>(written);
  _exit(kFirstSignal + interrupted);
}

/// Makes Ctrl-C and SIGTERM end the run after its current frame. The signals end the run in the
/// middle of this frame if the frame takes longer than kFramePatience.
void EndOnSignals() {
  struct sigaction action{};
  action.sa_handler = OnSignal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  action.sa_handler = OnAlarm;
  sigaction(SIGALRM, &action, nullptr);
}

std::string Join(const std::vector<std::string>& texts, char separator) {
  std::string joined;
  for (const std::string& text : texts) {
    if (!joined.empty()) joined += separator;
    joined += text;
  }
  return joined;
}

/// A law of a scene that could not be loaded, or that does not match its prototype.
class LawError : public SceneError {
  using SceneError::SceneError;
};

class SceneRun {
 public:
  SceneRun(Scene scene, const RunOptions& options)
      : scene_(std::move(scene)),
        options_(options),
        engine_(*scene_.prototype, {.threads = options.threads,
                                    .validate = options.validate,
                                    .law_path = Join(options.law_folders, ':'),
                                    .deferred = true,
                                    .log = [](uint32_t, const char* line) {
                                      std::cerr << "vesper: " << Visible(line) << "\n";
                                    }}) {
    AddSums();
    for (auto& [name, column] : scene_.columns) column.AddTo(engine_.PropertyProvider());
    for (const SceneLaw& law : scene_.laws) Load(law);
    if (options.ledger) engine_.SetLedger(true);
    if (!options.csv.empty() && !MayReplace(options.csv, "frame,time,row")) {
      throw FileError(options.csv + kNotReplaced);
    }
    if (!options.csv.empty()) csv_.emplace(options.csv, CsvColumns());
    if (options.png) pictures_.emplace(scene_, *options.png, ProgramFolder() + "/vesper-render");
  }

  void Advance() {
    Write(0);
    while (frame_ < options_.frames && interrupted == 0) {
      ++frame_;
      engine_.Advance(scene_.dt, scene_.steps);
      if (frame_ % options_.every == 0) Write(frame_);
    }
    if (csv_) csv_->Close();
  }

  /// Prints the cause of a failed frame. Returns the exit code for a failed law or for a faulty
  /// scene.
  int Explain(const Error& error) const {
    if (error.status() == VESPER_LAW_FAILED || error.status() == VESPER_LAW_MISBEHAVED) {
      return Fail(kFailed, scene_.file + ": frame " + std::to_string(frame_) + ": " + error.what());
    }
    const auto place = scene_.places.find(std::string(error.property()));
    return Fail(kInvalidScene, place == scene_.places.end()
                                   ? scene_.file + ": " + error.what()
                                   : SceneError(place->second, error.what()).what());
  }

  void Report() {
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016" PRIx64, engine_.StateHash());
    if (pictures_ && isatty(STDERR_FILENO) != 0) std::cerr << "\n";
    options_.json ? ReportJson(hash) : ReportText(hash);
  }

 private:
  /// Adds columns of zeros for the sums of forces, because scenes do not contain these columns.
  void AddSums() {
    const auto& prototype = *scene_.prototype;
    for (const auto& property : std::span(prototype.properties, prototype.property_count)) {
      const auto rows = scene_.rows.find(property.kind);
      if ((property.law_access & VESPER_ACCUMULATE) == 0 || rows == scene_.rows.end()) continue;
      scene_.columns.emplace(property.name, AnyColumn(property, rows->second));
    }
  }

  void Load(const SceneLaw& law) {
    try {
      libraries_.push_back(engine_.LoadPhysicsLaw(law.library, law.parameters));
    } catch (const Error& error) {
      throw LawError(law.place, law.library + ": " + error.what());
    }
  }

  std::vector<const AnyColumn*> CsvColumns() const {
    std::vector<std::string> names = scene_.csv;
    if (names.empty()) names = {"position"};
    std::vector<const AnyColumn*> columns;
    for (const std::string& name : names) {
      const AnyColumn* column = scene_.Find(name);
      if (column == nullptr) {
        throw std::runtime_error(scene_.file + ": no values for '" + name +
                                 "', which --csv would write; say what to write with 'csv NAME…'");
      }
      const std::string kind = column->descriptor().kind;
      columns.push_back(column);
      if (columns[0]->descriptor().kind != kind) {
        throw std::runtime_error(scene_.file + ": 'csv' names properties of " +
                                 columns[0]->descriptor().kind + " and of " + kind +
                                 "; expected one kind");
      }
    }
    return columns;
  }

  double Time(uint64_t frame) const {
    return static_cast<double>(frame * scene_.steps) * scene_.dt;
  }

  /// Writes a frame. Synchronizes only the columns that are written.
  void Write(uint64_t frame) {
    if (csv_) {
      std::vector<const char*> names;
      for (const AnyColumn* column : CsvColumns()) names.push_back(column->descriptor().name);
      engine_.Synchronize(names);
      csv_->WriteFrame(frame, Time(frame));
    }
    if (!pictures_) return;
    engine_.Synchronize();
    pictures_->WriteFrame(frame);
    ++picture_count_;
    if (isatty(STDERR_FILENO) != 0) {
      std::cerr << "\rframe " << frame << " of " << options_.frames << " is drawn" << std::flush;
    }
  }

  std::vector<vesper_law_info> Laws() const {
    std::vector<vesper_law_info> laws;
    for (const vesper_library_id library : libraries_) {
      const auto more = engine_.Laws(library);
      laws.insert(laws.end(), more.begin(), more.end());
    }
    return laws;
  }

  void ReportJson(const char* hash) {
    nlohmann::ordered_json report{{"scene", scene_.file},
                                  {"prototype", scene_.prototype->name},
                                  {"frames", frame_},
                                  {"steps", engine_.StepCount()},
                                  {"dt", scene_.dt},
                                  {"time", Time(frame_)},
                                  {"stateHash", hash},
                                  {"pictures", picture_count_},
                                  {"laws", nlohmann::ordered_json::array()}};
    for (const vesper_law_info& law : Laws()) {
      report["laws"].push_back({{"library", law.library},
                                {"law", law.name},
                                {"version", law.version},
                                {"calls", law.calls},
                                {"nanoseconds", law.nanoseconds}});
    }
    if (options_.ledger) report["ledger"] = LedgerJson(ReadLedger(engine_, Laws()));
    std::cout << report.dump() << "\n";
  }

  void ReportText(const char* hash) {
    std::cout << scene_.file << ": " << frame_ << " frames, " << engine_.StepCount()
              << " steps, t = " << FormatNumber(Time(frame_), VESPER_F32) << " s, state hash "
              << hash;
    if (pictures_) std::cout << ", " << picture_count_ << " pictures";
    std::cout << "\n";
    TextTable table;
    for (const vesper_law_info& law : Laws()) {
      const double each = law.calls == 0 ? 0
                                         : 1e-3 * static_cast<double>(law.nanoseconds) /
                                               static_cast<double>(law.calls);
      char time[32];
      std::snprintf(time, sizeof time, "%.2f us", each);
      table.push_back({law.name, law.version, std::to_string(law.calls) + " calls", time});
    }
    Print(std::cout, table, "  ");
    if (options_.ledger) PrintLedger(std::cout, ReadLedger(engine_, Laws()));
  }

  Scene scene_;
  const RunOptions& options_;
  PhysicsEngine engine_;
  std::vector<vesper_library_id> libraries_;
  std::optional<CsvWriter> csv_;
  std::optional<PictureWriter> pictures_;
  uint64_t picture_count_ = 0;
  uint64_t frame_ = 0;  // the last frame that was begun
};

}  // namespace

int Run(const RunOptions& options) {
  EndOnSignals();
  std::optional<SceneRun> run;
  try {
    run.emplace(ReadScene(options.scene, options.trusted), options);
  } catch (const LawError& error) {
    return Fail(kNotLoaded, error.what());
  } catch (const RendererError& error) {
    return Fail(kNotLoaded, error.what());
  } catch (const FileError& error) {
    return Fail(kFailed, error.what());
  } catch (const std::runtime_error& error) {
    return Fail(kInvalidScene, error.what());
  }
  try {
    run->Advance();
    alarm(0);  // the last frame has ended
    run->Report();
  } catch (const RendererError& error) {
    return Fail(kFailed, error.what());
  } catch (const FileError& error) {
    return Fail(kFailed, error.what());
  } catch (const SceneError& error) {
    return Fail(kInvalidScene, error.what());
  } catch (const Error& error) {
    return run->Explain(error);
  }
  return kDone;
}

}  // namespace vesper::cli
