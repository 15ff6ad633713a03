// SPDX-License-Identifier: Apache-2.0
#include "renderer.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "shaders.hpp"

namespace vesper::render {

namespace {

constexpr int kShadowSide = 2048;  // [px]

const void* Offset(size_t bytes) { return reinterpret_cast<const void*>(bytes); }

template <class T>
void Fill(const Gl& gl, GLenum where, const GlObject& buffer, const std::vector<T>& content,
          GLenum usage) {
  gl.BindBuffer(where, buffer.id());
  gl.BufferData(where, static_cast<GLsizeiptr>(content.size() * sizeof(T)), content.data(), usage);
}

bool CastsShadow(const DrawKey& key) { return key.mesh.shape != Shape::kPlane; }

/// Returns the exponent of the highlight (Blinn-Phong) that matches a roughness: 2 / roughness^4 -
/// 2.
double GlossExponent(double roughness) {
  return std::clamp(2 / std::pow(roughness, 4) - 2, 0.5, 2000.0);
}

}  // namespace

Renderer::Renderer(uint32_t max_samples)
    : gl_(context_),
      max_samples_(std::min(max_samples, static_cast<uint32_t>(gl_.Integer(GL_MAX_SAMPLES)))),
      vertex_array_(MakeVertexArray(gl_)),
      instance_buffer_(MakeBuffer(gl_)),
      line_buffer_(MakeBuffer(gl_)),
      line_indices_(MakeBuffer(gl_)),
      background_(gl_, shaders::kBackgroundVertex,
                  shaders::kBackground + shaders::kBackgroundFragment),
      shadow_program_(gl_, shaders::kInstanceAttributes + shaders::kShadowVertex,
                      shaders::kShadowFragment),
      line_program_(gl_, shaders::kLineVertex, shaders::kLineFragment),
      sense_program_(gl_, shaders::kInstanceAttributes + shaders::kSenseVertex,
                     shaders::kSenseFragment),
      sense_line_program_(gl_, shaders::kSenseLineVertex, shaders::kSenseFragment) {
  gl_.BindVertexArray(vertex_array_.id());
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.Enable(GL_FRAMEBUFFER_SRGB);
  gl_.DepthFunc(GL_LEQUAL);
}

GraphicsInfo Renderer::Info() const {
  return {gl_.Text(GL_VENDOR), gl_.Text(GL_RENDERER), gl_.Text(GL_VERSION),
          gl_.Integer(GL_MAX_SAMPLES), gl_.Integer(GL_MAX_RENDERBUFFER_SIZE)};
}

View Renderer::Prepare(const Scene& scene, const Extent& extent) {
  const View view(scene.camera, scene.image, extent);
  Sort(scene, view, list_);
  PrepareMeshes(scene, view);
  UploadInstances();
  return view;
}

const Pixels& Renderer::Render(const Scene& scene) {
  PrepareTarget(scene.image);
  const Extent extent = Measure(scene);
  const View view = Prepare(scene, extent);
  PrepareTextures(scene);

  std::optional<Eigen::Matrix4f> shadow;
  if (scene.image.shadows && scene.environment.light > 0 && !extent.casters.empty()) {
    shadow = ShadowMatrix(scene.environment.to_light, extent.casters);
    DrawShadowMap(*shadow);
  }
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_->framebuffer.id());
  gl_.Viewport(0, 0, static_cast<GLsizei>(target_->width), static_cast<GLsizei>(target_->height));
  DrawBackground(scene);
  gl_.Enable(GL_DEPTH_TEST);
  DrawSurfaces(scene, view, shadow ? &*shadow : nullptr);
  DrawLines(scene, view, line_program_);
  gl_.Disable(GL_DEPTH_TEST);
  ReadPixels();
  gl_.Check("drawing");
  return pixels_;
}

