// SPDX-License-Identifier: Apache-2.0
// Tests the scene reader: valid lines, and the messages for invalid ones.
#include "scene.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "visible.hpp"

namespace vesper::cli {
namespace {

constexpr auto kHead = "scene 1\ndt 1/240\n";

Scene Parse(const std::string& body) { return ParseScene(kHead + body, "s"); }

std::vector<double> Values(const Scene& scene, const std::string& property) {
  std::vector<double> values;
  const AnyColumn* column = scene.Find(property);
  const uint64_t count = column == nullptr ? 0 : column->size();
  for (uint64_t i = 0; i < count; ++i) values.push_back(column->Get(i));
  return values;
}

std::string ErrorOf(const std::string& text) {
  try {
    ParseScene(text, "s");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "no error";
}

/// Returns the error of a scene that declares rows of three kinds and then contains `line`.
std::string ErrorIn(const std::string& line) {
  return ErrorOf("scene 1\ndt 1\nrows world 1\nrows spring 2\nrows body 3\n" + line);
}

TEST(SceneTest, NumbersMayBeFractionsAndCommentsEndLines) {
  const Scene scene = Parse("steps 4 # per frame\n#\n   # nothing\n");
  EXPECT_EQ(scene.dt, 1.0 / 240);
  EXPECT_EQ(scene.steps, 4u);
  EXPECT_STREQ(scene.prototype->name, "si-f64");
}

TEST(SceneTest, LawsKeepTheirOrderAndParameters) {
  const Scene scene =
      ParseScene("scene 1\ndt 1\nlaw b x=2 y = -1e3\nlaw \"./a b.so\"\n", "s", true);
  ASSERT_EQ(scene.laws.size(), 2u);
  EXPECT_EQ(scene.laws[0].library, "b");
  ASSERT_EQ(scene.laws[0].parameters.size(), 2u);
  EXPECT_EQ(scene.laws[0].parameters[1].name, "y");
  EXPECT_EQ(scene.laws[0].parameters[1].value, -1000);
  EXPECT_EQ(scene.laws[1].library, "./a b.so");
}

TEST(SceneTest, ValuesAreListedRowByRowAndChangedByAt) {
  const Scene scene = Parse(
      "rows body 3\nmass 1 2 3\nposition (1 2 3) (4 5 6) (7 8 9)\n"
      "at 0 2..2: mass 1/2\n");
  EXPECT_EQ(Values(scene, "mass"), (std::vector<double>{0.5, 2, 0.5}));
  EXPECT_EQ(Values(scene, "position"), (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

TEST(SceneTest, UnitAtTheEndOfALineHoldsForAllItsValues) {
  const Scene scene = ParseScene(
      "scene 1\ndt 5 [ms]\nrows world 1\ngravity (0 -981 0) [cm/s^2]\nrows body 2\n"
      "mass line 1 3 [g]\nvelocity (36 0 0) (0 72 0) [km/h]\n"
      "position grid 2 1 1 spacing 2 origin (1 1 1) [km]\nat 1: mass 1/2 [t]\n"
      "charge random 1 2 seed 3 [uC]\nradius all 3 # [km]\n",
      "s");
  EXPECT_DOUBLE_EQ(scene.dt, 0.005);
  const auto expect_near = [&](const char* property, const std::vector<double>& expected) {
    const auto values = Values(scene, property);
    ASSERT_EQ(values.size(), expected.size());
    for (size_t i = 0; i < values.size(); ++i) EXPECT_DOUBLE_EQ(values[i], expected[i]) << property;
  };
  expect_near("gravity", {0, -9.81, 0});
  expect_near("mass", {1e-3, 500});
  expect_near("velocity", {10, 0, 0, 0, 20, 0});
  expect_near("position", {1000, 1000, 1000, 3000, 1000, 1000});
  expect_near("radius", {3, 3});
  for (const double charge : Values(scene, "charge")) {
    EXPECT_GE(charge, 1e-6);
    EXPECT_LE(charge, 2e-6);
  }
}

TEST(SceneTest, PrototypeMayComeFromAFileBesideTheScene) {
  const std::string folder = ::testing::TempDir();
  std::ofstream(folder + "heat.prototype")
      << "prototype heat extends si-f64\nbody temperature: real x1 [K] read_write\n";
  const Scene scene = ParseScene(
      "scene 1\nprototype heat.prototype\ndt 1\nrows body 2\n"
      "temperature 20 2000 [mK]\n",
      folder + "s.vesper");
  EXPECT_STREQ(scene.prototype->name, "heat");
  EXPECT_EQ(Values(scene, "temperature"), (std::vector<double>{0.02, 2}));
  EXPECT_EQ(ErrorOf("scene 1\nprototype ./none.prototype\n"),
            "s:2:11: './none.prototype' cannot be read: No such file or directory");
}

/// Reads a scene whose bodies come from a CSV file with this text.
Scene FromCsv(const std::string& csv) {
  const std::string folder = ::testing::TempDir();
  std::ofstream(folder + "bodies.csv") << csv;
  return ParseScene("scene 1\ndt 1\nrows body from bodies.csv\n", folder + "s.vesper");
}

std::string ErrorOfCsv(const std::string& csv) {
  try {
    FromCsv(csv);
  } catch (const SceneError& error) {
    return std::string(error.what()).substr((::testing::TempDir() + "bodies.csv").size());
  }
  return "no error";
}

TEST(CsvRowsTest, PropertiesAreNamedByTheFirstLineInAnyOrder) {
  const Scene scene = FromCsv("position.z,mass,position.x,position.y\n3,10,1,2\r\n6,1/4,4e0,-5");
  EXPECT_EQ(scene.rows.at("body"), 2u);
  EXPECT_EQ(Values(scene, "mass"), (std::vector<double>{10, 0.25}));
  EXPECT_EQ(Values(scene, "position"), (std::vector<double>{1, 2, 3, 4, -5, 6}));
}

TEST(CsvRowsTest, LastFrameOfARunIsRead) {
  const Scene scene = FromCsv("frame,time,row,mass\n0,0,0,1\n0,0,1,2\n5,0.1,0,3\n5,0.1,1,4\n");
  EXPECT_EQ(Values(scene, "mass"), (std::vector<double>{3, 4}));
}

TEST(CsvRowsTest, WhatIsWrongIsNamedByLineAndColumn) {
  EXPECT_EQ(ErrorOfCsv(""), ":1:1: the file is empty; expected names of properties");
  EXPECT_EQ(ErrorOfCsv("mass,maas\n"), ":1:6: 'maas' is no property of body; did you mean 'mass'?");
  EXPECT_EQ(ErrorOfCsv("mass,mass\n"), ":1:6: 'mass' is there twice");
  EXPECT_EQ(ErrorOfCsv("position.x,position.y\n"), ":1:1: 'position' has 3 components, found 2");
  EXPECT_EQ(ErrorOfCsv("externalForce.x\n"),
            ":1:1: 'externalForce.x' is summed up by the engine and cannot be given");
  EXPECT_EQ(ErrorOfCsv("mass\n1\n1,2\n"), ":3:1: 2 cells; expected 1, as in the first line");
  EXPECT_EQ(ErrorOfCsv("mass,charge\n1,nan\n"), ":2:3: found 'nan'; expected a number");
}

/// A folder with a scene's folder and files outside it.
class SceneTrustTest : public ::testing::Test {
 protected:
  SceneTrustTest() {
    std::string pattern = ::testing::TempDir() + "trust-XXXXXX";
    folder_ = mkdtemp(pattern.data());
    std::filesystem::create_directories(folder_ / "scene/sub");
    std::ofstream(folder_ / "secret.csv") << "hunter2\n";
    std::ofstream(folder_ / "mass.csv") << "mass\n7\n";
    std::ofstream(folder_ / "scene/sub/mass.csv") << "mass\n5\n";
  }
  ~SceneTrustTest() override { std::filesystem::remove_all(folder_); }

  void Link(const std::string& name, const std::filesystem::path& target) const {
    std::filesystem::create_symlink(target, folder_ / "scene" / name);
  }

  /// Reads a scene whose third line is `line`.
  Scene Read(const std::string& line, bool trusted) const {
    return ParseScene("scene 1\ndt 1\n" + line + "\n", folder_ / "scene/s", trusted);
  }

  std::string ErrorIn(const std::string& line, bool trusted = false) const {
    try {
      Read(line, trusted);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
};

TEST_F(SceneTrustTest, LawsHaveNamesAndNoPathsUnlessTheSceneIsTrusted) {
  for (const std::string path : {"./evil.so", "/tmp/evil.so", "sub/evil.law", "../evil.py", "/"}) {
    EXPECT_EQ(ErrorIn("law " + path),
              folder_.string() + "/scene/s:3:5: '" + path +
                  "' is a path; a scene names laws by name, such as newton_motion: put the library "
                  "into a folder of --laws, or run the scene with --trust, which opens the library "
                  "with all of your rights");
    EXPECT_EQ(ErrorIn("law " + path, true), "no error");
  }
  EXPECT_EQ(Read("law ./a.so", true).laws.at(0).library, folder_ / "scene/./a.so");
}

TEST_F(SceneTrustTest, FilesOutsideTheFolderOfASceneAreRefusedWithoutBeingRead) {
  Link("file.csv", "../secret.csv");
  Link("far.csv", folder_ / "secret.csv");
  Link("up", "..");
  Link("null.csv", "/dev/null");
  ASSERT_EQ(mkfifo((folder_ / "scene/pipe.csv").c_str(), 0600), 0);
  const std::string absolute = folder_ / "secret.csv";
  const std::pair<std::string, std::string> refused[] = {
      {"../secret.csv", "a path with '..'"},
      {"sub/../../secret.csv", "a path with '..'"},
      {absolute, "an absolute path"},
      {"file.csv", "a link that leads out of the scene's folder"},
      {"far.csv", "a link that leads out of the scene's folder"},
      {"up/secret.csv", "a link that leads out of the scene's folder"},
      {"null.csv", "a link that leads out of the scene's folder"},
      {"pipe.csv", "not a regular file"},
      {"./sub", "not a regular file"},
  };
  for (const auto& [name, found] : refused) {
    const std::string end = ": '" + name + "' is " + found +
                            "; a scene reads only regular files in its own folder or below it: "
                            "copy the file there, or run the scene with --trust if you trust its "
                            "author";
    const std::string scene = folder_ / "scene/s";
    EXPECT_EQ(ErrorIn("rows body from " + name), scene + ":3:16" + end);
    EXPECT_EQ(ErrorIn("prototype " + name), scene + ":3:11" + end);
  }
}

TEST_F(SceneTrustTest, FilesOfTheKernelAreRefusedInAFolderThatHoldsThem) {
  const auto error_of = [](const std::string& file) {
    try {
      ParseScene("scene 1\ndt 1\nrows body from " + file + "\n", "/s");
    } catch (const SceneError& error) {
      return std::string(error.what()).substr(0, 50);
    }
    return std::string("no error");
  };
  EXPECT_EQ(error_of("proc/version"), "/s:3:16: 'proc/version' is not a regular file; a s");
  EXPECT_EQ(error_of("dev/null"), "/s:3:16: 'dev/null' is not a regular file; a scene");
}

TEST_F(SceneTrustTest, FilesBelowTheFolderAreReadAndOthersOnlyOfATrustedScene) {
  Link("near.csv", "sub/mass.csv");
  Link("whole.csv", folder_ / "scene/sub/mass.csv");
  for (const char* name : {"sub/mass.csv", "./sub/mass.csv", "near.csv", "whole.csv"}) {
    const Scene scene = Read(std::string("rows body from ") + name, false);
    EXPECT_EQ(Values(scene, "mass"), std::vector<double>{5}) << name;
  }
  for (const std::string& name : {std::string("../mass.csv"), (folder_ / "mass.csv").string()}) {
    EXPECT_EQ(Values(Read("rows body from " + name, true), "mass"), std::vector<double>{7}) << name;
  }
  EXPECT_EQ(ErrorIn("prototype ../none.prototype", true),
            folder_.string() + "/scene/s:3:11: " + folder_.string() +
                "/scene/../none.prototype: No such file or directory");
}

TEST(VisibleTest, UnsafeCharactersAreEscapedAndLettersAreNot) {
  EXPECT_EQ(Visible("Ö 名前 می\u200cخواهم 🦆 §\n"), "Ö 名前 می\u200cخواهم 🦆 §\n");
  EXPECT_EQ(Visible("a\x1b[31m\r\x7f\u009b\u2028\u202e\ufeff"),
            "a\\u{1b}[31m\\u{d}\\u{7f}\\u{9b}\\u{2028}\\u{202e}\\u{feff}");
  EXPECT_EQ(Visible("\xff\xc0\x9b\xe2\x80"), "\\u{fffd}\\u{fffd}\\u{fffd}\\u{fffd}\\u{fffd}");
}

TEST(SceneTest, TimeUnitOfAPrototypeMustBeKnownBeforeDt) {
  const std::string folder = ::testing::TempDir();
  std::ofstream(folder + "slow.prototype") << "prototype slow\nreal f64\ntime [h]\n"
                                              "car place: real x1 [km] read_write\n";
  const std::string file = folder + "s.vesper";
  EXPECT_DOUBLE_EQ(ParseScene("scene 1\nprototype slow.prototype\ndt 30 [min]\n", file).dt, 0.5);
  EXPECT_THROW(ParseScene("scene 1\ndt 30 [min]\nprototype slow.prototype\n", file), SceneError);
}

TEST(SceneTest, DrawingIsWhatItsLinesSay) {
  const Scene scene = Parse(
      "image 100 50\ncamera from (1 2 3) at (0 0 0) fov 30\nbackground #102030\nground -1 #ffffff\n"
      "rows body 3\nposition all (0 0 0)\nmass 1 2 3\n"
      "draw body 0 2 radius 0.1 colour #000000 #ffffff by mass 1 3 unlit\n");
  const Drawing& drawing = scene.drawing;
  EXPECT_EQ(drawing.width, 100u);
  EXPECT_EQ(drawing.height, 50u);
  EXPECT_EQ(drawing.camera->eye, (Vec3<double>{1, 2, 3}));
  EXPECT_EQ(drawing.camera->fov, 30);
  EXPECT_EQ(drawing.bottom, (Colour{16, 32, 48, 255}));
  EXPECT_EQ(drawing.ground->height, -1);
  ASSERT_EQ(drawing.lines.size(), 1u);
  EXPECT_EQ(drawing.lines[0].rows, (std::vector<uint64_t>{0, 2}));
  EXPECT_EQ(drawing.lines[0].paint.colours.size(), 2u);
  EXPECT_EQ(drawing.lines[0].paint.property, "mass");
  EXPECT_EQ(drawing.lines[0].radius, 0.1);
  EXPECT_TRUE(drawing.lines[0].unlit);
}

TEST(SceneTest, SinglePrecisionHoldsSinglePrecision) {
  const Scene scene = Parse("prototype si-f32\nrows body 1\nmass 0.1\n");
  EXPECT_EQ(Values(scene, "mass"), std::vector<double>{0.1f});
}

TEST(GeneratorTest, LineIsEvenAndHoldsBothEnds) {
  EXPECT_EQ(Values(Parse("rows body 5\nmass line 1 3\n"), "mass"),
            (std::vector<double>{1, 1.5, 2, 2.5, 3}));
}

TEST(GeneratorTest, GridRunsFastestAlongX) {
  const Scene scene = Parse("rows body 8\nposition grid 2 2 2 spacing (1 2 4) origin (0 0 1)\n");
  EXPECT_EQ(Values(scene, "position"), (std::vector<double>{0, 0, 1, 1, 0, 1, 0, 2, 1, 1, 2, 1,  //
                                                            0, 0, 5, 1, 0, 5, 0, 2, 5, 1, 2, 5}));
}

TEST(GeneratorTest, GridEdgesJoinNeighboursOfTheGrid) {
  const Scene scene = Parse(
      "rows body 12\nposition grid 2 3 2 spacing 0.5\nrows spring 20\n"
      "endpoints grid-edges 2 3 2\nlength distance 2\n");
  EXPECT_EQ(Values(scene, "length"), std::vector<double>(20, 1));
}

// All segments of a spoke have equal length. A chord of the ring r has the length 2 r sin.
TEST(GeneratorTest, WebEdgesAreSpokesAndChords) {
  const Scene scene = Parse(
      "rows body 13\nposition web 2 6 radius 4\nrows spring 24\n"
      "endpoints web-edges 2 6\nlength distance\n");
  const auto lengths = Values(scene, "length");
  ASSERT_EQ(lengths.size(), 24u);
  for (size_t i = 0; i < 24; ++i) EXPECT_NEAR(lengths[i], i < 18 ? 2 : 4, 1e-12) << i;
}

TEST(GeneratorTest, ChainJoinsEachRowToTheNext) {
  EXPECT_EQ(Values(Parse("rows spring 3\nendpoints chain\n"), "endpoints"),
            (std::vector<double>{0, 1, 1, 2, 2, 3}));
}

TEST(GeneratorTest, RandomIsEvenInItsRangeAndGivenByItsSeed) {
  const std::string line = "rows body 1000\nposition random (0 -1 5) (1 1 5) seed ";
  const auto a = Values(Parse(line + "7\n"), "position");
  EXPECT_EQ(a, Values(Parse(line + "7\n"), "position"));
  EXPECT_NE(a, Values(Parse(line + "8\n"), "position"));
  double sum_x = 0, low_y = 1, high_y = -1;
  for (size_t i = 0; i < a.size(); i += 3) {
    sum_x += a[i];
    low_y = std::min(low_y, a[i + 1]);
    high_y = std::max(high_y, a[i + 1]);
    EXPECT_EQ(a[i + 2], 5);
  }
  EXPECT_NEAR(sum_x / 1000, 0.5, 0.03);  // three standard deviations
  EXPECT_NEAR(low_y, -1, 0.02);
  EXPECT_NEAR(high_y, 1, 0.02);
}

TEST(SceneErrorTest, FileAsAWhole) {
  EXPECT_EQ(ErrorOf(""), "s:1:1: expected 'scene 1' in the first line");
  EXPECT_EQ(ErrorOf("scene 2\n"), "s:1:1: expected 'scene 1' in the first line");
  EXPECT_EQ(ErrorOf("scene 1\n"), "s:1:8: the scene has no 'dt'");
}

struct Wrong {
  const char* line;
  const char* error;  // after "s:6:"
};
void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.line; }

class SceneLineErrorTest : public ::testing::TestWithParam<Wrong> {};

TEST_P(SceneLineErrorTest, NamesPlaceFoundAndExpected) {
  EXPECT_EQ(ErrorIn(GetParam().line), std::string("s:6:") + GetParam().error);
}

const Wrong kWrong[] = {
    {"dt 0", "4: expected a time above 0"},
    {"dt", "3: the line ends; expected the length of a step in seconds"},
    {"dt 1/0",
     "4: found '1/0'; expected the length of a step in seconds, a number such as 1.5, "
     "2e-3 or 1/240"},
    {"dt 1 s", "6: found 's'; expected the end of the line"},
    {"steps 1.5", "7: expected the number of steps per frame, a whole number from 1 to 1e9"},
    {"prototype si-f64", "1: must come before the first 'rows'"},
    {"law", "4: the line ends; expected the name of a law library"},
    {"law x y", "8: found the end of the line; expected '='"},
    {"law x y=z", "9: found 'z'; expected the value of y, a number such as 1.5, 2e-3 or 1/240"},
    {"law \"x", "5: a quote without its end"},
    {"dt\x01", "3: a control character; expected plain text"},
    {"rows bodi 3", "6: 'bodi' is no kind; did you mean 'body'?"},
    {"rows body 3", "6: the rows of body were given before"},
    {"rows surface -1", "14: expected the number of rows, a whole number from 0 to 1e9"},
    {"mas 1 2 3", "1: 'mas' is no statement or property of body; did you mean 'mass'?"},
    {"length 1",
     "1: 'length' is a property of spring, not of body; it belongs below 'rows spring "
     "…'"},
    {"externalForce all (0 0 0)",
     "1: 'externalForce' is summed up by the engine and cannot be "
     "given; give 'appliedForce' instead"},
    {"torque all (0 0 0)", "1: 'torque' is summed up by the engine and cannot be given"},
    {"mass 1 2",
     "8: 2 values for 'mass'; expected one for each of the 3 rows of body, or 'all "
     "VALUE'"},
    {"mass (1 2) 1 1", "10: 'mass' has 1 component per row, found 2"},
    {"position 1 2 3",
     "10: 'position' has 3 components per row, found 1; write them in "
     "parentheses: (x y …)"},
    {"position all (1 2", "18: '(' without its ')'"},
    {"mass al 1", "6: 'al' is no generator; did you mean 'all'?"},
    {"mass all 1e999",
     "10: found '1e999'; expected a value of 'mass', a number such as 1.5, 2e-3 "
     "or 1/240"},
    {"position grid 2 2 2 spacing 1",
     "19: this makes 8 values; expected one for each of the 3 "
     "rows of body"},
    {"position grid 3 1 1 1", "21: found '1'; expected 'spacing'"},
    {"mass grid 3 1 1 spacing 1", "6: makes points, but 'mass' has no three real components"},
    {"mass chain", "6: makes pairs of rows, but 'mass' has none"},
    {"mass distance", "6: needs 'endpoints' of the same kind, given before, and a real x 1"},
    {"position random (0 0) 1 seed 1", "21: expected 1 or 3 numbers for 'position'"},
    {"at 1: mass 1", "7: 'mass' has no values yet; give it for all rows first"},
    {"at 3: mass 1", "4: body has 3 rows; they count from 0"},
    {"at 2..1: mass 1", "4: expected a row number, or a range such as 3..7"},
    {"at : mass 1", "4: expected row numbers"},
    {"at 1 mass 1", "6: found 'mass'; expected ':'"},
    {"at 1: length 1",
     "7: 'length' is a property of spring, not of body; it belongs below 'rows "
     "spring …'"},
    {"mass all 1 [m]", "12: [m] is no unit of 'mass'; expected one of the same dimension as [kg]"},
    {"mass all 1 [kq]",
     "12: INVALID_ARGUMENT: unit 'kq', column 1: unknown unit 'kq'; did you "
     "mean 'kg'?"},
    {"mass all 1 [kg", "12: '[' without its ']'"},
    {"mass all [kg] 1",
     "10: found '[kg]'; expected a value of 'mass', a number such as 1.5, 2e-3 "
     "or 1/240"},
    {"at 1: length 1 [kg]",
     "7: 'length' is a property of spring, not of body; it belongs below "
     "'rows spring …'"},
    {"steps 4 [s]", "9: a unit does not belong here; expected the end of the line"},
    {"dt 1 [m]", "6: [m] is no unit of time; expected one of the same dimension as [s]"},
    {"image 10 9000", "10: a picture has at most 8192 pixels a side and 16777216 in all"},
    {"camera (0 0 1)", "8: found '('; expected 'from'"},
    {"camera from (0 0) at (0 0 0)", "17: expected where the camera is, a point such as (0 1 5)"},
    {"camera from (0 9 0) at (0 0 0)",
     "30: expected a direction that is not along the y axis, "
     "which is up in the picture"},
    {"camera from (0 0 1) at (0 0 0) fov 180",
     "36: expected the field of view in degrees, from "
     "0.1 to 170"},
    {"background red", "12: found 'red'; expected a colour such as #3498db"},
    {"draw surface", "6: 'surface' has no rows yet"},
    {"draw body",
     "6: 'body' cannot be drawn: it has neither 'position' nor two or three "
     "references to a kind that has"},
    {"csv positoin", "5: 'positoin' is no property; did you mean 'position'?"},
};
INSTANTIATE_TEST_SUITE_P(Lines, SceneLineErrorTest, ::testing::ValuesIn(kWrong));

const Wrong kWrongDrawing[] = {
    {"draw body raduis 1", "11: 'raduis' is no option of 'draw body'; did you mean 'radius'?"},
    {"draw body width 1",
     "11: 'width' is no option of 'draw body'; there are colour, radius, "
     "unlit"},
    {"draw body radius -1", "18: expected a radius of at least 0"},
    {"draw body 3 radius 1", "11: body has 3 rows; they count from 0"},
    {"draw body colour #12345", "18: found '#12345'; expected a colour such as #3498db"},
    {"draw body colour #123456 #123456", "33: found the end of the line; expected 'by'"},
    {"draw body colour #123456 #123456 by mass 0 1", "37: 'mass' has no values yet"},
    {"draw body colour #123456 #123456 by length 0 1",
     "37: 'length' is a property of spring, not of body"},
    {"draw body colour #123456 #123456 by position 1 1",
     "48: expected a value above that of the first colour"},
    {"draw spring unlit", "13: 'unlit' is no option of 'draw spring'; there are colour, width"},
    {"draw spring width 65", "19: expected the width in pixels, from 0.25 to 64"},
};
class SceneDrawingErrorTest : public ::testing::TestWithParam<Wrong> {};
TEST_P(SceneDrawingErrorTest, NamesPlaceFoundAndExpected) {
  EXPECT_EQ(ErrorOf("scene 1\ndt 1\nrows body 3\nposition all (0 0 0)\nrows spring 1\n"
                    "endpoints (0 1)\nlength 1\n" +
                    std::string(GetParam().line)),
            std::string("s:8:") + GetParam().error);
}
INSTANTIATE_TEST_SUITE_P(Lines, SceneDrawingErrorTest, ::testing::ValuesIn(kWrongDrawing));

TEST(SceneErrorTest, WholeNumbersHaveNoUnitAndDistancesThatOfPositions) {
  const std::string head = "scene 1\nrows body 2\nposition all (0 0 0)\nrows spring 1\n";
  EXPECT_EQ(ErrorOf(head + "endpoints (0 1) [m]\n"),
            "s:5:17: 'endpoints' is a whole number without a unit");
  EXPECT_EQ(ErrorOf(head + "endpoints (0 1)\nlength distance 2 [cm]\n"),
            "s:6:19: a distance has the unit of 'position'");
}

TEST(SceneErrorTest, RowsOfTheWorldAreOne) {
  EXPECT_EQ(ErrorOf("scene 1\nrows world 2\n"), "s:2:12: the world has 1 row");
}

TEST(SceneErrorTest, IntegersRefuseWhatTheyCannotHold) {
  const std::string head = "scene 1\nrows spring 1\nendpoints (0 ";
  const std::string tail = ": row 0 of 'endpoints': the property's type cannot hold this number";
  EXPECT_EQ(ErrorOf(head + "1.5)\n"), "s:3:17" + tail);
  EXPECT_EQ(ErrorOf(head + "-1)\n"), "s:3:16" + tail);
}

TEST(SceneErrorTest, SinglePrecisionRefusesWhatItCannotHold) {
  EXPECT_EQ(ErrorOf("scene 1\nprototype si-f32\nrows body 1\nmass 1e39\n"),
            "s:4:6: row 0 of 'mass': the property's type cannot hold this number");
}

TEST(SceneErrorTest, DistanceNeedsBodiesThatAreThere) {
  EXPECT_EQ(ErrorOf("scene 1\nrows body 2\nposition all (0 0 0)\nrows spring 1\nendpoints (0 2)\n"
                    "length distance\n"),
            "s:6:8: 'endpoints' of row 0 name a body that does not exist");
}

TEST(SceneErrorTest, FirstPropertyNeedsRows) {
  EXPECT_EQ(ErrorOf("scene 1\nmass 1\n"),
            "s:2:1: 'mass' is a property of body; it belongs below 'rows body …'");
  EXPECT_EQ(ErrorOf("scene 1\nlav x\n"), "s:2:1: 'lav' is no statement; did you mean 'law'?");
}

}  // namespace
}  // namespace vesper::cli
