// SPDX-License-Identifier: Apache-2.0
// Tests whole sessions with the program, with valid and damaged input.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "process.hpp"
#include "session.hpp"
#include "stream_writer.hpp"

namespace vesper::render::test {
namespace {

namespace fs = std::filesystem;

std::string Join(const std::vector<Message>& messages) {
  std::string stream;
  for (const Message& message : messages) stream += message.Bytes();
  return stream;
}

std::vector<Message> SmallScene() {
  return {Hello(),
          Image(80, 60, 4, 1),
          Perspective({3, 2, 5}, {0, 0, 0}, 0.6F),
          Mesh(3, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}),
          Instances(1, {Item{}, Item{{1, 0, 0}}}),
          Instances(4, {Item{{-1, 0, 0}}}, 3),
          Instances(3, {Item{{0, -1, 0}, {50, 0, 50}, {230, 230, 230, 255}, kGrid | kFade}}),
          Segments({{{-1, 0, 0}, {1, 0, 0}}}, 2)};
}

/// Returns width and height of a PNG that libpng decodes without warnings; 0, 0 for an invalid one.
std::pair<uint32_t, uint32_t> DecodedSize(const std::string& png) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&image, png.data(), png.size())) return {0, 0};
  image.format = PNG_FORMAT_RGB;
  std::vector<uint8_t> pixels(PNG_IMAGE_SIZE(image));
  if (!png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr)) return {0, 0};
  return {image.width, image.height};
}

class SessionTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = fs::temp_directory_path() / "vesper-render-XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

TEST_F(SessionTest, AnswersWithAPng) {
  auto scene = SmallScene();
  scene.push_back(RenderToAnswer());
  const Outcome outcome = RunProgram({}, Join(scene));
  EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.errors;
  const auto replies = Replies(outcome.output);
  ASSERT_EQ(replies.size(), 2U);
  EXPECT_EQ(replies[0].status, Status::kOk);
  EXPECT_EQ(replies[1].status, Status::kOk);
  EXPECT_GT(replies[1].microseconds, 0U);
  EXPECT_EQ(DecodedSize(replies[1].payload), (std::pair{80U, 60U}));
}

TEST_F(SessionTest, TwoProcessesGiveTheSameBytes) {
  auto scene = SmallScene();
  scene.push_back(RenderToAnswer());
  setenv("LP_NUM_THREADS", "1", 1);
  const auto one = Replies(RunProgram({}, Join(scene)).output);
  setenv("LP_NUM_THREADS", "3", 1);
  const auto three = Replies(RunProgram({}, Join(scene)).output);
  unsetenv("LP_NUM_THREADS");
  ASSERT_EQ(one.size(), 2U);
  ASSERT_EQ(three.size(), 2U);
  EXPECT_TRUE(one[1].payload == three[1].payload);
}

TEST_F(SessionTest, ItemsLastForOnePictureMeshesAndCameraForAll) {
  auto scene = SmallScene();
  const Message instances = Instances(4, {Item{{-1, 0, 0}}}, 3);
  for (const Message& message : {RenderToAnswer(), RenderToAnswer(), instances, RenderToAnswer(),
                                 instances, RenderToAnswer()}) {
    scene.push_back(message);
  }
  const auto replies = Replies(RunProgram({}, Join(scene)).output);
  ASSERT_EQ(replies.size(), 5U);
  EXPECT_LT(replies[2].payload.size(), replies[3].payload.size()) << "nothing left to show";
  EXPECT_TRUE(replies[3].payload == replies[4].payload);
}

TEST_F(SessionTest, RawPixelsAreLayersFromTheTop) {
  const std::vector<Message> scene{
      Hello(), Image(4, 2, 0, 0), Environment({9, 9, 9, 255}, {9, 9, 9, 255}, {0, 1, 0}, 0, 1),
      Perspective({0, 0, 1}, {0, 0, 0}, 1.0F),
      Instances(2, {Item{{0, 5, -0.5F}, {100, 10, 1}, {255, 0, 0, 255}, 1, {0, 0, 0, 1}, 3}})};
  std::vector<Message> stream = scene;
  stream.push_back(RenderToPixels(7));
  const Outcome outcome = RunProgram({}, Join(stream));
  EXPECT_EQ(outcome.exit_code, kExitOk);
  const std::string& output = outcome.output;
  ASSERT_EQ(output.size(), 2 * sizeof(AnswerHeader) + 8 * (3 + 4 + 4));
  const char* layers = output.data() + 2 * sizeof(AnswerHeader);
  std::array<uint8_t, 24> colour;
  std::array<float, 8> depth;
  std::array<uint32_t, 8> item;
  std::memcpy(colour.data(), layers, sizeof colour);
  std::memcpy(depth.data(), layers + 24, sizeof depth);
  std::memcpy(item.data(), layers + 56, sizeof item);
  for (size_t i = 0; i < 8; ++i) {  // the upper row shows the box, the lower row nothing
    EXPECT_EQ(item[i], i < 4 ? 3U : 0U);
    EXPECT_NEAR(depth[i], i < 4 ? 1.0F : 0.0F, 1e-5F);
    EXPECT_EQ(colour[3 * i], i < 4 ? 255 : 9);
    EXPECT_EQ(colour[3 * i + 1], i < 4 ? 0 : 9);
  }
}