const Seen& Renderer::Sense(const Scene& scene) {
  PrepareSenseTarget(scene.image);
  const View view = Prepare(scene, Measure(scene));
  const auto width = static_cast<GLsizei>(scene.image.width);
  const auto height = static_cast<GLsizei>(scene.image.height);
  const GLuint nothing[4] = {};
  const GLfloat nowhere[4] = {};
  gl_.BindFramebuffer(GL_FRAMEBUFFER, sense_target_->framebuffer.id());
  gl_.Viewport(0, 0, width, height);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  gl_.ClearBufferuiv(GL_COLOR, 0, nothing);
  gl_.ClearBufferfv(GL_COLOR, 1, nowhere);
  gl_.Enable(GL_DEPTH_TEST);
  sense_program_.Use();
  gl_.UniformMatrix4fv(sense_program_["clip"], 1, GL_FALSE, view.clip().data());
  for (const Draw& draw : draws_) {
    if (draw.mesh->closed) gl_.Enable(GL_CULL_FACE);
    DrawInstances(draw);
    gl_.Disable(GL_CULL_FACE);
  }
  DrawLines(scene, view, sense_line_program_);
  gl_.Disable(GL_DEPTH_TEST);

  seen_.width = scene.image.width;
  seen_.height = scene.image.height;
  seen_.item.resize(size_t{seen_.width} * seen_.height);
  seen_.depth.resize(seen_.item.size());
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_.ReadPixels(0, 0, width, height, GL_RED_INTEGER, GL_UNSIGNED_INT, seen_.item.data());
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT1);
  gl_.ReadPixels(0, 0, width, height, GL_RED, GL_FLOAT, seen_.depth.data());
  gl_.Check("sensing");
  return seen_;
}

GlObject Renderer::MakeStorage(const Image& image, uint32_t samples, GLenum format) const {
  GlObject storage = MakeRenderbuffer(gl_);
  gl_.BindRenderbuffer(GL_RENDERBUFFER, storage.id());
  gl_.RenderbufferStorageMultisample(GL_RENDERBUFFER, static_cast<GLsizei>(samples), format,
                                     static_cast<GLsizei>(image.width),
                                     static_cast<GLsizei>(image.height));
  return storage;
}

void Renderer::Attach(const GlObject& framebuffer, const GlObject& colour,
                      const GlObject* depth) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
  gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour.id());
  if (depth != nullptr) {
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth->id());
  }
  if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw GraphicsError(
        "the graphics library offers no sRGB picture of this size and number of "
        "samples; ask for a smaller one or for 0 samples");
  }
}

void Renderer::PrepareTarget(const Image& image) {
  const uint32_t wanted = std::min(image.samples, max_samples_);
  const uint32_t samples = wanted > 1 ? wanted : 0;
  if (target_ && target_->width == image.width && target_->height == image.height &&
      target_->samples == samples) {
    return;
  }
  target_.reset();
  Target target{image.width, image.height, samples, {}, {}, {}, {}, {}};
  target.colour = MakeStorage(image, samples, GL_SRGB8_ALPHA8);
  target.depth = MakeStorage(image, samples, GL_DEPTH_COMPONENT24);
  target.framebuffer = MakeFramebuffer(gl_);
  if (samples > 0) {
    target.averaged = MakeStorage(image, 0, GL_SRGB8_ALPHA8);
    target.averaged_framebuffer = MakeFramebuffer(gl_);
  }
  gl_.Check("making room for a picture");
  Attach(target.framebuffer, target.colour, &target.depth);
  if (samples > 0) Attach(target.averaged_framebuffer, target.averaged, nullptr);
  target_ = std::move(target);
}

