// SPDX-License-Identifier: Apache-2.0
#include "drawing_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "csv.hpp"
#include "picture.hpp"

namespace vesper::cli {
namespace {

constexpr uint64_t kLargestSide = 8192, kMostPixels = 1 << 24;  // limits of the renderer
constexpr double kFovs[] = {0.1, 170};                          // [degrees]
constexpr double kWidths[] = {0.25, 64};                        // [px]

double NumberIn(SceneReader& reader, const std::string& what, const double (&limits)[2]) {
  const double number = reader.Number(what);
  if (number >= limits[0] && number <= limits[1]) return number;
  reader.FailLast("expected " + what + ", from " + FormatNumber(limits[0], VESPER_F64) + " to " +
                  FormatNumber(limits[1], VESPER_F64));
}

Vec3<double> ReadPoint(SceneReader& reader, const std::string& what) {
  const Value value = reader.ReadValue(what);
  if (value.size() != 3) reader.FailLast("expected " + what + ", a point such as (0 1 5)");
  return {value[0], value[1], value[2]};
}

bool IsColour(const std::string& word) {
  return word.size() == 7 && word[0] == '#' &&
         std::all_of(word.begin() + 1, word.end(),
                     [](unsigned char c) { return std::isxdigit(c) != 0; });
}

Colour ReadColour(SceneReader& reader) {
  const std::string word = reader.Word("a colour such as #3498db");
  if (!IsColour(word)) reader.FailLast("found '" + word + "'; expected a colour such as #3498db");
  uint32_t rgb = 0;
  std::from_chars(word.data() + 1, word.data() + 7, rgb, 16);
  return {static_cast<uint8_t>(rgb >> 16), static_cast<uint8_t>(rgb >> 8 & 255),
          static_cast<uint8_t>(rgb & 255), 255};
}

/// Reads a paint of the form COLOUR, or COLOUR COLOUR… by PROPERTY LOW HIGH
Paint ReadPaint(SceneReader& reader, const Scene& scene, const std::string& kind) {
  Paint paint{{ReadColour(reader)}, {}};
  while (IsColour(reader.Peek())) paint.colours.push_back(ReadColour(reader));
  if (paint.colours.size() == 1) return paint;
  reader.Expect("by");
  paint.property = reader.Word("a property");
  const AnyColumn* column = scene.Find(paint.property);
  if (column == nullptr) reader.FailLast("'" + paint.property + "' has no values yet");
  if (column->descriptor().kind != kind) {
    reader.FailLast("'" + paint.property + "' is a property of " + column->descriptor().kind +
                    ", not of " + kind);
  }
  paint.low = reader.Number("the value of the first colour");
  paint.high = reader.Number("the value of the last colour");
  if (!(paint.low < paint.high)) reader.FailLast("expected a value above that of the first colour");
  return paint;
}

}  // namespace

/// Reads the line: image WIDTH HEIGHT
void ReadImage(SceneReader& reader, Scene& scene) {
  const uint64_t width = reader.Count("the picture's width in pixels", 1);
  const uint64_t height = reader.Count("the picture's height in pixels", 1);
  if (std::max(width, height) > kLargestSide || width * height > kMostPixels) {
    reader.FailLast("a picture has at most 8192 pixels a side and 16777216 in all");
  }
  scene.drawing.width = static_cast<uint32_t>(width);
  scene.drawing.height = static_cast<uint32_t>(height);
}

/// Reads the line: camera from P at P [fov DEGREES]
void ReadCamera(SceneReader& reader, Scene& scene) {
  Camera camera;
  reader.Expect("from");
  camera.eye = ReadPoint(reader, "where the camera is");
  reader.Expect("at");
  camera.target = ReadPoint(reader, "what the camera looks at");
  const Vec3<double> sight = camera.target - camera.eye;
  if (!(std::hypot(sight.x, sight.z) > 1e-3 * Length(sight))) {
    reader.FailLast(
        "expected a direction that is not along the y axis, which is up in the picture");
  }
  if (reader.Accept("fov")) camera.fov = NumberIn(reader, "the field of view in degrees", kFovs);
  scene.drawing.camera = camera;
}

/// Reads the line: background TOP [BOTTOM]
void ReadBackground(SceneReader& reader, Scene& scene) {
  scene.drawing.top = ReadColour(reader);
  scene.drawing.bottom = reader.AtEnd() ? scene.drawing.top : ReadColour(reader);
}

/// Reads the line: ground HEIGHT [COLOUR]
void ReadGround(SceneReader& reader, Scene& scene) {
  Ground ground{reader.Number("the ground's height"), {236, 238, 241, 255}};
  if (!reader.AtEnd()) ground.colour = ReadColour(reader);
  scene.drawing.ground = ground;
}

/// Reads the line: draw KIND [ROW…] [radius R] [width PX] [colour PAINT] [unlit]
void ReadDraw(SceneReader& reader, Scene& scene) {
  DrawLine line;
  line.place = reader.LineStart();
  line.kind = reader.Word("a kind");
  const auto rows = scene.rows.find(line.kind);
  if (rows == scene.rows.end()) reader.FailLast("'" + line.kind + "' has no rows yet");
  const Form form = FormOf(scene, line.kind);
  if (form == Form::kNone) {
    reader.FailLast("'" + line.kind +
                    "' cannot be drawn: it has neither 'position' nor two or "
                    "three references to a kind that has");
  }
  line.rows = reader.RowNumbers(rows->second, line.kind);
  std::vector<std::string> options{"colour"};
  if (form == Form::kBalls) options.push_back("radius");
  if (form == Form::kLines) options.push_back("width");
  if (form != Form::kLines) options.push_back("unlit");
  while (!reader.AtEnd()) {
    const std::string option = reader.Word("an option");
    if (std::ranges::find(options, option) == options.end()) {
      reader.FailUnknown("option of 'draw " + line.kind + "'", options);
    }
    if (option == "colour") line.paint = ReadPaint(reader, scene, line.kind);
    if (option == "width") line.width = NumberIn(reader, "the width in pixels", kWidths);
    if (option == "unlit") line.unlit = true;
    if (option == "radius") {
      line.radius = reader.Number("the radius");
      if (*line.radius < 0) reader.FailLast("expected a radius of at least 0");
    }
  }
  scene.drawing.lines.push_back(std::move(line));
}

}  // namespace vesper::cli
