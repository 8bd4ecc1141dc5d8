#pragma once
/// OpenGL 3.3 objects that free themselves. All belong to the thread whose context is current.

#include <epoxy/gl.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "mq/image/image.h"

namespace mq::view {

/// A shader program. Uniforms that the compiler removed are ignored.
class Shader {
 public:
  /// Throws `std::logic_error` with the compiler's words.
  Shader(const std::string& vertex, const std::string& fragment);
  ~Shader();
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;

  void use() const { glUseProgram(program_); }
  void set(const char* name, int value) const { glUniform1i(at(name), value); }
  void set(const char* name, float value) const { glUniform1f(at(name), value); }
  void set(const char* name, const Eigen::Vector2f& v) const {
    glUniform2f(at(name), v.x(), v.y());
  }
  void set(const char* name, const Eigen::Vector3f& v) const {
    glUniform3f(at(name), v.x(), v.y(), v.z());
  }
  void set(const char* name, const Eigen::Vector4f& v) const {
    glUniform4f(at(name), v.x(), v.y(), v.z(), v.w());
  }
  void set(const char* name, const Eigen::Matrix4f& m) const {
    glUniformMatrix4fv(at(name), 1, GL_FALSE, m.data());
  }

 private:
  GLint at(const char* name) const { return glGetUniformLocation(program_, name); }
  GLuint program_;
};

/// Vertices in the memory of the graphics card.
class Buffer {
 public:
  Buffer() { glGenBuffers(1, &id_); }
  ~Buffer() { glDeleteBuffers(1, &id_); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  template <class T>
  void fill(std::span<const T> values) {
    glBindBuffer(GL_ARRAY_BUFFER, id_);
    glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(values.size_bytes()), values.data(), GL_STATIC_DRAW);
  }
  GLuint id() const { return id_; }

 private:
  GLuint id_ = 0;
};

class VertexArray {
 public:
  VertexArray() { glGenVertexArrays(1, &id_); }
  ~VertexArray() { glDeleteVertexArrays(1, &id_); }
  VertexArray(const VertexArray&) = delete;
  VertexArray& operator=(const VertexArray&) = delete;

  void bind() const { glBindVertexArray(id_); }
  struct Layout {
    int size;  ///< components
    GLenum type;
    std::size_t stride, offset;  ///< bytes
    int divisor = 0;             ///< 1: one per instance
  };
  /// Attribute `index` out of a buffer; bytes are taken as 0 to 1.
  void attribute(int index, const Buffer& buffer, const Layout& layout);

 private:
  GLuint id_ = 0;
};

/// A picture in the memory of the graphics card.
class Picture {
 public:
  enum class Kind { bytes, halves };

  Picture() { glGenTextures(1, &id_); }
  ~Picture() { glDeleteTextures(1, &id_); }
  Picture(const Picture&) = delete;
  Picture& operator=(const Picture&) = delete;

  /// Four channels, nothing in it yet.
  void allocate(int width, int height, Kind kind);
  /// A rectangle; `texels` are rows of `stride` texels of four values, the first is its corner.
  void put(int x, int y, int width, int height, const std::uint8_t* texels, int stride) const;
  void put(int x, int y, int width, int height, const float* texels, int stride) const;
  /// All of it, from a picture as displayed.
  void show(const Image<float>& rgb);

  void bind(int unit) const;
  GLuint id() const { return id_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  GLuint id_ = 0;
  int width_ = 0, height_ = 0;
};

/// What a pane is drawn into: several samples per pixel, averaged by `resolve` into a picture.
class Canvas {
 public:
  Canvas();
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  void resize(int width, int height);
  void begin() const;  ///< draws go here from now on
  void resolve() const;
  GLuint picture() const { return picture_.id(); }
  /// What `resolve` made, row 0 on top.
  Image<float> read() const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_ = 0, height_ = 0;
  GLuint many_ = 0, one_ = 0, colour_ = 0, depth_ = 0;
  Picture picture_;
};

/// Line segments of the same width in pixels, whatever the projection.
class Lines {
 public:
  /// Pairs of points.
  void fill(const std::vector<Eigen::Vector3f>& ends);
  struct Style {
    Eigen::Matrix4f clip;
    Eigen::Vector2f viewport;
    Eigen::Vector4f colour;
    float width;   ///< pixels
    float nearer;  ///< by how much of the distance they are drawn in front of what they lie on
  };
  void draw(const Style& style) const;
  bool empty() const { return count_ == 0; }

 private:
  VertexArray array_;
  Buffer buffer_;
  int count_ = 0;
};

/// What the framebuffer 0 or the bound one shows, row 0 on top, red, green and blue.
Image<float> read_pixels(int width, int height);

}  // namespace mq::view