void Renderer::PrepareSenseTarget(const Image& image) {
  if (sense_target_ && sense_target_->width == image.width &&
      sense_target_->height == image.height) {
    return;
  }
  sense_target_.reset();
  SenseTarget target{image.width,
                     image.height,
                     MakeStorage(image, 0, GL_R32UI),
                     MakeStorage(image, 0, GL_R32F),
                     MakeStorage(image, 0, GL_DEPTH_COMPONENT32F),
                     MakeFramebuffer(gl_)};
  gl_.Check("making room for what is sensed");
  Attach(target.framebuffer, target.item, &target.depth);
  gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_RENDERBUFFER,
                              target.distance.id());
  constexpr GLenum kBoth[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  gl_.DrawBuffers(2, kBoth);
  if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw GraphicsError("the graphics library cannot draw numbers of items and depths at once");
  }
  sense_target_ = std::move(target);
}

void Renderer::ReadPixels() {
  const auto width = static_cast<GLsizei>(target_->width);
  const auto height = static_cast<GLsizei>(target_->height);
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, target_->framebuffer.id());
  if (target_->samples > 0) {
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, target_->averaged_framebuffer.id());
    gl_.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, target_->averaged_framebuffer.id());
  }
  pixels_.width = target_->width;
  pixels_.height = target_->height;
  pixels_.rgb.resize(size_t{target_->width} * target_->height * 3);
  gl_.ReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, pixels_.rgb.data());
}

Renderer::GpuMesh Renderer::Upload(const TriangleMesh& mesh, bool closed) const {
  GpuMesh uploaded{MakeBuffer(gl_), MakeBuffer(gl_), static_cast<GLsizei>(mesh.indices.size()), 0,
                   closed};
  Fill(gl_, GL_ARRAY_BUFFER, uploaded.vertices, mesh.vertices, GL_STATIC_DRAW);
  Fill(gl_, GL_ELEMENT_ARRAY_BUFFER, uploaded.indices, mesh.indices, GL_STATIC_DRAW);
  gl_.Check("uploading a mesh");
  return uploaded;
}

void Renderer::PrepareMeshes(const Scene& scene, const View& view) {
  std::erase_if(meshes_, [&](const auto& entry) {
    if (entry.first.shape != Shape::kMesh) return false;
    if (entry.first.detail == kLooseTriangles) return true;
    const auto mesh = scene.meshes.find(static_cast<uint32_t>(entry.first.detail));
    return mesh == scene.meshes.end() || mesh->second.revision != entry.second.revision;
  });
  for (const auto& [draw, records] : list_) {
    const MeshKey& key = draw.mesh;
    if (meshes_.contains(key)) continue;
    switch (key.shape) {
      case Shape::kSphere:
        meshes_[key] = Upload(UnitSphere(static_cast<int>(key.detail)), true);
        break;
      case Shape::kBox:
        meshes_[key] = Upload(UnitBox(), true);
        break;
      case Shape::kPlane:
        meshes_[key] = Upload(UnitPlane(), false);
        break;
      case Shape::kMesh: {
        if (key.detail == kLooseTriangles) {
          meshes_[key] = Upload(ToTriangles(scene.triangles, view.origin()), false);
          break;
        }
        const Mesh& mesh = scene.meshes.at(static_cast<uint32_t>(key.detail));
        GpuMesh uploaded = Upload(ToTriangles(mesh), false);
        uploaded.revision = mesh.revision;
        meshes_[key] = std::move(uploaded);
        break;
      }
    }
  }
}

void Renderer::PrepareTextures(const Scene& scene) {
  std::erase_if(textures_, [&](const auto& entry) {
    const auto texture = scene.textures.find(entry.first);
    return texture == scene.textures.end() || texture->second.revision != entry.second.revision;
  });
  for (const auto& [id, material] : scene.materials) {
    if (material.texture == 0 || textures_.contains(material.texture)) continue;
    const Texture& texture = scene.textures.at(material.texture);
    GpuTexture uploaded{MakeTexture(gl_), texture.revision};
    gl_.BindTexture(GL_TEXTURE_2D, uploaded.pixels.id());
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, static_cast<GLsizei>(texture.width),
                   static_cast<GLsizei>(texture.height), 0, GL_RGBA, GL_UNSIGNED_BYTE,
                   texture.pixels.data());
    gl_.GenerateMipmap(GL_TEXTURE_2D);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl_.Check("uploading a texture");
    textures_[material.texture] = std::move(uploaded);
  }
}