TEST_F(SessionTest, WritesAFileAndNothingElse) {
  auto scene = SmallScene();
  const fs::path path = folder_ / "ein Bild \xc3\xa4.png";
  scene.push_back(RenderToFile(path.string()));
  const auto replies = Replies(RunProgram({}, Join(scene)).output);
  ASSERT_EQ(replies.size(), 2U);
  EXPECT_EQ(replies[1].status, Status::kOk) << replies[1].payload;
  EXPECT_EQ(replies[1].payload, "");
  std::ifstream file(path, std::ios::binary);
  const std::string png((std::istreambuf_iterator<char>(file)), {});
  EXPECT_EQ(DecodedSize(png), (std::pair{80U, 60U}));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(SessionTest, AFileThatCannotBeWrittenIsAnAnswerNotAnEnd) {
  auto scene = SmallScene();
  scene.push_back(RenderToFile((folder_ / "no" / "such.png").string()));
  scene.push_back(RenderToAnswer());
  const Outcome outcome = RunProgram({}, Join(scene));
  EXPECT_EQ(outcome.exit_code, kExitOk);
  const auto replies = Replies(outcome.output);
  ASSERT_EQ(replies.size(), 3U);
  EXPECT_EQ(replies[1].status, Status::kOutput);
  EXPECT_NE(replies[1].payload.find("such.png\": No such file"), std::string::npos)
      << replies[1].payload;
  EXPECT_EQ(replies[2].status, Status::kOk);
}

TEST_F(SessionTest, SamplesAreCutToWhatTheProgramWasStartedWith) {
  auto with = SmallScene(), without = SmallScene();
  without[1] = Image(80, 60, 0, 1);
  with.push_back(RenderToAnswer());
  without.push_back(RenderToAnswer());
  const auto cut = Replies(RunProgram({"--samples", "0"}, Join(with)).output);
  const auto plain = Replies(RunProgram({}, Join(without)).output);
  const auto smooth = Replies(RunProgram({}, Join(with)).output);
  ASSERT_EQ(cut.size(), 2U);
  EXPECT_TRUE(cut[1].payload == plain[1].payload);
  EXPECT_FALSE(cut[1].payload == smooth[1].payload);
}

TEST_F(SessionTest, EndOfInputBetweenMessagesIsCleanInsideOneIsNot) {
  const std::string hello = Hello().Bytes();
  EXPECT_EQ(RunProgram({}, "").exit_code, kExitOk);
  EXPECT_EQ(RunProgram({}, hello).exit_code, kExitOk);
  for (const size_t cut : {1UL, 7UL, 8UL, hello.size() - 1}) {
    const Outcome outcome = RunProgram({}, hello.substr(0, cut));
    EXPECT_EQ(outcome.exit_code, kExitMalformed) << cut;
    const auto replies = Replies(outcome.output);
    ASSERT_EQ(replies.size(), 1U);
    EXPECT_EQ(replies[0].status, Status::kMalformed);
    EXPECT_NE(replies[0].payload.find("the input ends inside a message"), std::string::npos);
  }
}

TEST_F(SessionTest, MalformedInputEndsWithItsReasonOnBothOutputs) {
  const Outcome outcome =
      RunProgram({}, Join({Hello(), Instances(1, {Item{{0, 0, 0}, {-1, 0, 0}}})}));
  EXPECT_EQ(outcome.exit_code, kExitMalformed);
  const auto replies = Replies(outcome.output);
  ASSERT_EQ(replies.size(), 2U);
  EXPECT_EQ(replies[1].status, Status::kMalformed);
  EXPECT_EQ(replies[1].payload, "INSTANCES: size of row 0 is negative");
  EXPECT_NE(outcome.errors.find(replies[1].payload), std::string::npos);
}

// The whole program, including the graphics library, survives damaged streams.
TEST_F(SessionTest, DamagedStreamsEndWithExitCode0Or3) {
  auto scene = SmallScene();
  scene.push_back(RenderToAnswer());
  const std::string whole = Join(scene);
  const uint32_t seed = 987654;
  RecordProperty("seed", std::to_string(seed));
  std::mt19937 random(seed);
  Renderer renderer(4);
  const int nowhere = open("/dev/null", O_WRONLY);
  int malformed = 0;
  constexpr int kRounds = 400;
  for (int round = 0; round < kRounds; ++round) {
    std::string damaged = whole;
    const size_t header = Hello().Bytes().size();
    for (uint32_t hits = 1 + random() % 4; hits > 0; --hits) {
      damaged[header + random() % (damaged.size() - header)] = static_cast<char>(random());
    }
    FILE* input = tmpfile();
    fwrite(damaged.data(), 1, damaged.size(), input);
    rewind(input);
    testing::internal::CaptureStderr();
    const int code = Session(renderer, fileno(input), nowhere).Run();
    const std::string errors = testing::internal::GetCapturedStderr();
    fclose(input);
    ASSERT_TRUE(code == kExitOk || code == kExitMalformed) << "seed " << seed << " round " << round;
    EXPECT_EQ(code == kExitMalformed, errors.find("malformed") != std::string::npos);
    malformed += code == kExitMalformed;
  }
  close(nowhere);
  EXPECT_GT(malformed, kRounds / 10);
  EXPECT_LT(malformed, kRounds);
}

}  // namespace
}  // namespace vesper::render::test
