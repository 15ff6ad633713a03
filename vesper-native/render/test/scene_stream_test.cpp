// SPDX-License-Identifier: Apache-2.0
#include "scene_stream.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "stream_writer.hpp"

namespace vesper::render::test {
namespace {

using testing::Test;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Passes whole messages to a decoder, as the session does.
Request Feed(SceneDecoder& decoder, const Message& message) {
  const std::string bytes = message.Bytes();
  MessageHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  decoder.CheckHeader(header);
  return decoder.Decode(static_cast<MessageType>(header.type),
                        std::as_bytes(std::span(bytes)).subspan(sizeof header));
}

Request FeedAll(const std::vector<Message>& messages) {
  SceneDecoder decoder;
  Request last;
  for (const Message& message : messages) last = Feed(decoder, message);
  return last;
}

/// Returns the decoder's error for the last of `messages`, after the decoder has accepted the other
/// messages. Returns "" if it accepts all of them.
std::string Refusal(const std::vector<Message>& messages) {
  SceneDecoder decoder;
  for (size_t i = 0; i + 1 < messages.size(); ++i) Feed(decoder, messages[i]);
  try {
    Feed(decoder, messages.back());
    return "";
  } catch (const MalformedStream& problem) {
    return problem.what();
  }
}

Message Camera() { return Perspective({0, 0, 10}, {0, 0, 0}, 0.5F); }

TEST(SceneStream, ColumnsArriveInTheirRows) {
  SceneDecoder decoder;
  Feed(decoder, Hello());
  Feed(decoder, Instances(2, {{{1, 2, 3}, {4, 5, 6}, {7, 8, 9, 10}, 1, {0, 0, 0, 1}},
                              {{-1, -2, -3}, {0, 0, 0}, {0, 0, 0, 0}, 4, {1, 0, 0, 0}}}));
  Feed(decoder, Segments({{{1, 0, 0}, {0, 1, 0}, {1, 2, 3, 4}}}, 2.5F));
  const Scene& scene = decoder.scene();
  ASSERT_EQ(scene.batches.size(), 1U);
  ASSERT_EQ(scene.batches[0].instances.size(), 2U);
  const Instance &first = scene.batches[0].instances[0], &second = scene.batches[0].instances[1];
  EXPECT_EQ(scene.batches[0].shape, Shape::kBox);
  EXPECT_EQ(first.position, Vector3f(1, 2, 3));
  EXPECT_EQ(first.size, Vector3f(4, 5, 6));
  EXPECT_EQ(first.colour, (Colour{7, 8, 9, 10}));
  EXPECT_EQ(first.flags, kUnlit);
  EXPECT_EQ(second.position, Vector3f(-1, -2, -3));
  EXPECT_EQ(second.orientation.x(), 1);
  EXPECT_EQ(second.orientation.w(), 0);
  EXPECT_EQ(second.flags, kFade);
  ASSERT_EQ(scene.segments.size(), 1U);
  EXPECT_EQ(scene.segments[0].to, Vector3f(0, 1, 0));
  EXPECT_EQ(scene.segments[0].width, 2.5F);
}

TEST(SceneStream, NextPictureForgetsItemsAndKeepsMeshesAndTextures) {
  SceneDecoder decoder;
  Feed(decoder, Hello());
  Feed(decoder, Mesh(7, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}));
  Feed(decoder, Instances(4, {Item{}}, 7));
  Feed(decoder, Segments({{{0, 0, 0}, {1, 0, 0}}}, 1));
  Feed(decoder, Texture(3, 1, 1, {{1, 2, 3, 4}}));
  Feed(decoder, Material(1, {}, 0, 0, 3));
  Feed(decoder, Triangles({{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {}}}));
  decoder.NextPicture();
  EXPECT_TRUE(decoder.scene().batches.empty());
  EXPECT_TRUE(decoder.scene().materials.empty());
  EXPECT_TRUE(decoder.scene().triangles.empty());
  EXPECT_EQ(decoder.scene().textures.at(3).pixels, (std::vector<uint8_t>{1, 2, 3, 4}));
  EXPECT_TRUE(decoder.scene().segments.empty());
  EXPECT_EQ(decoder.scene().meshes.count(7), 1U);
  Feed(decoder, Mesh(7, {}, {}));
  EXPECT_TRUE(decoder.scene().meshes.empty());
}

TEST(SceneStream, RenderSaysWhereThePictureGoes) {
  EXPECT_EQ(FeedAll({Hello()}).kind, Request::Kind::kHello);
  EXPECT_EQ(FeedAll({Hello(), Camera()}).kind, Request::Kind::kNothing);
  EXPECT_EQ(FeedAll({Hello(), Camera(), RenderToAnswer()}).kind, Request::Kind::kPng);
  const Request file = FeedAll({Hello(), Camera(), RenderToFile("a b.png")});
  EXPECT_EQ(file.kind, Request::Kind::kFile);
  EXPECT_EQ(file.path, "a b.png");
}

TEST(SceneStream, BreachesAreRefusedWithTheirReason) {
  const Item item;
  const Rgba white{255, 255, 255, 255};
  const Message triangle = Mesh(1, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  const auto with_item = [&](auto change) {
    Item changed = item;
    change(changed);
    return std::vector{Hello(), Instances(1, {item, changed})};
  };
  const std::vector<std::pair<std::vector<Message>, std::string>> cases{
      {{Camera()}, "HELLO must come first, found CAMERA"},
      {{Hello(), Hello()}, "a second HELLO"},
      {{Message(1).Text("GIF8").U32(1)}, "does not begin with \"VSCN\""},
      {{Message(1).Text("VSCN").U32(9)}, "version 9, this program speaks 3"},
      {{Hello(), Message(99)}, "unknown message type 99"},
      {{Hello(), Message(2).U32(1)}, "IMAGE: too short for height: 4 bytes needed, 0 left"},
      {{Hello(), Image(64, 64, 0, 0).U32(5)}, "IMAGE: 4 bytes too many"},
      {{Hello(), Image(0, 64, 0, 0)}, "IMAGE: width is 0, expected 1 to 8192"},
      {{Hello(), Image(8192, 8192, 0, 0)}, "8192 x 8192 pixels"},
      {{Hello(), Image(64, 64, 17, 0)}, "samples is 17"},
      {{Hello(), Image(64, 64, 0, 2)}, "image flags is 2"},
      {{Hello(), Perspective({0, 0, kNan}, {0, 0, 0}, 1)}, "CAMERA: eye is not finite"},
      {{Hello(), Perspective({0, 0, 1}, {0, 0, 2e15F}, 1)}, "CAMERA: target is not finite"},
      {{Hello(), Perspective({1, 2, 3}, {1, 2, 3}, 1)}, "eye and target are the same point"},
      {{Hello(), Perspective({0, 5, 0}, {0, 0, 0}, 1)}, "up is zero or parallel"},
      {{Hello(), Perspective({0, 0, 5}, {0, 0, 0}, 1, {0, 0, 0})}, "up is zero or parallel"},
      {{Hello(), Perspective({0, 0, 5}, {0, 0, 0}, kNan)}, "vertical field of view is nan"},
      {{Hello(), Orthographic({0, 0, 5}, {0, 0, 0}, 0)}, "height of the view is 0"},
      {{Hello(), Environment({}, {}, {0, 0, 0}, 1, 1)}, "direction to the light is zero"},
      {{Hello(), Environment({}, {}, {0, 1, 0}, -1, 1)}, "light is -1, expected 0 to 8"},
      {{Hello(), Message(5).U32(1).U32(~0U).U32(0).U32(0)}, "number of vertices is 4294967295"},
      {{Hello(), Message(5).U32(1).U32(1000).U32(0).U32(0)},
       "MESH: too short for position: 12000 bytes needed, 0 left"},
      {{Hello(), Mesh(1, {{0, 0, 0}, {0, kInfinity, 0}}, {})}, "position of row 1 is not finite"},
      {{Hello(), Mesh(1, {{0, 0, 0}}, {{0, 0, 1}})}, "triangle of row 0 refers to vertex 1 of 1"},
      {{Hello(), Mesh(1, {{0, 0, 0}}, {}), Instances(4, {item}, 1), Mesh(1, {}, {})},
       "id 1 is in use by INSTANCES"},
      {{Hello(), Instances(4, {item}, 3)}, "mesh 3 is not known"},
      {{Hello(), Instances(5, {item})}, "shape is 5, expected 1 to 4"},
      {{Hello(), Message(6).U32(1).U32(0).Put(Part{}).U32(1U << 20)}, "too short for position"},
      {{Hello(), Message(6).U32(1).U32(0).Put(Part{}).U32(~0U)},
       "number of instances is 4294967295"},
      {with_item([](Item& i) { i.position[2] = kNan; }), "position of row 1 is not finite"},
      {with_item([](Item& i) { i.size[0] = -1; }), "size of row 1 is negative"},
      {with_item([](Item& i) { i.orientation[3] = 2; }), "orientation of row 1 has the length 2"},
      {with_item([](Item& i) { i.orientation[3] = 0; }), "expected a unit quaternion"},
      {with_item([](Item& i) { i.flags = 8; }), "item flags of row 1 has unknown bits: 8"},
      {{Hello(), Message(5).U32(1).U32(3).U32(1).U32(8)}, "attributes is 8, expected 0 to 7"},
      {{Hello(), Instances(1, {item}, 0, {1})}, "material 1 is not known"},
      {{Hello(), triangle, Instances(4, {item}, 1, {0, 1, 1})}, "triangles 1 to 2 of a shape that"},
      {{Hello(), triangle, Instances(4, {item}, 1, {0, ~0U, 2})}, "triangles 4294967295 to 429"},
      {{Hello(), Instances(2, {item}, 0, {0, 0, 1})}, "triangles 0 to 1 of a shape that has 0"},
      {{Hello(), Texture(0, 1, 1, {white})}, "0 is no id"},
      {{Hello(), Texture(1, 2, 1, {white})}, "TEXTURE: too short for pixels: 8 bytes needed, 4"},
      {{Hello(), Message(9).U32(1).U32(8192).U32(8192)}, "67108864 pixels, at most 16777216"},
      {{Hello(), Material(1, white, 0, 0, 3)}, "texture 3 is not known"},
      {{Hello(), Material(0, white, 0, 0)}, "id 0 is the default"},
      {{Hello(), Material(1, white, 0, 0), Material(1, white, 0, 0)}, "id 1 is taken"},
      {{Hello(), Material(1, white, 1.5F, 0)}, "roughness is 1.5, expected 0 to 1"},
      {{Hello(), Material(1, white, 0, kNan)}, "metallic is nan"},
      {{Hello(), Texture(1, 1, 1, {white}), Material(1, white, 0, 0, 1), Texture(1, 0, 0, {})},
       "id 1 is in use by a MATERIAL"},
      {{Hello(), Triangles({{{{{0, 0, 0}, {0, kNan, 0}, {0, 0, 0}}}, {}}})},
       "corners of row 0 is not finite"},
      {{Hello(), Message(11).U32(~0U)}, "number of triangles is 4294967295"},
      {{Hello(), Segments({{{0, 0, 0}, {1, 0, 0}}}, 0)}, "width is 0, expected 0.25 to 64"},
      {{Hello(), Segments({{{0, 0, 0}, {kNan, 0, 0}}}, 1)}, "to of row 0 is not finite"},
      {{Hello(), RenderToAnswer()}, "no CAMERA came before it"},
      {{Hello(), Camera(), Message(8).U32(3)}, "destination is 3, expected 0 to 2"},
      {{Hello(), Camera(), RenderToPixels(8)}, "layers is 8, expected 1 to 7"},
      {{Hello(), Camera(), Message(8).U32(2)}, "too short for layers"},
      {{Hello(), Orthographic({0, 0, 5}, {0, 0, 0}, 2), RenderToPixels(2)},
       "no depth with an orthographic camera"},
      {{Hello(), Camera(), RenderToFile("")}, "needs a path"},
      {{Hello(), Camera(), Message(8).U32(0).Text("x")}, "has no path, found 1 bytes"},
      {{Hello(), Camera(), RenderToFile(std::string("a\0b", 3))}, "has a zero byte in it"},
  };
  for (const auto& [messages, reason] : cases) {
    const std::string refusal = Refusal(messages);
    EXPECT_NE(refusal.find(reason), std::string::npos)
        << "expected: " << reason << "\nfound: " << refusal;
  }
}

TEST(SceneStream, AMessageOfMoreThanTheLimitIsRefusedByItsHeader) {
  SceneDecoder decoder;
  Feed(decoder, Hello());
  EXPECT_NO_THROW(decoder.CheckHeader({6, kMaxMessageBytes}));
  EXPECT_THROW(decoder.CheckHeader({6, kMaxMessageBytes + 1}), MalformedStream);
}

// The scene must obey the rules of the renderer if a decoder accepts a damaged message.
TEST(SceneStream, DamagedMessagesAreRefusedOrWithinTheRules) {
  const uint32_t seed = 20260411;
  RecordProperty("seed", std::to_string(seed));
  std::mt19937 random(seed);
  const std::vector<Message> whole{Hello(),
                                   Image(64, 48, 4, 1),
                                   Camera(),
                                   Environment({}, {}, {0, 1, 0}, 1, 0.5F),
                                   Mesh(1, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}),
                                   Instances(4, {Item{}, Item{}}, 1),
                                   Instances(1, {Item{}, Item{}, Item{}}),
                                   Segments({{{0, 0, 0}, {1, 0, 0}}}, 2),
                                   RenderToAnswer()};
  int refused = 0;
  constexpr int kRounds = 20'000;
  for (int round = 0; round < kRounds; ++round) {
    SceneDecoder decoder;
    const size_t victim = random() % whole.size();
    try {
      for (size_t i = 0; i < whole.size(); ++i) {
        std::string payload = whole[i].payload();
        if (i == victim) {
          for (uint32_t hits = 1 + random() % 3; hits > 0 && !payload.empty(); --hits) {
            const size_t at = random() % payload.size();
            if (random() % 4 == 0)
              payload.resize(at);
            else
              payload[at] = static_cast<char>(random());
          }
        }
        // The copy has exactly this size, so that the address sanitizer detects an access past the
        // end.
        const std::vector<char> exact(payload.begin(), payload.end());
        MessageHeader header;
        std::memcpy(&header, whole[i].Bytes().data(), sizeof header);
        decoder.Decode(static_cast<MessageType>(header.type), std::as_bytes(std::span(exact)));
      }
    } catch (const MalformedStream& problem) {
      EXPECT_GT(std::string(problem.what()).size(), 10U);
      ++refused;
    }
    for (const InstanceBatch& batch : decoder.scene().batches) {
      for (const Instance& instance : batch.instances) {
        ASSERT_TRUE(instance.position.allFinite() && instance.size.minCoeff() >= 0) << seed;
      }
    }
    for (const auto& [id, mesh] : decoder.scene().meshes) {
      for (const uint32_t index : mesh.indices) ASSERT_LT(index, mesh.positions.size()) << seed;
    }
  }
  EXPECT_GT(refused, kRounds / 4);
  EXPECT_LT(refused, kRounds);
}

}  // namespace
}  // namespace vesper::render::test
