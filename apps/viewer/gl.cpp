#include "gl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace mq::view {
namespace {

GLuint compiled(GLenum kind, const std::string& source) {
  const GLuint shader = glCreateShader(kind);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good == 0) {
    char words[4096] = "";
    glGetShaderInfoLog(shader, sizeof(words), nullptr, words);
    throw std::logic_error(fmt::format("a shader does not compile: {}", words));
  }
  return shader;
}

constexpr const char* line_vertex = R"(#version 330 core
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
uniform mat4 clip;
uniform vec2 viewport;
uniform float width;
uniform float nearer;
void main() {
  vec4 a = clip * vec4(from, 1), b = clip * vec4(to, 1);
  const float least = 1e-6;
  if (a.w < least && b.w < least) { gl_Position = vec4(0, 0, 2, 1); return; }
  if (a.w < least) a = mix(b, a, (b.w - least) / (b.w - a.w));
  if (b.w < least) b = mix(a, b, (a.w - least) / (a.w - b.w));
  vec2 along = (b.xy / b.w - a.xy / a.w) * viewport;
  float size = length(along);
  along = size > 0 ? along / size : vec2(1, 0);
  vec2 across = vec2(-along.y, along.x);
  int corner = int[6](0, 1, 2, 2, 1, 3)[gl_VertexID];
  vec4 end = corner < 2 ? a : b;
  vec2 offset = (corner % 2 == 0 ? 1 : -1) * across + (corner < 2 ? -1 : 1) * 0.5 * along;
  end.xy += offset * width / viewport * end.w;
  end.z -= nearer * end.w;
  gl_Position = end;
}
)";

constexpr const char* line_fragment = R"(#version 330 core
uniform vec4 colour;
out vec4 shown;
void main() { shown = colour; }
)";

const Shader& line_shader() {
  static thread_local const Shader* shader = new Shader(line_vertex, line_fragment);
  return *shader;
}

}  // namespace

Shader::Shader(const std::string& vertex, const std::string& fragment)
    : program_(glCreateProgram()) {
  const GLuint parts[] = {compiled(GL_VERTEX_SHADER, vertex),
                          compiled(GL_FRAGMENT_SHADER, fragment)};
  for (const GLuint part : parts) glAttachShader(program_, part);
  glLinkProgram(program_);
  for (const GLuint part : parts) glDeleteShader(part);
  GLint good = 0;
  glGetProgramiv(program_, GL_LINK_STATUS, &good);
  if (good == 0) {
    char words[4096] = "";
    glGetProgramInfoLog(program_, sizeof(words), nullptr, words);
    throw std::logic_error(fmt::format("a shader does not link: {}", words));
  }
}

Shader::~Shader() { glDeleteProgram(program_); }

void VertexArray::attribute(int index, const Buffer& buffer, const Layout& layout) {
  bind();
  glBindBuffer(GL_ARRAY_BUFFER, buffer.id());
  glEnableVertexAttribArray(GLuint(index));
  glVertexAttribPointer(GLuint(index), layout.size, layout.type,
                        layout.type == GL_UNSIGNED_BYTE ? GL_TRUE : GL_FALSE,
                        GLsizei(layout.stride), reinterpret_cast<const void*>(layout.offset));
  glVertexAttribDivisor(GLuint(index), GLuint(layout.divisor));
}

