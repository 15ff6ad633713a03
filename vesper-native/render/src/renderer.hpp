// SPDX-License-Identifier: Apache-2.0
// Renderer of scenes to pixels.
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

/// Limits and versions of the graphics library.
struct GraphicsInfo {
  std::string vendor, renderer, version;
  int max_samples, max_side;  ///< samples per pixel; [px]
};

/// The item and the depth at the centre of each pixel; rows from bottom to top.
struct Seen {
  uint32_t width = 0, height = 0;  ///< [px]
  std::vector<uint32_t> item;      ///< (height x width), 0 for no item
  std::vector<float> depth;        ///< (height x width) along the view direction [m], 0 for no item
};

/// Draws scenes. Use it only on the thread that created it, because a GL context is current on one
/// thread.
class Renderer {
 public:
  /// Creates the renderer; `max_samples` limits the samples that images request. Throws
  /// GraphicsError.
  explicit Renderer(uint32_t max_samples);

  GraphicsInfo Info() const;

  /// Draws a scene that the decoder accepted. Equal scenes give equal bytes. The pixels are valid
  /// until the next call. Throws GraphicsError; the renderer remains usable.
  const Pixels& Render(const Scene& scene);

  /// Returns item and depth of each pixel of the picture, without multisampling and blending. With
  /// an orthographic camera, the depth has no meaning. The result is valid until the next call.
  /// Throws GraphicsError; the renderer remains usable.
  const Seen& Sense(const Scene& scene);

 private:
  /// Key of the shader variant that draws a surface.
  struct Surface {
    bool plane, sphere, textured, shadows;
    auto operator<=>(const Surface&) const = default;
  };
  /// Colour and depth buffers of one size; with multisampling, also a buffer for the averaged
  /// pixels.
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
  /// A mesh in graphics memory. Its vertex attributes are bound together with those of the
  /// instances in each draw.
  struct GpuMesh {
    GlObject vertices, indices;
    GLsizei index_count = 0;
    uint64_t revision = 0;
    bool closed = false;  ///< the mesh is closed, so its back faces are never visible
  };
  /// A texture in graphics memory.
  struct GpuTexture {
    GlObject pixels;
    uint64_t revision = 0;
  };
  /// Offset of the instances of a draw in the instance buffer.
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
  std::map<Surface, Program> surfaces_;  ///< compiled when first needed
  std::map<MeshKey, GpuMesh> meshes_;
  std::map<uint32_t, GpuTexture> textures_;
  std::optional<Target> target_;
  std::optional<SenseTarget> sense_target_;
  std::optional<ShadowMap> shadow_map_;
  DrawList list_;
  std::vector<Draw> draws_;
  std::vector<LineVertex> line_vertices_;
  size_t line_capacity_ = 0;  ///< number of lines for which line_indices_ contains indices
  Pixels pixels_;
  Seen seen_;
};

}  // namespace vesper::render
