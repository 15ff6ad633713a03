// SPDX-License-Identifier: Apache-2.0
#include "law_runs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "exit_code.hpp"
#include "law_scene.hpp"
#include "text_table.hpp"

namespace vesper::cli {
namespace {

using Json = nlohmann::ordered_json;
using Vector = std::array<double, 3>;

constexpr int kPrinted = 20;    // lines of the table of a plot
constexpr double kStep = 1e-9;  // step in which forces are evaluated [s]

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

double Length(const Vector& v) { return std::hypot(v[0], v[1], v[2]); }

/// Splits "w=1,2,3" into a name and numbers. Throws std::invalid_argument.
PropertyValue Given(const char* option, const std::string& text, const char* expected) {
  const size_t sign = text.find('=');
  PropertyValue value{text.substr(0, sign), {}};
  bool valid = sign != std::string::npos && sign > 0;
  for (size_t begin = sign + 1; valid;) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const std::string number = text.substr(begin, end - begin);
    char* rest = nullptr;
    value.components.push_back(std::strtod(number.c_str(), &rest));
    valid = !number.empty() && *rest == '\0' && std::isfinite(value.components.back());
    if (end == text.size()) break;
    begin = end + 1;
  }
  if (valid) return value;
  throw std::invalid_argument(std::string(option) + " " + text + ": expected " + expected);
}

std::vector<ParameterValue> Parameters(const std::vector<std::string>& texts) {
  constexpr const char* kExpected = "a name and a number in SI units, such as c=20";
  std::vector<ParameterValue> values;
  for (const std::string& text : texts) {
    const PropertyValue value = Given("--parameter", text, kExpected);
    if (value.components.size() != 1) {
      throw std::invalid_argument("--parameter " + text + ": expected " + kExpected);
    }
    values.push_back({value.name, value.components.front()});
  }
  return values;
}

std::vector<PropertyValue> Properties(const std::vector<std::string>& texts) {
  std::vector<PropertyValue> values;
  for (const std::string& text : texts) {
    values.push_back(Given("--set", text,
                           "a property and its numbers in the property's unit, such as "
                           "temperature=300 or velocity=1,0,0"));
  }
  return values;
}

// --- runs -------------------------------------------------------------------------------------

/// The conserved quantities of the bodies at one time.
struct Sums {
  double time = 0;                  // [s]
  double kinetic = 0;               // [J]
  std::optional<double> potential;  // [J]; nothing if no law reports one
  Vector momentum{};                // [kg*m/s]
  Vector angular{};                 // about the origin [kg*m^2/s]

