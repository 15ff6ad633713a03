// SPDX-License-Identifier: Apache-2.0
#include "session.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <system_error>

namespace vesper::render {

namespace {

/// Step by which the payload buffer grows as bytes arrive [B]. Therefore a message that claims a
/// large length, but is short, does not allocate much memory.
constexpr size_t kGrowth = 1 << 20;

using Clock = std::chrono::steady_clock;

uint32_t MicrosecondsSince(Clock::time_point start) {
  const auto elapsed = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - start);
  return static_cast<uint32_t>(std::min<int64_t>(elapsed.count(), UINT32_MAX));
}

}  // namespace

int Session::Run() {
  try {
    MessageHeader header;
    while (ReadMessage(header)) {
      Serve(decoder_.Decode(static_cast<MessageType>(header.type), payload_));
    }
    return kExitOk;
  } catch (const MalformedStream& problem) {
    std::fprintf(stderr, "vesper-render: malformed scene stream: %s\n", problem.what());
    Answer(Status::kMalformed, 0, problem.what(), std::strlen(problem.what()));
    return kExitMalformed;
  }
}

bool Session::ReadMessage(MessageHeader& header) {
  const size_t got = ReadFully(&header, sizeof header);
  if (got == 0) return false;
  if (got < sizeof header) throw MalformedStream("the input ends inside a message header");
  decoder_.CheckHeader(header);
  payload_.clear();
  while (payload_.size() < header.length) {
    const size_t have = payload_.size(), more = std::min(kGrowth, header.length - have);
    payload_.resize(have + more);
    if (ReadFully(payload_.data() + have, more) < more) {
      throw MalformedStream("the input ends inside a message of " + std::to_string(header.length) +
                            " bytes");
    }
  }
  return true;
}

size_t Session::ReadFully(void* to, size_t bytes) {
  size_t done = 0;
  while (done < bytes) {
    const ssize_t got = read(input_, static_cast<char*>(to) + done, bytes - done);
    if (got == 0) break;
    if (got > 0)
      done += static_cast<size_t>(got);
    else if (errno != EINTR)
      throw std::system_error(errno, std::generic_category(), "input");
  }
  return done;
}

void Session::Serve(const Request& request) {
  if (request.kind == Request::Kind::kNothing) return;
  if (request.kind == Request::Kind::kHello) return Answer(Status::kOk, 0, nullptr, 0);
  const auto start = Clock::now();
  const auto refuse = [&](Status status, const std::exception& problem) {
    Answer(status, MicrosecondsSince(start), problem.what(), std::strlen(problem.what()));
  };
  try {
    if (request.kind == Request::Kind::kPixels) {
      CollectPixels(request.layers);
    } else {
      EncodePng(renderer_.Render(decoder_.scene()), answer_);
    }
    decoder_.NextPicture();
  } catch (const GraphicsError& problem) {
    decoder_.NextPicture();
    return refuse(Status::kGraphics, problem);
  }
  if (request.kind != Request::Kind::kFile) {
    return Answer(Status::kOk, MicrosecondsSince(start), answer_.data(), answer_.size());
  }
  try {
    WriteFileAtOnce(request.path, answer_);
  } catch (const std::runtime_error& problem) {
    return refuse(Status::kOutput, problem);
  }
  Answer(Status::kOk, MicrosecondsSince(start), nullptr, 0);
}

void Session::CollectPixels(uint32_t layers) {
  answer_.clear();
  const auto append = [this](const void* rows, size_t row_bytes, size_t height) {
    const auto* first = static_cast<const std::byte*>(rows);
    for (size_t row = height; row-- > 0;) {  // `pixels` begins with the bottom row, the output with
                                             // the top row
      answer_.insert(answer_.end(), first + row * row_bytes, first + (row + 1) * row_bytes);
    }
  };
  if (layers & kColourLayer) {
    const Pixels& pixels = renderer_.Render(decoder_.scene());
    append(pixels.rgb.data(), size_t{pixels.width} * 3, pixels.height);
  }
  if ((layers & (kDepthLayer | kItemLayer)) == 0) return;
  const Seen& seen = renderer_.Sense(decoder_.scene());
  if (layers & kDepthLayer) append(seen.depth.data(), seen.width * sizeof(float), seen.height);
  if (layers & kItemLayer) append(seen.item.data(), seen.width * sizeof(uint32_t), seen.height);
}

void Session::Answer(Status status, uint32_t microseconds, const void* payload, size_t bytes) {
  const AnswerHeader header{static_cast<uint32_t>(status), microseconds,
                            static_cast<uint32_t>(bytes)};
  const auto write_fully = [this](const void* from, size_t count) {
    for (size_t done = 0; done < count;) {
      const ssize_t put = write(output_, static_cast<const char*>(from) + done, count - done);
      if (put >= 0)
        done += static_cast<size_t>(put);
      else if (errno != EINTR)
        throw std::system_error(errno, std::generic_category(), "output");
    }
  };
  write_fully(&header, sizeof header);
  write_fully(payload, bytes);
}

}  // namespace vesper::render
