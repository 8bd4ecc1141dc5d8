#include "mq/io/detail/ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/folder.h"
#include "mq/io/detail/ply_body.h"

namespace mq {
namespace {

using Encoding = PlyHeader::Encoding;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

MeshFile read(const std::string& bytes) {
  Document document;
  document.format = Document::Format::ply;
  document.name = "a.ply";
  document.bytes = to_bytes(bytes);
  return read_ply(document);
}

std::string refusal_of_ply(const std::string& bytes) {
  return io_error_of([&] { read(bytes); });
}

constexpr std::pair<Encoding, const char*> encodings[] = {
    {Encoding::text, "ascii"},
    {Encoding::little_endian, "binary_little_endian"},
    {Encoding::big_endian, "binary_big_endian"}};

/// Values of a body, in one encoding.
class Body {
 public:
  explicit Body(Encoding encoding) : encoding_(encoding) {}
  Body& add(PlyType type, std::initializer_list<double> values) {
    for (const double v : values) {
      text += encoded(v, type, encoding_);
      if (encoding_ == Encoding::text) text += ' ';
    }
    return *this;
  }
  Body& row() {
    if (encoding_ == Encoding::text) text += '\n';
    return *this;
  }
  std::string text;

 private:
  Encoding encoding_;
};

/// A quad and a triangle with everything that is read, among things that are not.
std::string everything(Encoding encoding, const std::string& format, const std::string& end) {
  std::string header;
  for (const std::string& line : {std::string("ply"),
                                  "format " + format + " 1.0",
                                  std::string("comment TextureFile a b.png"),
                                  std::string("comment hello"),
                                  std::string("obj_info x"),
                                  std::string("element camera 2"),
                                  std::string("property list uchar short junk"),
                                  std::string("property double f"),
                                  std::string("element vertex 5"),
                                  std::string("property uchar flag"),
                                  std::string("property double x"),
                                  std::string("property float y"),
                                  std::string("property int16 z"),
                                  std::string("property ushort red"),
                                  std::string("property ushort green"),
                                  std::string("property ushort blue"),
                                  std::string("element face 2"),
                                  std::string("property list uint8 uint vertex_index"),
                                  std::string("property int texnumber"),
                                  std::string("property list uchar float texcoord"),
                                  std::string("element edge 1"),
                                  std::string("property int vertex1"),
                                  std::string("end_header")})
    header += line + end;
  Body body(encoding);
  using enum PlyType;
  body.add(u8, {2}).add(i16, {-7, 7}).add(f64, {0.25}).row();
  body.add(u8, {0}).add(f64, {0.5}).row();
  const double at[5][3] = {{0.1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2.5, 0}, {0, 0, -300}};
  for (int v = 0; v < 5; ++v)
    body.add(u8, {double(v)})
        .add(f64, {at[v][0]})
        .add(f32, {at[v][1]})
        .add(i16, {at[v][2]})
        .add(u16, {0, double(v), 65535})
        .row();
  body.add(u8, {4})
      .add(u32, {0, 1, 2, 3})
      .add(i32, {0})
      .add(u8, {8})
      .add(f32, {0, 0, 1, 0, 1, 1, 0, 1})
      .row();
  body.add(u8, {3}).add(u32, {0, 4, 1}).add(i32, {-1}).add(u8, {0}).row();
  body.add(i32, {3}).row();
  return header + body.text;
}

TEST(Ply, ReadsTheSameFromEveryEncodingAndLineEnd) {
  for (const auto& [encoding, format] : encodings)
    for (const std::string end : {"\n", "\r\n", "\r"}) {
      const MeshFile file = read(everything(encoding, format, end));
      EXPECT_THAT(file.mesh.triangles,
                  ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{0, 4, 1}));
      EXPECT_EQ(file.mesh.positions[0], Vector3(0.1, 0, 0));
      EXPECT_EQ(file.mesh.positions[3], Vector3(0, 2.5, 0));
      EXPECT_EQ(file.mesh.positions[4], Vector3(0, 0, -300));
      EXPECT_EQ(file.mesh.uv(1, 1), Vector2(1, 1));
      EXPECT_EQ(file.mesh.corner_uvs[2], (Triangle{-1, -1, -1}));
      EXPECT_THAT(file.mesh.textures, ElementsAre(0, 0, -1));
      EXPECT_EQ(file.textures.at(0).name, "a b.png");
      EXPECT_EQ(file.colors.channels, 3);
      EXPECT_EQ(file.colors.depth, Depth::u16);
      EXPECT_EQ(file.colors.values[3 * 4 + 1], 4.0f / 65535);
      EXPECT_EQ(file.colors.values[3 * 4 + 2], 1);
    }
}

const std::string head =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
    "z\n";
const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const std::string points = "0 0 0\n1 0 0\n0 1 0\n";

TEST(Ply, ReadsTextureCoordinatesPerVertexUnderTheirUsualNames) {
  for (const auto& [u, v] : {std::pair("s", "t"),
                             {"u", "v"},
                             {"texture_u", "texture_v"},
                             {"texture_s", "texture_t"},
                             {"u0", "v0"}}) {
    const MeshFile file = read(head + "property float " + u + "\nproperty double " + v + "\n" +
                               faces + "0 0 0 0.5 1\n1 0 0 2 3\n0 1 0 4 5\n3 0 1 2\n");
    ASSERT_TRUE(file.mesh.has_uvs()) << u;
    EXPECT_EQ(file.mesh.uv(0, 0), Vector2(0.5, 1));
    EXPECT_EQ(file.mesh.uv(0, 2), Vector2(4, 5));
  }
}

TEST(Ply, SharesTextureCoordinatesOfAVertexThatAgree) {
  const MeshFile file = read(head +
                             "element face 2\nproperty list uchar int vertex_indices\n"
                             "property list uchar float texcoord\nend_header\n" +
                             points + "3 0 1 2 6 0 0 1 0 0 1\n3 0 2 1 6 0 0 0.5 1 1 0\n");
  EXPECT_THAT(file.mesh.corner_uvs, ElementsAre(Triangle{0, 1, 2}, Triangle{0, 3, 1}));
}

TEST(Ply, ReadsFloatColoursAsTheyAre) {
  const std::string colors =
      "property float red\nproperty float green\nproperty float blue\n"
      "property float alpha\n";
  const MeshFile file =
      read(head + colors + faces + "0 0 0 2 0.5 0 1\n1 0 0 0 0 0 1\n0 1 0 0 0 0 1\n3 0 1 2\n");
  EXPECT_EQ(file.colors.channels, 4);
  EXPECT_EQ(file.colors.depth, Depth::f32);
  EXPECT_EQ(file.colors.values[0], 2);
}

TEST(Ply, SaysThatItHasNoFaces) {
  EXPECT_THAT(read(head + "end_header\n" + points).notes, ElementsAre("it has no faces"));
}

TEST(Ply, RefusesWithTheElement) {
  const std::string all = head + faces + points;
  EXPECT_THAT(refusal_of_ply(all + "3 0 1 3\n"), HasSubstr("a.ply, face 0 (byte "));
  EXPECT_THAT(refusal_of_ply(all + "3 0 1 3\n"), HasSubstr("vertex 3 is not there: the file has 3"));
  EXPECT_THAT(refusal_of_ply(all + "3 0 1 -1\n"), HasSubstr("vertex -1 is not there"));
  EXPECT_THAT(refusal_of_ply(all + "3 0 1\n"), HasSubstr("the file ends there; it may be cut short"));
  EXPECT_THAT(refusal_of_ply(all + "-3 0 1 2\n"), HasSubstr("has -3 values"));
  EXPECT_THAT(refusal_of_ply(all + "1e9 0 1 2\n"), HasSubstr("more than are left in the file"));
  EXPECT_THAT(refusal_of_ply(head + faces + "0 0 0\n1 0 y\n0 1 0\n3 0 1 2\n"),
              HasSubstr("a.ply, vertex 1 (byte "));
  EXPECT_THAT(refusal_of_ply(head + faces + "0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n"),
              HasSubstr("): \"x\" is not a number"));
  EXPECT_THAT(refusal_of_ply(head + faces + "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n"),
              HasSubstr("): its coordinates 1, 0, nan must be finite"));
}

TEST(Ply, RefusesHeadersItCannotFollow) {
  EXPECT_THAT(refusal_of_ply("ply\nformat ascii 1.0\nelement vertex 3\n"), HasSubstr("header has no end"));
  EXPECT_THAT(refusal_of_ply("ply\nformat ascii 1.0\nelement vertex x\n"),
              HasSubstr("a.ply, line 3: \"x\" is not a count"));
  EXPECT_THAT(refusal_of_ply("ply\nformat ascii 1.0\nproperty float x\n"),
              HasSubstr("before any element"));
  EXPECT_THAT(refusal_of_ply("ply\nformat zip 1.0\n"), HasSubstr("format \"zip\" is none of"));
  EXPECT_THAT(refusal_of_ply("ply\nelement vertex 1\nproperty vec3 x\n"), HasSubstr("not a type of PLY"));
  EXPECT_THAT(refusal_of_ply("ply\nbanana\n"), HasSubstr("no part of a PLY header"));
  EXPECT_THAT(refusal_of_ply("ply\nformat ascii 1.0\nend_header\n"), HasSubstr("no element vertex"));
  EXPECT_THAT(refusal_of_ply(head +
                      "element tristrips 1\nproperty list int int vertex_indices\n"
                      "end_header\n" +
                      points + "3 0 1 2\n"),
              HasSubstr("triangles come as strips"));
}

TEST(Ply, RefusesCountsThatTheFileCannotHold) {
  for (const char* format : {"ascii", "binary_little_endian"})
    for (const char* count : {"4000000000", "9223372036854775807"})
      EXPECT_THAT(
          refusal_of_ply(std::string("ply\nformat ") + format + " 1.0\nelement vertex " + count +
                  "\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0"),
          HasSubstr("the elements need at least"))
          << count;
}

TEST(Ply, RefusesATextureThatIsNotThere) {
  const std::string textured =
      "ply\nformat ascii 1.0\ncomment TextureFile a.png\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nproperty int "
      "texnumber\nend_header\n";
  EXPECT_THAT(refusal_of_ply(textured + points + "3 0 1 2 1\n"),
              HasSubstr("texnumber 1 is not there: the header names 1 texture"));
}

}  // namespace
}  // namespace mq
