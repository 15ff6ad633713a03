// SPDX-License-Identifier: Apache-2.0
// A table of the OpenGL 3.3 functions in use, and owners of GL objects.
#pragma once

#include <GL/glcorearb.h>

#include <initializer_list>
#include <string>
#include <utility>

#include "osmesa.hpp"

namespace vesper::render {

// clang-format off
#define VESPER_RENDER_GL_FUNCTIONS(X) \
  X(ACTIVETEXTURE, ActiveTexture) X(ATTACHSHADER, AttachShader) X(BINDBUFFER, BindBuffer) \
  X(BINDFRAMEBUFFER, BindFramebuffer) X(BINDRENDERBUFFER, BindRenderbuffer) \
  X(BINDTEXTURE, BindTexture) X(BINDVERTEXARRAY, BindVertexArray) \
  X(BLITFRAMEBUFFER, BlitFramebuffer) X(BUFFERDATA, BufferData) X(BUFFERSUBDATA, BufferSubData) \
  X(CHECKFRAMEBUFFERSTATUS, CheckFramebufferStatus) X(CLEAR, Clear) \
  X(CLEARBUFFERFV, ClearBufferfv) X(CLEARBUFFERUIV, ClearBufferuiv) \
  X(COMPILESHADER, CompileShader) X(CREATEPROGRAM, CreateProgram) X(CREATESHADER, CreateShader) \
  X(DELETEBUFFERS, DeleteBuffers) X(DELETEFRAMEBUFFERS, DeleteFramebuffers) \
  X(DELETEPROGRAM, DeleteProgram) X(DELETERENDERBUFFERS, DeleteRenderbuffers) \
  X(DELETESHADER, DeleteShader) X(DELETETEXTURES, DeleteTextures) \
  X(DELETEVERTEXARRAYS, DeleteVertexArrays) X(DEPTHFUNC, DepthFunc) X(DISABLE, Disable) \
  X(DISABLEVERTEXATTRIBARRAY, DisableVertexAttribArray) \
  X(DRAWARRAYS, DrawArrays) X(DRAWBUFFER, DrawBuffer) X(DRAWBUFFERS, DrawBuffers) \
  X(DRAWELEMENTS, DrawElements) \
  X(DRAWELEMENTSINSTANCED, DrawElementsInstanced) X(ENABLE, Enable) \
  X(ENABLEVERTEXATTRIBARRAY, EnableVertexAttribArray) \
  X(FRAMEBUFFERRENDERBUFFER, FramebufferRenderbuffer) \
  X(FRAMEBUFFERTEXTURE2D, FramebufferTexture2D) X(GENBUFFERS, GenBuffers) \
  X(GENERATEMIPMAP, GenerateMipmap) \
  X(GENFRAMEBUFFERS, GenFramebuffers) X(GENRENDERBUFFERS, GenRenderbuffers) \
  X(GENTEXTURES, GenTextures) X(GENVERTEXARRAYS, GenVertexArrays) X(GETERROR, GetError) \
  X(GETINTEGERV, GetIntegerv) X(GETPROGRAMINFOLOG, GetProgramInfoLog) \
  X(GETPROGRAMIV, GetProgramiv) X(GETSHADERINFOLOG, GetShaderInfoLog) \
  X(GETSHADERIV, GetShaderiv) X(GETSTRING, GetString) X(GETUNIFORMLOCATION, GetUniformLocation) \
  X(LINKPROGRAM, LinkProgram) X(PIXELSTOREI, PixelStorei) X(POLYGONOFFSET, PolygonOffset) \
  X(READBUFFER, ReadBuffer) X(READPIXELS, ReadPixels) \
  X(RENDERBUFFERSTORAGEMULTISAMPLE, RenderbufferStorageMultisample) \
  X(SHADERSOURCE, ShaderSource) X(TEXIMAGE2D, TexImage2D) X(TEXPARAMETERFV, TexParameterfv) \
  X(TEXPARAMETERI, TexParameteri) X(UNIFORM1F, Uniform1f) X(UNIFORM1I, Uniform1i) \
  X(UNIFORM2F, Uniform2f) X(UNIFORM3FV, Uniform3fv) X(UNIFORM4FV, Uniform4fv) \
  X(UNIFORMMATRIX4FV, UniformMatrix4fv) X(USEPROGRAM, UseProgram) \
  X(VERTEXATTRIBDIVISOR, VertexAttribDivisor) X(VERTEXATTRIBIPOINTER, VertexAttribIPointer) \
  X(VERTEXATTRIBPOINTER, VertexAttribPointer) X(VIEWPORT, Viewport)
// clang-format on

/// Table of GL functions: `gl.Clear(...)` is glClear. Use it on the context's thread only.
struct Gl {
#define VESPER_RENDER_GL_MEMBER(TYPE, Name) PFNGL##TYPE##PROC Name;
  VESPER_RENDER_GL_FUNCTIONS(VESPER_RENDER_GL_MEMBER)
#undef VESPER_RENDER_GL_MEMBER

  /// Loads the functions. Throws GraphicsError with the first function that the library lacks.
  explicit Gl(const OsMesaContext& context);

  int Integer(GLenum name) const;
  std::string Text(GLenum name) const;
  /// Throws GraphicsError if GL has recorded an error since the last check.
  void Check(const char* while_doing) const;
};

/// Owner of one GL object; move-only; 0 means none.
class GlObject {
 public:
  using Delete = void (*)(const Gl&, GLuint);
  GlObject() = default;
  GlObject(const Gl& gl, GLuint id, Delete del) : gl_(&gl), id_(id), delete_(del) {}
  GlObject(GlObject&& other) noexcept { *this = std::move(other); }
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(gl_, other.gl_);
    std::swap(id_, other.id_);
    std::swap(delete_, other.delete_);
    return *this;
  }
  ~GlObject() {
    if (id_ != 0) delete_(*gl_, id_);
  }
  GLuint id() const { return id_; }

 private:
  const Gl* gl_ = nullptr;
  GLuint id_ = 0;
  Delete delete_ = nullptr;
};

GlObject MakeBuffer(const Gl& gl);
GlObject MakeVertexArray(const Gl& gl);
GlObject MakeTexture(const Gl& gl);
GlObject MakeRenderbuffer(const Gl& gl);
GlObject MakeFramebuffer(const Gl& gl);

/// A linked shader program, from GLSL 3.30 sources without their "#version" line.
class Program {
 public:
  /// Compiles and links the program. Throws GraphicsError with the compiler's log.
  Program(const Gl& gl, const std::string& vertex, const std::string& fragment);
  void Use() const { gl_.UseProgram(program_.id()); }
  /// Returns the location of a uniform, or -1, which GL ignores, if the program does not use it.
  GLint operator[](const char* uniform) const {
    return gl_.GetUniformLocation(program_.id(), uniform);
  }

 private:
  const Gl& gl_;
  GlObject program_;
};

}  // namespace vesper::render