  double Energy() const { return kinetic + potential.value_or(0); }
};

Sums Sum(LawScene& scene, double time) {
  Sums sums;
  sums.time = time;
  sums.potential = scene.PotentialEnergy();
  const auto &mass = scene.Column("mass"), &x = scene.Column("position"),
             &v = scene.Column("velocity");
  for (uint64_t i = 0; i < scene.bodies(); ++i) {
    for (size_t k = 0; k < 3; ++k) {
      const size_t l = (k + 1) % 3, m = (k + 2) % 3;
      sums.kinetic += 0.5 * mass[i] * v[3 * i + k] * v[3 * i + k];
      sums.momentum[k] += mass[i] * v[3 * i + k];
      sums.angular[k] += mass[i] * (x[3 * i + l] * v[3 * i + m] - x[3 * i + m] * v[3 * i + l]);
    }
  }
  return sums;
}

Json ToJson(const Sums& sums) {
  Json row{{"time", sums.time}, {"kinetic", sums.kinetic}};
  if (sums.potential) row["potential"] = *sums.potential;
  row["momentum"] = sums.momentum;
  row["angularMomentum"] = sums.angular;
  return row;
}

double Largest(const std::vector<Sums>& rows, double (*size)(const Sums&)) {
  double most = 0;
  for (const Sums& row : rows) most = std::max(most, size(row));
  return most;
}

void PrintRun(const LawScene& scene, const LawRunOptions& options, const std::string& partner,
              const std::vector<Sums>& rows) {
  const bool potential = rows.front().potential.has_value();
  std::cout << options.file << ": " << scene.bodies() << " bodies of 1 kg, "
            << Number(1.2 * scene.length()) << " m apart, with " << partner << ", "
            << Number(options.dt) << " s per step\n";
  TextTable table{{"time [s]", "kinetic [J]", "potential [J]", "energy [J]", "momentum [kg*m/s]",
                   "angular momentum [kg*m^2/s]"}};
  for (const Sums& row : rows) {
    table.push_back({Number(row.time), Number(row.kinetic),
                     potential ? Number(*row.potential) : "-",
                     potential ? Number(row.Energy()) : "-", Number(Length(row.momentum)),
                     Number(Length(row.angular))});
  }
  Print(std::cout, table, "  ");
  const double change = rows.back().Energy() - rows.front().Energy();
  const double scale = Largest(rows, [](const Sums& row) { return row.kinetic; });
  if (!potential) {
    std::cout << "  The law reports no potential energy, so energy need not be conserved.\n";
  } else {
    std::cout << "  The energy changed by " << Number(change) << " J, "
              << Number(scale == 0 ? 0 : 100 * change / scale)
              << " % of the largest kinetic energy.\n";
  }
}

int RunScene(const LawRunOptions& options) {
  LawScene scene(options.file, options.bodies, Properties(options.properties));
  scene.Load(Parameters(options.parameters));
  const bool integrates = scene.law().phase == VESPER_PHASE_INTEGRATE;
  const std::string partner = integrates ? "hooke_spring" : "velocity_verlet";
  scene.LoadMore(partner);
  const auto steps = static_cast<uint64_t>(std::llround(options.seconds / options.dt));
  const uint64_t count = std::min(options.rows, std::max<uint64_t>(steps, 1) + 1);
  std::vector<Sums> rows;
  uint64_t done = 0;
  for (uint64_t row = 0; row < count; ++row) {
    const uint64_t until = steps * row / (count - 1);
    while (done < until) {
      const auto next = static_cast<uint32_t>(std::min<uint64_t>(until - done, 1000));
      scene.Advance(options.dt, next);
      done += next;
    }
    rows.push_back(Sum(scene, static_cast<double>(done) * options.dt));
  }
  if (!options.json) {
    PrintRun(scene, options, partner, rows);
    return kDone;
  }
  Json report{{"file", options.file}, {"law", scene.law().name},  {"with", partner},
              {"dt", options.dt},     {"bodies", scene.bodies()}, {"rows", Json::array()}};
  for (const Sums& row : rows) report["rows"].push_back(ToJson(row));
  std::cout << report.dump() << "\n";
  return kDone;
}

// --- plots ------------------------------------------------------------------------------------

enum class Over { kDistance, kSpeed, kPlace };

const char* NameOf(Over over) {
  return over == Over::kDistance ? "distance" : over == Over::kSpeed ? "speed" : "place";
}

/// Evaluates the force of a law on the second of two bodies, and its energy.
class Curve {
 public:
  struct Point {
    double x;                      // [m] or [m/s]
    double force;                  // [N]
    std::optional<double> energy;  // [J]
  };

  explicit Curve(const LawPlotOptions& options)
      : scene_(options.file, 2, Properties(options.properties)) {
    if (scene_.law().phase != VESPER_PHASE_FORCE) {
      throw std::runtime_error(options.file + ": " + scene_.law().name +
                               " adds no forces, so there is nothing to plot; `law run` shows what "
                               "it does");
    }
    scene_.Load(Parameters(options.parameters));
    const double s = scene_.length();
    const Vector there = ForceAt(s, 0, 0), moved = ForceAt(s, 0, -0.37 * s);
    const bool is_pair = there != moved;
    if (options.over.empty()) {
      over_ = is_pair                                ? Over::kDistance
              : ForceAt(s, 0, 0) != ForceAt(s, 1, 0) ? Over::kSpeed
                                                     : Over::kPlace;
    } else {
      over_ = options.over == "distance" ? Over::kDistance
              : options.over == "speed"  ? Over::kSpeed
                                         : Over::kPlace;
    }
    const double least = over_ == Over::kDistance ? 0.5 * s : over_ == Over::kSpeed ? 0 : -2 * s;
    const double most = over_ == Over::kDistance ? 3 * s : over_ == Over::kSpeed ? 10 : 2 * s;
    const double from = options.from.value_or(least), to = options.to.value_or(most);
    if (!(from < to)) throw std::invalid_argument("--from must be below --to");
    for (uint32_t i = 0; i < options.points; ++i) {
      Add(from + (to - from) * i / (options.points - 1));
    }
  }

