// SPDX-License-Identifier: Apache-2.0
// Draws scenes into pixels.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "draw_list.hpp"
#include "gl.hpp"
#include "osmesa.hpp"
#include "png.hpp"
#include "scene.hpp"
#include "shapes.hpp"
#include "view.hpp"

namespace vesper::render {

/// What the graphics library says of itself.
struct GraphicsInfo {
  std::string vendor, renderer, version;
  int max_samples, max_side;  ///< per pixel; [px]
};

/// What each pixel of a picture shows at its middle, rows from the bottom to the top.
struct Seen {
  uint32_t width = 0, height = 0;  ///< [px]
  std::vector<uint32_t> item;      ///< (height x width), 0 where nothing is
  std::vector<float> depth;        ///< (height x width) along the view [m], 0 where nothing is
};

/// Belongs to the thread that made it: a GL context is current on one thread.
class Renderer {
 public:
  /// `max_samples`: upper limit for what images ask for. Throws GraphicsError.
  explicit Renderer(uint32_t max_samples);

  GraphicsInfo Info() const;

  /// Draws a scene that the decoder accepted. Equal scenes give equal bytes. The pixels are valid
  /// until the next call. Throws GraphicsError; the renderer stays usable.
  const Pixels& Render(const Scene& scene);

  /// What the pixels of that picture show: no samples, no blending. Depth is meaningless where the
  /// camera is orthographic. As for Render.
  const Seen& Sense(const Scene& scene);

 private:
  /// Which variant of the shaders draws a surface.
  struct Surface {
    bool plane, sphere, textured, shadows;
    auto operator<=>(const Surface&) const = default;
  };
  /// Colour and depth of one size; with samples, a second buffer that they are averaged into.
  struct Target {
    uint32_t width, height, samples;
    GlObject colour, depth, framebuffer, averaged, averaged_framebuffer;
  };
  struct SenseTarget {
    uint32_t width, height;
    GlObject item, distance, depth, framebuffer;
  };
  struct ShadowMap {
    GlObject depth, framebuffer;
  };
  /// A mesh in graphics memory. Its attributes are bound with each draw's instances.
  struct GpuMesh {
    GlObject vertices, indices;
    GLsizei index_count = 0;
    uint64_t revision = 0;
    bool closed = false;  ///< back sides are never seen
  };
  /// A texture in graphics memory.
  struct GpuTexture {
    GlObject pixels;
    uint64_t revision = 0;
  };
  /// Where a draw's instances begin in the instance buffer.
  struct Draw {
    DrawKey key;
    const GpuMesh* mesh;
    size_t first;
    GLsizei count;
  };

  View Prepare(const Scene& scene, const Extent& extent);
  void PrepareTarget(const Image& image);
  void PrepareSenseTarget(const Image& image);
  GlObject MakeStorage(const Image& image, uint32_t samples, GLenum format) const;
  void Attach(const GlObject& framebuffer, const GlObject& colour, const GlObject* depth) const;
  void PrepareShadowMap();
  void PrepareMeshes(const Scene& scene, const View& view);
  void PrepareTextures(const Scene& scene);
  GpuMesh Upload(const TriangleMesh& mesh, bool closed) const;
  void UploadInstances();
  void DrawShadowMap(const Eigen::Matrix4f& matrix);
  void DrawBackground(const Scene& scene);
  void DrawSurfaces(const Scene& scene, const View& view, const Eigen::Matrix4f* shadow);
  void SetSurfaceUniforms(const Program& program, const Scene& scene, const View& view,
                          const Eigen::Matrix4f* shadow) const;
  void SetMaterial(const Program& program, const Material& material) const;
  void DrawInstances(const Draw& draw) const;
  void DrawLines(const Scene& scene, const View& view, const Program& program);
  void SetBackground(const Program& program, const Scene& scene) const;
  void ReadPixels();
  const Program& SurfaceProgram(const Surface& surface);

  OsMesaContext context_;
  Gl gl_;
  uint32_t max_samples_;
  GlObject vertex_array_, instance_buffer_, line_buffer_, line_indices_;
  Program background_, shadow_program_, line_program_, sense_program_, sense_line_program_;
  std::map<Surface, Program> surfaces_;  ///< made when needed
  std::map<MeshKey, GpuMesh> meshes_;
  std::map<uint32_t, GpuTexture> textures_;
  std::optional<Target> target_;
  std::optional<SenseTarget> sense_target_;
  std::optional<ShadowMap> shadow_map_;
  DrawList list_;
  std::vector<Draw> draws_;
  std::vector<LineVertex> line_vertices_;
  size_t line_capacity_ = 0;  ///< lines that line_indices_ has indices for
  Pixels pixels_;
  Seen seen_;
};

}  // namespace vesper::render
