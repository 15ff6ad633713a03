// SPDX-License-Identifier: Apache-2.0
#include "gl.hpp"

#include <cstdio>

namespace vesper::render {

Gl::Gl(const OsMesaContext& context) {
#define VESPER_RENDER_GL_FIND(TYPE, Name)                               \
  Name = reinterpret_cast<PFNGL##TYPE##PROC>(context.Find("gl" #Name)); \
  if (Name == nullptr) throw GraphicsError("the graphics library has no function gl" #Name);
  VESPER_RENDER_GL_FUNCTIONS(VESPER_RENDER_GL_FIND)
#undef VESPER_RENDER_GL_FIND
}

int Gl::Integer(GLenum name) const {
  GLint value = 0;
  GetIntegerv(name, &value);
  return value;
}

std::string Gl::Text(GLenum name) const {
  const GLubyte* text = GetString(name);
  return text == nullptr ? "" : reinterpret_cast<const char*>(text);
}

void Gl::Check(const char* while_doing) const {
  const GLenum error = GetError();
  if (error == GL_NO_ERROR) return;
  char code[16];
  std::snprintf(code, sizeof code, "0x%04x", error);
  throw GraphicsError(std::string("the graphics library failed while ") + while_doing + ": " +
                      (error == GL_OUT_OF_MEMORY ? "out of memory; ask for a smaller image, "
                                                   "fewer samples or fewer items"
                                                 : code));
}

GlObject MakeBuffer(const Gl& gl) {
  GLuint id;
  gl.GenBuffers(1, &id);
  return {gl, id, [](const Gl& g, GLuint i) { g.DeleteBuffers(1, &i); }};
}

GlObject MakeVertexArray(const Gl& gl) {
  GLuint id;
  gl.GenVertexArrays(1, &id);
  return {gl, id, [](const Gl& g, GLuint i) { g.DeleteVertexArrays(1, &i); }};
}

GlObject MakeTexture(const Gl& gl) {
  GLuint id;
  gl.GenTextures(1, &id);
  return {gl, id, [](const Gl& g, GLuint i) { g.DeleteTextures(1, &i); }};
}

GlObject MakeRenderbuffer(const Gl& gl) {
  GLuint id;
  gl.GenRenderbuffers(1, &id);
  return {gl, id, [](const Gl& g, GLuint i) { g.DeleteRenderbuffers(1, &i); }};
}

GlObject MakeFramebuffer(const Gl& gl) {
  GLuint id;
  gl.GenFramebuffers(1, &id);
  return {gl, id, [](const Gl& g, GLuint i) { g.DeleteFramebuffers(1, &i); }};
}

namespace {

GlObject Compile(const Gl& gl, GLenum stage, const std::string& source) {
  GlObject shader(gl, gl.CreateShader(stage), [](const Gl& g, GLuint i) { g.DeleteShader(i); });
  const char* text[] = {"#version 330 core\n", source.c_str()};
  gl.ShaderSource(shader.id(), 2, text, nullptr);
  gl.CompileShader(shader.id());
  GLint compiled = 0;
  gl.GetShaderiv(shader.id(), GL_COMPILE_STATUS, &compiled);
  if (!compiled) {
    char log[2048] = "";
    gl.GetShaderInfoLog(shader.id(), sizeof log, nullptr, log);
    throw GraphicsError(std::string("a shader does not compile: ") + log);
  }
  return shader;
}

}  // namespace

Program::Program(const Gl& gl, const std::string& vertex, const std::string& fragment)
    : gl_(gl), program_(gl, gl.CreateProgram(), [](const Gl& g, GLuint i) { g.DeleteProgram(i); }) {
  const GlObject vertex_shader = Compile(gl, GL_VERTEX_SHADER, vertex);
  const GlObject fragment_shader = Compile(gl, GL_FRAGMENT_SHADER, fragment);
  gl.AttachShader(program_.id(), vertex_shader.id());
  gl.AttachShader(program_.id(), fragment_shader.id());
  gl.LinkProgram(program_.id());
  GLint linked = 0;
  gl.GetProgramiv(program_.id(), GL_LINK_STATUS, &linked);
  if (!linked) {
    char log[2048] = "";
    gl.GetProgramInfoLog(program_.id(), sizeof log, nullptr, log);
    throw GraphicsError(std::string("a shader program does not link: ") + log);
  }
}

}  // namespace vesper::render
