// SPDX-License-Identifier: Apache-2.0
// Pictures drawn for tests.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "renderer.hpp"
#include "scene_stream.hpp"
#include "stream_writer.hpp"

namespace vesper::render::test {

inline constexpr Rgba kBlack{0, 0, 0, 255}, kWhite{255, 255, 255, 255}, kRed{255, 0, 0, 255},
    kGreen{0, 255, 0, 255}, kBlue{0, 0, 255, 255};

/// A picture whose origin is its upper left.
struct Picture {
  Pixels pixels;

  Rgba At(uint32_t x, uint32_t y) const {
    const size_t at = (size_t{pixels.height - 1 - y} * pixels.width + x) * 3;
    return {pixels.rgb[at], pixels.rgb[at + 1], pixels.rgb[at + 2], 255};
  }

  /// Returns the pixels whose colour satisfies a predicate.
  template <class Predicate>
  std::vector<Eigen::Vector2i> Where(Predicate predicate) const {
    std::vector<Eigen::Vector2i> found;
    for (uint32_t y = 0; y < pixels.height; ++y) {
      for (uint32_t x = 0; x < pixels.width; ++x) {
        if (predicate(At(x, y))) found.emplace_back(x, y);
      }
    }
    return found;
  }
  std::vector<Eigen::Vector2i> Of(Rgba colour) const {
    return Where([&](Rgba pixel) { return pixel == colour; });
  }
};

class PictureTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    renderer_ = std::make_unique<Renderer>(16);
    decoder_ = std::make_unique<SceneDecoder>();
    Feed(Hello());
  }
  static void TearDownTestSuite() {
    decoder_.reset();
    renderer_.reset();
  }

  /// Draws with a black background, one sample and no shadows, unless the messages set other
  /// values.
  static Picture Draw(const std::vector<Message>& messages) {
    Compose(messages);
    const Picture picture{renderer_->Render(decoder_->scene())};
    decoder_->NextPicture();
    return picture;
  }

  /// Returns item and depth of each pixel of that picture, rows from the bottom.
  static Seen Sense(const std::vector<Message>& messages) {
    Compose(messages);
    const Seen seen = renderer_->Sense(decoder_->scene());
    decoder_->NextPicture();
    return seen;
  }

 private:
  static void Compose(const std::vector<Message>& messages) {
    Feed(Image(400, 300, 0, 0));
    Feed(Environment(kBlack, kBlack, {0, 1, 0}, 0.5F, 0.25F));
    for (const Message& message : messages) Feed(message);
  }
  static void Feed(const Message& message) {
    const std::string bytes = message.Bytes();
    MessageHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    decoder_->Decode(static_cast<MessageType>(header.type),
                     std::as_bytes(std::span(bytes)).subspan(sizeof header));
  }

  static inline std::unique_ptr<SceneDecoder> decoder_;
  static inline std::unique_ptr<Renderer> renderer_;
};

inline Item Unlit(Vec3 position, Vec3 size, Rgba colour) {
  return {position, size, colour, kUnlit};
}

}  // namespace vesper::render::test