  Over over() const { return over_; }
  /// Returns which component of the force is shown.
  const char* component() const { return kComponents[component_]; }
  const std::vector<Point>& points() const { return points_; }
  LawScene& scene() { return scene_; }

  /// Chooses the component with the largest force. Therefore a plot also shows a force that is
  /// perpendicular to the axis.
  void Choose() {
    std::array<double, 3> most{};
    for (const Vector& force : forces_) {
      for (size_t k = 0; k < 3; ++k) most[k] = std::max(most[k], std::abs(force[k]));
    }
    component_ = static_cast<size_t>(std::ranges::max_element(most) - most.begin());
    for (size_t i = 0; i < points_.size(); ++i) points_[i].force = forces_[i][component_];
  }

 private:
  static constexpr const char* kComponents[] = {"x", "y", "z"};

  Vector ForceAt(double place, double speed, double other) {
    auto &x = scene_.Column("position"), &v = scene_.Column("velocity");
    std::ranges::fill(x, 0);
    std::ranges::fill(v, 0);
    x[0] = other;
    x[3] = place;
    v[3] = speed;
    scene_.Advance(kStep, 1);
    const auto& force = scene_.Column("externalForce");
    return {force[3], force[4], force[5]};
  }

  void Add(double at) {
    const bool speed = over_ == Over::kSpeed;
    forces_.push_back(ForceAt(speed ? scene_.length() : at, speed ? at : 0, 0));
    points_.push_back({at, 0, scene_.PotentialEnergy()});
  }

  LawScene scene_;
  Over over_ = Over::kDistance;
  size_t component_ = 0;
  std::vector<Vector> forces_;
  std::vector<Point> points_;
};

int PrintPlot(const LawPlotOptions& options) {
  Curve curve(options);
  curve.Choose();
  const bool energy = curve.points()[0].energy && curve.over() != Over::kSpeed;
  const char* unit = curve.over() == Over::kSpeed ? "m/s" : "m";
  if (options.json) {
    Json report{{"file", options.file},           {"law", curve.scene().law().name},
                {"over", NameOf(curve.over())},   {"unit", unit},
                {"component", curve.component()}, {"points", Json::array()}};
    for (const Curve::Point& point : curve.points()) {
      Json row{point.x, point.force};
      if (energy) row.push_back(*point.energy);
      report["points"].push_back(std::move(row));
    }
    std::cout << report.dump() << "\n";
    return kDone;
  }
  TextTable table{{std::string(NameOf(curve.over())) + " [" + unit + "]",
                   std::string("force ") + curve.component() + " [N]"}};
  if (energy) table[0].push_back("energy [J]");
  const size_t every = std::max<size_t>(1, curve.points().size() / kPrinted);
  for (size_t i = 0; i < curve.points().size(); i += every) {
    const Curve::Point& point = curve.points()[i];
    table.push_back({Number(point.x), Number(point.force)});
    if (energy) table.back().push_back(Number(*point.energy));
  }
  Print(std::cout, table);
  return kDone;
}

/// Throws unless a file is a law as text. Code of other laws would run with all rights of the user.
void RequireText(const std::string& file) {
  if (!file.ends_with(".law")) {
    throw std::invalid_argument(file + ": expected a law as text, whose name ends in .law");
  }
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw std::runtime_error(file + ": " + (error ? error.message() : "not a regular file"));
  }
}

/// Runs a command on a law. Prints the reason and returns the exit code if the command fails.
template <class Options>
int Explained(const Options& options, int (*command)(const Options&)) {
  try {
    RequireText(options.file);
    return command(options);
  } catch (const std::invalid_argument& error) {
    return Fail(kWrongUsage, error.what());
  } catch (const Error& error) {
    const bool failed =
        error.status() == VESPER_LAW_FAILED || error.status() == VESPER_LAW_MISBEHAVED;
    return Fail(failed ? kFailed : kNotLoaded, options.file + ": " + error.what());
  } catch (const std::runtime_error& error) {
    return Fail(kFailed, error.what());
  }
}

}  // namespace

int RunLaw(const LawRunOptions& options) { return Explained(options, RunScene); }
int PlotLaw(const LawPlotOptions& options) { return Explained(options, PrintPlot); }

}  // namespace vesper::cli