void Renderer::UploadInstances() {
  draws_.clear();
  size_t count = 0;
  for (const auto& [key, records] : list_) {
    draws_.push_back({key, &meshes_.at(key.mesh), count, static_cast<GLsizei>(records.size())});
    count += records.size();
  }
  constexpr size_t kBytes = sizeof(InstanceRecord);
  gl_.BindBuffer(GL_ARRAY_BUFFER, instance_buffer_.id());
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(count * kBytes), nullptr, GL_STREAM_DRAW);
  for (const Draw& draw : draws_) {
    gl_.BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(draw.first * kBytes),
                      static_cast<GLsizeiptr>(draw.count * kBytes), list_.at(draw.key).data());
  }
  gl_.Check("uploading instances");
}

void Renderer::DrawInstances(const Draw& draw) const {
  const auto per_vertex = [&](GLuint at, GLint components, size_t offset) {
    gl_.EnableVertexAttribArray(at);
    gl_.VertexAttribPointer(at, components, GL_FLOAT, GL_FALSE, sizeof(Vertex), Offset(offset));
    gl_.VertexAttribDivisor(at, 0);
  };
  gl_.BindBuffer(GL_ARRAY_BUFFER, draw.mesh->vertices.id());
  per_vertex(0, 3, offsetof(Vertex, position));
  per_vertex(1, 3, offsetof(Vertex, normal));
  per_vertex(7, 2, offsetof(Vertex, coordinates));
  per_vertex(8, 3, offsetof(Vertex, colour));
  gl_.EnableVertexAttribArray(10);
  gl_.VertexAttribIPointer(10, 1, GL_UNSIGNED_INT, sizeof(Vertex), Offset(offsetof(Vertex, item)));
  gl_.VertexAttribDivisor(10, 0);

  constexpr GLsizei kBytes = sizeof(InstanceRecord);
  const size_t first = draw.first * kBytes;
  gl_.BindBuffer(GL_ARRAY_BUFFER, instance_buffer_.id());
  for (GLuint row = 0; row < 3; ++row) {
    gl_.VertexAttribPointer(2 + row, 4, GL_FLOAT, GL_FALSE, kBytes,
                            Offset(first + row * 4 * sizeof(float)));
  }
  gl_.VertexAttribPointer(5, 3, GL_FLOAT, GL_FALSE, kBytes,
                          Offset(first + offsetof(InstanceRecord, colour)));
  gl_.VertexAttribIPointer(6, 1, GL_UNSIGNED_INT, kBytes,
                           Offset(first + offsetof(InstanceRecord, flags)));
  gl_.VertexAttribIPointer(9, 1, GL_UNSIGNED_INT, kBytes,
                           Offset(first + offsetof(InstanceRecord, item)));
  for (const GLuint at : {2, 3, 4, 5, 6, 9}) {
    gl_.EnableVertexAttribArray(at);
    gl_.VertexAttribDivisor(at, 1);
  }
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, draw.mesh->indices.id());
  const GLsizei indices = draw.key.triangle_count > 0
                              ? static_cast<GLsizei>(draw.key.triangle_count * 3)
                              : draw.mesh->index_count;
  gl_.DrawElementsInstanced(GL_TRIANGLES, indices, GL_UNSIGNED_INT,
                            Offset(size_t{draw.key.first_triangle} * 3 * sizeof(uint32_t)),
                            draw.count);
}