void Picture::allocate(int width, int height, Kind kind) {
  width_ = width, height_ = height;
  bind(0);
  const bool bytes = kind == Kind::bytes;
  glTexImage2D(GL_TEXTURE_2D, 0, bytes ? GL_RGBA8 : GL_RGBA16F, width, height, 0, GL_RGBA,
               bytes ? GL_UNSIGNED_BYTE : GL_FLOAT, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void Picture::put(int x, int y, int width, int height, const std::uint8_t* texels,
                  int stride) const {
  bind(0);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, stride);
  glTexSubImage2D(GL_TEXTURE_2D, 0, x, y, width, height, GL_RGBA, GL_UNSIGNED_BYTE, texels);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

void Picture::put(int x, int y, int width, int height, const float* texels, int stride) const {
  bind(0);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, stride);
  glTexSubImage2D(GL_TEXTURE_2D, 0, x, y, width, height, GL_RGBA, GL_FLOAT, texels);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

void Picture::show(const Image<float>& rgb) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(std::size_t(rgb.pixel_count()) * 4);
  for (int y = 0; y < rgb.height(); ++y)
    for (int x = 0; x < rgb.width(); ++x)
      for (int c = 0; c < 4; ++c)
        bytes.push_back(c >= rgb.channels()
                            ? 255
                            : std::uint8_t(std::lround(std::clamp(rgb(x, y, c), 0.F, 1.F) * 255)));
  allocate(rgb.width(), rgb.height(), Kind::bytes);
  put(0, 0, rgb.width(), rgb.height(), bytes.data(), rgb.width());
}

void Picture::bind(int unit) const {
  glActiveTexture(GLenum(GL_TEXTURE0 + unit));
  glBindTexture(GL_TEXTURE_2D, id_);
}

Canvas::Canvas() {
  glGenFramebuffers(1, &many_);
  glGenFramebuffers(1, &one_);
  glGenRenderbuffers(1, &colour_);
  glGenRenderbuffers(1, &depth_);
}

Canvas::~Canvas() {
  glDeleteFramebuffers(1, &many_);
  glDeleteFramebuffers(1, &one_);
  glDeleteRenderbuffers(1, &colour_);
  glDeleteRenderbuffers(1, &depth_);
}

void Canvas::resize(int width, int height) {
  if (width == width_ && height == height_) return;
  width_ = width, height_ = height;
  constexpr int samples = 4;  // per pixel; what every OpenGL 3.3 has
  glBindFramebuffer(GL_FRAMEBUFFER, many_);
  glBindRenderbuffer(GL_RENDERBUFFER, colour_);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_RGBA8, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  glBindRenderbuffer(GL_RENDERBUFFER, depth_);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  picture_.allocate(width, height, Picture::Kind::bytes);
  glBindFramebuffer(GL_FRAMEBUFFER, one_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture_.id(), 0);
}

void Canvas::begin() const {
  glBindFramebuffer(GL_FRAMEBUFFER, many_);
  glViewport(0, 0, width_, height_);
  glDisable(GL_SCISSOR_TEST);
}

void Canvas::resolve() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, many_);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, one_);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

Image<float> Canvas::read() const {
  glBindFramebuffer(GL_FRAMEBUFFER, one_);
  return read_pixels(width_, height_);
}

void Lines::fill(const std::vector<Eigen::Vector3f>& ends) {
  count_ = int(ends.size() / 2);
  buffer_.fill(std::span<const Eigen::Vector3f>(ends));
  constexpr std::size_t point = sizeof(Eigen::Vector3f);
  array_.attribute(0, buffer_, {3, GL_FLOAT, 2 * point, 0, 1});
  array_.attribute(1, buffer_, {3, GL_FLOAT, 2 * point, point, 1});
}

void Lines::draw(const Style& style) const {
  if (count_ == 0) return;
  const Shader& shader = line_shader();
  shader.use();
  shader.set("clip", style.clip);
  shader.set("viewport", style.viewport);
  shader.set("width", style.width);
  shader.set("nearer", style.nearer);
  shader.set("colour", style.colour);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  array_.bind();
  glDrawArraysInstanced(GL_TRIANGLES, 0, 6, count_);
  glDisable(GL_BLEND);
}

Image<float> read_pixels(int width, int height) {
  std::vector<std::uint8_t> bytes(std::size_t(width) * height * 4);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
  Image<float> picture(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        picture(x, y, c) = float(bytes[(std::size_t(height - 1 - y) * width + x) * 4 + c]) / 255;
  return picture;
}

}  // namespace mq::view