void Renderer::PrepareShadowMap() {
  if (shadow_map_) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, shadow_map_->framebuffer.id());
    return;
  }
  ShadowMap map{MakeTexture(gl_), MakeFramebuffer(gl_)};
  gl_.BindTexture(GL_TEXTURE_2D, map.depth.id());
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, kShadowSide, kShadowSide, 0,
                 GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  // Points outside of the shadow map are lit.
  const float border[] = {1, 1, 1, 1};
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  gl_.TexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, border);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, map.framebuffer.id());
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, map.depth.id(), 0);
  gl_.DrawBuffer(GL_NONE);
  gl_.ReadBuffer(GL_NONE);
  gl_.Check("making room for shadows");
  shadow_map_ = std::move(map);
}

void Renderer::DrawShadowMap(const Eigen::Matrix4f& matrix) {
  PrepareShadowMap();
  gl_.Viewport(0, 0, kShadowSide, kShadowSide);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  gl_.Enable(GL_POLYGON_OFFSET_FILL);
  gl_.PolygonOffset(1.5F, 4);
  shadow_program_.Use();
  gl_.UniformMatrix4fv(shadow_program_["shadow_matrix"], 1, GL_FALSE, matrix.data());
  for (const Draw& draw : draws_) {
    if (CastsShadow(draw.key)) DrawInstances(draw);
  }
  gl_.Disable(GL_POLYGON_OFFSET_FILL);
  gl_.Disable(GL_DEPTH_TEST);
}

void Renderer::SetBackground(const Program& program, const Scene& scene) const {
  const auto top = ToLinear(scene.environment.top), bottom = ToLinear(scene.environment.bottom);
  gl_.Uniform3fv(program["background_top"], 1, top.data());
  gl_.Uniform3fv(program["background_bottom"], 1, bottom.data());
  gl_.Uniform1f(program["image_height"], static_cast<float>(scene.image.height));
}

void Renderer::DrawBackground(const Scene& scene) {
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  background_.Use();
  SetBackground(background_, scene);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

const Program& Renderer::SurfaceProgram(const Surface& surface) {
  const auto found = surfaces_.find(surface);
  if (found != surfaces_.end()) return found->second;
  const auto define = [](bool wanted, const char* name) {
    return wanted ? std::string("#define ") + name + "\n" : "";
  };
  const std::string variant = define(surface.plane, "PLANE") + define(surface.sphere, "SPHERE") +
                              define(surface.textured, "TEXTURED") +
                              define(surface.shadows, "SHADOWS");
  return surfaces_
      .try_emplace(surface, gl_, variant + shaders::kInstanceAttributes + shaders::kSurfaceVertex,
                   variant + shaders::kBackground + shaders::kSurfaceFragment)
      .first->second;
}

void Renderer::SetSurfaceUniforms(const Program& program, const Scene& scene, const View& view,
                                  const Eigen::Matrix4f* shadow) const {
  const Vector3f to_light = scene.environment.to_light.stableNormalized();
  const float spacing = std::pow(10.0F, std::floor(std::log10(view.target_height() / 10)));
  gl_.UniformMatrix4fv(program["clip"], 1, GL_FALSE, view.clip().data());
  gl_.Uniform3fv(program["origin"], 1, view.origin().data());
  gl_.Uniform4fv(program["eye"], 1, view.Eye().data());
  gl_.Uniform3fv(program["to_light"], 1, to_light.data());
  gl_.Uniform1f(program["light"], scene.environment.light);
  gl_.Uniform1f(program["ambient"], scene.environment.ambient);
  gl_.Uniform1f(program["grid_spacing"], spacing);
  gl_.Uniform1f(program["fade_radius"], view.fade_radius());
  SetBackground(program, scene);
  if (shadow == nullptr) return;
  const float side = 1 / std::min(shadow->row(0).head<3>().norm(), shadow->row(1).head<3>().norm());
  gl_.BindTexture(GL_TEXTURE_2D, shadow_map_->depth.id());
  gl_.Uniform1i(program["shadow_map"], 0);
  gl_.UniformMatrix4fv(program["shadow_matrix"], 1, GL_FALSE, shadow->data());
  gl_.Uniform1f(program["shadow_blur"], 2.0F / kShadowSide);
  gl_.Uniform1f(program["shadow_offset"], 4 * side / kShadowSide);
}

void Renderer::SetMaterial(const Program& program, const Material& material) const {
  const auto colour = ToLinear(material.colour);
  const double exponent = GlossExponent(material.roughness);
  // This formula makes the total light of a highlight independent of its size.
  const double strength = std::min(0.22 * (exponent + 2) / (GlossExponent(0.45) + 2), 1.5);
  gl_.Uniform3fv(program["material_colour"], 1, colour.data());
  gl_.Uniform1f(program["gloss_exponent"], static_cast<float>(exponent));
  gl_.Uniform1f(program["gloss_strength"], static_cast<float>(strength));
  gl_.Uniform1f(program["roughness"], material.roughness);
  gl_.Uniform1f(program["metallic"], material.metallic);
  if (material.texture == 0) return;
  gl_.ActiveTexture(GL_TEXTURE1);
  gl_.BindTexture(GL_TEXTURE_2D, textures_.at(material.texture).pixels.id());
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.Uniform1i(program["colour_map"], 1);
}

void Renderer::DrawSurfaces(const Scene& scene, const View& view, const Eigen::Matrix4f* shadow) {
  const Material plain;
  for (const bool plane : {false, true}) {
    const Program* program = nullptr;
    for (const Draw& draw : draws_) {
      const Shape shape = draw.key.mesh.shape;
      if ((shape == Shape::kPlane) != plane) continue;
      const Material& material =
          draw.key.material == 0 ? plain : scene.materials.at(draw.key.material);
      const bool textured = material.texture != 0;
      const Program& wanted =
          SurfaceProgram({plane, textured && shape == Shape::kSphere, textured, shadow != nullptr});
      if (program != &wanted) {
        program = &wanted;
        program->Use();
        SetSurfaceUniforms(*program, scene, view, shadow);
      }
      SetMaterial(*program, material);
      if (draw.mesh->closed) gl_.Enable(GL_CULL_FACE);
      DrawInstances(draw);
      gl_.Disable(GL_CULL_FACE);
    }
  }
}

void Renderer::DrawLines(const Scene& scene, const View& view, const Program& program) {
  ExpandSegments(scene.segments, view, scene.image, line_vertices_);
  if (line_vertices_.empty()) return;
  const size_t lines = line_vertices_.size() / 4;
  if (lines > line_capacity_) {
    std::vector<uint32_t> indices;
    indices.reserve(lines * 6);
    for (uint32_t corner = 0; corner < lines * 4; corner += 4) {
      for (const uint32_t i : {0, 1, 2, 2, 1, 3}) indices.push_back(corner + i);
    }
    Fill(gl_, GL_ELEMENT_ARRAY_BUFFER, line_indices_, indices, GL_STATIC_DRAW);
    line_capacity_ = lines;
  }
  Fill(gl_, GL_ARRAY_BUFFER, line_buffer_, line_vertices_, GL_STREAM_DRAW);
  program.Use();
  gl_.VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(LineVertex),
                          Offset(offsetof(LineVertex, clip)));
  gl_.VertexAttribPointer(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(LineVertex),
                          Offset(offsetof(LineVertex, colour)));
  gl_.VertexAttribIPointer(2, 1, GL_UNSIGNED_INT, sizeof(LineVertex),
                           Offset(offsetof(LineVertex, item)));
  for (GLuint at = 0; at <= 10; ++at) {
    gl_.VertexAttribDivisor(at, 0);
    if (at <= 2)
      gl_.EnableVertexAttribArray(at);
    else
      gl_.DisableVertexAttribArray(at);
  }
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, line_indices_.id());
  gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(lines * 6), GL_UNSIGNED_INT, nullptr);
}

}  // namespace vesper::render
